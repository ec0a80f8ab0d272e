#include "qcf_labels.h"

#include <string.h>

#include "../base/bits.h"
#include "../base/bytes.h"
#include "../base/saturate.h"
#include "qcf_runs.h"
#include "sites.h"

static bool corrupt(qs_reader *reader, const qs_chunk *chunk, const char *what)
{
    return qs_reject(reader, QS_E_CORRUPT, chunk->offset, what);
}

/* ---- labl ---- */

static qs_labels load(const uint8_t *p)
{
    return (qs_labels){
        .encoding = (qs_encoding)qs_load_u32(p),
        .pairwise = {(qs_smoothness)qs_load_u32(p + 4), qs_load_u32(p + 8), NULL},
        .labels = qs_load_u32(p + 12),
        .scale = qs_load_u32(p + 16),
        .penalty = (qs_penalty)qs_load_u32(p + 20),
        .gap = qs_load_u32(p + 24),
        .weight = qs_load_i32(p + 28),
        .width = qs_load_u32(p + 32),
        .height = qs_load_u32(p + 36),
        .frame = {qs_load_u32(p + 40), qs_load_u32(p + 44), qs_load_u32(p + 48),
                  qs_load_u32(p + 52), qs_load_i32(p + 56)},
    };
}

/* Returns true if each field that means something only beside another one has it. */
static bool fields_agree(const qs_labels *l, bool masked)
{
    const qs_frame *f = &l->frame;
    bool truncates = l->pairwise.smoothness == QS_TRUNCATED_LINEAR ||
                     l->pairwise.smoothness == QS_TRUNCATED_QUADRATIC;
    bool framed = f->picture_width > 0 || f->picture_height > 0 || f->x > 0 || f->y > 0;
    if (l->encoding == QS_DOMAIN_WALL && l->pairwise.smoothness == QS_TABLE) {
        return false; /* each edge has its own there */
    }
    return (l->width > 0 || (!masked && !framed)) && (truncates || l->pairwise.truncation == 0) &&
           (qs_penalty_keeps_gap(l->penalty) || l->gap == 1) &&
           qs_encoding_holds(l->encoding, &l->pairwise, l->labels) &&
           qs_encoding_allows_penalty(l->encoding, l->penalty, &l->pairwise);
}

static bool in_range(const qs_labels *l)
{
    const qs_frame *f = &l->frame;
    bool known = qs_encoding_facts_of(l->encoding) && l->pairwise.smoothness <= QS_TABLES &&
                 l->penalty <= QS_PENALTY_MINIMAL && l->scale >= 1 && l->gap >= 1 &&
                 l->gap <= INT32_MAX && l->weight >= -1 && f->first > INT32_MIN && l->labels >= 1 &&
                 l->labels <= QS_LABELS_MAX;
    bool framed = (l->width == 0) == (l->height == 0) && l->width <= f->picture_width &&
                  l->height <= f->picture_height && f->x <= f->picture_width - l->width &&
                  f->y <= f->picture_height - l->height &&
                  (uint64_t)l->width * l->height <= QS_VARIABLES_MAX;
    return known && framed;
}

/* The number of sites that a mask leaves; false where its spare bits are in use. */
static bool count_mask(const qs_labels *l, uint32_t *sites)
{
    uint64_t cells = (uint64_t)l->width * l->height;
    *sites = 0;
    for (uint64_t byte = 0; byte < qs_bit_bytes(cells); byte++) {
        *sites += qs_byte_count(l->mask[byte]);
    }
    return cells % 8 == 0 || l->mask[cells / 8] >> cells % 8 == 0;
}

static bool read_labl(qs_reader *reader, const qs_chunk *chunk, qs_qubo *q)
{
    if (q->has_labels || chunk->length < QS_LABL_HEAD) {
        return corrupt(reader, chunk, "length or number of labl");
    }
    qs_labels labels = load(chunk->payload);
    uint32_t masked = qs_load_u32(chunk->payload + 60);
    if (!in_range(&labels) || masked > 1 || !fields_agree(&labels, masked != 0)) {
        return corrupt(reader, chunk, "contents of labl");
    }
    uint64_t cells = (uint64_t)labels.width * labels.height;
    if (chunk->length != QS_LABL_HEAD + (masked ? qs_bit_bytes(cells) : 0)) {
        return corrupt(reader, chunk, "length of labl");
    }
    labels.sites = cells > 0 ? (uint32_t)cells : q->groups;
    if (masked) {
        labels.mask = chunk->payload + QS_LABL_HEAD;
        if (!count_mask(&labels, &labels.sites)) {
            return corrupt(reader, chunk, "mask of labl");
        }
    }
    labels.undecided = labels.sites;
    q->labels = labels;
    q->has_labels = true;
    return true;
}

/* ---- mean ---- */

static bool read_mean(qs_reader *reader, const qs_chunk *chunk, qs_qubo *q, bool in_place)
{
    const uint8_t *p = chunk->payload;
    if (!in_place || chunk->length != QS_MEAN_SIZE) {
        return corrupt(reader, chunk, "length, place or number of mean");
    }
    qs_meaning meaning = {(qs_meaning_kind)qs_load_u32(p),
                          qs_load_u32(p + 4),
                          qs_load_u32(p + 8),
                          qs_load_u32(p + 12),
                          qs_load_i32(p + 16),
                          qs_load_i32(p + 20)};
    bool disparity = meaning.kind == QS_MEANS_DISPARITY;
    if (!qs_meaning_is_valid(&meaning) || (disparity && meaning.unit == 0) ||
        (!disparity && q->labels.frame.first < 0)) {
        return corrupt(reader, chunk, "contents of mean");
    }
    q->labels.meaning = meaning;
    return true;
}

/* ---- kept ---- */

/* Two labels or more, none beyond the last. */
static bool is_set(const uint8_t *set, uint32_t labels)
{
    uint32_t count = 0;
    for (uint32_t byte = 0; byte < qs_bit_bytes(labels); byte++) {
        count += qs_byte_count(set[byte]);
    }
    return count >= 2 && (labels % 8 == 0 || set[labels / 8] >> labels % 8 == 0);
}

static bool read_sets(qs_reader *reader, const qs_chunk *chunk, qs_labels *l)
{
    uint64_t map = (uint64_t)l->sites * l->fixed_bytes, each = qs_bit_bytes(l->labels);
    if (chunk->length < QS_KEPT_HEAD + map) {
        return corrupt(reader, chunk, "length of kept");
    }
    l->fixed = chunk->payload + QS_KEPT_HEAD;
    l->sets = l->fixed + map;
    l->undecided = 0;
    for (uint32_t site = 0; site < l->sites; site++) {
        uint32_t fixed = qs_fixed_at(l, site);
        if (fixed != qs_undecided_mark(l) && fixed >= l->labels) {
            return corrupt(reader, chunk, "a fixed label of kept");
        }
        l->undecided += fixed == qs_undecided_mark(l);
    }
    if (chunk->length != QS_KEPT_HEAD + map + l->undecided * each) {
        return corrupt(reader, chunk, "length of kept");
    }
    for (uint32_t site = 0; site < l->undecided; site++) {
        if (!is_set(l->sets + site * each, l->labels)) {
            return corrupt(reader, chunk, "a set of labels of kept");
        }
    }
    return true;
}

static bool read_kept(qs_reader *reader, const qs_chunk *chunk, qs_qubo *q, bool first)
{
    qs_labels *l = &q->labels;
    if (!first || chunk->length < QS_KEPT_HEAD) {
        return corrupt(reader, chunk, "length, number or place of kept");
    }
    uint32_t sites = qs_load_u32(chunk->payload);
    l->fixed_bytes = qs_load_u32(chunk->payload + 4);
    bool width = l->fixed_bytes == 0 || l->fixed_bytes == (l->labels <= UINT8_MAX ? 1 : 2);
    bool plain = l->fixed_bytes == 0; /* all sites are undecided: each has a group at least */
    if (sites == 0 || !width || (l->width > 0 && sites != l->sites) ||
        (plain && (chunk->length != QS_KEPT_HEAD || sites > q->groups))) {
        return corrupt(reader, chunk, "head of kept");
    }
    l->sites = l->undecided = sites;
    return plain || read_sets(reader, chunk, l);
}

/* ---- trnc ---- */

/* `counted`: it is known that the file is large enough for the sites that labl and kept name. */
static bool read_trnc(qs_reader *reader, const qs_chunk *chunk, qs_labels *l, bool counted)
{
    if (!counted || l->trimmed || chunk->length < QS_TRNC_HEAD) {
        return corrupt(reader, chunk, "length, number or place of trnc");
    }
    uint32_t bytes = qs_load_u32(chunk->payload);
    uint64_t left = 0;
    for (qs_site site = {.labels = l}; qs_site_next(&site);) {
        left += site.is_undecided ? site.count : 0;
    }
    if ((bytes != 1 && bytes != 2 && bytes != 4) || qs_load_u32(chunk->payload + 4) != 0 ||
        chunk->length != QS_TRNC_HEAD + left * bytes) {
        return corrupt(reader, chunk, "head or length of trnc");
    }
    l->trimmed_bytes = bytes;
    l->trimmed = chunk->payload + QS_TRNC_HEAD;
    return true;
}

/* ---- best ---- */

/* The labels that a group can have: a wall of n variables has n + 1. */
static uint32_t group_labels(const qs_qubo *q, size_t run)
{
    return qs_group_run_at(q, run).size + (qs_code_of(&q->labels) == QS_CODE_WALL);
}

static bool are_labels(const qs_qubo *q, const qs_known *known)
{
    const uint8_t *label = known->labels;
    for (size_t run = 0; run < q->group_run_count; run++) {
        for (uint32_t g = qs_group_run_at(q, run).count; g > 0; g--) {
            if (qs_load_unsigned(label, known->bytes) >= group_labels(q, run)) {
                return false;
            }
            label += known->bytes;
        }
    }
    return true;
}

static bool read_best(qs_reader *reader, const qs_chunk *chunk, qs_qubo *q)
{
    const qs_labels *l = &q->labels;
    if (!q->has_labels || q->known.bytes > 0 || q->groups == 0 ||
        !qs_encoding_facts_of(l->encoding)->has_model || chunk->length < QS_KNOWN_HEAD) {
        return corrupt(reader, chunk, "length, number or place of best");
    }
    qs_known known = {.bytes = l->labels <= UINT8_MAX ? 1 : 2,
                      .labels = chunk->payload + QS_KNOWN_HEAD,
                      .lower_bound = qs_load_i64(chunk->payload)};
    bool bounded = known.lower_bound == QS_NO_BOUND ||
                   qs_absolute(known.lower_bound) <= (uint64_t)QS_ENERGY_MAX;
    if (!bounded || qs_load_u32(chunk->payload + 8) != known.bytes ||
        qs_load_u32(chunk->payload + 12) != 0 ||
        chunk->length != QS_KNOWN_HEAD + (uint64_t)q->groups * known.bytes) {
        return corrupt(reader, chunk, "head or length of best");
    }
    if (!are_labels(q, &known)) {
        return corrupt(reader, chunk, "a label of best");
    }
    q->known = known;
    return true;
}

/* ---- What labels and groups must have in common. ---- */

/* Walks the groups of a file. */
typedef struct group_cursor {
    const qs_qubo *qubo;
    size_t run;
    uint32_t in_run;
} group_cursor;

/* Moves to the next group; false where there is none, or it does not have `size` variables. */
static bool next_group(group_cursor *at, uint64_t size)
{
    if (at->run == at->qubo->group_run_count) {
        return false;
    }
    qs_group_run run = qs_group_run_at(at->qubo, at->run);
    if (run.size != size) {
        return false;
    }
    bool last = ++at->in_run == run.count;
    at->run += last;
    at->in_run = last ? 0 : at->in_run;
    return true;
}

/* The numbers of terminals: one for each label where the encoding has them. */
static uint32_t terminals_of(const qs_labels *l)
{
    bool any = qs_encoding_facts_of(l->encoding)->auxiliaries == QS_TERMINALS && l->undecided > 0;
    return any ? l->labels : 0;
}

/* Returns true if each undecided site is a group of its size, and terminals are the rest. */
static bool groups_agree(const qs_qubo *q)
{
    const qs_labels *l = &q->labels;
    group_cursor at = {.qubo = q};
    for (qs_site site = {.labels = l}; qs_site_next(&site);) {
        uint32_t size = qs_encoding_site_variables(l->encoding, site.count);
        if (site.is_undecided && !next_group(&at, size)) {
            return false;
        }
    }
    for (uint32_t t = terminals_of(l); t > 0; t--) {
        if (!next_group(&at, l->labels)) {
            return false;
        }
    }
    return at.run == q->group_run_count;
}

/* Returns true if each variable is a group, and there are those of the sites' chains, of source and
 * sink, and of arcs if the encoding has them. */
static bool vertices_agree(const qs_qubo *q)
{
    qs_site site = {.labels = &q->labels};
    while (qs_site_next(&site)) {
    }
    bool any = q->labels.undecided > 0;
    bool arcs = qs_encoding_facts_of(q->labels.encoding)->auxiliaries == QS_SOURCE_SINK_AND_ARCS;
    uint64_t vertices = any ? site.next_variable + 2 : 0;
    return q->groups == q->variables &&
           (any && arcs ? q->variables >= vertices : q->variables == vertices);
}

/* Returns true if a file without the chunk kept has a single run of groups, one for each site. */
static bool plain_agrees(const qs_qubo *q)
{
    const qs_labels *l = &q->labels;
    return qs_encoding_facts_of(l->encoding)->is_streamed && q->groups == l->sites &&
           q->group_run_count == 1 && qs_group_run_at(q, 0).size == l->labels;
}

/* Returns true if every group has a penalty in the encodings whose groups are one-hot. A group
 * without one would not be one-hot. */
static bool penalties_agree(const qs_qubo *q)
{
    if (qs_encoding_facts_of(q->labels.encoding)->code != QS_CODE_ONE_HOT) {
        return true;
    }
    for (size_t r = 0; r < q->penalty_run_count; r++) {
        qs_penalty_run run = qs_penalty_run_at(q, r);
        if (run.a == 0 && run.b == 0) {
            return false;
        }
    }
    return true;
}

static bool agree(const qs_qubo *q, bool kept)
{
    if (!kept) {
        return plain_agrees(q);
    }
    bool chains = qs_encoding_facts_of(q->labels.encoding)->code == QS_CODE_CHAIN;
    return chains ? vertices_agree(q) : groups_agree(q);
}

/* One side chunk. `labl` is the chunk of that name and `kept` is true once they have been read. A
 * side chunk of another name is ignored. */
static bool read_side_chunk(qs_reader *reader, const qs_chunk *chunk, qs_qubo *q, qs_chunk *labl,
                            bool *kept)
{
    bool before_trnc = q->has_labels && !q->labels.trimmed && q->known.bytes == 0;
    if (memcmp(chunk->type, "labl", 4) == 0) {
        *labl = *chunk;
        return read_labl(reader, chunk, q);
    }
    if (memcmp(chunk->type, "mean", 4) == 0) {
        bool first = before_trnc && !*kept && q->labels.meaning.kind == QS_MEANS_DISPARITY &&
                     q->labels.meaning.unit == 0;
        return read_mean(reader, chunk, q, first);
    }
    if (memcmp(chunk->type, "kept", 4) == 0) {
        bool first = before_trnc && !*kept;
        *kept = true;
        return read_kept(reader, chunk, q, first);
    }
    if (memcmp(chunk->type, "best", 4) == 0) {
        return read_best(reader, chunk, q);
    }
    bool counted = q->known.bytes == 0 && (*kept || (q->has_labels && plain_agrees(q)));
    return memcmp(chunk->type, "trnc", 4) != 0 || read_trnc(reader, chunk, &q->labels, counted);
}

bool qs_labels_read(qs_reader *reader, qs_qubo *qubo)
{
    bool kept = false;
    qs_chunk labl = {0};
    for (qs_chunk chunk; qs_read_side_chunk(reader, &chunk);) {
        if (!read_side_chunk(reader, &chunk, qubo, &labl, &kept)) {
            return false;
        }
    }
    if (reader->status != QS_OK || !qubo->has_labels) {
        return reader->status == QS_OK;
    }
    if (!agree(qubo, kept)) {
        return corrupt(reader, &labl, "labels that do not fit the groups");
    }
    return penalties_agree(qubo) || corrupt(reader, &labl, "a site or terminal without a penalty");
}
