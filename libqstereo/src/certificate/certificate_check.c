#include "../../include/qstereo/certificate.h"

#include <string.h>

#include "../../include/qstereo/limits.h"
#include "../base/arena.h"
#include "../base/bits.h"
#include "../base/bytes.h"
#include "../base/minmax.h"
#include "certificate_layout.h"
#include "exact.h"
#include "goldstein.h"
#include "search.h"
#include "split.h"

typedef struct checker {
    const qs_certificate *file;
    qs_stated stated;
    qs_split split;
    qs_exact exact;
    uint64_t exact_cells; /* of all parts up to now */
    qs_search search;
    uint16_t *labelling;
    uint8_t *claimed; /* of each label: a stage says that it stays */
    uint64_t at; /* in the stages */
    qs_status status;
    qs_fault fault;
    qs_verdict verdict;
} checker;

static size_t take_parts(checker *c, const qs_index *index, void *workspace)
{
    qs_arena arena = {.base = workspace};
    uint64_t sites = index->qubo->groups, labels = index->qubo->variables + sites;
    qs_stated_take(&c->stated, index, &arena);
    qs_split_take(&c->split, &c->stated, &arena);
    qs_exact_take(&c->exact, &c->stated, &arena);
    qs_search_take(&c->search, &c->exact, &arena);
    c->search.work = QS_SEARCH_WORK;
    c->labelling = qs_arena_take(&arena, sites, sizeof *c->labelling);
    c->claimed = qs_arena_take(&arena, labels, 1);
    return qs_arena_size(&arena);
}

size_t qs_certificate_workspace(const qs_index *index)
{
    checker c = {0};
    return take_parts(&c, index, NULL);
}

/* The file is malformed. Always false. */
static bool reject(checker *c, qs_status status, const char *what)
{
    c->status = status;
    c->fault = (qs_fault){c->file->stage_offset + c->at, what};
    return false;
}

/* The file says what is not so. Always false. */
static bool refute(checker *c, const char *why)
{
    c->verdict.why = why;
    return false;
}

/* The next bytes of the stages; NULL if there are fewer. */
static const uint8_t *next_bytes(checker *c, uint64_t size)
{
    const uint8_t *bytes = c->file->stage_bytes + c->at;
    if (size > c->file->stage_size - c->at) {
        reject(c, QS_E_CORRUPT, "the stages end too early");
        return NULL;
    }
    c->at += size;
    return bytes;
}

/* Reads how many there are of something. */
static bool read_count(checker *c, uint32_t *count)
{
    const uint8_t *at = next_bytes(c, 4);
    *count = at ? qs_load_u32(at) : 0;
    return at != NULL;
}

/* ---- The labelling. ---- */

static bool read_label(checker *c, const uint8_t *at, uint32_t site)
{
    uint32_t label = (uint32_t)qs_load_unsigned(at, c->file->label_bytes);
    c->labelling[site] = (uint16_t)label;
    return label < c->stated.count[site];
}

static bool check_best(checker *c)
{
    for (uint32_t p = 0; p < c->stated.sites; p++) {
        if (!read_label(c, c->file->labelling + (size_t)p * c->file->label_bytes, p)) {
            c->at = 0;
            return reject(c, QS_E_CORRUPT, "a label in BEST that there is not");
        }
    }
    c->verdict.energy = qs_stated_energy(&c->stated, c->labelling);
    return c->verdict.energy == c->file->energy ||
           refute(c, "its labelling has another energy than it states");
}

/* ---- A stage. ---- */

typedef struct stage_head {
    uint32_t has, scale;
    unsigned slot_bytes, share_bytes;
} stage_head;

static bool read_head(checker *c, stage_head *head)
{
    const uint8_t *at = next_bytes(c, QS_STAGE_HEAD);
    if (!at) {
        return false;
    }
    *head = (stage_head){qs_load_u32(at), qs_load_u32(at + 4), qs_load_u32(at + 8),
                         qs_load_u32(at + 12)};
    bool known = (head->has >= 1 && head->has <= QS_STAGE_PARTS) || head->has == QS_STAGE_SEARCHES;
    bool sound = head->scale == 0 && head->slot_bytes == 0 && head->share_bytes == 0;
    if (head->has & QS_STAGE_SPLITS) {
        sound = head->scale >= 1 && head->scale <= QS_SCALE_MOST &&
                (head->slot_bytes == 1 || head->slot_bytes == 2) &&
                (head->share_bytes == 1 || head->share_bytes == 2 || head->share_bytes == 4 ||
                 head->share_bytes == 8);
    }
    c->at -= known && sound ? 0 : QS_STAGE_HEAD;
    return (known && sound) || reject(c, QS_E_CORRUPT, "the head of a stage");
}

/* Reads the labels that a stage compares with: they are left. */
static bool read_labelling(checker *c, const uint32_t *sites, uint32_t count)
{
    const uint8_t *at = next_bytes(c, (uint64_t)count * c->file->label_bytes);
    for (uint32_t i = 0; at && i < count; i++) {
        if (!read_label(c, at, sites[i]) ||
            !c->stated.kept[qs_stated_at(&c->stated, sites[i], c->labelling[sites[i]])]) {
            return reject(c, QS_E_CORRUPT, "a label of a stage that is not left");
        }
        at += c->file->label_bytes;
    }
    return at != NULL;
}

/* Reads which labels stay: a bit for each that is left to the sites. */
static bool read_sets(checker *c, const uint32_t *sites, uint32_t count)
{
    const qs_stated *s = &c->stated;
    uint64_t labels = 0, bit = 0;
    for (uint32_t i = 0; i < count; i++) {
        labels += s->left[sites[i]];
    }
    const uint8_t *bits = next_bytes(c, (labels + 7) / 8);
    if (!bits) {
        return false;
    }
    bool sound = labels % 8 == 0 || bits[labels / 8] >> labels % 8 == 0;
    for (uint32_t i = 0; i < count; i++) {
        uint8_t stay = 0;
        for (size_t at = s->start[sites[i]]; at < s->start[sites[i] + 1]; at++) {
            c->claimed[at] = s->kept[at] && qs_bit(bits + bit / 8, bit % 8);
            bit += s->kept[at];
            stay |= c->claimed[at];
        }
        sound = sound && stay;
    }
    return sound || reject(c, QS_E_CORRUPT, "the label set of a site");
}

/* Takes over the sets of a stage if its labels that leave are ruled out. */
static bool take_sets(checker *c, const uint32_t *sites, uint32_t count, bool are_out)
{
    qs_stated *s = &c->stated;
    for (uint32_t i = 0; are_out && i < count; i++) {
        size_t at = s->start[sites[i]];
        memcpy(s->kept + at, c->claimed + at, s->count[sites[i]]);
    }
    for (uint32_t i = 0; are_out && i < count; i++) {
        qs_stated_fold(s, sites[i]);
    }
    return are_out || refute(c, "a label leaves that its stage does not rule out");
}

/* Whether a label leaves each of the sites. Else a small file could ask for long work. */
static bool is_less(const checker *c, const uint32_t *sites, uint32_t count)
{
    bool all = true;
    for (uint32_t i = 0; all && i < count; i++) {
        size_t at = c->stated.start[sites[i]];
        all = memcmp(c->stated.kept + at, c->claimed + at, c->stated.count[sites[i]]) != 0;
    }
    return all;
}

/* A round: the labels of some sites are compared with one each. */
static bool check_round(checker *c, uint32_t count)
{
    const qs_stated *s = &c->stated;
    const uint8_t *at = next_bytes(c, 4 * (uint64_t)count);
    uint32_t *sites = c->split.sites;
    for (uint32_t i = 0; at && i < count; i++) {
        uint32_t p = qs_load_u32(at + 4 * (size_t)i);
        if (p >= s->sites || s->settled[p] || (i > 0 && p <= sites[i - 1])) {
            return reject(c, QS_E_CORRUPT, "the sites of a stage");
        }
        sites[i] = p;
    }
    if (!at || !read_labelling(c, sites, count) || !read_sets(c, sites, count)) {
        return false;
    }
    if (!is_less(c, sites, count)) {
        return reject(c, QS_E_CORRUPT, "a round in which no label leaves a site");
    }
    bool are_out = true;
    for (uint32_t i = 0; are_out && i < count; i++) {
        are_out =
            qs_goldstein_rules_out(s, sites[i], c->labelling[sites[i]], c->claimed, c->split.work);
    }
    return take_sets(c, sites, count, are_out);
}

static bool check_rounds(checker *c)
{
    uint32_t count;
    bool good = read_count(c, &count);
    if (good && count == 0) {
        return reject(c, QS_E_CORRUPT, "a stage of no sites");
    }
    while (good && count > 0) {
        good = check_round(c, count) && read_count(c, &count);
    }
    return good;
}

/* ---- A split. ---- */

static bool are_small(const checker *c, uint64_t count)
{
    int64_t most = (int64_t)(QS_MOST_SHARES / qs_max_u64(c->split.slots, 1));
    bool small = true;
    for (uint64_t i = 0; small && c->split.share_bytes == 8 && i < count; i++) {
        int64_t share = qs_load_i64(c->split.shares + 8 * (size_t)i);
        small = share >= -most && share <= most;
    }
    return small;
}

static bool read_chains(checker *c, const stage_head *head)
{
    if (c->stated.magnitude > QS_MOST_COSTS / head->scale) {
        return reject(c, QS_E_OVERFLOW, "a scale too large for 64 bits");
    }
    const uint8_t *slots = next_bytes(c, 2 * qs_split_count_edges(&c->split) * head->slot_bytes);
    if (!slots) {
        return false;
    }
    if (!qs_split_set_slots(&c->split, slots, head->slot_bytes)) {
        return reject(c, QS_E_CORRUPT, "slots that make no chains");
    }
    if (c->split.slots > QS_MOST_SLOTS) {
        return reject(c, QS_E_OVERFLOW, "too many slots for 64 bits");
    }
    c->split.share_bytes = head->share_bytes;
    uint64_t count = qs_split_count_shares(&c->split);
    c->split.shares = next_bytes(c, count * head->share_bytes);
    return c->split.shares &&
           (are_small(c, count) || reject(c, QS_E_OVERFLOW, "a share too large for 64 bits"));
}

/* A stage of a split, by which labels may leave. */
static bool check_split(checker *c, const stage_head *head)
{
    bool leaves = head->has & QS_STAGE_LEAVES;
    qs_split *split = &c->split;
    qs_split_begin(split, head->scale, leaves ? c->labelling : NULL);
    if (!read_chains(c, head) || (leaves && (!read_labelling(c, split->sites, split->count) ||
                                             !read_sets(c, split->sites, split->count)))) {
        return false;
    }
    c->verdict.lower_bound = qs_max_i64(c->verdict.lower_bound, qs_split_bound(split));
    return !leaves ||
           take_sets(c, split->sites, split->count, qs_split_rules_out(split, c->claimed));
}

/* ---- Parts that are solved. ---- */

/* Reads how many sites a part has; none at the end of the stage. */
static bool read_size(checker *c)
{
    bool good = read_count(c, &c->exact.count);
    if (c->exact.count > QS_EXACT_SITES || c->exact.count > c->stated.sites) {
        return reject(c, QS_E_CORRUPT, "a part of too many sites");
    }
    return good;
}

static bool read_sites(checker *c)
{
    const uint8_t *at = next_bytes(c, 4 * (uint64_t)c->exact.count);
    for (uint32_t i = 0; at && i < c->exact.count; i++) {
        c->exact.sites[i] = qs_load_u32(at + 4 * (size_t)i);
    }
    return at != NULL;
}

/* A part that is solved by tables. */
static bool check_part(checker *c)
{
    const uint8_t *value = next_bytes(c, 8);
    if (!value || !read_sites(c)) {
        return false;
    }
    qs_exact_laid laid = qs_exact_lay(&c->exact);
    if (laid == QS_EXACT_NO_PART) {
        return reject(c, QS_E_CORRUPT, "sites that are no part");
    }
    c->exact_cells += laid == QS_EXACT_LAID ? qs_exact_cells(&c->exact) : 0;
    if (laid == QS_EXACT_TOO_WIDE || c->exact_cells > QS_EXACT_ALL_CELLS) {
        return reject(c, QS_E_CORRUPT, "a part whose tables are too large");
    }
    qs_exact_solve(&c->exact);
    if (c->exact.value != qs_load_i64(value)) {
        return refute(c, "a part has another least energy than it states");
    }
    qs_exact_settle(&c->exact);
    return true;
}

/* A part that is searched, suffix after suffix, the shortest first. */
static bool check_search(checker *c)
{
    qs_search *x = &c->search;
    uint32_t count = c->exact.count;
    if (!read_sites(c)) {
        return false;
    }
    if (!qs_search_lay(x)) {
        return reject(c, QS_E_CORRUPT, "sites that are no part, or too many to search");
    }
    const uint8_t *bounds = next_bytes(c, 8 * (uint64_t)count);
    for (uint32_t i = 0; bounds && i < count; i++) {
        x->least[i] = qs_load_i64(bounds + 8 * (size_t)i);
        if (x->least[i] < -QS_ENERGY_MAX || x->least[i] > QS_ENERGY_MAX) {
            return reject(c, QS_E_CORRUPT, "a bound of a search");
        }
    }
    for (uint32_t i = count; bounds && i-- > 0;) {
        int64_t least = x->least[i];
        if (!qs_search_suffix(x, i)) {
            return reject(c, QS_E_CORRUPT, "a search that takes too long");
        }
        if (x->least[i] != least) {
            return refute(c, "a part costs less than the least that it states");
        }
    }
    c->exact.value = x->least[0] + x->edges_least;
    qs_exact_close(&c->exact);
    return bounds != NULL;
}

static bool check_parts(checker *c, bool are_searched)
{
    bool good = read_size(c);
    if (good && c->exact.count == 0) {
        return reject(c, QS_E_CORRUPT, "a stage of no sites");
    }
    while (good && c->exact.count > 0) {
        good = (are_searched ? check_search(c) : check_part(c)) && read_size(c);
    }
    return good;
}

static bool check_stage(checker *c)
{
    stage_head head;
    if (!read_head(c, &head)) {
        return false;
    }
    if (head.has & QS_STAGE_SPLITS) {
        return check_split(c, &head);
    }
    return head.has == QS_STAGE_LEAVES ? check_rounds(c)
                                       : check_parts(c, head.has == QS_STAGE_SEARCHES);
}

/* ---- The whole. ---- */

static void count_left(checker *c)
{
    for (uint32_t p = 0; p < c->stated.sites; p++) {
        uint32_t left = c->stated.left[p];
        c->verdict.undecided += left > 1;
        c->verdict.labels += left > 1 ? left : 0;
    }
    if (c->stated.open_count == 0) { /* every optimum is left, and all of one cost */
        c->verdict.lower_bound = qs_max_i64(c->verdict.lower_bound, c->stated.constant);
    }
}

static bool check(checker *c)
{
    const qs_qubo *qubo = c->stated.index->qubo;
    uint8_t digest[QS_DIGEST_SIZE];
    qs_digest(qubo->bytes, qubo->size, digest);
    if (memcmp(digest, c->file->problem, QS_DIGEST_SIZE) != 0) {
        return refute(c, "it is of another problem: the digests differ");
    }
    if (c->file->sites != c->stated.sites) {
        return reject(c, QS_E_CORRUPT, "another number of sites than the problem has");
    }
    qs_stated_read(&c->stated);
    if (c->stated.magnitude > QS_ENERGY_MAX) {
        return reject(c, QS_E_OVERFLOW, "costs of the problem");
    }
    if (!check_best(c)) {
        return false;
    }
    qs_stated_fold_all(&c->stated);
    for (; c->verdict.stage < c->file->stages; c->verdict.stage++) {
        if (!check_stage(c)) {
            return false;
        }
    }
    if (c->at != c->file->stage_size) {
        return reject(c, QS_E_CORRUPT, "bytes after the last stage");
    }
    count_left(c);
    return c->verdict.lower_bound >= c->file->lower_bound ||
           refute(c, "it states a higher bound than it proves");
}

qs_status qs_certificate_check(const qs_index *index, const qs_certificate *certificate,
                               void *workspace, size_t workspace_size, qs_verdict *verdict,
                               uint8_t *left, qs_fault *fault)
{
    if (!index || !certificate || !workspace || !verdict) {
        return QS_E_ARGUMENT;
    }
    if (!index->qubo->has_labels) {
        return QS_E_UNSUPPORTED;
    }
    if (!qs_stated_takes(index->qubo)) {
        return QS_E_ENCODING;
    }
    checker c = {.file = certificate, .verdict = {.lower_bound = QS_NO_BOUND}};
    size_t size = take_parts(&c, index, workspace);
    if (workspace_size < size || size == SIZE_MAX) {
        return QS_E_WORKSPACE;
    }
    c.verdict.valid = check(&c);
    if (c.status != QS_OK) {
        if (fault) {
            *fault = c.fault;
        }
        return c.status;
    }
    if (c.verdict.valid && left) {
        memcpy(left, c.stated.kept, c.stated.start[c.stated.sites]);
    }
    *verdict = c.verdict;
    return QS_OK;
}
