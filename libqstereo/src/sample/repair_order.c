#include "../base/arena.h"
#include "../base/fraction.h"
#include "candidates.h"
#include "repair.h"
#include "site_code.h"

/* Take a random order of all labels and let each site have the first of its candidates in it. Then
 * the expected cost of a site is the mean over its candidates. Two neighbours differ with
 * probability 1 - m / u, where m candidates are common to both and u belong to either. The sum of
 * all this is not above H of the sample (docs/MATHS.md, Lemma R).
 *
 * The order is chosen label by label, such that the expectation over the rest of the order never
 * rises. If c is next, each site with the candidate c takes it, and the expectation changes by
 *
 *     delta_c =   sum over sites p with c of [cost_p(c) - mean_p]
 *               + sum over edges of weight * { -(1 - m / u) where both sites have c
 *                                            {  m / u       where one has it
 *
 * over the ambiguous sites, those with two candidates or more, and their edges. The mean of delta
 * over all c is 0, so the least delta is not above 0. A site that is no longer ambiguous has no
 * candidate in common with one that still is. */

typedef struct search {
    const qs_index *index;
    uint8_t *bits;
    qs_fraction *delta; /* of each label */
    int64_t *costs; /* of a site's labels by rank */
    uint32_t *holders; /* of each label: how many ambiguous sites have it as a candidate */
    uint8_t *own, *other; /* candidates of two sites, a byte for each label */
} search;

static search take_search(qs_arena *arena, const qs_index *index)
{
    uint32_t labels = index->qubo->labels.labels;
    return (search){
        .index = index,
        .delta = qs_arena_take(arena, labels, sizeof(qs_fraction)),
        .costs = qs_arena_take(arena, labels, sizeof(int64_t)),
        .holders = qs_arena_take(arena, labels, sizeof(uint32_t)),
        .own = qs_arena_take(arena, labels, 1),
        .other = qs_arena_take(arena, labels, 1),
    };
}

size_t qs_order_workspace(const qs_index *index)
{
    qs_arena arena = {0};
    take_search(&arena, index);
    return qs_arena_size(&arena);
}

static search begin(const qs_index *index, uint8_t *bits, void *workspace)
{
    qs_arena arena = {.base = workspace};
    search s = take_search(&arena, index);
    s.bits = bits;
    for (uint32_t d = 0; d < index->qubo->labels.labels; d++) {
        s.delta[d] = (qs_fraction){0, 0};
        s.holders[d] = 0;
    }
    return s;
}

/* Marks the candidates of a site; returns their number. */
static uint32_t mark_candidates(const search *s, uint32_t site, uint8_t *marks)
{
    qs_site of = qs_undecided_site(&s->index->qubo->labels, site);
    uint32_t rank = 0, count = 0;
    for (uint32_t d = 0; d < of.labels->labels; d++) {
        marks[d] = qs_site_has(&of, d) && qs_is_candidate(s->index, s->bits, site, rank++);
        count += marks[d];
    }
    return count;
}

/* The chain of a wall couples u_r-1 with u_r, which are both 1 from rank r on. */
static int64_t chain_cost(const search *s, uint32_t site, uint32_t rank)
{
    const qs_index *index = s->index;
    int64_t cost = 0;
    for (uint32_t n = index->near_start[site]; n < index->near_start[site + 1]; n++) {
        const qs_neighbour *near = &index->near[n];
        if (near->group == site) {
            cost += (int64_t)qs_index_block(index, near->block, rank - 2, rank - 1) * near->weight;
        }
    }
    return cost;
}

/* Takes out what an edge has put into the linear terms: its cost while the neighbour has its lowest
 * label. */
static void take_out_edge(const search *s, uint32_t site, const qs_neighbour *near)
{
    const qs_labels *labels = &s->index->qubo->labels;
    qs_site own = qs_undecided_site(labels, site), other = qs_undecided_site(labels, near->group);
    uint32_t label = qs_site_label_from(&own, 0), lowest = qs_site_label_from(&other, 0),
             first = label;
    for (uint32_t rank = 1; rank < qs_site_size(s->index, site); rank++) {
        label = qs_site_label_from(&own, label + 1);
        s->costs[rank] -= (int64_t)near->weight * ((label != lowest) - (first != lowest));
    }
}

/* The unary cost of each of a wall's labels, by rank, less that of rank 0. */
static void wall_costs(const search *s, uint32_t site)
{
    const qs_index *index = s->index;
    uint32_t from = index->start[site], size = qs_site_size(index, site);
    s->costs[0] = 0;
    for (uint32_t rank = 1; rank < size; rank++) {
        s->costs[rank] = s->costs[rank - 1] + qs_qubo_linear(index->qubo, from + rank - 1);
        if (rank > 1) {
            s->costs[rank] += chain_cost(s, site, rank);
        }
    }
    for (uint32_t n = index->near_start[site]; n < index->near_start[site + 1]; n++) {
        if (index->near[n].group != site) {
            take_out_edge(s, site, &index->near[n]);
        }
    }
}

static void take_costs(const search *s, uint32_t site)
{
    uint32_t from = s->index->start[site];
    if (qs_is_wall(s->index)) {
        wall_costs(s, site);
        return;
    }
    for (uint32_t i = from; i < s->index->start[site + 1]; i++) {
        s->costs[i - from] = qs_qubo_linear(s->index->qubo, i);
    }
}

static void change(qs_fraction *delta, qs_fraction by, bool add)
{
    *delta = add ? qs_plus(*delta, by) : qs_minus(*delta, by);
}

/* A site's own terms, its candidates being marked. */
static void change_site(const search *s, uint32_t site, uint32_t count, bool add)
{
    qs_site of = qs_undecided_site(&s->index->qubo->labels, site);
    qs_fraction mean = {0, 0};
    int64_t rest = 0;
    uint32_t rank = 0;
    take_costs(s, site);
    for (uint32_t d = qs_site_label_from(&of, 0); d < of.labels->labels;
         d = qs_site_label_from(&of, d + 1), rank++) {
        mean.whole += s->own[d] ? s->costs[rank] / (int64_t)count : 0;
        rest += s->own[d] ? s->costs[rank] % (int64_t)count : 0;
    }
    mean = qs_plus(mean, qs_share(rest, 1, count));
    rank = 0;
    for (uint32_t d = qs_site_label_from(&of, 0); d < of.labels->labels;
         d = qs_site_label_from(&of, d + 1), rank++) {
        if (s->own[d]) {
            change(&s->delta[d], qs_minus((qs_fraction){s->costs[rank], 0}, mean), add);
            s->holders[d] += add ? 1 : UINT32_MAX;
        }
    }
}

/* An edge's terms, the candidates of both ends being marked. */
static void change_edge(const search *s, uint32_t own_count, uint32_t other_count, int64_t weight,
                        bool add)
{
    uint32_t labels = s->index->qubo->labels.labels, common = 0;
    for (uint32_t d = 0; d < labels; d++) {
        common += s->own[d] & s->other[d];
    }
    int64_t either = (int64_t)own_count + other_count - common;
    qs_fraction alike = qs_share(weight, common, either),
                unlike = qs_share(weight, either - common, either);
    if (common == 0) {
        return;
    }
    for (uint32_t d = 0; d < labels; d++) {
        if (s->own[d] & s->other[d]) {
            change(&s->delta[d], unlike, !add);
        } else if (s->own[d] | s->other[d]) {
            change(&s->delta[d], alike, add);
        }
    }
}

/* All terms of an ambiguous site and of its edges. The edge to a lower-numbered neighbour is left
 * out if that neighbour changes its terms: if it is ambiguous and has the candidate `label` (the
 * number of labels = any). */
static void change_terms(const search *s, uint32_t site, uint32_t label, bool add)
{
    const qs_index *index = s->index;
    uint32_t labels = index->qubo->labels.labels, count = mark_candidates(s, site, s->own);
    change_site(s, site, count, add);
    for (uint32_t n = index->near_start[site]; n < index->near_start[site + 1]; n++) {
        const qs_neighbour *near = &index->near[n];
        if (near->group == site) {
            continue;
        }
        uint32_t others = mark_candidates(s, near->group, s->other);
        bool seen = near->group < site && others > 1 && (label == labels || s->other[label]);
        if (!seen) {
            change_edge(s, count, others, near->weight, add);
        }
    }
}

/* The label of least delta among the candidates of ambiguous sites; the number of labels where no
 * site is ambiguous. */
static uint32_t best_label(const search *s)
{
    uint32_t labels = s->index->qubo->labels.labels, best = labels;
    for (uint32_t d = 0; d < labels; d++) {
        if (s->holders[d] > 0 && (best == labels || qs_less(s->delta[d], s->delta[best]))) {
            best = d;
        }
    }
    return best;
}

/* Returns true if a site is ambiguous and has the candidate, whose rank is put into `rank`. */
static bool takes(const search *s, uint32_t site, uint32_t label, uint32_t *rank)
{
    qs_site of = qs_undecided_site(&s->index->qubo->labels, site);
    if (!qs_site_has(&of, label)) {
        return false;
    }
    *rank = qs_site_rank(&of, label);
    return qs_is_candidate(s->index, s->bits, site, *rank) &&
           qs_candidates(s->index, s->bits, site) > 1;
}

void qs_repair_order(const qs_index *index, uint8_t *bits, void *workspace)
{
    search s = begin(index, bits, workspace);
    uint32_t labels = index->qubo->labels.labels, groups = index->qubo->groups, rank;
    for (uint32_t p = 0; p < groups; p++) {
        if (qs_candidates(index, bits, p) > 1) {
            change_terms(&s, p, labels, true);
        }
    }
    for (uint32_t c = best_label(&s); c < labels; c = best_label(&s)) {
        for (uint32_t p = 0; p < groups; p++) {
            if (takes(&s, p, c, &rank)) {
                change_terms(&s, p, c, false);
            }
        }
        for (uint32_t p = 0; p < groups; p++) {
            if (takes(&s, p, c, &rank)) {
                qs_choose_candidate(index, bits, p, rank);
            }
        }
    }
}
