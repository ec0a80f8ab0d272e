/* One-hot and one-hot-sparse; and multiway-cut, which is one-hot with a terminal for each label
 * (docs/MATHS.md). */
#include "../base/minmax.h"
#include "../base/saturate.h"
#include "../model/edge_value.h"
#include "../problem/pairwise.h"
#include "recoder.h"

/* Copies the costs; returns the sum of each site's largest one. */
static uint64_t enter_costs(qs_recoder *r)
{
    const qs_remaining *rest = &r->rest;
    uint64_t sum = 0;
    for (uint32_t p = 0; p < rest->counts.undecided; p++) {
        int64_t largest = 0;
        for (uint32_t i = rest->start[p]; i < rest->start[p + 1]; i++) {
            r->draft.linear[i] = rest->cost[i];
            largest = qs_max_i64(largest, rest->cost[i]);
        }
        qs_grow(&sum, 1, (uint64_t)largest);
    }
    return sum;
}

static uint64_t weight_sum(const qs_remaining *rest)
{
    uint64_t sum = 0;
    for (uint64_t e = 0; e < rest->counts.edges; e++) {
        sum += (uint64_t)rest->edges[e].weight;
    }
    return sum;
}

/* What all edges together can cost. */
static uint64_t edge_sum(const qs_remaining *rest)
{
    uint64_t sum = 0;
    for (uint64_t e = 0; e < rest->counts.edges; e++) {
        const qs_remaining_edge *edge = &rest->edges[e];
        qs_grow(&sum, (uint64_t)edge->weight, (uint64_t)qs_edge_most(rest->model, edge->edge));
    }
    return sum;
}

/* The paper's alpha: above what any labelling costs. */
static uint64_t paper_alpha(const qs_remaining *rest, uint64_t largest)
{
    uint64_t bound = largest;
    qs_grow(&bound, 1, edge_sum(rest));
    qs_grow(&bound, 1, (uint64_t)qs_max_i64(rest->constant, 0) + 1);
    return bound;
}

/* The sites' groups and penalties. */
static void enter_groups(qs_recoder *r)
{
    const qs_remaining *rest = &r->rest;
    const qs_model *m = rest->model;
    for (uint32_t p = 0; p < rest->counts.undecided; p++) {
        uint64_t a = r->alpha, b = 2 * r->alpha;
        if (qs_penalty_keeps_gap(r->penalty)) {
            qs_one_hot_bound(r->encoding, r->penalty, &m->pairwise, m->labels, r->gap,
                             rest->reach[p], &a, &b);
        }
        qs_draft_groups(&r->draft, 1, qs_remaining_size(rest, p), a, b);
    }
}

/* A whole problem is written as qs_encode writes it, to the byte: it has a block also where it has
 * no edge (but for tables of edges), and its couplings are lattices in a grid and a list in any
 * other graph. */
static void match_encode(qs_recoder *r)
{
    if (r->draft.block_count == 0 && !r->rest.model->tables) {
        qs_add_block(r, (qs_block_of){QS_PAIR_BLOCK, 0, 0, 0});
    }
    r->draft.lattice = r->rest.model->width > 0 ? 1 : UINT32_MAX;
}

void qs_recode_one_hot(qs_recoder *r)
{
    const qs_remaining *rest = &r->rest;
    const qs_model *m = rest->model;
    uint64_t largest = enter_costs(r);
    if (r->penalty == QS_PENALTY_PAPER) {
        r->alpha = paper_alpha(rest, largest);
    }
    enter_groups(r);
    qs_number_sets(r);
    qs_couple_neighbours(r);
    if (rest->counts.whole) {
        match_encode(r);
    }
    if (r->encoding == QS_ONE_HOT_SPARSE) {
        uint64_t edges = 0;
        qs_grow(&edges, weight_sum(rest), qs_band(&m->pairwise, m->labels));
        qs_draft_add(&r->draft, &r->draft.offset, (int64_t)edges);
    }
}

/* ---- Multiway cut. ---- */

/* K of a site: one more than its largest cost. The edge between a site p and the terminal t of a
 * label left to it has the capacity C(p, t) = K - cost. */
static int64_t ceiling(const qs_remaining *rest, uint32_t p)
{
    int64_t largest = 0;
    for (uint32_t i = rest->start[p]; i < rest->start[p + 1]; i++) {
        largest = qs_max_i64(largest, rest->cost[i]);
    }
    return largest + 1;
}

/* The sum of C over a site's terminals. */
static uint64_t site_capacity(const qs_remaining *rest, uint32_t p)
{
    uint64_t sum = 0;
    int64_t top = ceiling(rest, p);
    for (uint32_t i = rest->start[p]; i < rest->start[p + 1]; i++) {
        qs_grow(&sum, 1, (uint64_t)(top - rest->cost[i]));
    }
    return sum;
}

/* The groups and penalties of the sites, and the offset that makes H equal F: the cut of a
 * labelling is F + sum_p (sum_t C(p, t) - K). */
static void enter_sites(qs_recoder *r)
{
    const qs_remaining *rest = &r->rest;
    uint64_t capacities = weight_sum(rest);
    for (uint32_t p = 0; p < rest->counts.undecided; p++) {
        uint64_t capacity = site_capacity(rest, p);
        qs_grow(&capacities, 1, capacity);
        qs_draft_add(&r->draft, &r->draft.offset, ceiling(rest, p) - (int64_t)capacity);
    }
    if (r->penalty == QS_PENALTY_PAPER) {
        r->alpha = capacities + 1;
    }
    for (uint32_t p = 0; p < rest->counts.undecided; p++) {
        uint64_t a = r->alpha, b = 2 * r->alpha;
        if (qs_penalty_keeps_gap(r->penalty)) {
            a = rest->reach[p].most + r->gap;
            qs_grow(&a, 1, site_capacity(rest, p));
            b = a + r->gap;
        }
        qs_draft_groups(&r->draft, 1, qs_remaining_size(rest, p), a, b);
    }
}

/* The groups and penalties of the terminals, and the linear terms that bind each to its own label.
 * First the linear term of a terminal's own label holds the sum of its C, for the penalty. */
static void enter_terminals(qs_recoder *r)
{
    const qs_remaining *rest = &r->rest;
    uint32_t labels = rest->model->labels;
    int64_t *linear = r->draft.linear + rest->counts.labels;
    for (uint32_t p = 0; p < rest->counts.undecided; p++) {
        int64_t top = ceiling(rest, p);
        for (uint32_t i = rest->start[p]; i < rest->start[p + 1]; i++) {
            size_t t = rest->label[i];
            qs_draft_add(&r->draft, &linear[t * labels + t], top - rest->cost[i]);
        }
    }
    for (size_t t = 0; t < labels; t++) {
        uint64_t a =
            qs_penalty_keeps_gap(r->penalty) ? (uint64_t)linear[t * labels + t] + r->gap : r->alpha;
        uint64_t b = qs_penalty_keeps_gap(r->penalty) ? a + r->gap : 2 * a;
        for (size_t d = 0; d < labels; d++) {
            linear[t * labels + d] = d == t ? 0 : (int64_t)a;
        }
        qs_draft_groups(&r->draft, 1, labels, a, b);
    }
}

/* Sites with the same label set share a block; in `order` they stand one after another. */
static void couple_terminals(qs_recoder *r)
{
    const qs_remaining *rest = &r->rest;
    uint32_t sites = (uint32_t)rest->counts.undecided, block = 0;
    for (uint32_t i = 0; i < sites; i++) {
        uint32_t p = r->order[i];
        int64_t top = ceiling(rest, p);
        if (i == 0 || r->set[p] != r->set[r->order[i - 1]]) {
            block = qs_add_block(r, (qs_block_of){QS_TERMINAL_BLOCK, p, p, 0});
        }
        for (uint32_t n = rest->start[p]; n < rest->start[p + 1]; n++) {
            qs_draft_couple(&r->draft, p, sites + rest->label[n], block, top - rest->cost[n]);
        }
    }
}

void qs_recode_multiway(qs_recoder *r)
{
    enter_sites(r);
    enter_terminals(r);
    qs_number_sets(r);
    couple_terminals(r);
    qs_couple_neighbours(r);
}
