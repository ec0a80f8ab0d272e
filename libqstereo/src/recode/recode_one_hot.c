/* One-hot, one-hot-sparse, and multiway-cut, which is one-hot with a terminal a label
 * (docs/MATHS.md). */
#include "../base/saturate.h"
#include "../problem/pairwise.h"
#include "recoding.h"

/* Copies the costs; returns the sum of each site's largest one. */
static uint64_t enter_costs(qs_recoding *r)
{
    const qs_left *left = &r->left;
    uint64_t sum = 0;
    for (uint32_t p = 0; p < left->counts.open; p++) {
        int64_t largest = 0;
        for (uint32_t i = left->start[p]; i < left->start[p + 1]; i++) {
            r->draft.linear[i] = left->cost[i];
            largest = left->cost[i] > largest ? left->cost[i] : largest;
        }
        qs_grow(&sum, 1, (uint64_t)largest);
    }
    return sum;
}

static uint64_t weight_sum(const qs_left *left)
{
    uint64_t sum = 0;
    for (uint64_t e = 0; e < left->counts.edges; e++) {
        sum += (uint64_t)left->edges[e].weight;
    }
    return sum;
}

/* The paper's alpha: above what any labelling costs. */
static uint64_t paper_alpha(const qs_left *left, uint64_t largest)
{
    uint64_t bound = largest;
    qs_grow(&bound, weight_sum(left), (uint64_t)left->model->pairwise_max);
    qs_grow(&bound, 1, left->constant > 0 ? (uint64_t)left->constant + 1 : 1);
    return bound;
}

void qs_recode_one_hot(qs_recoding *r)
{
    const qs_left *left = &r->left;
    const qs_model *m = left->model;
    uint64_t largest = enter_costs(r);
    if (r->penalty == QS_PENALTY_PAPER) {
        r->alpha = paper_alpha(left, largest);
    }
    for (uint32_t p = 0; p < left->counts.open; p++) {
        uint64_t a = r->alpha, b = 2 * r->alpha;
        if (qs_penalty_keeps_gap(r->penalty)) {
            qs_one_hot_bound(r->encoding, r->penalty, &m->pairwise, m->labels, r->gap,
                             left->reach[p], &a, &b);
        }
        qs_draft_groups(&r->draft, 1, qs_left_size(left, p), a, b);
    }
    qs_number_sets(r);
    qs_couple_neighbours(r);
    if (left->counts.whole && r->draft.block_count == 0) {
        qs_add_block(r, (qs_block_of){QS_PAIR_BLOCK, 0,
                                      0}); /* which a whole problem has also where it has no edge */
    }
    if (left->counts.whole) {
        r->draft.lattice = m->width > 0 ? 1 : UINT32_MAX; /* a grid's runs, a graph's list */
    }
    if (r->encoding == QS_ONE_HOT_SPARSE) {
        uint64_t edges = 0;
        qs_grow(&edges, weight_sum(left), qs_band(&m->pairwise, m->labels));
        qs_draft_add(&r->draft, &r->draft.offset, (int64_t)edges);
    }
}

/* ---- Multiway cut. ---- */

/* C(p, t) = K - cost: the capacity of the edge between a site and the terminal of a label that is
 * left to it, K being above the site's costs. */
static int64_t ceiling(const qs_left *left, uint32_t p)
{
    int64_t largest = 0;
    for (uint32_t i = left->start[p]; i < left->start[p + 1]; i++) {
        largest = left->cost[i] > largest ? left->cost[i] : largest;
    }
    return largest + 1;
}

/* The sum of C over a site's terminals. */
static uint64_t site_capacity(const qs_left *left, uint32_t p)
{
    uint64_t sum = 0;
    int64_t top = ceiling(left, p);
    for (uint32_t i = left->start[p]; i < left->start[p + 1]; i++) {
        qs_grow(&sum, 1, (uint64_t)(top - left->cost[i]));
    }
    return sum;
}

/* The sites' groups and penalties; the offset such that H is F: the cut of a labelling is F + sum_p
 * (sum_t C(p, t) - K). */
static void enter_sites(qs_recoding *r)
{
    const qs_left *left = &r->left;
    uint64_t capacities = weight_sum(left);
    for (uint32_t p = 0; p < left->counts.open; p++) {
        uint64_t capacity = site_capacity(left, p);
        qs_grow(&capacities, 1, capacity);
        qs_draft_add(&r->draft, &r->draft.offset, ceiling(left, p) - (int64_t)capacity);
    }
    if (r->penalty == QS_PENALTY_PAPER) {
        r->alpha = capacities + 1;
    }
    for (uint32_t p = 0; p < left->counts.open; p++) {
        uint64_t a = r->alpha, b = 2 * r->alpha;
        if (qs_penalty_keeps_gap(r->penalty)) {
            a = left->reach[p].most + r->gap;
            qs_grow(&a, 1, site_capacity(left, p));
            b = a + r->gap;
        }
        qs_draft_groups(&r->draft, 1, qs_left_size(left, p), a, b);
    }
}

/* The terminals, each bound to its own label; C of each is gathered in the linear terms, which come
 * to hold what binds it. */
static void enter_terminals(qs_recoding *r)
{
    const qs_left *left = &r->left;
    uint32_t labels = left->model->labels;
    int64_t *linear = r->draft.linear + left->counts.labels;
    for (uint32_t p = 0; p < left->counts.open; p++) {
        int64_t top = ceiling(left, p);
        for (uint32_t i = left->start[p]; i < left->start[p + 1]; i++) {
            size_t t = left->label[i];
            qs_draft_add(&r->draft, &linear[t * labels + t], top - left->cost[i]);
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

/* Sites of one set after another share a block. */
static void couple_terminals(qs_recoding *r)
{
    const qs_left *left = &r->left;
    uint32_t open = (uint32_t)left->counts.open, block = 0;
    for (uint32_t i = 0; i < open; i++) {
        uint32_t p = r->order[i];
        int64_t top = ceiling(left, p);
        if (i == 0 || r->set[p] != r->set[r->order[i - 1]]) {
            block = qs_add_block(r, (qs_block_of){QS_TERMINAL_BLOCK, p, p});
        }
        for (uint32_t n = left->start[p]; n < left->start[p + 1]; n++) {
            qs_draft_couple(&r->draft, p, open + left->label[n], block, top - left->cost[n]);
        }
    }
}

void qs_recode_multiway(qs_recoding *r)
{
    enter_sites(r);
    enter_terminals(r);
    qs_number_sets(r);
    couple_terminals(r);
    qs_couple_neighbours(r);
}
