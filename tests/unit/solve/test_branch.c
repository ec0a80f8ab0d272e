/* Small problems with a table for each edge, beside all their labellings: bounds, labels that
 * leave, elimination, and branch and bound. */
#include "stopping.h"
#include "tiny.h"

#include <string.h>

#include "solve/branch.h"

enum { ROUNDS = 4000, NODES = 7, LABELS = 4, EDGES = 14, CELLS = 400, MEMORY = 1 << 20, FEW = 60 };

/* A problem, its labellings one by one, and what each costs (times the unit). */
typedef struct bench {
    qs_tables t;
    uint32_t start[NODES + 1], link_start[NODES + 1], link[2 * EDGES];
    qs_table_edge edge[EDGES];
    int64_t cells[CELLS], unit, least;
    uint32_t labels[NODES];
} bench;

static bench b;
static uint64_t memory[MEMORY / 8];

static bool step(uint32_t *x)
{
    for (uint32_t p = 0; p < b.t.nodes; p++) {
        if (++x[p] < b.labels[p]) {
            return true;
        }
        x[p] = 0;
    }
    return false;
}

/* What a labelling costs; INT64_MAX: one of its labels has left. */
static int64_t cost_of(int64_t constant, const int64_t *cells, const uint32_t *x)
{
    int64_t cost = constant;
    for (uint32_t p = 0; p < b.t.nodes; p++) {
        if (cells[b.start[p] + x[p]] == QS_TABLES_OUT) {
            return INT64_MAX;
        }
        cost += cells[b.start[p] + x[p]];
    }
    for (uint32_t e = 0; e < b.t.edges; e++) {
        const qs_table_edge *edge = &b.edge[e];
        cost += cells[edge->table + x[edge->first] * b.labels[edge->second] + x[edge->second]];
    }
    return cost;
}

/* Edges of all kinds, two between the same nodes among them; costs with many ties, or few. */
static void make(uint64_t *state)
{
    uint32_t range = 2 + tiny_random(state, 30), cells = 0;
    b.unit = (int64_t)1 << tiny_random(state, 11);
    b.t = (qs_tables){.nodes = 1 + tiny_random(state, NODES),
                      .start = b.start,
                      .edge = b.edge,
                      .link_start = b.link_start,
                      .link = b.link};
    for (uint32_t p = 0; p < b.t.nodes; p++) {
        b.labels[p] = 1 + tiny_random(state, LABELS);
        b.start[p] = cells;
        cells += b.labels[p];
    }
    b.start[b.t.nodes] = cells;
    b.t.edges = b.t.nodes > 1 ? tiny_random(state, EDGES + 1) : 0;
    for (uint32_t e = 0; e < b.t.edges; e++) {
        uint32_t q = 1 + tiny_random(state, b.t.nodes - 1);
        b.edge[e] = (qs_table_edge){tiny_random(state, q), q, cells};
        cells += b.labels[b.edge[e].first] * b.labels[q];
    }
    b.t.cells = cells;
    assert_true(cells <= CELLS);
    for (uint32_t i = 0; i < cells; i++) {
        b.cells[i] = tiny_random(state, range) * b.unit;
    }
    qs_tables_link(&b.t);
    uint32_t x[NODES] = {0};
    b.least = INT64_MAX;
    do {
        int64_t cost = cost_of(0, b.cells, x);
        b.least = cost < b.least ? cost : b.least;
    } while (step(x));
}

/* The search with its memory, and the problem at level 0. The best labelling known is any,
 * and a few steps down. */
static qs_branch begin(uint64_t *state, uint32_t levels, size_t cells)
{
    qs_branch s = {.t = &b.t, .unit = b.unit};
    qs_arena arena = {.base = (char *)memory};
    qs_branch_take(&s, levels, cells, &arena);
    assert_true(qs_arena_size(&arena) <= sizeof memory);
    memset(memory, 0xa5, sizeof memory);
    s.level[0].constant = 0;
    memcpy(s.level[0].cells, b.cells, sizeof *b.cells * b.t.cells);
    memcpy(s.level[0].left, b.labels, sizeof *b.labels * b.t.nodes);
    for (uint32_t p = 0; p < b.t.nodes; p++) {
        s.labels[p] = tiny_random(state, b.labels[p]);
        s.score[p] = 0;
    }
    for (uint32_t tries = 0; tries < 20; tries++) {
        uint32_t p = tiny_random(state, b.t.nodes), was = s.labels[p];
        int64_t before = cost_of(0, b.cells, s.labels);
        s.labels[p] = tiny_random(state, b.labels[p]);
        s.labels[p] = cost_of(0, b.cells, s.labels) > before ? was : s.labels[p];
    }
    s.best = cost_of(0, b.cells, s.labels);
    return s;
}

/* All labellings that are left cost what they did; those that are not cost more than `most`. */
static void check_equal(const qs_table_costs *c, int64_t most)
{
    uint32_t x[NODES] = {0}, left[NODES] = {0};
    do {
        int64_t cost = cost_of(c->constant, c->cells, x), before = cost_of(0, b.cells, x);
        assert_true(cost == before || (cost == INT64_MAX && before > most));
        assert_true(before < c->constant ? before > most : true);
    } while (step(x));
    for (uint32_t p = 0; p < b.t.nodes; p++) {
        for (uint32_t a = 0; a < b.labels[p]; a++) {
            left[p] += c->cells[b.start[p] + a] != QS_TABLES_OUT;
        }
        assert_int_equal(left[p], c->left[p]);
    }
}

static void passes_keep_every_labelling(void **unused)
{
    (void)unused;
    uint64_t state = 51;
    uint32_t refuted = 0, tight = 0;
    for (int round = 0; round < ROUNDS; round++) {
        make(&state);
        qs_branch s = begin(&state, 1, 1);
        int64_t most = b.least + (int64_t)tiny_random(&state, 7) * b.unit - 3 * b.unit;
        qs_allowance work = {.left = UINT64_MAX};
        if (qs_tables_tighten(&b.t, &s.level[0], most, 1 + tiny_random(&state, 20), &work)) {
            check_equal(&s.level[0], most);
            tight += s.level[0].constant > b.least - b.unit;
        } else {
            assert_true(most < b.least);
            refuted++;
        }
    }
    assert_true(refuted > ROUNDS / 4 && tight > ROUNDS / 4);
}

static void elimination_is_exact(void **unused)
{
    (void)unused;
    uint64_t state = 52;
    uint32_t wide = 0;
    for (int round = 0; round < ROUNDS; round++) {
        make(&state);
        size_t cells = tiny_random(&state, 3) ? CELLS + 1000 : tiny_random(&state, 200);
        qs_branch s = begin(&state, 1, cells);
        int64_t known = s.best;
        qs_look look = look_that_stops_after(tiny_random(&state, 2 * CELLS));
        qs_allowance work = {UINT64_MAX, tiny_random(&state, 9) ? NULL : &look};
        if (!qs_branch_eliminate(&s, &work)) {
            assert_true(cells <= CELLS || look.stopped);
            wide++;
            continue;
        }
        assert_int_equal(s.best, b.least);
        assert_true(s.best <= known && cost_of(0, b.cells, s.labels) == s.best);
    }
    assert_true(wide > ROUNDS / 50 && wide < ROUNDS / 2);
}

/* The probe keeps all labellings as good as the best one known. */
static void probes_keep_ties(void **unused)
{
    (void)unused;
    uint64_t state = 53;
    uint32_t gone = 0;
    for (int round = 0; round < ROUNDS; round++) {
        make(&state);
        qs_branch s = begin(&state, 1, 1);
        qs_look look = look_that_stops_after(tiny_random(&state, 3000));
        qs_allowance work = {tiny_random(&state, 2) ? UINT64_MAX : tiny_random(&state, 3000),
                             tiny_random(&state, 3) ? NULL : &look};
        qs_branch_probe(&s, &work);
        check_equal(&s.level[0], s.best);
        for (uint32_t p = 0; p < b.t.nodes; p++) {
            gone += b.labels[p] - s.level[0].left[p];
        }
    }
    assert_true(gone > ROUNDS);
}

/* At times with little memory for elimination, few levels or little work, or until a watch stops
 * it. */
static void search_is_exact(void **unused)
{
    (void)unused;
    uint64_t state = 54;
    uint32_t ended = 0, stopped = 0, watched = 0;
    for (int round = 0; round < ROUNDS; round++) {
        make(&state);
        bool few = tiny_random(&state, 4) == 0, probe = tiny_random(&state, 2);
        qs_branch s =
            begin(&state, few ? 1 + tiny_random(&state, 3) : 30, tiny_random(&state, FEW));
        qs_look look = look_that_stops_after(tiny_random(&state, 20000));
        qs_allowance work = {tiny_random(&state, 4) ? UINT64_MAX : tiny_random(&state, 20000),
                             tiny_random(&state, 4) ? NULL : &look};
        bool all = !few && work.left == UINT64_MAX;
        if (probe) {
            qs_branch_probe(&s, &work);
        }
        int64_t bound = qs_branch_search(&s, &work);
        assert_true(bound <= b.least && s.best >= b.least);
        assert_int_equal(cost_of(0, b.cells, s.labels), s.best);
        assert_int_equal(bound % b.unit, 0);
        assert_true(!all || look.stopped || bound == s.best);
        assert_true(!look.stopped || work.left == 0);
        watched += look.stopped && bound < s.best;
        ended += bound == s.best;
        stopped += bound < s.best;
    }
    print_message("ended %u, stopped %u of %d, by a look %u\n", ended, stopped, ROUNDS, watched);
    assert_true(ended > ROUNDS / 2 && stopped > ROUNDS / 100 && watched > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(passes_keep_every_labelling),
        cmocka_unit_test(elimination_is_exact),
        cmocka_unit_test(probes_keep_ties),
        cmocka_unit_test(search_is_exact),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
