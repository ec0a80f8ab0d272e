#include "../base/bytes.h"
#include "../base/minmax.h"
#include "../base/saturate.h"
#include "../problem/edge_runs.h"
#include "encoder.h"

/* Gathers neighbouring sites of equal penalties into runs. With a writer it puts each run, without
 * one it counts them. */
typedef struct run_maker {
    const qs_encoder *encoder;
    qs_writer *writer;
    qs_penalty_run run; /* the one under way; count 0 = none */
    uint64_t ended; /* runs before it */
    uint64_t largest, magnitude;
} run_maker;

static void end_run(run_maker *m)
{
    const qs_penalty_run *run = &m->run;
    uint64_t labels = m->encoder->problem->labels;
    if (run->count == 0) {
        return;
    }
    if (m->writer) {
        qs_put_penalty_run(m->writer, run, m->encoder->qcf.penalty_bytes);
        return;
    }
    m->ended++;
    m->largest = qs_max_u64(m->largest, qs_max_u64(run->a, run->b));
    qs_grow(&m->magnitude, run->a, run->count * (1 + labels));
    qs_grow(&m->magnitude, run->b, run->count * (labels * (labels - 1) / 2));
}

/* W: the most that a site's edges can cost, given the sums of the weights of those in which it
 * comes first and second; saturated. */
static uint64_t most_cost(const qs_encoder *e, uint64_t first, uint64_t second)
{
    uint64_t most = 0;
    if (!qs_has_table(e)) {
        qs_grow(&most, first + second, (uint64_t)e->block_max);
        return most;
    }
    for (uint32_t d = 0; d < e->problem->labels; d++) {
        uint64_t cost = 0;
        qs_grow(&cost, first, (uint64_t)e->largest[d]);
        qs_grow(&cost, second, (uint64_t)e->largest[e->problem->labels + d]);
        most = qs_max_u64(most, cost);
    }
    return most;
}

/* Goes on with `count` sites whose edges are alike. */
static void push_alike(run_maker *m, uint32_t count, qs_site_edges edges)
{
    const qs_encoder *e = m->encoder;
    uint64_t a = e->alpha, b = 2 * e->alpha;
    if (qs_penalty_keeps_gap(e->penalty)) {
        qs_one_hot_bound(e->encoding, e->penalty, &e->problem->pairwise, e->problem->labels, e->gap,
                         edges, &a, &b);
    }
    if (a != m->run.a || b != m->run.b) {
        end_run(m);
        m->run.count = 0;
    }
    m->run = (qs_penalty_run){a, b, m->run.count + count};
}

/* A qs_reach_visit. */
static void push_sites(void *context, uint32_t count, int64_t first, int64_t second)
{
    run_maker *m = context;
    qs_site_edges edges = {(uint64_t)(first + second),
                           most_cost(m->encoder, (uint64_t)first, (uint64_t)second)};
    push_alike(m, count, edges);
}

#ifndef QS_SMALL
/* A qs_table_reach_visit. One-hot does not need the weights. */
static void push_site(void *context, uint64_t most)
{
    push_alike(context, 1, (qs_site_edges){0, most});
}
#endif

static void make_runs(run_maker *m)
{
    const qs_encoder *e = m->encoder;
    if (!qs_penalty_keeps_gap(e->penalty)) {
        push_alike(m, (uint32_t)e->qcf.groups, (qs_site_edges){0, 0});
#ifndef QS_SMALL
    } else if (qs_has_tables(e)) {
        qs_table_reach_all(&e->strip, e->reach, push_site, m);
#endif
    } else {
        qs_reach_visit_all(e->problem, e->sums, push_sites, m);
    }
    end_run(m);
}

void qs_plan_penalties(qs_encoder *e)
{
    run_maker m = {.encoder = e};
    make_runs(&m);
    e->qcf.penalty_bytes = qs_bytes_of(m.largest);
    e->qcf.penalty_runs = m.ended;
    qs_grow(&e->magnitude, 1, m.magnitude);
}

void qs_put_the_penalties(qs_writer *writer, const void *encoder)
{
    run_maker m = {.encoder = encoder, .writer = writer};
    make_runs(&m);
}
