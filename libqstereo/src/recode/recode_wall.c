/* Domain walls: u_i = 1 where the label of the site is the i-th left to it or a higher one, counted
 * from 0 (docs/MATHS.md). */
#include "../base/minmax.h"
#include "../base/sort.h"
#include "../model/edge_value.h"
#include "recoder.h"

/* First variable of a site: u_1. */
static uint32_t first_wall(const qs_remaining *rest, uint32_t p)
{
    return rest->start[p] - p;
}

/* kappa of a site. */
static uint64_t bound(const qs_recoder *r, uint32_t p)
{
    const qs_remaining *rest = &r->rest;
    const qs_model *m = rest->model;
    int64_t inner = 0;
    if (r->first_choice) {
        return (uint64_t)qs_kappa_of_values(r, p);
    }
    for (uint32_t i = rest->start[p] + 1; i + 1 < rest->start[p + 1]; i++) {
        inner = qs_max_i64(inner, rest->cost[i]);
    }
    return qs_wall_bound(&m->pairwise, m->labels, r->gap, (uint64_t)inner, rest->reach[p].weights);
}

/* The groups, the costs, and the linear part of kappa (1 - u_i) u_i+1. */
static void enter_sites(qs_recoder *r)
{
    const qs_remaining *rest = &r->rest;
    for (uint32_t p = 0; p < rest->counts.undecided; p++) {
        uint32_t size = qs_remaining_size(rest, p);
        const int64_t *cost = rest->cost + rest->start[p];
        int64_t *u = r->draft.linear + first_wall(rest, p), kappa = (int64_t)bound(r, p);
        qs_draft_groups(&r->draft, 1, size - 1, 0, 0);
        qs_draft_add(&r->draft, &r->draft.offset, cost[0]);
        for (uint32_t i = 1; i < size; i++) {
            qs_draft_add(&r->draft, &u[i - 1], cost[i] - cost[i - 1] + (i > 1 ? kappa : 0));
        }
    }
}

/* Adds to one site of an edge what the edge costs while the other site has its lowest label. */
static void add_edge(qs_recoder *r, const qs_remaining_edge *edge, bool first)
{
    const qs_remaining *rest = &r->rest;
    const qs_model *m = rest->model;
    uint32_t p = first ? edge->first : edge->second,
             lowest = rest->label[rest->start[first ? edge->second : edge->first]];
    int64_t *u = r->draft.linear + first_wall(rest, p);
    for (uint32_t i = rest->start[p] + 1; i < rest->start[p + 1]; i++) {
        uint32_t below = rest->label[i - 1], here = rest->label[i];
        int64_t rise = first ? qs_edge_value(m, edge->edge, here, lowest) -
                                   qs_edge_value(m, edge->edge, below, lowest)
                             : qs_edge_value(m, edge->edge, lowest, here) -
                                   qs_edge_value(m, edge->edge, lowest, below);
        qs_draft_add(&r->draft, &u[i - rest->start[p] - 1], edge->weight * rise);
    }
}

static bool shorter(const void *context, uint32_t a, uint32_t b)
{
    return qs_remaining_size(context, a) < qs_remaining_size(context, b);
}

/* The quadratic part of kappa (1 - u_i) u_i+1: one block for each number of labels. */
static void couple_chains(qs_recoder *r)
{
    const qs_remaining *rest = &r->rest;
    uint32_t sites = (uint32_t)rest->counts.undecided, block = 0, size = 0;
    for (uint32_t p = 0; p < sites; p++) {
        r->order[p] = p;
    }
    qs_sort(r->order, r->scratch, sites, shorter, rest);
    for (uint32_t i = 0; i < sites; i++) {
        uint32_t p = r->order[i];
        if (qs_remaining_size(rest, p) < 3) {
            continue; /* a single variable */
        }
        if (size != qs_remaining_size(rest, p)) {
            size = qs_remaining_size(rest, p);
            block = qs_add_block(r, (qs_block_of){QS_CHAIN_BLOCK, p, p, 0});
        }
        qs_draft_couple(&r->draft, p, p, block, (int64_t)bound(r, p));
    }
}

void qs_recode_wall(qs_recoder *r)
{
    const qs_remaining *rest = &r->rest;
    qs_number_sets(r);
    if (r->first_choice) {
        qs_find_kappa(r);
    }
    enter_sites(r);
    for (uint64_t e = 0; e < rest->counts.edges; e++) {
        const qs_remaining_edge *edge = &rest->edges[e];
        uint32_t first = rest->label[rest->start[edge->first]],
                 second = rest->label[rest->start[edge->second]];
        qs_draft_add(&r->draft, &r->draft.offset,
                     edge->weight * qs_edge_value(rest->model, edge->edge, first, second));
        add_edge(r, edge, true);
        add_edge(r, edge, false);
    }
    qs_couple_neighbours(r);
    couple_chains(r);
}
