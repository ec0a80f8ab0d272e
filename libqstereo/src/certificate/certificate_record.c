#include "record_book.h"

#include <string.h>

#include "../../include/qstereo/limits.h"
#include "../base/arena.h"
#include "../base/minmax.h"
#include "../qubo/sites.h"
#include "certificate_layout.h"

/* Of all searches, also of those that come to nothing: a part may be tried again and again. */
#define SEARCH_TRIES (2 * QS_SEARCH_WORK)

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
    b->claimed = qs_arena_take(&arena, labels, 1);
    b->sets = qs_arena_take(&arena, labels, 1);
    b->stage = qs_arena_take(&arena, sites, sizeof *b->stage);
    b->due = qs_arena_take(&arena, sites, 1);
    b->costs = qs_arena_take(&arena, labels, sizeof *b->costs);
    qs_exact_take(&b->exact, &b->stated, &arena);
    qs_exact_order_take(&b->order, &b->stated, &arena);
    qs_search_take(&b->search, &b->exact, &arena);
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
    memset(b->site, 0xff, sizeof *b->site * model->sites); /* QS_NO_SITE */
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

/* The slots of a site of a graph, which are numbered in a file by 2 bytes at most. */
static bool slots_fit(const qs_model *model)
{
    uint32_t most = 0;
    for (uint32_t p = 0; model->width == 0 && p < model->sites; p++) {
        uint32_t earlier, later;
        count_links(model, p, &earlier, &later);
        most = qs_max_u32(most, qs_max_u32(earlier, later));
    }
    return most <= UINT16_MAX + 1u;
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
    (void)take_parts(&book, index, model, workspace);
    qs_stated_read(&book->stated);
    if (has_double_edges(book)) {
        return QS_E_ENCODING;
    }
    if (!slots_fit(model)) {
        return QS_E_LIMIT;
    }
    qs_stated_fold_all(&book->stated);
    place_sites(book, model);
    book->pending = false;
    book->unended = 0;
    book->exact_cells = 0;
    book->search_work = QS_SEARCH_WORK;
    book->search_tries = SEARCH_TRIES;
    *recorder = (qs_recorder){.index = index, .model = model, .sink = stages, .book = book};
    return QS_OK;
}

/* ---- As a witness. ---- */

/* Lists the sites of a part of the model. Returns false if one is none of the file's problem. */
static bool list_part(qs_record_book *b, const uint32_t *cells, uint32_t count)
{
    bool known = count <= QS_EXACT_SITES && count <= b->stated.sites;
    b->exact.count = count;
    for (uint32_t i = 0; known && i < count; i++) {
        uint32_t site = b->site[cells[i]];
        known = site != QS_NO_SITE && qs_record_is_open(&b->stated, site);
        b->exact.sites[i] = site;
    }
    return known;
}

static bool solve_by_tables(qs_recorder *r)
{
    qs_record_book *b = r->book;
    if (!qs_exact_order_find(&b->order, &b->exact) || qs_exact_lay(&b->exact) != QS_EXACT_LAID ||
        qs_exact_cells(&b->exact) > QS_EXACT_ALL_CELLS - b->exact_cells ||
        !qs_record_may_add(r, QS_STAGE_PARTS)) {
        return false;
    }
    b->exact_cells += qs_exact_cells(&b->exact);
    qs_exact_solve(&b->exact);
    qs_exact_settle(&b->exact);
    qs_record_part(r, QS_STAGE_PARTS);
    return true;
}

/* Finds the least energies of all suffixes. Returns false if that is too much work. */
static bool search_part(qs_record_book *b)
{
    qs_search *x = &b->search;
    uint64_t allowed = qs_min_u64(b->search_work, b->search_tries);
    bool found = true;
    x->work = allowed;
    for (uint32_t i = b->exact.count; found && i-- > 0;) {
        x->least[i] = QS_ENERGY_MAX;
        found = qs_search_suffix(x, i);
    }
    b->search_tries -= allowed - x->work;
    b->search_work -= found ? allowed - x->work : 0;
    return found;
}

static bool solve_by_search(qs_recorder *r)
{
    qs_record_book *b = r->book;
    if (b->exact.count > QS_SEARCH_SITES) {
        return false;
    }
    qs_search_order(&b->search);
    if (!qs_search_lay(&b->search) || !search_part(b) || !qs_record_may_add(r, QS_STAGE_SEARCHES)) {
        return false;
    }
    b->exact.value = b->search.least[0] + b->search.edges_least;
    qs_exact_close(&b->exact);
    qs_record_part(r, QS_STAGE_SEARCHES);
    return true;
}

/* A search finds no labels. */
static bool solve_part(void *context, const uint32_t *cells, uint32_t count, bool labels)
{
    qs_recorder *r = context;
    qs_record_book *b = r->book;
    bool known = r->status == QS_OK && list_part(b, cells, count);
    bool solved = known && (solve_by_tables(r) ||
                            (!labels && list_part(b, cells, count) && solve_by_search(r)));
    bool wide = count > QS_EXACT_SITES;
    r->has_refused = r->has_refused || wide || (known && !solved);
    return solved;
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
            bool stays =
                !kept || kept[b->cell[p] * labels + b->name[at]] || !qs_record_is_open(s, p);
            b->claimed[at] = s->kept[at] && stays;
            leaves = leaves || b->claimed[at] != s->kept[at];
        }
    }
    if (leaves && r->status == QS_OK) {
        qs_record_leave(r);
    }
    b->told = true;
}

/* The addresses of functions of other files would need a table of the linker. */
static void take_split(void *context, const qs_model *model, unsigned shift,
                       const uint16_t *labelling)
{
    qs_record_split(context, model, shift, labelling);
}

static void take_share(void *context, const qs_model *model, uint32_t cell, uint32_t chain,
                       const void *share, unsigned bytes)
{
    qs_record_share(context, model, cell, chain, share, bytes);
}

qs_witness qs_recorder_witness(qs_recorder *recorder)
{
    return (qs_witness){take_split, take_share, end_stage, solve_part, recorder};
}

qs_status qs_recorder_end(qs_recorder *recorder)
{
    if (!recorder) {
        return QS_E_ARGUMENT;
    }
    if (recorder->status == QS_OK && recorder->book->pending) {
        qs_record_stage(recorder, false);
    }
    qs_record_end_stage(recorder);
    recorder->has_refused = recorder->has_refused && recorder->book->stated.open_count > 0;
    if (recorder->status == QS_OK && recorder->stages == 0) {
        return QS_E_ENCODING;
    }
    return recorder->status;
}
