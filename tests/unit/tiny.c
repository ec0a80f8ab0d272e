#include "tiny.h"

#include <string.h>

/* SplitMix64. */
uint32_t tiny_random(uint64_t *state, uint32_t below)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (uint32_t)((z ^ z >> 31) >> 16) % below;
}

static int32_t random_cost(uint64_t *state, uint32_t kind, int32_t weight)
{
    switch (kind) {
    case 0: return (int32_t)tiny_random(state, 60) - 10;
    case 1: return tiny_random(state, 4) == 0 ? 0 : 200;
    case 2: return 0;
    case 3: return (int32_t)tiny_random(state, 2);
    default: return weight * (int32_t)tiny_random(state, 4);
    }
}

static void make_edges(tiny *t, uint64_t *state)
{
    qs_problem *p = &t->problem;
    for (uint32_t a = 0; a < p->sites; a++) {
        for (uint32_t b = a + 1; b < p->sites; b++) {
            if (p->edge_count < TINY_EDGES && tiny_random(state, 3) > 0) {
                t->edges[p->edge_count++] = (qs_edge){a, b, (int32_t)tiny_random(state, 12)};
            }
        }
    }
    p->edges = t->edges;
}

static void make_grid(tiny *t, uint64_t *state, uint32_t cells)
{
    qs_problem *p = &t->problem;
    p->grid.width = 1 + tiny_random(state, cells);
    p->grid.height = 1 + tiny_random(state, cells / p->grid.width);
    cells = p->grid.width * p->grid.height;
    if (tiny_random(state, 3) == 0) {
        for (uint32_t c = 0; c < cells; c++) {
            t->mask[c] = tiny_random(state, 4) > 0;
        }
        t->mask[tiny_random(state, cells)] = 1;
        p->grid.mask = t->mask;
    }
    if (tiny_random(state, 3) == 0) {
        for (uint32_t c = 0; c < cells; c++) {
            t->right[c] = (int32_t)tiny_random(state, 9);
            t->down[c] = (int32_t)tiny_random(state, 9);
        }
        p->grid.right = t->right;
        p->grid.down = t->down;
    }
}

static void make_smoothness(tiny *t, uint64_t *state)
{
    qs_problem *p = &t->problem;
    p->pairwise.smoothness = (qs_smoothness)tiny_random(state, 4);
    p->pairwise.truncation = tiny_random(state, 4);
    for (uint32_t i = 0; i < p->labels * p->labels; i++) {
        t->table[i] = (int32_t)tiny_random(state, 7);
    }
    p->pairwise.table = t->table;
}

void tiny_make(tiny *t, uint64_t *state, uint32_t bits, bool potts)
{
    memset(t, 0, sizeof *t);
    qs_problem *p = &t->problem;
    p->labels = 1 + tiny_random(state, 5);
    p->scale = 1;
    p->weight = (int32_t)tiny_random(state, 15);
    uint32_t most = bits / p->labels < TINY_SITES ? bits / p->labels : TINY_SITES;
    if (tiny_random(state, 4) == 0) {
        p->sites = 1 + tiny_random(state, most);
        make_edges(t, state);
    } else {
        make_grid(t, state, most);
    }
    if (!potts) {
        make_smoothness(t, state);
    }
    uint32_t kind = tiny_random(state, 5);
    for (uint32_t i = 0; i < TINY_SITES * TINY_LABELS; i++) {
        t->costs[i] = random_cost(state, kind, p->weight);
    }
    p->costs = t->costs;
}

void tiny_encode(const qs_problem *problem, qs_encode_options options, tiny_qubo *q)
{
    qs_buffer buffer = {q->file, sizeof q->file, 0};
    qs_sink sink = qs_buffer_sink(&buffer);
    uint64_t memory[8192];
    assert_true(qs_encode_workspace(problem) <= sizeof memory);
    assert_int_equal(
        qs_encode(problem, &options, &sink, memory, qs_encode_workspace(problem), NULL), QS_OK);
    q->size = buffer.size;
    assert_int_equal(qs_qubo_open(q->file, q->size, TINY_INDEX, &q->qubo, NULL), QS_OK);
    assert_int_equal(qs_index_build(&q->qubo, q->memory, qs_index_workspace(&q->qubo), &q->index),
                     QS_OK);
}

int64_t tiny_minimum(const qs_problem *problem)
{
    uint16_t labelling[TINY_SITES] = {0};
    uint32_t sites = qs_problem_sites(problem);
    int64_t least = INT64_MAX;
    for (bool more = true; more;) {
        int64_t energy;
        assert_int_equal(qs_problem_energy(problem, labelling, NULL, 65536, &energy), QS_OK);
        least = energy < least ? energy : least;
        more = false;
        for (uint32_t p = 0; p < sites && !more; p++) {
            more = ++labelling[p] < problem->labels;
            labelling[p] = more ? labelling[p] : 0;
        }
    }
    return least;
}

void tiny_bits(uint32_t state, uint8_t bits[4])
{
    for (int i = 0; i < 4; i++) {
        bits[i] = (uint8_t)(state >> 8 * i);
    }
}

size_t tiny_edges(const qs_problem *problem, tiny_edge edges[TINY_EDGES])
{
    const qs_grid *grid = &problem->grid;
    size_t count = 0;
    for (size_t e = 0; grid->width == 0 && e < problem->edge_count; e++) {
        edges[count++] = (tiny_edge){problem->edges[e].first, problem->edges[e].second,
                                     problem->edges[e].weight};
    }
    int site[TINY_SITES], next = 0;
    for (uint32_t c = 0; c < grid->width * grid->height; c++) {
        site[c] = grid->mask && grid->mask[c] == 0 ? -1 : next++;
    }
    for (uint32_t c = 0; c < grid->width * grid->height; c++) {
        uint32_t right = c + 1, down = c + grid->width;
        if (right % grid->width != 0 && site[c] >= 0 && site[right] >= 0) {
            edges[count++] = (tiny_edge){(uint32_t)site[c], (uint32_t)site[right],
                                         grid->right ? grid->right[c] : problem->weight};
        }
        if (down < grid->width * grid->height && site[c] >= 0 && site[down] >= 0) {
            edges[count++] = (tiny_edge){(uint32_t)site[c], (uint32_t)site[down],
                                         grid->down ? grid->down[c] : problem->weight};
        }
    }
    return count;
}

int64_t tiny_energy(const qs_problem *problem, bool sparse, const qs_index *index, uint32_t state)
{
    uint32_t labels = problem->labels, sites = qs_problem_sites(problem);
    int64_t energy = 0;
    for (uint32_t p = 0; p < sites; p++) {
        int64_t a, b, hot = 0, least = INT64_MAX;
        qs_index_penalty(index, p, &a, &b);
        for (uint32_t d = 0; d < labels; d++) {
            int64_t cost = problem->costs[p * labels + d];
            least = cost < least ? cost : least;
        }
        for (uint32_t d = 0; d < labels; d++) {
            if (state >> (p * labels + d) & 1) {
                hot++;
                energy += problem->costs[p * labels + d] - least;
            }
        }
        energy += least + a * (1 - hot) + b * hot * (hot - 1) / 2;
    }
    tiny_edge edges[TINY_EDGES];
    size_t count = tiny_edges(problem, edges);
    for (size_t e = 0; e < count; e++) {
        int64_t pairs = sparse;
        for (uint32_t d1 = 0; d1 < labels; d1++) {
            for (uint32_t d2 = 0; d2 < labels; d2++) {
                bool both = (state >> (edges[e].p * labels + d1) & 1) &&
                            (state >> (edges[e].q * labels + d2) & 1);
                if (both) {
                    pairs += sparse ? -(d1 == d2) : qs_pairwise_cost(problem, d1, d2);
                }
            }
        }
        energy += edges[e].weight * pairs;
    }
    return energy;
}
