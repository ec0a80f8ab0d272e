#include "record_book.h"

#include <string.h>

#include "../base/minmax.h"
#include "../base/saturate.h"
#include "certificate_layout.h"

/* ---- The slots of a split. ---- */

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

/* The chain of TRW-S that an edge belongs to at the site of a cell. */
static uint32_t chain_of(const qs_model *model, uint32_t cell, uint32_t other)
{
    return model->width > 0 ? !is_row(model, qs_min_u32(cell, other), qs_max_u32(cell, other))
                            : rank_of(model, cell, other);
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

void qs_record_split(qs_recorder *r, const qs_model *model, unsigned shift,
                     const uint16_t *labelling)
{
    qs_record_book *b = r->book;
    const qs_stated *s = &b->stated;
    size_t at = 0;
    b->pending = true;
    b->told = false;
    b->shift = shift;
    memset(b->slots, 0, sizeof *b->slots * s->sites);
    if (model->width > 0) {
        find_grid_slots(b, model);
    } else {
        find_graph_slots(b, model);
    }
    for (uint32_t p = 0; p < s->sites; p++) {
        b->labelling[p] = qs_record_label(b, p, labelling[b->cell[p]]);
        b->share_at[p] = at;
        at += qs_record_is_open(s, p) ? (size_t)(b->slots[p] - 1) * s->count[p] : 0;
    }
    memset(b->shares, 0, sizeof *b->shares * at);
}

/* ---- The shares of a split. ---- */

/* The slot of the file that a chain of the model is at a site, if it has a share of its own. */
static bool slot_with_share(const qs_record_book *b, uint32_t site, uint32_t chain, uint32_t *slot)
{
    *slot = chain;
    return qs_record_is_open(&b->stated, site) && chain + 1 < b->slots[site];
}

static int64_t number_at(const void *numbers, unsigned bytes, uint32_t at)
{
    return bytes == 4 ? ((const int32_t *)numbers)[at] : ((const int64_t *)numbers)[at];
}

/* The costs of an edge in the file are those in the model and, for each label of either site, a
 * number more: a domain wall has put them into the site's own costs. Subtracts them, scaled, from
 * the share of the edge's chain. */
static bool move_costs(const qs_record_book *b, const qs_model *model, const qs_stated_edge *edge,
                       uint32_t site, int64_t *share)
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
        if (qs_absolute(more) > (uint64_t)QS_MOST_SHARE >> b->shift) {
            return false;
        }
        share[a] -= more * ((int64_t)1 << b->shift);
    }
    return true;
}

/* A chain of the model may have an edge that is no longer alive: its costs were too large to become
 * costs of the other site there. Adds them, scaled, to the share. */
static bool add_settled(const qs_record_book *b, const qs_model *model, const qs_stated_edge *edge,
                        uint32_t site, int64_t *share)
{
    const qs_stated *s = &b->stated;
    uint32_t other = qs_stated_other(edge, site), one = b->cell[edge->first],
             two = b->cell[edge->second], number = edge_number(model, one, two);
    int64_t weight = weight_of(model, one, two);
    uint32_t fixed = b->name[qs_stated_at(s, other, s->fixed[other])];
    for (uint32_t a = 0; a < s->count[site]; a++) {
        uint32_t own = b->name[qs_stated_at(s, site, a)];
        int64_t cost =
            weight * (edge->first == site ? qs_model_edge_pairwise(model, number, own, fixed)
                                          : qs_model_edge_pairwise(model, number, fixed, own));
        if (cost > QS_MOST_SHARE >> b->shift) {
            return false;
        }
        share[a] += cost * ((int64_t)1 << b->shift);
    }
    return true;
}

static bool add_all_settled(const qs_record_book *b, const qs_model *model, uint32_t site,
                            uint32_t chain, int64_t *share)
{
    const qs_stated *s = &b->stated;
    bool fits = true;
    for (uint32_t n = s->near_start[site]; fits && n < s->near_start[site + 1]; n++) {
        const qs_stated_edge *edge = &s->edges[s->near[n]];
        uint32_t other = qs_stated_other(edge, site);
        bool goes_on = !edge->alive && s->settled[other] == QS_HAS_ONE_LABEL &&
                       weight_of(model, b->cell[edge->first], b->cell[edge->second]) > 0;
        fits = !goes_on || chain_of(model, b->cell[site], b->cell[other]) != chain ||
               add_settled(b, model, edge, site, share);
    }
    return fits;
}

void qs_record_share(qs_recorder *r, const qs_model *model, uint32_t cell, uint32_t chain,
                     const void *share, unsigned bytes)
{
    qs_record_book *b = r->book;
    const qs_stated *s = &b->stated;
    uint32_t site = b->site[cell], slot;
    if (!b->pending || site == QS_NO_SITE || !slot_with_share(b, site, chain, &slot)) {
        return;
    }
    int64_t *own = b->shares + b->share_at[site] + (size_t)slot * s->count[site];
    for (uint32_t a = 0; a < s->count[site]; a++) {
        size_t at = qs_stated_at(s, site, a);
        own[a] = s->kept[at] ? number_at(share, bytes, b->name[at]) : 0;
        if (own[a] < -QS_MOST_SHARE || own[a] > QS_MOST_SHARE) {
            r->status = QS_E_OVERFLOW;
            return;
        }
    }
    if (!add_all_settled(b, model, site, chain, own)) {
        r->status = QS_E_OVERFLOW;
    }
    if (b->stated.index->qubo->labels.encoding != QS_DOMAIN_WALL) {
        return; /* there it is one number for all labels of an edge */
    }
    for (uint32_t n = s->near_start[site]; n < s->near_start[site + 1]; n++) {
        const qs_stated_edge *edge = &s->edges[s->near[n]];
        if (!edge->alive) {
            continue; /* it has no slots */
        }
        uint32_t there =
            edge->first == site ? b->first_slot[s->near[n]] : b->second_slot[s->near[n]];
        if (there == slot && !move_costs(b, model, edge, site, own)) {
            r->status = QS_E_OVERFLOW;
        }
    }
}
