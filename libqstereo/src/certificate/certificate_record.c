#include "../../include/qstereo/certificate.h"

#include <string.h>

#include "../base/arena.h"
#include "../base/bits.h"
#include "../base/bytes.h"
#include "../base/minmax.h"
#include "../files/container.h"
#include "../qubo/sites.h"
#include "../solve/messages.h"
#include "certificate_layout.h"
#include "exact_order.h"
#include "stated_problem.h"

/* What a recorder keeps, in its workspace. Sites and labels are those of the file. */
typedef struct qs_record_book {
    qs_stated stated;
    uint32_t *cell; /* of each site: the model's site */
    uint32_t *place; /* of each site: the problem's, fixed ones and all */
    uint32_t *site; /* of each of the model's sites: the file's, or NO_SITE */
    uint16_t *name; /* of each label: the model's label */
    uint32_t *slots; /* of each site: how many */
    uint16_t *first_slot, *second_slot; /* of each edge that is alive */
    size_t *share_at; /* of each site: where its shares begin */
    int32_t *shares; /* of each slot of a site but the last, of each of its labels */
    uint16_t *labelling; /* of each site, of the stage */
    uint8_t *sets; /* of each label */
    unsigned shift;
    bool pending; /* there is a split that has not been written */
    bool has_parts; /* the last stage has parts, and has not ended */
    qs_exact exact;
    qs_exact_order order;
    uint64_t exact_cells; /* of all parts up to now */
} qs_record_book;

enum { PIECE = 256 };

#define NO_SITE UINT32_MAX

/* ---- Memory. ---- */

/* Links of a vertex to earlier and later sites, of weight above 0. */
static void count_links(const qs_model *model, uint32_t p, uint32_t *earlier, uint32_t *later)
{
    *earlier = *later = 0;
    for (uint32_t n = model->link_start[p]; n < model->link_start[p + 1]; n++) {
        if (model->links[n].weight > 0) {
            ++*(model->links[n].site < p ? earlier : later);
        }
    }
}

/* Shares that there can be. */
static uint64_t most_shares(const qs_model *model)
{
    uint64_t rows = 0;
    if (model->width > 0) {
        return (uint64_t)model->sites * model->labels;
    }
    for (uint32_t p = 0; p < model->sites; p++) {
        uint32_t earlier, later;
        count_links(model, p, &earlier, &later);
        rows += qs_max_u32(qs_max_u32(earlier, later), 1) - 1;
    }
    return rows * model->labels;
}

static size_t take_parts(qs_record_book **book, const qs_index *index, const qs_model *model,
                         void *workspace)
{
    qs_arena arena = {.base = workspace};
    uint64_t sites = index->qubo->groups, labels = index->qubo->variables + sites,
             couplings = index->qubo->couplings;
    *book = qs_arena_take(&arena, 1, sizeof **book);
    qs_record_book counted = {0}, *b = *book ? *book : &counted;
    qs_stated_take(&b->stated, index, &arena);
    b->cell = qs_arena_take(&arena, sites, sizeof *b->cell);
    b->place = qs_arena_take(&arena, sites, sizeof *b->place);
    b->site = qs_arena_take(&arena, model->sites, sizeof *b->site);
    b->name = qs_arena_take(&arena, labels, sizeof *b->name);
    b->slots = qs_arena_take(&arena, sites, sizeof *b->slots);
    b->first_slot = qs_arena_take(&arena, couplings, sizeof *b->first_slot);
    b->second_slot = qs_arena_take(&arena, couplings, sizeof *b->second_slot);
    b->share_at = qs_arena_take(&arena, sites, sizeof *b->share_at);
    b->shares = qs_arena_take(&arena, most_shares(model), sizeof *b->shares);
    b->labelling = qs_arena_take(&arena, sites, sizeof *b->labelling);
    b->sets = qs_arena_take(&arena, labels, 1);
    qs_exact_take(&b->exact, &b->stated, &arena);
    qs_exact_order_take(&b->order, &b->stated, &arena);
    return qs_arena_size(&arena);
}

size_t qs_recorder_workspace(const qs_index *index, const qs_model *model)
{
    qs_record_book *book;
    return take_parts(&book, index, model, NULL);
}

/* ---- The file's sites and labels in the model. ---- */

static void name_labels(const qs_record_book *b, const qs_site *site)
{
    size_t at = b->stated.start[site->number];
    for (uint32_t d = qs_site_label_from(site, 0); d < site->labels->labels;
         d = qs_site_label_from(site, d + 1)) {
        b->name[at++] = (uint16_t)d;
    }
}

static void place_sites(const qs_record_book *b, const qs_model *model)
{
    uint32_t cell = 0;
    memset(b->site, 0xff, sizeof *b->site * model->sites); /* NO_SITE */
    for (qs_site site = {.labels = &b->stated.index->qubo->labels}; qs_site_next(&site); cell++) {
        while (model->width > 0 && qs_is_masked(model->mask, cell)) {
            cell++;
        }
        if (site.is_undecided) {
            b->cell[site.number] = cell;
            b->place[site.number] = site.next - 1;
            b->site[cell] = site.number;
            name_labels(b, &site);
        }
    }
}

/* Returns true if two edges join the same two sites. */
static bool has_double_edges(const qs_record_book *b)
{
    const qs_stated *s = &b->stated;
    memset(b->slots, 0xff, sizeof *b->slots * s->sites); /* the site that was last seen beside */
    for (uint32_t p = 0; p < s->sites; p++) {
        for (uint32_t n = s->near_start[p]; n < s->near_start[p + 1]; n++) {
            const qs_stated_edge *edge = &s->edges[s->near[n]];
            if (edge->first == p) {
                if (b->slots[edge->second] == p) {
                    return true;
                }
                b->slots[edge->second] = p;
            }
        }
    }
    return false;
}

qs_status qs_recorder_begin(qs_recorder *recorder, const qs_index *index, const qs_model *model,
                            void *workspace, size_t workspace_size, const qs_sink *stages)
{
    if (!recorder || !index || !model || !workspace || !stages) {
        return QS_E_ARGUMENT;
    }
    qs_record_book *book;
    size_t size = take_parts(&book, index, model, NULL);
    if (workspace_size < size || size == SIZE_MAX) {
        return QS_E_WORKSPACE;
    }
    if (!qs_messages_fit(model, true)) {
        return QS_E_OVERFLOW;
    }
    (void)take_parts(&book, index, model, workspace);
    qs_stated_read(&book->stated);
    if (has_double_edges(book)) {
        return QS_E_ENCODING;
    }
    qs_stated_fold(&book->stated);
    place_sites(book, model);
    book->pending = book->has_parts = false;
    book->exact_cells = 0;
    *recorder = (qs_recorder){.index = index, .model = model, .sink = stages, .book = book};
    return QS_OK;
}

/* ---- The slots of a split. ---- */

static bool is_alive(const qs_stated *s, uint32_t site)
{
    return !s->settled[site];
}

static bool is_row(const qs_model *model, uint32_t cell, uint32_t other)
{
    return other == cell + 1 && other % model->width != 0;
}

/* Which chain of TRW-S an edge belongs to at one of its sites, in a graph: its number among the
 * site's links to the same side. */
static uint16_t rank_of(const qs_model *model, uint32_t cell, uint32_t other)
{
    uint32_t rank = 0;
    for (uint32_t n = model->link_start[cell]; model->links[n].site != other; n++) {
        rank += model->links[n].weight > 0 && (model->links[n].site > cell) == (other > cell);
    }
    return (uint16_t)rank;
}

static int32_t weight_of(const qs_model *model, uint32_t cell, uint32_t other)
{
    if (model->width > 0) {
        return is_row(model, cell, other) ? model->right[cell] : model->down[cell];
    }
    uint32_t n = model->link_start[cell];
    while (model->links[n].site != other) {
        n++;
    }
    return model->links[n].weight;
}

/* The number of an edge: see qs_model_edge_pairwise. */
static uint32_t edge_number(const qs_model *model, uint32_t cell, uint32_t other)
{
    if (model->width > 0) {
        return 2 * cell + !is_row(model, cell, other);
    }
    uint32_t n = model->link_start[cell];
    while (model->links[n].site != other) {
        n++;
    }
    return model->links[n].edge;
}

/* The sides that a site of a grid has edges on. */
enum { ROW = 1, COLUMN = 2 };

/* Finds the slots of a grid: the row's first. Where there are edges along one alone, that is the
 * only slot. */
static void find_grid_slots(qs_record_book *b, const qs_model *model)
{
    const qs_stated *s = &b->stated;
    for (uint32_t e = 0; e < s->edge_count; e++) {
        const qs_stated_edge *edge = &s->edges[e];
        uint32_t side = is_row(model, b->cell[edge->first], b->cell[edge->second]) ? ROW : COLUMN;
        b->slots[edge->first] |= edge->alive ? side : 0;
        b->slots[edge->second] |= edge->alive ? side : 0;
    }
    for (uint32_t e = 0; e < s->edge_count; e++) {
        const qs_stated_edge *edge = &s->edges[e];
        bool column = !is_row(model, b->cell[edge->first], b->cell[edge->second]);
        b->first_slot[e] = column && b->slots[edge->first] == (ROW | COLUMN);
        b->second_slot[e] = column && b->slots[edge->second] == (ROW | COLUMN);
    }
    for (uint32_t p = 0; p < s->sites; p++) {
        b->slots[p] = b->slots[p] == (ROW | COLUMN) ? 2 : 1;
    }
}

static void find_graph_slots(qs_record_book *b, const qs_model *model)
{
    const qs_stated *s = &b->stated;
    for (uint32_t e = 0; e < s->edge_count; e++) {
        const qs_stated_edge *edge = &s->edges[e];
        uint32_t p = edge->first, q = edge->second;
        if (edge->alive) {
            b->first_slot[e] = rank_of(model, b->cell[p], b->cell[q]);
            b->second_slot[e] = rank_of(model, b->cell[q], b->cell[p]);
            b->slots[p] = qs_max_u32(b->slots[p], b->first_slot[e] + 1u);
            b->slots[q] = qs_max_u32(b->slots[q], b->second_slot[e] + 1u);
        }
    }
    for (uint32_t p = 0; p < s->sites; p++) {
        b->slots[p] = qs_max_u32(b->slots[p], 1);
    }
}

/* Returns true if an edge is of a part that was solved. A solver may go on with it. */
static bool is_solved(const qs_stated *s, const qs_stated_edge *edge)
{
    return s->settled[edge->first] == QS_IN_SOLVED_PART;
}

/* Returns true if the edges that are alive are those that the model has. */
static bool edges_agree(const qs_record_book *b, const qs_model *model)
{
    const qs_stated *s = &b->stated;
    for (uint32_t e = 0; e < s->edge_count; e++) {
        const qs_stated_edge *edge = &s->edges[e];
        bool has = weight_of(model, b->cell[edge->first], b->cell[edge->second]) > 0;
        if (edge->alive != has && !is_solved(s, edge)) {
            return false;
        }
    }
    return true;
}

/* The label of the file that the model's label is, at a site that has it. */
static uint16_t label_named(const qs_record_book *b, uint32_t site, uint32_t name)
{
    const uint16_t *names = b->name + b->stated.start[site];
    uint32_t a = 0;
    while (a + 1 < b->stated.count[site] && names[a] != name) {
        a++;
    }
    return (uint16_t)a;
}

static void begin_split(void *context, const qs_model *model, unsigned shift,
                        const uint16_t *labelling)
{
    qs_recorder *r = context;
    qs_record_book *b = r->book;
    const qs_stated *s = &b->stated;
    size_t at = 0;
    b->pending = edges_agree(b, model);
    if (!b->pending) {
        r->status = QS_E_OVERFLOW; /* costs that were too large to fold */
        return;
    }
    b->shift = shift;
    memset(b->slots, 0, sizeof *b->slots * s->sites);
    if (model->width > 0) {
        find_grid_slots(b, model);
    } else {
        find_graph_slots(b, model);
    }
    for (uint32_t p = 0; p < s->sites; p++) {
        b->labelling[p] = label_named(b, p, labelling[b->cell[p]]);
        b->share_at[p] = at;
        at += is_alive(s, p) ? (size_t)(b->slots[p] - 1) * s->count[p] : 0;
    }
    memset(b->shares, 0, sizeof *b->shares * at);
}

/* ---- The shares of a split. ---- */

/* The slot of the file that a chain of the model is at a site, if it has a share of its own. */
static bool slot_with_share(const qs_record_book *b, uint32_t site, uint32_t chain, uint32_t *slot)
{
    *slot = chain;
    return is_alive(&b->stated, site) && chain + 1 < b->slots[site];
}

/* The costs of an edge in the file are those in the model and, for each label of either site, a
 * number more: a domain wall has put them into the site's own costs. Subtracts them, scaled, from
 * the share of the edge's chain. */
static bool move_costs(const qs_record_book *b, const qs_model *model, const qs_stated_edge *edge,
                       uint32_t site, int32_t *share)
{
    const qs_stated *s = &b->stated;
    const uint16_t *first = b->name + s->start[edge->first],
                   *second = b->name + s->start[edge->second];
    uint32_t one = b->cell[edge->first], other = b->cell[edge->second],
             number = edge_number(model, one, other);
    int64_t weight = weight_of(model, one, other);
    for (uint32_t a = 0; a < s->count[site]; a++) {
        uint32_t x = edge->first == site ? a : 0, y = edge->first == site ? 0 : a;
        int64_t value = weight * qs_model_edge_pairwise(model, number, first[x], second[y]),
                more = qs_stated_cost(s, edge, x, y) - value;
        int64_t moved = share[a] - more * ((int64_t)1 << b->shift);
        if (moved < INT32_MIN || moved > INT32_MAX) {
            return false;
        }
        share[a] = (int32_t)moved;
    }
    return true;
}

static void take_share(void *context, const qs_model *model, uint32_t cell, uint32_t chain,
                       const int32_t *share)
{
    qs_recorder *r = context;
    qs_record_book *b = r->book;
    const qs_stated *s = &b->stated;
    uint32_t site = b->site[cell], slot;
    if (!b->pending || site == NO_SITE || !slot_with_share(b, site, chain, &slot)) {
        return;
    }
    int32_t *own = b->shares + b->share_at[site] + (size_t)slot * s->count[site];
    for (uint32_t a = 0; a < s->count[site]; a++) {
        bool kept = s->kept[qs_stated_at(s, site, a)] != 0;
        own[a] = kept ? share[b->name[qs_stated_at(s, site, a)]] : 0;
    }
    if (b->stated.index->qubo->labels.encoding != QS_DOMAIN_WALL) {
        return; /* there it is one number for all labels of an edge */
    }
    for (uint32_t n = s->near_start[site]; n < s->near_start[site + 1]; n++) {
        const qs_stated_edge *edge = &s->edges[s->near[n]];
        uint32_t there =
            edge->first == site ? b->first_slot[s->near[n]] : b->second_slot[s->near[n]];
        if (edge->alive && there == slot && !move_costs(b, model, edge, site, own)) {
            r->status = QS_E_OVERFLOW;
        }
    }
}

/* ---- Writing a stage. ---- */

typedef struct stage_writer {
    const qs_sink *sink;
    bool failed;
    size_t used;
    uint8_t piece[PIECE];
} stage_writer;

static void flush(stage_writer *w)
{
    w->failed = w->failed || (w->used > 0 && !w->sink->write(w->sink->context, w->piece, w->used));
    w->used = 0;
}

static void put(stage_writer *w, uint64_t value, unsigned bytes)
{
    uint8_t stored[8];
    if (w->used + bytes > PIECE) {
        flush(w);
    }
    qs_store_u64(stored, value);
    memcpy(w->piece + w->used, stored, bytes);
    w->used += bytes;
}

static unsigned label_bytes(const qs_stated *s)
{
    return s->most_labels <= UINT8_MAX + 1u ? 1 : 2;
}

static unsigned slot_bytes(const qs_record_book *b)
{
    uint32_t most = 0;
    for (uint32_t p = 0; p < b->stated.sites; p++) {
        most = qs_max_u32(most, b->slots[p]);
    }
    return most <= UINT8_MAX + 1u ? 1 : 2;
}

static unsigned share_bytes(const qs_record_book *b)
{
    const qs_stated *s = &b->stated;
    int32_t low = 0, high = 0;
    for (uint32_t p = 0; p < s->sites; p++) {
        size_t count = is_alive(s, p) ? (size_t)(b->slots[p] - 1) * s->count[p] : 0;
        for (size_t i = 0; i < count; i++) {
            low = qs_min_i32(low, b->shares[b->share_at[p] + i]);
            high = qs_max_i32(high, b->shares[b->share_at[p] + i]);
        }
    }
    if (low >= INT8_MIN && high <= INT8_MAX) {
        return 1;
    }
    return low >= INT16_MIN && high <= INT16_MAX ? 2 : 4;
}

static void put_split(stage_writer *w, const qs_record_book *b, unsigned slot, unsigned share)
{
    const qs_stated *s = &b->stated;
    for (uint32_t e = 0; e < s->edge_count; e++) {
        if (s->edges[e].alive) {
            put(w, b->first_slot[e], slot);
            put(w, b->second_slot[e], slot);
        }
    }
    for (uint32_t p = 0; p < s->sites; p++) {
        for (uint32_t i = 0; is_alive(s, p) && i + 1 < b->slots[p]; i++) {
            for (uint32_t a = 0; a < s->count[p]; a++) {
                if (s->kept[qs_stated_at(s, p, a)]) {
                    int32_t number = b->shares[b->share_at[p] + (size_t)i * s->count[p] + a];
                    put(w, (uint64_t)(int64_t)number, share);
                }
            }
        }
    }
}

static void put_labels(stage_writer *w, const qs_record_book *b)
{
    const qs_stated *s = &b->stated;
    for (uint32_t p = 0; p < s->sites; p++) {
        if (is_alive(s, p)) {
            put(w, b->labelling[p], label_bytes(s));
        }
    }
}

static void put_sets(stage_writer *w, const qs_record_book *b)
{
    const qs_stated *s = &b->stated;
    for (uint32_t p = 0; p < s->sites; p++) {
        for (uint32_t first = 0; is_alive(s, p) && first < s->count[p]; first += 8) {
            unsigned bits = 0;
            for (uint32_t a = first; a < first + 8 && a < s->count[p]; a++) {
                bits |= (unsigned)b->sets[qs_stated_at(s, p, a)] << (a - first);
            }
            put(w, bits, 1);
        }
    }
}

static void put_head(stage_writer *w, unsigned has, uint64_t scale, unsigned slot, unsigned share)
{
    put(w, has, 4);
    put(w, scale, 4);
    put(w, slot, 4);
    put(w, share, 4);
}

static void end_writing(qs_recorder *r, stage_writer *w)
{
    flush(w);
    r->status = w->failed ? QS_E_IO : r->status;
}

/* A stage of parts ends with one that has no sites. */
static void end_parts(qs_recorder *r)
{
    stage_writer w = {.sink = r->sink};
    if (r->book->has_parts) {
        put(&w, 0, 4);
        end_writing(r, &w);
    }
    r->book->has_parts = false;
}

static bool may_begin_stage(qs_recorder *r)
{
    end_parts(r);
    if (r->stages == QS_STAGES_MOST) {
        r->status = QS_E_OVERFLOW;
    }
    return r->status == QS_OK;
}

/* Writes the stage: its split, if there is one, and the sets, if labels leave. */
static void write_stage(qs_recorder *r, bool leaves)
{
    qs_record_book *b = r->book;
    if (!may_begin_stage(r)) {
        return;
    }
    stage_writer w = {.sink = r->sink};
    unsigned slot = b->pending ? slot_bytes(b) : 0, share = b->pending ? share_bytes(b) : 0;
    put_head(&w, (b->pending ? QS_STAGE_SPLITS : 0u) | (leaves ? QS_STAGE_LEAVES : 0u),
             b->pending ? (uint64_t)1 << b->shift : 0, slot, share);
    if (b->pending) {
        put_split(&w, b, slot, share);
    }
    if (b->pending && leaves) {
        put_labels(&w, b);
    }
    if (leaves) {
        put_sets(&w, b);
    }
    end_writing(r, &w);
    r->stages++;
    b->pending = false;
}

/* Writes the part that has been solved. Parts that come one after another are a stage. A split that
 * waits is of the problem with the part, and there will be another without it. */
static void write_part(qs_recorder *r)
{
    qs_record_book *b = r->book;
    stage_writer w = {.sink = r->sink};
    if (!b->has_parts) {
        put_head(&w, QS_STAGE_PARTS, 0, 0, 0);
        r->stages++;
    }
    b->has_parts = true;
    b->pending = false;
    put(&w, b->exact.count, 4);
    put(&w, (uint64_t)b->exact.value, 8);
    for (uint32_t i = 0; i < b->exact.count; i++) {
        put(&w, b->exact.sites[i], 4);
    }
    end_writing(r, &w);
}

/* Lists the sites of a part of the model. Returns false if one is none of the file's problem. */
static bool list_part(qs_record_book *b, const uint32_t *cells, uint32_t count)
{
    bool known = count <= QS_EXACT_SITES && count <= b->stated.sites;
    b->exact.count = count;
    for (uint32_t i = 0; known && i < count; i++) {
        uint32_t site = b->site[cells[i]];
        known = site != NO_SITE && is_alive(&b->stated, site);
        b->exact.sites[i] = site;
    }
    return known;
}

static bool solve_part(void *context, const uint32_t *cells, uint32_t count)
{
    qs_recorder *r = context;
    qs_record_book *b = r->book;
    if (r->status != QS_OK || (!b->has_parts && !may_begin_stage(r)) ||
        !list_part(b, cells, count) || !qs_exact_order_find(&b->order, &b->exact) ||
        qs_exact_lay(&b->exact) != QS_EXACT_LAID ||
        qs_exact_cells(&b->exact) > QS_EXACT_ALL_CELLS - b->exact_cells) {
        return false;
    }
    b->exact_cells += qs_exact_cells(&b->exact);
    qs_exact_solve(&b->exact);
    qs_exact_settle(&b->exact);
    write_part(r);
    return true;
}

static void end_stage(void *context, const uint8_t *kept)
{
    qs_recorder *r = context;
    qs_record_book *b = r->book;
    const qs_stated *s = &b->stated;
    size_t labels = r->model->labels;
    bool leaves = false;
    for (uint32_t p = 0; p < s->sites; p++) {
        for (uint32_t a = 0; a < s->count[p]; a++) {
            size_t at = qs_stated_at(s, p, a);
            bool stays = !kept || kept[b->cell[p] * labels + b->name[at]] || !is_alive(s, p);
            b->sets[at] = s->kept[at] && stays;
            leaves = leaves || b->sets[at] != s->kept[at];
        }
    }
    if (leaves && r->status == QS_OK) {
        write_stage(r, true);
        memcpy(s->kept, b->sets, s->start[s->sites]);
        qs_stated_fold(&b->stated);
    }
}

qs_witness qs_recorder_witness(qs_recorder *recorder)
{
    return (qs_witness){begin_split, take_share, end_stage, solve_part, recorder};
}

qs_status qs_recorder_end(qs_recorder *recorder)
{
    if (!recorder) {
        return QS_E_ARGUMENT;
    }
    if (recorder->status == QS_OK && recorder->book->pending) {
        write_stage(recorder, false);
    }
    end_parts(recorder);
    if (recorder->status == QS_OK && recorder->stages == 0) {
        return QS_E_ENCODING;
    }
    return recorder->status;
}

/* ---- The file. ---- */

typedef struct certificate_parts {
    const qs_recorder *recorder;
    const uint16_t *labelling;
    const uint8_t *stages;
    size_t stages_size;
} certificate_parts;

static void put_problem(qs_writer *writer, const void *context)
{
    const certificate_parts *parts = context;
    uint8_t digest[QS_DIGEST_SIZE];
    qs_digest(parts->recorder->index->qubo->bytes, parts->recorder->index->qubo->size, digest);
    qs_put(writer, digest, sizeof digest);
}

static void put_best(qs_writer *writer, const void *context)
{
    const certificate_parts *parts = context;
    const qs_record_book *b = parts->recorder->book;
    unsigned bytes = label_bytes(&b->stated);
    qs_put_u32(writer, bytes);
    for (uint32_t p = 0; p < b->stated.sites; p++) {
        qs_put_unsigned(writer, label_named(b, p, parts->labelling[b->place[p]]), bytes);
    }
}

static void put_stages(qs_writer *writer, const void *context)
{
    const certificate_parts *parts = context;
    qs_put(writer, parts->stages, parts->stages_size);
}

static void put_chunks(qs_writer *writer, const void *context)
{
    const certificate_parts *parts = context;
    const qs_stated *s = &parts->recorder->book->stated;
    qs_put_chunk(writer, "PROB", QS_DIGEST_SIZE, put_problem, context);
    qs_put_chunk(writer, "BEST", QS_BEST_HEAD + (uint64_t)s->sites * label_bytes(s), put_best,
                 context);
    qs_put_chunk(writer, "STGS", parts->stages_size, put_stages, context);
}

qs_status qs_certificate_write(const qs_recorder *recorder, const uint16_t *labelling,
                               int64_t lower_bound, int64_t energy, const uint8_t *stages,
                               size_t stages_size, const qs_sink *sink, uint64_t *size)
{
    if (!recorder || !labelling || (!stages && stages_size > 0)) {
        return QS_E_ARGUMENT;
    }
    const qs_record_book *b = recorder->book;
    for (uint32_t p = 0; p < b->stated.sites; p++) {
        uint32_t name = labelling[b->place[p]];
        if (b->name[b->stated.start[p] + label_named(b, p, name)] != name) {
            return QS_E_ARGUMENT;
        }
    }
    uint8_t fields[QS_HEADER_OWN] = {0};
    qs_store_u32(fields, b->stated.sites);
    qs_store_u32(fields + 4, recorder->stages);
    qs_store_u64(fields + 8, (uint64_t)lower_bound);
    qs_store_u64(fields + 16, (uint64_t)energy);
    certificate_parts parts = {recorder, labelling, stages, stages_size};
    return qs_write_file(sink, QS_MAGIC_QPF, QS_QPF_CHUNK_COUNT, fields, put_chunks, &parts, size);
}
