#include <string.h>

#include "candidates.h"
#include "../base/fraction.h"
#include "repair.h"
#include "site_code.h"

/* Let a random order of all labels decide, each site taking the first of its candidates. Then a
 * site's cost is expected to be the mean over its candidates, and two neighbours to differ with
 * probability 1 - m / u, where m candidates are common to both and u to either; the sum is not
 * above H of the sample (docs/MATHS.md, Lemma R). The order is chosen label by label such that what
 * is expected of the rest does not rise: if c comes next, each site with the candidate c takes it,
 * and the expectation changes by
 *
 *     delta_c = sum over p with c of [cost_p(c) - mean_p] + sum over edges of weight * { -(1 - m /
 * u) where both have c, m / u where one has }
 *
 * over the undecided sites, those that have two candidates or more, and their edges. The mean of
 * delta over all c is 0, so the least is not above it. A neighbour that has been decided has no
 * candidate in common with who has not been. */

typedef struct search {
    const qs_index *index;
    uint8_t *bits;
    qs_fraction *delta; /* of each label */
    int64_t *costs; /* of a site's labels by rank */
    uint32_t *holders; /* of each label: the undecided sites that have it as a candidate */
    uint8_t *own, *other; /* candidates of two sites, a byte a label */
} search;

uint64_t qs_order_workspace(const qs_index *index)
{
    return (sizeof(qs_fraction) + sizeof(int64_t) + sizeof(uint32_t) + 2) *
           (uint64_t)index->qubo->labels.labels;
}

static search lay_out(const qs_index *index, uint8_t *bits, void *workspace)
{
    uint32_t labels = index->qubo->labels.labels;
    search s = {.index = index, .bits = bits, .delta = workspace};
    s.costs = (int64_t *)(void *)(s.delta + labels);
    s.holders = (uint32_t *)(void *)(s.costs + labels);
    s.own = (uint8_t *)(s.holders + labels);
    s.other = s.own + labels;
    memset(s.delta, 0, sizeof *s.delta * labels);
    memset(s.holders, 0, sizeof *s.holders * labels);
    return s;
}

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

/* The cost of each of a wall's labels, by rank, less that of rank 0: what the chain and the edges
 * have put into the linear terms is taken out again. */
static void wall_costs(const search *s, uint32_t site)
{
    const qs_index *index = s->index;
    uint32_t from = index->start[site], size = qs_site_size(index, site);
    s->costs[0] = 0;
    for (uint32_t rank = 1; rank < size; rank++) {
        s->costs[rank] = s->costs[rank - 1] + qs_qubo_linear(index->qubo, from + rank - 1);
        for (uint32_t n = index->near_start[site]; rank > 1 && n < index->near_start[site + 1];
             n++) {
            const qs_neighbour *near = &index->near[n];
            s->costs[rank] +=
                near->group == site
                    ? (int64_t)qs_index_block(index, near->block, rank - 2, rank - 1) * near->weight
                    : 0;
        }
    }
    qs_site own = qs_undecided_site(&index->qubo->labels, site);
    for (uint32_t n = index->near_start[site]; n < index->near_start[site + 1]; n++) {
        const qs_neighbour *near = &index->near[n];
        qs_site other = qs_undecided_site(&index->qubo->labels, near->group);
        uint32_t label = qs_site_label(&own, 0), lowest = qs_site_label(&other, 0), first = label;
        for (uint32_t rank = 1; near->group != site && rank < size; rank++) {
            label = qs_site_label(&own, label + 1);
            s->costs[rank] -= (int64_t)near->weight * ((label != lowest) - (first != lowest));
        }
    }
}

static void take_costs(const search *s, uint32_t site)
{
    uint32_t from = s->index->start[site];
    if (s->index->qubo->labels.encoding == QS_DOMAIN_WALL) {
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
    for (uint32_t d = qs_site_label(&of, 0); d < of.labels->labels;
         d = qs_site_label(&of, d + 1), rank++) {
        mean.whole += s->own[d] ? s->costs[rank] / (int64_t)count : 0;
        rest += s->own[d] ? s->costs[rank] % (int64_t)count : 0;
    }
    mean = qs_plus(mean, qs_share(rest, 1, count));
    rank = 0;
    for (uint32_t d = qs_site_label(&of, 0); d < of.labels->labels;
         d = qs_site_label(&of, d + 1), rank++) {
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
    for (uint32_t d = 0; common > 0 && d < labels; d++) {
        if (s->own[d] & s->other[d]) {
            change(&s->delta[d], unlike, !add);
        } else if (s->own[d] | s->other[d]) {
            change(&s->delta[d], alike, add);
        }
    }
}

/* All terms of an undecided site and of its edges, but those of the edges that its lower-numbered
 * neighbours have seen to: the undecided ones, of which `label` (if it is one) is a candidate. */
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

/* The label of least delta among the candidates of undecided sites; `labels` where all are decided.
 */
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

/* Whether a site is undecided and has the candidate; its rank. */
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
    search s = lay_out(index, bits, workspace);
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
