/* Labels that leave a problem, beside all labellings of tiny ones: none that leaves is in any
 * optimum. */
#include "stopping.h"
#include "tiny.h"

#include <string.h>

#include "reduce/label_sets.h"
#include "reduce/parts.h"
#include "base/simd.h"
#include "model/neighbours.h"
#include "solve/trws.h"
#include "wide_grid.h"

enum { ROUNDS = 2000, BITS = 18, MEMORY = 1 << 17, WORK = 1 << 23 };

/* A tiny problem, its model with sets of labels, and the least energy of all labellings of these
 * with a label at a site (INT64_MAX: no such label). */
typedef struct bench {
    tiny t;
    tiny_qubo qubo;
    uint64_t model_memory[MEMORY / 8];
    qs_model model;
    int32_t unary[TINY_SITES * TINY_LABELS];
    uint8_t kept[TINY_SITES * TINY_LABELS];
    int64_t least[TINY_SITES][TINY_LABELS], minimum;
} bench;

static bench b;
static uint64_t memory[WORK / 8];

static bool is_masked(uint32_t site)
{
    return b.model.mask && (b.model.mask[site / 8] >> site % 8 & 1) == 0;
}

static bool is_there(uint32_t site, uint32_t label)
{
    return is_masked(site) ? label == 0
                           : !b.model.kept || b.model.kept[site * b.model.labels + label];
}

/* The next labelling of labels that are there; false after the last. */
static bool step(uint16_t *labelling)
{
    for (uint32_t p = 0; p < b.model.sites; p++) {
        for (uint16_t d = (uint16_t)(labelling[p] + 1); d < b.model.labels; d++) {
            if (is_there(p, d)) {
                labelling[p] = d;
                return true;
            }
        }
        for (labelling[p] = 0; !is_there(p, labelling[p]); labelling[p]++) {
        }
    }
    return false;
}

static void enumerate(void)
{
    uint16_t labelling[TINY_SITES] = {0};
    b.minimum = INT64_MAX;
    for (uint32_t p = 0; p < b.model.sites; p++) {
        for (uint32_t d = 0; d < TINY_LABELS; d++) {
            b.least[p][d] = INT64_MAX;
        }
        for (; !is_there(p, labelling[p]); labelling[p]++) {
        }
    }
    do {
        int64_t energy = qs_model_energy(&b.model, labelling);
        b.minimum = energy < b.minimum ? energy : b.minimum;
        for (uint32_t p = 0; p < b.model.sites; p++) {
            int64_t *least = &b.least[p][labelling[p]];
            *least = energy < *least ? energy : *least;
        }
    } while (step(labelling));
}

static void build(void)
{
    tiny_encode(&b.t.problem, (qs_encode_options){QS_ONE_HOT, QS_PENALTY_LOCAL, 0, 0}, &b.qubo);
    assert_int_equal(qs_model_build(&b.qubo.index, b.model_memory, sizeof b.model_memory, &b.model),
                     QS_OK);
}

static int64_t weights_at(uint32_t site)
{
    int64_t sum = 0;
    for (uint32_t p = 0; b.model.width > 0 && p < b.model.sites; p++) {
        sum += p == site || p + 1 == site ? b.model.right[p] : 0;
        sum += p == site || p + b.model.width == site ? b.model.down[p] : 0;
    }
    for (uint32_t n = b.model.width > 0 ? 0 : b.model.link_start[site];
         b.model.width == 0 && n < b.model.link_start[site + 1]; n++) {
        sum += b.model.links[n].weight;
    }
    return sum;
}

/* Takes a third of the labels out, as the reader of a reduced file does. */
static void thin_out(uint64_t *state)
{
    memset(b.kept, 1, sizeof b.kept);
    for (uint32_t p = 0; p < b.model.sites; p++) {
        uint8_t *kept = b.kept + p * b.model.labels;
        int32_t *unary = b.unary + p * b.model.labels, least = INT32_MAX;
        uint32_t stays = tiny_random(state, b.model.labels);
        for (uint32_t d = 0; d < b.model.labels; d++) {
            kept[d] = d == stays || is_masked(p) || tiny_random(state, 3) > 0;
            unary[d] = b.model.unary[p * b.model.labels + d];
            least = kept[d] && unary[d] < least ? unary[d] : least;
        }
        for (uint32_t d = 0; d < b.model.labels; d++) {
            unary[d] = kept[d] ? unary[d] - least
                               : (int32_t)(weights_at(p) * b.model.pairwise_max) + 1 +
                                     (int32_t)tiny_random(state, 3);
        }
        b.model.constant += least;
    }
    b.model.unary = b.unary;
    b.model.kept = b.kept;
}

/* Some graphs have an edge twice. */
static void make_problem(uint64_t *state, bool potts)
{
    tiny_make(&b.t, state, BITS, potts);
    qs_problem *p = &b.t.problem;
    if (p->edge_count > 0 && p->edge_count < TINY_EDGES && tiny_random(state, 2)) {
        b.t.edges[p->edge_count] = b.t.edges[tiny_random(state, (uint32_t)p->edge_count)];
        b.t.edges[p->edge_count++].weight = (int32_t)tiny_random(state, 12);
    }
}

static void make(uint64_t *state)
{
    make_problem(state, tiny_random(state, 2));
    build();
    if (tiny_random(state, 4) == 0) {
        thin_out(state);
    }
    enumerate();
}

/* Every label of every optimum must be there, of each site one or more, of a masked cell label 0.
 * Returns the labels beyond those. */
static uint32_t check_sets(const uint8_t *kept)
{
    uint32_t more = 0;
    for (uint32_t p = 0; p < b.model.sites; p++) {
        for (uint32_t d = 0; d < b.model.labels; d++) {
            uint8_t is = kept[p * b.model.labels + d];
            assert_true(is <= 1);
            if (is_masked(p)) {
                assert_int_equal(is, d == 0);
                continue;
            }
            assert_true(is || b.least[p][d] != b.minimum);
            assert_true(!is || b.least[p][d] < INT64_MAX);
            more += is && b.least[p][d] != b.minimum;
        }
    }
    return more;
}

static void check_counts(const uint8_t *kept, bool walls, const qs_reduction *r)
{
    uint64_t variables = 0;
    uint32_t open = 0;
    for (uint32_t p = 0; p < b.model.sites; p++) {
        uint32_t count = 0;
        for (uint32_t d = 0; d < b.model.labels; d++) {
            count += kept[p * b.model.labels + d];
        }
        if (count > 1) {
            open++;
            variables += walls ? count - 1 : count;
        }
    }
    assert_int_equal(variables, r->variables);
    assert_int_equal(open, r->undecided);
}

static void check_labelling(const uint8_t *kept, const uint16_t *labelling, const qs_reduction *r)
{
    for (uint32_t p = 0; p < b.model.sites; p++) {
        assert_true(labelling[p] < b.model.labels);
        assert_true(kept[p * b.model.labels + labelling[p]]);
    }
    assert_int_equal(qs_model_energy(&b.model, labelling), r->upper_bound);
    assert_true(r->upper_bound >= b.minimum);
    assert_true(r->lower_bound == QS_NO_BOUND || r->lower_bound <= b.minimum);
}

typedef struct witness {
    const uint8_t *kept;
    const uint16_t *labelling;
    bool walls;
    uint64_t calls, patience, variables, target;
    int64_t lower, upper;
} witness;

static bool watch(void *context, const qs_reduction *r)
{
    witness *w = context;
    check_sets(w->kept);
    check_counts(w->kept, w->walls, r);
    check_labelling(w->kept, w->labelling, r);
    assert_true(w->calls == 0 || w->target == 0 || w->variables > w->target);
    assert_true(r->variables <= w->variables && r->lower_bound >= w->lower &&
                r->upper_bound <= w->upper);
    w->variables = r->variables;
    w->lower = r->lower_bound;
    w->upper = r->upper_bound;
    return ++w->calls < w->patience;
}

static void begin_sets(qs_elimination *e, const qs_model *of, bool walls, uint8_t *kept,
                       uint16_t *labelling)
{
    qs_arena arena = {.base = (char *)memory};
    qs_eliminate_take(e, of, &arena);
    assert_true(qs_arena_size(&arena) <= sizeof memory);
    qs_eliminate_lay(e, of, walls, kept, labelling);
    qs_model_winner(of, labelling);
    qs_eliminate_begin(e);
}

/* Reduces it and checks all that must hold of any answer. */
static qs_reduction reduce(qs_reduce_options options, uint64_t patience, uint8_t *kept)
{
    uint16_t labelling[TINY_SITES];
    uint8_t before[TINY_SITES * TINY_LABELS];
    qs_elimination e;
    begin_sets(&e, &b.model, options.walls, before, labelling);
    bool at_once = options.target > 0 && e.variables <= options.target;
    qs_reduction r;
    witness w = {kept,       labelling,      options.walls, 0,        patience,
                 UINT64_MAX, options.target, INT64_MIN,     INT64_MAX};
    options.watch = watch;
    options.context = &w;
    assert_true(qs_reduce_workspace(&b.model) <= sizeof memory);
    memset(memory, 0xa5, qs_reduce_workspace(&b.model));
    assert_int_equal(
        qs_reduce(&b.model, &options, memory, qs_reduce_workspace(&b.model), kept, labelling, &r),
        QS_OK);
    check_sets(kept);
    check_counts(kept, options.walls, &r);
    check_labelling(kept, labelling, &r);
    assert_true(w.calls > 0 && w.calls <= patience);
    assert_true(!at_once || (w.calls == 1 &&
                             memcmp(kept, before, (size_t)b.model.sites * b.model.labels) == 0));
    if (options.target > 0 && w.calls < patience && r.variables > options.target) {
        assert_true(r.lower_bound == r.upper_bound || r.iterations == options.iterations);
    }
    return r;
}

static void no_optimum_is_lost(void **unused)
{
    (void)unused;
    uint64_t state = 31;
    uint32_t proven = 0, ties_only = 0, decided = 0;
    for (int round = 0; round < 2 * ROUNDS; round++) {
        uint8_t kept[TINY_SITES * TINY_LABELS];
        make(&state);
        qs_reduction r =
            reduce((qs_reduce_options){.iterations = 100, .walls = round % 2}, UINT64_MAX, kept);
        proven += r.upper_bound == r.lower_bound;
        ties_only += check_sets(kept) == 0;
        decided += r.undecided == 0;
    }
    print_message("proven %u, ties only %u, decided %u of %d\n", proven, ties_only, decided,
                  2 * ROUNDS);
    assert_true(proven > 2 * ROUNDS * 9 / 10);
    assert_true(ties_only > 2 * ROUNDS * 97 / 100);
}

/* The result is not above a start: any labelling, or an optimum. */
static void never_above_the_start(void **unused)
{
    (void)unused;
    uint64_t state = 48;
    uint32_t kept_start = 0;
    for (int round = 0; round < ROUNDS; round++) {
        uint8_t kept[TINY_SITES * TINY_LABELS];
        uint16_t start[TINY_SITES] = {0}, next[TINY_SITES] = {0};
        make(&state);
        for (uint32_t p = 0; p < b.model.sites; p++) {
            for (; !is_there(p, next[p]); next[p]++) {
            }
        }
        bool best = tiny_random(&state, 2);
        do {
            memcpy(start, next, sizeof next);
        } while (best ? qs_model_energy(&b.model, start) > b.minimum && step(next)
                      : tiny_random(&state, 20) && step(next));
        int64_t energy = qs_model_energy(&b.model, start);
        qs_reduction r = reduce(
            (qs_reduce_options){.iterations = 1 + tiny_random(&state, 3), .start = start}, 1, kept);
        assert_true(r.upper_bound <= energy);
        kept_start += r.upper_bound == energy;
    }
    assert_true(kept_start > ROUNDS / 4);
}

/* Stopped anywhere: at a target, by the watch, by the iterations. */
static void stopped_anywhere(void **unused)
{
    (void)unused;
    uint64_t state = 32;
    uint32_t reached = 0;
    for (int round = 0; round < ROUNDS; round++) {
        uint8_t kept[TINY_SITES * TINY_LABELS];
        make(&state);
        qs_reduce_options options = {.iterations = 1 + tiny_random(&state, 12),
                                     .walls = tiny_random(&state, 2)};
        options.target = tiny_random(&state, 3) ? tiny_random(&state, 12) : 0;
        qs_reduction r =
            reduce(options, tiny_random(&state, 2) ? 1 + tiny_random(&state, 5) : UINT64_MAX, kept);
        reached += options.target > 0 && r.variables <= options.target && r.variables > 0;
    }
    assert_true(reached > ROUNDS / 20);
}

/* Parts alone, from any labelling of kept labels. What is closed has its best labelling, and has it
 * again when the caller has replaced it. */
static void parts_are_solved(void **unused)
{
    (void)unused;
    static uint64_t room[WORK / 8];
    uint64_t state = 47;
    uint32_t solved = 0, open = 0;
    for (int round = 0; round < ROUNDS; round++) {
        uint8_t kept[TINY_SITES * TINY_LABELS];
        uint16_t labelling[TINY_SITES];
        qs_elimination e;
        make(&state);
        begin_sets(&e, &b.model, false, kept, labelling);
        size_t size = tiny_random(&state, 3) ? qs_parts_memory(&b.model) : 4 * MEMORY;
        qs_look look = look_that_stops_after(tiny_random(&state, 5000));
        qs_allowance work = {tiny_random(&state, 3) ? UINT64_MAX : tiny_random(&state, 5000),
                             tiny_random(&state, 3) ? NULL : &look};
        bool all = work.left == UINT64_MAX;
        assert_true(size <= sizeof room);
        memset(room, 0xa5, size);
        (void)qs_parts_solve(&e, room, size, &work, NULL);
        check_sets(kept);
        for (uint32_t i = 0; i < e.left_count; i++) {
            open += !e.closed[e.left[i]];
            all = all && e.closed[e.left[i]];
        }
        for (uint32_t i = 0; i < e.left_count; i++) {
            uint16_t *label = &labelling[e.left[i]];
            do {
                *label = (uint16_t)tiny_random(&state, b.model.labels);
            } while (!kept[e.left[i] * b.model.labels + *label]);
        }
        qs_eliminate_restore(&e);
        solved += all;
        assert_true(!all || qs_model_energy(&e.model, labelling) == b.minimum);
    }
    print_message("solved %u of %d, sites left open %u\n", solved, ROUNDS, open);
    assert_true(solved > ROUNDS / 2 && open > 0);
}

static qs_trws_state state_of(void)
{
    qs_trws_state s = {.model = &b.model};
    assert_true(qs_scale_choose(&b.model, 14, &s.scale));
    memset(memory, 0, MEMORY);
    s.messages = (int32_t *)memory + qs_trws_padding(&b.model);
    s.scratch = s.messages + qs_trws_messages(&b.model);
    return s;
}

/* The bound plus the marginal of a label is not above the least energy with that label. On a single
 * chain the two are equal after one iteration. The messages are those of an iteration that finds no
 * marginals. */
static void check_marginals(uint64_t *random, bool chain)
{
    static uint32_t marginal[MEMORY / 4];
    static int32_t once[2 * TINY_SITES * TINY_LABELS];
    b.model.kept = b.model.kept ? b.model.kept : memset(b.kept, 1, sizeof b.kept);
    qs_trws_state s = state_of();
    uint32_t iterations = tiny_random(random, 10) + chain;
    size_t size = sizeof *once * qs_trws_messages(&b.model);
    assert_true(sizeof(uint32_t) * qs_trws_marginal_numbers(&b.model) <= sizeof marginal);
    qs_trws_iterate(&s, iterations + 1);
    memcpy(once, s.messages, size);
    s = state_of();
    qs_trws_iterate(&s, iterations);
    memset(marginal, 0xa5, sizeof marginal);
    int64_t bound = 0, shares[TINY_SITES];
    qs_trws_marginals(&s, marginal, shares);
    for (uint32_t p = 0; p < b.model.sites; p++) {
        bound += shares[p];
    }
    assert_memory_equal(once, s.messages, size);
    for (uint32_t p = 0; p < b.model.sites; p++) {
        for (uint32_t d = 0; d < b.model.labels; d++) {
            if (!is_there(p, d) || is_masked(p)) {
                continue;
            }
            int64_t above = bound + marginal[p * b.model.labels + d],
                    scaled = (b.least[p][d] - b.model.constant) * ((int64_t)1 << s.scale.shift);
            assert_true(above <= scaled);
            assert_true(!chain || above == scaled ||
                        b.model.unary[p * b.model.labels + d] > s.scale.most);
        }
    }
}

static void marginals_are_below_what_labels_cost(void **unused)
{
    (void)unused;
    uint64_t state = 33;
    for (int round = 0; round < 2 * ROUNDS; round++) {
        make(&state);
        check_marginals(&state, false);
    }
}

/* One row, or a list of edges from each site to the next. */
static void marginals_are_exact_on_chains(void **unused)
{
    (void)unused;
    uint64_t state = 34;
    for (int round = 0; round < ROUNDS; round++) {
        tiny_make(&b.t, &state, BITS, false);
        qs_problem *p = &b.t.problem;
        uint32_t sites = qs_problem_sites(p);
        p->grid = (qs_grid){0};
        p->edge_count = 0;
        p->sites = sites;
        if (tiny_random(&state, 2)) {
            p->sites = 0;
            p->edges = NULL;
            p->grid.width = sites;
            p->grid.height = 1;
        }
        for (uint32_t q = 1; q < p->sites; q++) {
            b.t.edges[p->edge_count++] = (qs_edge){q - 1, q, (int32_t)tiny_random(&state, 12)};
            p->edges = b.t.edges;
        }
        build();
        enumerate();
        check_marginals(&state, true);
    }
}

/* What each site charges to its row (or column) in a pass forward from `before` to `after`, as
 * trws.h says. If both its chains go on, each gets a half. If one goes on, it gets all. If none
 * does, the row gets all. */
static void charge(const int32_t *before, const int32_t *after, bool column, qs_scale scale,
                   int32_t charged[TINY_SITES][TINY_LABELS])
{
    const qs_model *m = &b.model;
    for (uint32_t p = 0; p < m->sites; p++) {
        bool left = p > 0 && m->right[p - 1] > 0, up = p >= m->width && m->down[p - m->width] > 0,
             right = m->right[p] > 0, down = m->down[p] > 0;
        bool two = (left && up) || (right && down), all = right || !down;
        for (uint32_t d = 0; d < m->labels; d++) {
            int32_t unary =
                m->unary[p * m->labels + d] < scale.most ? m->unary[p * m->labels + d] : scale.most;
            int32_t row =
                before[2 * m->labels * p + d] + (left ? after[2 * m->labels * (p - 1) + d] : 0);
            int32_t other = before[2 * m->labels * p + m->labels + d] +
                            (up ? after[2 * m->labels * (p - m->width) + m->labels + d] : 0);
            int32_t total = unary * (1 << scale.shift) + row + other,
                    half = (total - (total % 2 != 0 && total < 0)) / 2;
            int32_t part = two ? half : all ? total : 0;
            charged[p][d] = column ? total - part - other : part - row;
        }
    }
}

/* Adds to the marginal of each label of a line of sites what the best labelling of the line with it
 * costs above the line's best. */
static void add_line(int32_t charged[TINY_SITES][TINY_LABELS], uint32_t first, uint32_t length,
                     uint32_t by, const int32_t *weight, unsigned shift,
                     int64_t marginal[TINY_SITES][TINY_LABELS])
{
    uint32_t labels = b.model.labels, labelling[TINY_SITES] = {0};
    int64_t least[TINY_SITES][TINY_LABELS], all = INT64_MAX;
    for (uint32_t i = 0; i < TINY_SITES * TINY_LABELS; i++) {
        least[i / TINY_LABELS][i % TINY_LABELS] = INT64_MAX;
    }
    for (uint32_t at = 0; at < length;) {
        int64_t cost = 0;
        for (uint32_t i = 0; i < length; i++) {
            cost += charged[first + i * by][labelling[i]];
            cost += i > 0 ? weight[first + (i - 1) * by] *
                                qs_model_pairwise(&b.model, labelling[i - 1], labelling[i]) *
                                ((int64_t)1 << shift)
                          : 0;
        }
        all = cost < all ? cost : all;
        for (uint32_t i = 0; i < length; i++) {
            least[i][labelling[i]] = cost < least[i][labelling[i]] ? cost : least[i][labelling[i]];
        }
        for (at = 0; at < length && ++labelling[at] == labels; at++) {
            labelling[at] = 0;
        }
    }
    for (uint32_t i = 0; i < length; i++) {
        for (uint32_t d = 0; d < labels; d++) {
            marginal[first + i * by][d] += least[i][d] - all;
        }
    }
}

static void marginals_by_definition(void **unused)
{
    (void)unused;
    static uint32_t marginal[MEMORY / 4];
    static int32_t before[2 * TINY_SITES * TINY_LABELS];
    static int32_t charged[TINY_SITES][TINY_LABELS];
    uint64_t state = 38;
    for (int round = 0; round < ROUNDS; round++) {
        int64_t expected[TINY_SITES][TINY_LABELS] = {{0}}, shares[TINY_SITES];
        tiny_make(&b.t, &state, BITS, tiny_random(&state, 2));
        build();
        if (b.model.width == 0) {
            continue;
        }
        qs_trws_state s = state_of();
        qs_trws_iterate(&s, tiny_random(&state, 10));
        memcpy(before, s.messages, sizeof *before * qs_trws_messages(&b.model));
        qs_trws_grid_marginals(&s, marginal, shares);
        charge(before, s.messages, false, s.scale, charged);
        for (uint32_t y = 0; y < b.model.height; y++) {
            add_line(charged, y * b.model.width, b.model.width, 1, b.model.right, s.scale.shift,
                     expected);
        }
        charge(before, s.messages, true, s.scale, charged);
        for (uint32_t x = 0; x < b.model.width; x++) {
            add_line(charged, x, b.model.height, b.model.width, b.model.down, s.scale.shift,
                     expected);
        }
        for (uint32_t p = 0; p < b.model.sites; p++) {
            for (uint32_t d = 0; d < b.model.labels; d++) {
                assert_int_equal(marginal[p * b.model.labels + d], expected[p][d]);
            }
        }
    }
}

/* The site's links of weight above 0 to earlier (or later) sites: the number of them, and number
 * `i`. */
static uint32_t links_of(uint32_t site, bool later, uint32_t i, const qs_link **link)
{
    uint32_t count = 0;
    for (uint32_t n = b.model.link_start[site]; n < b.model.link_start[site + 1]; n++) {
        if (b.model.links[n].weight > 0 && (b.model.links[n].site > site) == later) {
            *link = count == i ? &b.model.links[n] : *link;
            count++;
        }
    }
    return count;
}

/* Follows chain `i` from where it begins, part by part, and adds its marginal. */
static void add_chain(const int32_t *before, const int32_t *after, qs_scale scale, uint32_t site,
                      uint32_t i, int64_t marginal[TINY_SITES][TINY_LABELS])
{
    static int32_t charged[TINY_SITES][TINY_LABELS];
    int64_t line[TINY_SITES][TINY_LABELS] = {{0}};
    int32_t weights[TINY_SITES] = {0};
    uint32_t sites[TINY_SITES], length = 0, labels = b.model.labels;
    const qs_link *came = NULL, *link = NULL;
    for (bool more = true; more; length++) {
        uint32_t lower = links_of(site, false, 0, &link), higher = links_of(site, true, 0, &link),
                 chains = lower > higher ? lower : higher;
        sites[length] = site;
        more = i < higher;
        links_of(site, true, i, &link);
        for (uint32_t d = 0; d < labels; d++) {
            int32_t total = b.model.unary[site * labels + d] < scale.most
                                ? b.model.unary[site * labels + d]
                                : scale.most;
            total *= 1 << scale.shift;
            for (uint32_t n = b.model.link_start[site]; n < b.model.link_start[site + 1]; n++) {
                const qs_link *other = &b.model.links[n];
                total += other->weight > 0
                             ? (other->site < site ? after : before)[other->edge * labels + d]
                             : 0;
            }
            int32_t parts = chains > 0 ? (int32_t)chains : 1, rest = total % parts;
            int32_t part =
                total / parts + (rest > 0 && (int32_t)i < rest) - (rest < 0 && (int32_t)i < -rest);
            charged[length][d] = part - (came ? after[came->edge * labels + d] : 0) -
                                 (more ? before[link->edge * labels + d] : 0);
        }
        if (more) {
            weights[length] = link->weight;
            came = link;
            site = link->site;
            const qs_link *back = NULL;
            for (i = 0; links_of(site, false, i, &back) > 0 && back->edge != came->edge; i++) {
            }
        }
    }
    add_line(charged, 0, length, 1, weights, scale.shift, line);
    for (uint32_t at = 0; at < length; at++) {
        for (uint32_t d = 0; d < labels; d++) {
            marginal[sites[at]][d] += line[at][d];
        }
    }
}

static void graph_marginals_by_definition(void **unused)
{
    (void)unused;
    static uint32_t marginal[MEMORY / 4];
    static int32_t before[TINY_EDGES * TINY_LABELS];
    uint64_t state = 43;
    for (int round = 0; round < 4 * ROUNDS; round++) {
        int64_t expected[TINY_SITES][TINY_LABELS] = {{0}}, shares[TINY_SITES];
        make_problem(&state, tiny_random(&state, 2));
        build();
        if (b.model.width > 0) {
            continue;
        }
        qs_trws_state s = state_of();
        qs_trws_iterate(&s, tiny_random(&state, 10));
        memcpy(before, s.messages, sizeof *before * qs_trws_messages(&b.model));
        qs_trws_graph_marginals(&s, marginal, shares);
        for (uint32_t p = 0; p < b.model.sites; p++) {
            const qs_link *link = NULL;
            uint32_t lower = links_of(p, false, 0, &link), higher = links_of(p, true, 0, &link);
            for (uint32_t i = lower; i < higher || (i == 0 && lower + higher == 0); i++) {
                add_chain(before, s.messages, s.scale, p, i, expected);
            }
        }
        for (uint32_t p = 0; p < b.model.sites; p++) {
            for (uint32_t d = 0; d < b.model.labels; d++) {
                assert_int_equal(marginal[p * b.model.labels + d], expected[p][d]);
            }
        }
    }
}

/* Whether Goldstein's criterion of Potts costs still takes out a label, from the definition. */
static bool criterion_holds(const uint8_t *kept, const tiny_edge *edges, size_t count, uint32_t p,
                            uint32_t d, uint32_t e)
{
    uint32_t k = b.model.labels;
    int64_t better = (int64_t)b.model.unary[p * k + d] - b.model.unary[p * k + e];
    for (size_t i = 0; i < count; i++) {
        if (edges[i].p != p && edges[i].q != p) {
            continue;
        }
        uint32_t q = edges[i].p == p ? edges[i].q : edges[i].p;
        int64_t least = INT64_MAX;
        for (uint32_t l = 0; l < k; l++) {
            int64_t change = edges[i].weight * ((d != l) - (e != l));
            least = kept[q * k + l] && change < least ? change : least;
        }
        better += least;
    }
    return better > 0;
}

/* What is out costs more than what is kept, whatever the neighbours; the cheapest that is kept
 * costs 0; a site of one label has no edges. */
static void check_costs(const qs_elimination *e)
{
    b.model = e->model;
    for (uint32_t p = 0; p < b.model.sites; p++) {
        int32_t least = INT32_MAX, highest = 0;
        uint32_t count = 0;
        for (uint32_t d = 0; d < b.model.labels; d++) {
            int32_t cost = e->unary[p * b.model.labels + d];
            if (e->kept[p * b.model.labels + d]) {
                least = cost < least ? cost : least;
                highest = cost > highest ? cost : highest;
                count++;
            }
        }
        for (uint32_t d = 0; d < b.model.labels; d++) {
            assert_true(e->kept[p * b.model.labels + d] ||
                        e->unary[p * b.model.labels + d] >
                            highest + weights_at(p) * b.model.pairwise_max);
        }
        assert_int_equal(least, 0);
        assert_true(count > 1 || weights_at(p) == 0);
    }
}

/* Alone: no optimum is lost, and when it is done there is nothing more that the criterion takes
 * out. */
static void goldstein_by_definition(void **unused)
{
    (void)unused;
    uint64_t state = 35;
    uint32_t taken = 0;
    for (int round = 0; round < ROUNDS; round++) {
        uint8_t kept[TINY_SITES * TINY_LABELS];
        uint16_t labelling[TINY_SITES];
        qs_elimination e;
        make_problem(&state, round % 4 > 0);
        build();
        if (tiny_random(&state, 4) == 0) {
            thin_out(&state);
        }
        enumerate();
        qs_model given = b.model;
        begin_sets(&e, &b.model, false, kept, labelling);
        taken += check_sets(kept) > 0;
        qs_reduction r = {.upper_bound = qs_model_energy(&b.model, labelling),
                          .lower_bound = QS_NO_BOUND};
        check_labelling(kept, labelling, &r);
        assert_int_equal(qs_model_energy(&e.model, labelling), r.upper_bound);
        check_costs(&e);
        tiny_edge edges[TINY_EDGES];
        size_t count = tiny_edges(&b.t.problem, edges);
        b.model = given;
        for (uint32_t i = 0; i < b.model.sites * b.model.labels * b.model.labels && !b.model.mask &&
                             b.model.pairwise.smoothness == QS_POTTS;
             i++) {
            uint32_t f = i % b.model.labels, d = i / b.model.labels % b.model.labels,
                     p = i / b.model.labels / b.model.labels;
            if (kept[p * b.model.labels + d] && kept[p * b.model.labels + f] && d != f) {
                assert_false(criterion_holds(kept, edges, count, p, d, f));
            }
        }
    }
    assert_true(taken > ROUNDS / 10);
}

/* Costs too large for messages in 32 bits: all holds, and most is proven all the same. */
static void huge_costs(void **unused)
{
    (void)unused;
    uint64_t state = 36;
    uint32_t large = 0, proven = 0;
    for (int round = 0; round < ROUNDS / 4; round++) {
        uint8_t kept[TINY_SITES * TINY_LABELS];
        tiny_make(&b.t, &state, BITS, tiny_random(&state, 2));
        if (b.t.problem.labels == 1) {
            continue;
        }
        int32_t times = 1 << (24 + tiny_random(&state, 3));
        for (uint32_t i = 0; i < TINY_SITES * TINY_LABELS; i++) {
            b.t.costs[i] *=
                b.t.costs[i] < INT32_MAX / times / 2 && b.t.costs[i] > -INT32_MAX / times / 2
                    ? times
                    : 1;
        }
        b.t.problem.weight *= times;
        for (uint32_t i = 0; i < TINY_SITES; i++) {
            b.t.right[i] *= times;
            b.t.down[i] *= times;
        }
        for (size_t i = 0; i < b.t.problem.edge_count; i++) {
            b.t.edges[i].weight *= times;
        }
        build();
        enumerate();
        qs_reduction r = reduce((qs_reduce_options){.iterations = 20}, UINT64_MAX, kept);
        large += !qs_messages_fit(&b.model, true);
        proven += !qs_messages_fit(&b.model, true) && r.lower_bound == r.upper_bound;
    }
    assert_true(large > ROUNDS / 50);
    assert_true(proven > large / 2);
}

static bool bounds_hold(void *context, const qs_reduction *r)
{
    const int64_t *minimum = context;
    assert_true(r->lower_bound <= *minimum && *minimum <= r->upper_bound);
    return true;
}

/* With targets, so that labels leave in many iterations, each of which must leave the rest
 * right. */
static void larger_grids_step_by_step(void **unused)
{
    (void)unused;
    static wide_grid g;
    uint64_t state = 44;
    uint64_t left[2] = {0}, before = 0;
    for (int round = 0; round < ROUNDS / 10; round++) {
        uint8_t kept[COLUMNS * ROWS * WIDE_LABELS];
        uint16_t labelling[COLUMNS * ROWS];
        qs_reduction r;
        make_wide(&g, &state);
        int64_t minimum = least_with(&g, g.model.sites, 0);
        qs_reduce_options options = {
            .target = 1 + tiny_random(&state, 30), .watch = bounds_hold, .context = &minimum};
        assert_int_equal(qs_reduce(&g.model, &options, memory, sizeof memory, kept, labelling, &r),
                         QS_OK);
        assert_int_equal(qs_model_energy(&g.model, labelling), r.upper_bound);
        assert_true(r.variables <= options.target || r.lower_bound == r.upper_bound ||
                    r.iterations == 2000);
        for (uint32_t p = 0; p < g.model.sites; p++) {
            assert_true(kept[p * WIDE_LABELS + labelling[p]]);
        }
        qs_elimination e;
        begin_sets(&e, &g.model, false, kept, labelling);
        before += e.variables;
        for (int i = 0; i < 2;
             i++) { /* to the end of the iterations: at the last one labels leave, too */
            options = (qs_reduce_options){
                .iterations = 1 + (uint64_t)i, .watch = bounds_hold, .context = &minimum};
            assert_int_equal(
                qs_reduce(&g.model, &options, memory, sizeof memory, kept, labelling, &r), QS_OK);
            assert_int_equal(qs_model_energy(&g.model, labelling), r.upper_bound);
            left[i] += r.variables;
        }
    }
    print_message("variables by Goldstein's criterion %d, after one iteration %d, after two %d\n",
                  (int)before, (int)left[0], (int)left[1]);
    assert_true(left[0] < before / 4 && left[1] < left[0]);
}

/* With sets of labels there is room for a label that leaves, and for the marginal. */
static void scale_has_room(void **unused)
{
    (void)unused;
    uint64_t state = 41;
    for (int round = 0; round < ROUNDS; round++) {
        make_problem(&state, false);
        build();
        memset(b.kept, 1, sizeof b.kept);
        b.model.kept = b.kept;
        qs_scale scale;
        assert_true(qs_scale_choose(&b.model, 29, &scale));
        int64_t edges = 0, most = 0, neighbours = 4;
        for (uint32_t p = 0; p < b.model.sites; p++) {
            edges = weights_at(p) * b.model.pairwise_max > edges
                        ? weights_at(p) * b.model.pairwise_max
                        : edges;
            for (uint32_t n = b.model.width > 0 ? 0 : b.model.link_start[p];
                 b.model.width == 0 && n < b.model.link_start[p + 1]; n++) {
                most = b.model.links[n].weight > most ? b.model.links[n].weight : most;
            }
            if (b.model.width > 0) {
                most = b.model.right[p] > most ? b.model.right[p] : most;
                most = b.model.down[p] > most ? b.model.down[p] : most;
            } else {
                uint32_t links = b.model.link_start[p + 1] - b.model.link_start[p];
                neighbours = p == 0 || links > neighbours ? links : neighbours;
            }
        }
        assert_true(scale.most > edges);
        assert_true((scale.most + (neighbours + 3) * most * b.model.pairwise_max) *
                        ((int64_t)1 << scale.shift) <=
                    INT32_MAX);
    }
}

static void mended_by_definition(void **unused)
{
    (void)unused;
    uint64_t state = 42;
    for (int round = 0; round < ROUNDS; round++) {
        uint16_t labelling[TINY_SITES], best = 0;
        make_problem(&state, false);
        build();
        thin_out(&state);
        for (uint32_t i = 0; i < b.model.sites * b.model.labels; i++) {
            b.unary[i] = (int32_t)tiny_random(&state, 10); /* what is out may be cheap here */
        }
        for (uint32_t p = 0; p < b.model.sites; p++) {
            labelling[p] = (uint16_t)tiny_random(&state, b.model.labels);
        }
        uint32_t site = tiny_random(&state, b.model.sites);
        uint16_t old = labelling[site];
        int64_t least = INT64_MAX;
        for (uint16_t d = 0; d < b.model.labels; d++) {
            labelling[site] = d;
            if (b.kept[site * b.model.labels + d] && qs_model_energy(&b.model, labelling) < least) {
                least = qs_model_energy(&b.model, labelling);
                best = d;
            }
        }
        labelling[site] = old;
        bool was = b.kept[site * b.model.labels + old];
        assert_int_equal(qs_take_kept_label(&b.model, labelling, site), !was);
        assert_int_equal(labelling[site], was ? old : best);
    }
}

static void refusals(void **unused)
{
    (void)unused;
    uint64_t state = 37;
    uint8_t kept[TINY_SITES * TINY_LABELS];
    uint16_t labelling[TINY_SITES];
    qs_reduction r;
    make(&state);
    size_t size = qs_reduce_workspace(&b.model);
    assert_int_equal(qs_reduce(NULL, NULL, memory, size, kept, labelling, &r), QS_E_ARGUMENT);
    assert_int_equal(qs_reduce(&b.model, NULL, NULL, size, kept, labelling, &r), QS_E_ARGUMENT);
    assert_int_equal(qs_reduce(&b.model, NULL, memory, size, NULL, labelling, &r), QS_E_ARGUMENT);
    assert_int_equal(qs_reduce(&b.model, NULL, memory, size, kept, NULL, &r), QS_E_ARGUMENT);
    assert_int_equal(qs_reduce(&b.model, NULL, memory, size, kept, labelling, NULL), QS_E_ARGUMENT);
    uint16_t beyond[TINY_SITES] = {(uint16_t)b.model.labels};
    assert_int_equal(qs_reduce(&b.model, &(qs_reduce_options){.start = beyond}, memory, size, kept,
                               labelling, &r),
                     QS_E_ARGUMENT);
    assert_int_equal(qs_reduce(&b.model, NULL, memory, size - 1, kept, labelling, &r),
                     QS_E_WORKSPACE);
    assert_int_equal(qs_reduce(&b.model, NULL, memory, size, kept, labelling, &r), QS_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_optimum_is_lost),
        cmocka_unit_test(stopped_anywhere),
        cmocka_unit_test(never_above_the_start),
        cmocka_unit_test(parts_are_solved),
        cmocka_unit_test(marginals_are_below_what_labels_cost),
        cmocka_unit_test(marginals_are_exact_on_chains),
        cmocka_unit_test(marginals_by_definition),
        cmocka_unit_test(graph_marginals_by_definition),
        cmocka_unit_test(goldstein_by_definition),
        cmocka_unit_test(huge_costs),
        cmocka_unit_test(larger_grids_step_by_step),
        cmocka_unit_test(scale_has_room),
        cmocka_unit_test(mended_by_definition),
        cmocka_unit_test(refusals),
    };
    return cmocka_run_group_tests_name("reduce", tests, NULL, NULL);
}
