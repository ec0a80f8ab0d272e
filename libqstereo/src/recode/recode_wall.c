/* Domain walls: u_i = [the site's label is its i-th or a higher one] (docs/MATHS.md). */
#include "../base/saturate.h"
#include "recoding.h"
#include "../base/sort.h"

/* First variable of a site: u_1. */
static uint32_t first_wall(const qs_left *left, uint32_t p)
{
    return left->start[p] - p;
}

static uint64_t bound(const qs_recoding *r, uint32_t p)
{
    const qs_left *left = &r->left;
    const qs_model *m = left->model;
    int64_t inner = 0;
    for (uint32_t i = left->start[p] + 1; i + 1 < left->start[p + 1]; i++) {
        inner = left->cost[i] > inner ? left->cost[i] : inner;
    }
    return qs_wall_bound(&m->pairwise, m->labels, r->gap, (uint64_t)inner, left->reach[p].weights);
}

/* Costs and kappa (1 - u_i) u_i+1, without its couplings. */
static void enter_sites(qs_recoding *r)
{
    const qs_left *left = &r->left;
    for (uint32_t p = 0; p < left->counts.open; p++) {
        uint32_t size = qs_left_size(left, p);
        const int64_t *cost = left->cost + left->start[p];
        int64_t *u = r->draft.linear + first_wall(left, p), kappa = (int64_t)bound(r, p);
        qs_draft_groups(&r->draft, 1, size - 1, 0, 0);
        qs_draft_add(&r->draft, &r->draft.offset, cost[0]);
        for (uint32_t i = 1; i < size; i++) {
            qs_draft_add(&r->draft, &u[i - 1], cost[i] - cost[i - 1] + (i > 1 ? kappa : 0));
        }
    }
}

/* What an edge costs each label of one site while the other has its first. */
static void add_edge(qs_recoding *r, const qs_edge *edge, bool first)
{
    const qs_left *left = &r->left;
    const qs_model *m = left->model;
    uint32_t p = first ? edge->first : edge->second,
             lowest = left->label[left->start[first ? edge->second : edge->first]];
    int64_t *u = r->draft.linear + first_wall(left, p);
    for (uint32_t i = left->start[p] + 1; i < left->start[p + 1]; i++) {
        uint32_t below = left->label[i - 1], here = left->label[i];
        int64_t rise =
            first ? qs_model_pairwise(m, here, lowest) - qs_model_pairwise(m, below, lowest)
                  : qs_model_pairwise(m, lowest, here) - qs_model_pairwise(m, lowest, below);
        qs_draft_add(&r->draft, &u[i - left->start[p] - 1], edge->weight * rise);
    }
}

static bool shorter(const void *context, uint32_t a, uint32_t b)
{
    return qs_left_size(context, a) < qs_left_size(context, b);
}

/* The chains: one block for each number of labels. */
static void couple_chains(qs_recoding *r)
{
    const qs_left *left = &r->left;
    uint32_t open = (uint32_t)left->counts.open, block = 0, size = 0;
    for (uint32_t p = 0; p < open; p++) {
        r->order[p] = p;
    }
    qs_sort(r->order, r->scratch, open, shorter, left);
    for (uint32_t i = 0; i < open; i++) {
        uint32_t p = r->order[i];
        if (qs_left_size(left, p) < 3) {
            continue; /* a single variable */
        }
        if (size != qs_left_size(left, p)) {
            size = qs_left_size(left, p);
            block = qs_add_block(r, (qs_block_of){QS_CHAIN_BLOCK, p, p});
        }
        qs_draft_couple(&r->draft, p, p, block, (int64_t)bound(r, p));
    }
}

void qs_recode_wall(qs_recoding *r)
{
    const qs_left *left = &r->left;
    enter_sites(r);
    for (uint64_t e = 0; e < left->counts.edges; e++) {
        const qs_edge *edge = &left->edges[e];
        uint32_t first = left->label[left->start[edge->first]],
                 second = left->label[left->start[edge->second]];
        qs_draft_add(&r->draft, &r->draft.offset,
                     edge->weight * qs_model_pairwise(left->model, first, second));
        add_edge(r, edge, true);
        add_edge(r, edge, false);
    }
    qs_number_sets(r);
    qs_couple_neighbours(r);
    couple_chains(r);
}
