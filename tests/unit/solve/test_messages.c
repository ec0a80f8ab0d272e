/* Belief propagation, TRW-S and its bound against all labellings of tiny problems. */
#include "tiny.h"

#include <string.h>

#include "solve/bp_visit.h"
#include "solve/label_from_messages.h"
#include "solve/trws.h"

enum { ROUNDS = 3000, BITS = 12, MEMORY = 1 << 16, MANY_LABELS = 41 };

/* A tiny problem, its model, and memory for a solver. */
typedef struct bench {
    tiny t;
    tiny_qubo qubo;
    uint64_t model_memory[MEMORY / 8];
    qs_model model;
    int64_t minimum;
} bench;

static bench b;
static uint64_t memory[MEMORY / 8];

static void build(void)
{
    tiny_encode(&b.t.problem, (qs_encode_options){QS_ONE_HOT, QS_PENALTY_LOCAL, 0, 0}, &b.qubo);
    assert_int_equal(qs_model_build(&b.qubo.index, b.model_memory, sizeof b.model_memory, &b.model),
                     QS_OK);
    b.minimum = tiny_minimum(&b.t.problem);
}

static void make(uint64_t *state)
{
    tiny_make(&b.t, state, BITS, false);
    build();
}

/* Runs a solver on it and checks all that must hold of any answer. */
static qs_solution solve(qs_solver *solver, size_t needed, const qs_solve_options *options,
                         uint16_t *labelling)
{
    qs_solution s;
    assert_true(needed <= sizeof memory);
    memset(memory, 0xa5, sizeof memory);
    memset(labelling, 0xff, sizeof *labelling * b.model.sites);
    assert_int_equal(solver(&b.model, options, memory, needed, labelling, &s), QS_OK);
    for (uint32_t p = 0; p < b.model.sites; p++) {
        assert_true(labelling[p] < b.model.labels);
    }
    assert_int_equal(s.energy, qs_model_energy(&b.model, labelling));
    assert_true(s.energy >= b.minimum);
    assert_true(s.lower_bound == QS_NO_BOUND || s.lower_bound <= b.minimum);
    return s;
}

static qs_solution trws(uint64_t iterations, uint16_t *labelling)
{
    return solve(qs_trws, qs_trws_workspace(&b.model),
                 &(qs_solve_options){.iterations = iterations}, labelling);
}

static qs_solution bp(uint64_t iterations, uint16_t *labelling)
{
    return solve(qs_bp, qs_bp_workspace(&b.model), &(qs_solve_options){.iterations = iterations},
                 labelling);
}

/* Bounds and energies of both, on problems of all kinds; most are proven. */
static void answers_hold(void **unused)
{
    (void)unused;
    uint64_t state = 1;
    int proven = 0;
    for (int round = 0; round < ROUNDS; round++) {
        uint16_t labelling[TINY_SITES], again[TINY_SITES];
        make(&state);
        qs_solution s = trws(1 + tiny_random(&state, 60), labelling);
        assert_true(s.lower_bound != QS_NO_BOUND);
        assert_int_equal(s.converged, s.energy == s.lower_bound);
        proven += s.converged;
        qs_solution same = trws(s.iterations, again);
        assert_memory_equal(labelling, again, sizeof *labelling * b.model.sites);
        assert_int_equal(s.lower_bound, same.lower_bound);
        s = bp(1 + tiny_random(&state, 20), labelling);
        assert_int_equal(s.lower_bound, QS_NO_BOUND);
    }
    assert_true(proven > ROUNDS * 9 / 10);
}

static qs_trws_state state_of(bool wide)
{
    qs_trws_state s = {.model = &b.model, .wide = wide};
    assert_true(qs_scale_choose(&b.model, 20, &s.scale));
    memset(memory, 0, sizeof memory);
    s.messages = (int32_t *)memory + qs_trws_padding(&b.model);
    s.scratch = s.messages + qs_trws_messages(&b.model);
    return s;
}

/* A message of garbage, from minus the most to the most that a true one can be; none where there is
 * no edge. */
static void garbage(uint64_t *state, int32_t *message, int32_t weight, const qs_trws_state *s)
{
    int32_t most = (int32_t)(weight * b.model.pairwise_max) << s->scale.shift;
    for (uint32_t d = 0; d < b.model.labels; d++) {
        message[d] = most == 0 ? 0
                               : (int32_t)tiny_random(state, (uint32_t)most) -
                                     (tiny_random(state, 2) ? most : 0);
    }
}

static void all_garbage(uint64_t *state, const qs_trws_state *s)
{
    uint32_t labels = b.model.labels;
    for (uint32_t p = 0; p < b.model.sites; p++) {
        if (b.model.width > 0) {
            garbage(state, s->messages + 2 * labels * p, b.model.right[p], s);
            garbage(state, s->messages + 2 * labels * p + labels, b.model.down[p], s);
            continue;
        }
        for (uint32_t n = b.model.link_start[p]; n < b.model.link_start[p + 1]; n++) {
            garbage(state, s->messages + labels * b.model.links[n].edge, b.model.links[n].weight,
                    s);
        }
    }
}

/* From any messages at all, either way, a pass bounds the energy. */
static void bound_of_garbage(void **unused)
{
    (void)unused;
    uint64_t state = 2;
    for (int round = 0; round < ROUNDS; round++) {
        make(&state);
        qs_trws_state s = state_of(false);
        for (int way = 0; way < 2; way++) {
            all_garbage(&state, &s);
            int64_t bound =
                b.model.width > 0 ? qs_trws_grid_pass(&s, way) : qs_trws_graph_pass(&s, way);
            int64_t optimum = (b.minimum - b.model.constant) * ((int64_t)1 << s.scale.shift);
            assert_true(bound <= optimum);
            assert_true(bound >= -((int64_t)1 << 40));
        }
    }
}

/* A chain as a grid of one row or column, a chain or any tree as a list of edges, at each site's
 * number any number below for a parent. */
static void make_tree(uint64_t *state, bool tree)
{
    tiny_make(&b.t, state, BITS, false);
    qs_problem *p = &b.t.problem;
    uint32_t sites = qs_problem_sites(p);
    p->grid = (qs_grid){0};
    p->sites = sites;
    p->edge_count = 0;
    p->edges = b.t.edges;
    if (!tree && tiny_random(state, 2)) {
        p->sites = 0;
        p->edges = NULL;
        p->grid.width = tiny_random(state, 2) ? sites : 1;
        p->grid.height = p->grid.width == 1 ? sites : 1;
    }
    for (uint32_t q = 1; q < p->sites; q++) { /* none of a grid */
        b.t.edges[p->edge_count++] =
            (qs_edge){tree ? tiny_random(state, q) : q - 1, q, (int32_t)tiny_random(state, 12)};
    }
    build();
}

static void exact_on_chains(void **unused)
{
    (void)unused;
    uint64_t state = 3;
    for (int round = 0; round < ROUNDS; round++) {
        uint16_t labelling[TINY_SITES];
        make_tree(&state, false);
        qs_solution s = trws(1, labelling);
        assert_true(s.converged);
        assert_int_equal(s.energy, b.minimum);
        assert_int_equal(bp(60, labelling).energy, b.minimum);
    }
}

static void exact_on_trees(void **unused)
{
    (void)unused;
    uint64_t state = 4;
    for (int round = 0; round < ROUNDS; round++) {
        uint16_t labelling[TINY_SITES];
        make_tree(&state, true);
        qs_solution s = trws(500, labelling);
        assert_true(s.converged);
        assert_int_equal(s.energy, b.minimum);
        assert_int_equal(bp(60, labelling).energy, b.minimum);
    }
}

/* Every kind of message beside the minimum over all pairs of labels. */
static void messages_by_definition(void **unused)
{
    (void)unused;
    static int32_t table[MANY_LABELS * MANY_LABELS];
    uint64_t state = 5;
    for (int round = 0; round < ROUNDS; round++) {
        int32_t costs[MANY_LABELS], given[MANY_LABELS], message[MANY_LABELS],
            scratch[2 * MANY_LABELS];
        qs_model m = {
            .labels = 1 + tiny_random(&state, MANY_LABELS),
            .pairwise = {(qs_smoothness)tiny_random(&state, 4), tiny_random(&state, 30), table}};
        uint32_t range = 1u << tiny_random(&state, 12);
        int32_t weight = (int32_t)tiny_random(&state, 5) << tiny_random(&state, 10);
        bool upward = tiny_random(&state, 2);
        for (uint32_t i = 0; i < m.labels * m.labels; i++) {
            table[i] = (int32_t)tiny_random(&state, 50);
        }
        for (uint32_t a = 0; a < m.labels; a++) {
            costs[a] = given[a] = (int32_t)tiny_random(&state, range) - (int32_t)(range / 3);
            for (uint32_t c = 0; c < m.labels; c++) {
                m.pairwise_max = qs_model_pairwise(&m, a, c) > m.pairwise_max
                                     ? qs_model_pairwise(&m, a, c)
                                     : m.pairwise_max;
            }
        }
        int32_t taken = qs_message_send(&m, 0, weight, upward, costs, message, scratch);
        for (uint32_t d = 0; d < m.labels; d++) {
            int64_t least = INT64_MAX;
            for (uint32_t a = 0; a < m.labels; a++) {
                int64_t cost = given[a] + weight * (upward ? qs_model_pairwise(&m, a, d)
                                                           : qs_model_pairwise(&m, d, a));
                least = cost < least ? cost : least;
            }
            assert_int_equal(message[d] + (int64_t)taken, least);
        }
    }
}

/* A grid of more labels than a tiny problem has, as a model. */
static void make_wide(uint64_t *state, uint32_t labels)
{
    static int32_t unary[64 * MANY_LABELS], right[64], down[64];
    uint32_t width = 1 + tiny_random(state, 8), height = 1 + tiny_random(state, 8);
    b.model = (qs_model){.sites = width * height,
                         .labels = labels,
                         .width = width,
                         .height = height,
                         .unary = unary,
                         .right = right,
                         .down = down};
    b.model.pairwise_max = 1;
    for (uint32_t p = 0; p < b.model.sites; p++) {
        right[p] = (p + 1) % width != 0 ? (int32_t)tiny_random(state, 20) : 0;
        down[p] = p + width < b.model.sites ? (int32_t)tiny_random(state, 20) : 0;
        for (uint32_t d = 0; d < labels; d++) {
            unary[p * labels + d] = (int32_t)tiny_random(state, 120) * (tiny_random(state, 3) > 0);
        }
    }
}

static void wide_trws_is_plain(uint64_t *state)
{
    static int32_t plain[2 * 64 * MANY_LABELS];
    size_t size = sizeof *plain * (size_t)qs_trws_messages(&b.model);
    uint16_t labelling[2][64];
    int64_t bound[6];
    uint64_t same = *state;
    for (int wide = 0; wide < 2; wide++) {
        qs_trws_state s = state_of(wide);
        *state = same;
        all_garbage(state, &s);
        for (int i = 0; i < 6; i++) {
            int64_t got = qs_trws_grid_pass(&s, i % 2 == 0);
            assert_true(wide == 0 || got == bound[i]);
            bound[i] = got;
        }
        qs_trws_grid_labels(&s, true, labelling[wide]);
        if (wide == 0) {
            memcpy(plain, s.messages, size);
        } else {
            assert_memory_equal(plain, s.messages, size);
        }
    }
    assert_memory_equal(labelling[0], labelling[1], sizeof **labelling * b.model.sites);
}

/* Numbers of all messages of a model. */
static size_t bp_messages(const qs_model *of)
{
    size_t messages = of->width > 0 ? QS_FROM_ALL * (size_t)of->sites : 2 * (size_t)of->edges;
    return messages * of->labels;
}

static void wide_bp_is_plain(void)
{
    static int32_t plain[4 * 64 * MANY_LABELS];
    size_t size = sizeof *plain * bp_messages(&b.model);
    for (int wide = 0; wide < 2; wide++) {
        qs_bp_state s = {.model = &b.model, .messages = (int32_t *)memory};
        assert_true(qs_scale_choose(&b.model, 12, &s.scale));
        memset(memory, 0, sizeof memory);
        s.scratch = s.messages + bp_messages(&b.model);
        for (int i = 0; i < 3; i++) {
#if QS_HAVE_AVX2
            (wide ? qs_bp_wide_sweep : qs_bp_grid_sweep)(&s);
#endif
        }
        if (wide == 0) {
            memcpy(plain, s.messages, size);
        } else {
            assert_memory_equal(plain, s.messages, size);
        }
    }
}

static void wide_is_plain(void **unused)
{
    (void)unused;
    if (!qs_lanes_avx2()) {
        skip();
    }
    uint64_t state = 6;
    for (uint32_t round = 0; round < 10 * MANY_LABELS; round++) {
        uint32_t labels = 8 + round % (MANY_LABELS - 7);
        make_wide(&state, round % 3 == 0 ? (round % 2 ? 16 : 20) : labels);
        wide_trws_is_plain(&state);
        wide_bp_is_plain();
    }
}

/* With any truncation: steps within runs of lanes, across them, and beyond all labels. */
static void wide_linear_is_plain(void **unused)
{
    (void)unused;
    if (!qs_lanes_avx2()) {
        skip();
    }
    uint64_t state = 7;
    for (uint32_t round = 0; round < 20 * MANY_LABELS; round++) {
        uint32_t labels = 8 + round % (MANY_LABELS - 7);
        make_wide(&state, round % 3 == 0 ? (round % 2 ? 16 : 20) : labels);
        b.model.pairwise.smoothness = QS_TRUNCATED_LINEAR;
        b.model.pairwise.truncation = tiny_random(&state, b.model.labels + 2);
        b.model.pairwise_max = qs_model_pairwise(&b.model, 0, b.model.labels - 1);
        wide_trws_is_plain(&state);
    }
}

/* Tables for the edges of that grid: one for all, or some that the edges share. */
static void add_tables(uint64_t *state, bool own)
{
    enum { TABLES = 3 };
    static int32_t tables[TABLES * MANY_LABELS * MANY_LABELS], most[TABLES];
    static uint32_t table_of[2 * 64];
    size_t entries = (size_t)b.model.labels * b.model.labels;
    memset(most, 0, sizeof most);
    for (size_t i = 0; i < TABLES * entries; i++) {
        tables[i] = (int32_t)tiny_random(state, 50);
        most[i / entries] = tables[i] > most[i / entries] ? tables[i] : most[i / entries];
    }
    for (uint32_t e = 0; e < 2 * b.model.sites; e++) {
        table_of[e] = tiny_random(state, TABLES);
    }
    b.model.pairwise.smoothness = own ? QS_TABLES : QS_TABLE;
    b.model.pairwise.table = own ? NULL : tables;
    b.model.pairwise_max = own ? 50 : most[0];
    b.model.tables = own ? tables : NULL;
    b.model.table_of = own ? table_of : NULL;
    b.model.table_max = own ? most : NULL;
}

static void wide_tables_are_plain(void **unused)
{
    (void)unused;
    if (!qs_lanes_avx2()) {
        skip();
    }
    uint64_t state = 8;
    for (uint32_t round = 0; round < 10 * MANY_LABELS; round++) {
        make_wide(&state, 1 + round % MANY_LABELS);
        add_tables(&state, round / MANY_LABELS % 2 == 0);
        wide_trws_is_plain(&state);
    }
}

/* A labelling by decode.h's words: random messages, every label tried. */
static void labels_by_definition(void **unused)
{
    (void)unused;
    uint64_t state = 11;
    for (int round = 0; round < ROUNDS; round++) {
        uint16_t labelling[64];
        bool many = round % 2;
        make(&state);
        if (many || b.model.width == 0) {
            make_wide(&state, 1 + tiny_random(&state, MANY_LABELS));
        }
        qs_trws_state s = state_of(many && qs_lanes_avx2());
        s.scale.shift = 0; /* ties */
        all_garbage(&state, &s);
        bool forward = tiny_random(&state, 2);
        qs_trws_grid_labels(&s, forward, labelling);
        uint32_t labels = b.model.labels, width = b.model.width;
        for (uint32_t p = 0; p < b.model.sites; p++) {
            int64_t least = INT64_MAX;
            uint32_t best = 0;
            for (uint32_t d = 0; d < labels; d++) {
                const int32_t *message = s.messages + 2 * labels * p + d;
                int64_t cost = b.model.unary[p * labels + d] < s.scale.most
                                   ? b.model.unary[p * labels + d]
                                   : s.scale.most;
                if (forward) {
                    cost += message[0] + message[labels];
                    cost += p % width > 0 ? b.model.right[p - 1] *
                                                qs_model_pairwise(&b.model, labelling[p - 1], d)
                                          : 0;
                    cost += p >= width ? b.model.down[p - width] *
                                             qs_model_pairwise(&b.model, labelling[p - width], d)
                                       : 0;
                } else {
                    cost += p % width > 0 ? message[-2 * (int)labels] : 0;
                    cost += p >= width ? message[(int)labels - 2 * (int)(labels * width)] : 0;
                    cost +=
                        b.model.right[p] > 0
                            ? b.model.right[p] * qs_model_pairwise(&b.model, d, labelling[p + 1])
                            : 0;
                    cost +=
                        b.model.down[p] > 0
                            ? b.model.down[p] * qs_model_pairwise(&b.model, d, labelling[p + width])
                            : 0;
                }
                best = cost < least ? d : best;
                least = cost < least ? cost : least;
            }
            assert_int_equal(labelling[p], best);
        }
    }
}

/* Messages of a tiny grid: from the left, the right, above, below. */
typedef int64_t naive_messages[TINY_SITES][4][TINY_LABELS];

/* From p to q, as which it is to q's side `side`; what p hears from there, the other way, it does
 * not send back. */
static void naive_send(naive_messages in, const qs_bp_state *s, uint32_t p, uint32_t q, int side,
                       int64_t weight)
{
    int64_t message[TINY_LABELS], least = INT64_MAX;
    for (uint32_t d = 0; d < b.model.labels; d++) {
        message[d] = INT64_MAX;
        for (uint32_t a = 0; a < b.model.labels; a++) {
            int64_t unary = b.model.unary[p * b.model.labels + a];
            int64_t cost = (unary < s->scale.most ? unary : s->scale.most) << s->scale.shift;
            for (int from = 0; from < 4; from++) {
                cost += from == (side ^ 1) ? 0 : in[p][from][a];
            }
            cost += (weight << s->scale.shift) *
                    (p < q ? qs_model_pairwise(&b.model, a, d) : qs_model_pairwise(&b.model, d, a));
            message[d] = cost < message[d] ? cost : message[d];
        }
        least = message[d] < least ? message[d] : least;
    }
    for (uint32_t d = 0; d < b.model.labels; d++) {
        in[q][side][d] = message[d] - least + (in[q][side][d] - (message[d] - least)) * 3 / 16;
    }
}

/* Right, left, down, up. */
static void naive_sweep(naive_messages in, const qs_bp_state *s)
{
    uint32_t width = b.model.width, sites = b.model.sites;
    for (int side = 0; side < 4; side++) {
        uint32_t step = side < 2 ? 1 : width;
        for (uint32_t i = 0; i < sites; i++) {
            uint32_t low = side % 2 ? sites - 1 - i : i;
            int64_t weight = side < 2 ? b.model.right[low] : b.model.down[low];
            if (weight > 0) {
                naive_send(in, s, side % 2 ? low + step : low, side % 2 ? low : low + step, side,
                           weight);
            }
        }
    }
}

static void bp_by_definition(void **unused)
{
    (void)unused;
    uint64_t state = 12;
    for (int round = 0; round < ROUNDS; round++) {
        naive_messages in = {0};
        do {
            make(&state);
        } while (b.model.width == 0);
        qs_bp_state s = {.model = &b.model, .messages = (int32_t *)memory};
        assert_true(qs_scale_choose(&b.model, 12, &s.scale));
        memset(memory, 0, sizeof memory);
        s.scratch = s.messages + bp_messages(&b.model);
        for (int i = 0; i < 4; i++) {
            qs_bp_grid_sweep(&s);
            naive_sweep(in, &s);
        }
        for (size_t i = 0; i < bp_messages(&b.model); i++) {
            uint32_t at = (uint32_t)i, d = at % b.model.labels, side = at / b.model.labels % 4,
                     p = at / b.model.labels / 4;
            assert_int_equal(s.messages[i], in[p][side][d]);
        }
    }
}

static bool stop_at(void *context, const qs_progress *progress)
{
    assert_true(progress->iteration > 0);
    assert_true(progress->energy >= progress->lower_bound);
    return progress->iteration < *(uint64_t *)context;
}

/* A watch is asked after every iteration; what it stops has an answer, even after the first. */
static void watch_stops(void **unused)
{
    (void)unused;
    uint64_t state = 7;
    int stopped = 0;
    for (int round = 0; round < ROUNDS; round++) {
        uint16_t labelling[TINY_SITES];
        uint64_t at = 1 + tiny_random(&state, 9);
        qs_solve_options options = {.iterations = 50, .watch = stop_at, .context = &at};
        make(&state);
        qs_solution s = solve(qs_trws, qs_trws_workspace(&b.model), &options, labelling);
        assert_true(s.iterations == at || (s.iterations < at && s.converged));
        stopped += !s.converged;
        s = solve(qs_bp, qs_bp_workspace(&b.model), &options, labelling);
        assert_int_equal(s.iterations, at);
        assert_false(s.converged);
    }
    assert_true(stopped > 0);
}

static void defaults(void **unused)
{
    (void)unused;
    uint16_t labelling[TINY_SITES];
    uint64_t state = 8;
    do {
        make(&state);
    } while (trws(600, labelling).converged); /* few are not proven: cycles that frustrate */
    assert_int_equal(trws(0, labelling).iterations, 500);
    assert_int_equal(bp(0, labelling).iterations, 50);
    qs_solution s;
    assert_int_equal(qs_bp(&b.model, NULL, memory, sizeof memory, labelling, &s), QS_OK);
    assert_int_equal(s.iterations, 50);
}

static qs_status status_of(qs_solver *solver, size_t size)
{
    uint16_t labelling[64];
    qs_solution s;
    return solver(&b.model, NULL, memory, size, labelling, &s);
}

static void refusals(void **unused)
{
    (void)unused;
    uint64_t state = 9;
    uint16_t labelling[64];
    qs_solution s;
    make_wide(&state, 3);
    int32_t *right = (int32_t *)(uintptr_t)b.model.right;
    assert_int_equal(status_of(qs_trws, qs_trws_workspace(&b.model) - 1), QS_E_WORKSPACE);
    assert_int_equal(status_of(qs_bp, qs_bp_workspace(&b.model) - 1), QS_E_WORKSPACE);
    assert_int_equal(qs_trws(NULL, NULL, memory, sizeof memory, labelling, &s), QS_E_ARGUMENT);
    assert_int_equal(qs_bp(&b.model, NULL, memory, sizeof memory, NULL, &s), QS_E_ARGUMENT);
    right[0] = INT32_MAX / 4; /* fits a label's cost but not the sums */
    assert_false(qs_messages_fit(&b.model, false));
    assert_int_equal(status_of(qs_trws, qs_trws_workspace(&b.model)), QS_OK); /* in 64 bits */
    assert_int_equal(status_of(qs_bp, qs_bp_workspace(&b.model)), QS_OK);
    make_wide(&state, 1); /* one label: no weight matters */
    b.model.pairwise_max = 0;
    right[0] = INT32_MAX;
    b.model.width = b.model.sites;
    b.model.height = 1;
    right[b.model.sites - 1] = 0;
    memset((int32_t *)(uintptr_t)b.model.down, 0, sizeof *b.model.down * b.model.sites);
    assert_int_equal(status_of(qs_trws, sizeof memory), QS_OK);
    assert_int_equal(status_of(qs_bp, sizeof memory), QS_OK);
}

/* Costs as large as they come: what all edges of a site cannot outweigh counts as just that. */
static void huge_unaries(void **unused)
{
    (void)unused;
    uint64_t state = 10;
    for (int round = 0; round < ROUNDS; round++) {
        uint16_t labelling[TINY_SITES];
        tiny_make(&b.t, &state, BITS, false);
        for (uint32_t i = 0; i < qs_problem_sites(&b.t.problem) * b.t.problem.labels; i++) {
            b.t.costs[i] *= b.t.problem.labels > 1 && tiny_random(&state, 4) == 0 ? 1 << 20 : 1;
        }
        build();
        trws(20, labelling);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(answers_hold),
        cmocka_unit_test(bound_of_garbage),
        cmocka_unit_test(exact_on_chains),
        cmocka_unit_test(exact_on_trees),
        cmocka_unit_test(messages_by_definition),
        cmocka_unit_test(wide_is_plain),
        cmocka_unit_test(wide_linear_is_plain),
        cmocka_unit_test(wide_tables_are_plain),
        cmocka_unit_test(watch_stops),
        cmocka_unit_test(defaults),
        cmocka_unit_test(labels_by_definition),
        cmocka_unit_test(bp_by_definition),
        cmocka_unit_test(refusals),
        cmocka_unit_test(huge_unaries),
    };
    return cmocka_run_group_tests_name("messages", tests, NULL, NULL);
}
