#include "window_search.h"

#include <string.h>

#include "../base/minmax.h"
#include "../base/simd.h"
#include "../model/neighbours.h"

enum {
    ITERATIONS = 20, /* of messages after a site has been fixed */
    NODES = 1 << 12,
    AROUND = 3, /* a site is chosen by the gap of as many cells around it */
    LEAST_PART = 32, /* parts within a LEAST_PART-th of a unit of the best labelling are left out */
    NUMBERS_A_LABEL = 8 /* that an iteration looks at */
};

#define ROOT UINT32_MAX

/* A part of the labellings: those of its parent with one label at a cell. */
typedef struct node {
    int64_t bound;
    uint32_t parent, cell;
    uint16_t label;
    bool open;
} node;

typedef struct search {
    qs_block *b;
    qs_model model; /* of the part that is looked at: the window with sites fixed */
    int32_t *unary; /* its */
    qs_trws_state state;
    uint32_t *visits; /* cells with edges */
    uint32_t visit_count;
    size_t message_count;
    int32_t *root, *parent; /* messages of the whole window, and of the part that is divided */
    node *nodes;
    uint32_t count;
    int64_t *gaps; /* of cells, for the labelling of the messages */
    uint32_t *marginals;
    int64_t unit;
    qs_allowance *work;
} search;

int64_t qs_gap_at(const qs_trws_state *state, const int64_t *shares, const uint16_t *labelling,
                  uint32_t site)
{
    const qs_model *model = state->model;
    size_t labels = model->labels, label = labelling[site];
    const qs_number *own = state->messages + 2 * labels * site;
    int64_t gap = qs_scaled_cost(model, state->scale, labels * site + label) - shares[site];
    gap += (own - 2 * labels)[label] + (own - 2 * labels * model->width + labels)[label];
    qs_edge_seen edge;
    for (uint32_t at = 0; qs_see_edge(model, site, at, &edge); at++) {
        if (edge.weight > 0 && edge.first) {
            uint32_t other = labelling[edge.site];
            gap += qs_seen_cost(model, &edge, (uint32_t)label, other) *
                   ((int64_t)1 << state->scale.shift);
            gap -= (qs_is_vertical(&edge) ? own + labels : own)[other];
        }
    }
    return gap;
}

/* Takes the memory behind the block's. Returns false if it does not suffice. */
static bool take(search *s)
{
    qs_block *b = s->b;
    const qs_model *model = &b->model;
    qs_arena arena = {.base = (char *)b->marginals};
    s->message_count = (size_t)qs_trws_messages(model);
    s->marginals = qs_arena_take(&arena, qs_trws_marginal_numbers(model), sizeof *s->marginals);
    s->unary = qs_arena_take(&arena, (uint64_t)model->sites * model->labels, sizeof *s->unary);
    s->visits = qs_arena_take(&arena, model->sites, sizeof *s->visits);
    s->root = qs_arena_take(&arena, s->message_count, sizeof *s->root);
    s->parent = qs_arena_take(&arena, s->message_count, sizeof *s->parent);
    s->gaps = qs_arena_take(&arena, model->sites, sizeof *s->gaps);
    s->nodes = qs_arena_take(&arena, NODES, sizeof *s->nodes);
    return qs_arena_size(&arena) <= b->parts_size;
}

static void list_visits(search *s)
{
    s->visit_count = 0;
    for (uint32_t c = 0; c < s->model.sites; c++) {
        qs_edge_seen edge;
        bool joined = false;
        for (uint32_t at = 0; !joined && qs_see_edge(&s->model, c, at, &edge); at++) {
            joined = edge.weight > 0;
        }
        if (joined) {
            s->visits[s->visit_count++] = c;
        }
    }
}

static void begin(search *s)
{
    s->model = s->b->model;
    s->model.unary = s->unary;
    s->state = s->b->state;
    s->state.model = &s->model;
    s->state.wide = qs_lanes_avx2();
    s->state.look = NULL;
    list_visits(s);
    s->state.visits = s->visits;
    s->state.visit_count = s->visit_count;
}

static void copy_messages(const search *s, int32_t *to, const int32_t *from)
{
    memcpy(to, from, sizeof *to * s->message_count);
}

/* A cell may have one label only. */
static void fix(search *s, uint32_t cell, uint32_t label)
{
    int32_t *unary = s->unary + (size_t)cell * s->model.labels;
    s->model.constant += unary[label];
    for (uint32_t d = 0; d < s->model.labels; d++) {
        unary[d] = d == label ? 0 : INT32_MAX;
    }
}

/* The costs of a part. */
static void lay(search *s, uint32_t at)
{
    size_t all = (size_t)s->model.sites * s->model.labels;
    memcpy(s->unary, s->b->unary, sizeof *s->unary * all);
    s->model.constant = s->b->model.constant;
    for (; at != 0; at = s->nodes[at].parent) {
        fix(s, s->nodes[at].cell, s->nodes[at].label);
    }
}

static int64_t scaled(const search *s, int64_t energy)
{
    return energy * ((int64_t)1 << s->state.scale.shift);
}

static void pay(search *s, uint64_t iterations)
{
    (void)qs_spend(s->work, iterations * NUMBERS_A_LABEL * s->visit_count * s->model.labels + 1);
}

/* Returns the bound after some iterations. */
static int64_t iterate(search *s)
{
    int64_t bound = INT64_MIN;
    for (uint32_t i = 0; i < ITERATIONS; i++) {
        (void)qs_trws_grid_pass(&s->state, true);
        bound = qs_trws_grid_pass(&s->state, false);
    }
    pay(s, ITERATIONS);
    return bound + scaled(s, s->model.constant);
}

/* No part is of interest that costs so much. */
static int64_t limit_of(const search *s)
{
    return scaled(s, s->b->energy) - s->unit / LEAST_PART;
}

/* Takes the trial if it is better than the best labelling. */
static void offer(search *s)
{
    qs_block *b = s->b;
    int64_t energy = qs_model_energy(&b->model, b->trial);
    if (energy < b->energy) {
        b->energy = energy;
        memcpy(b->labelling, b->trial, sizeof *b->trial * b->model.sites);
    }
}

/* Makes a labelling from the messages, then finds marginals, shares and gaps. Returns the bound
 * that the marginals are above. */
static int64_t examine(search *s)
{
    qs_block *b = s->b;
    qs_solution ended;
    int64_t bound = 0;
    qs_trws_grid_labels(&s->state, true, b->trial);
    if (qs_icm(&s->model, NULL, NULL, 0, b->trial, &ended) == QS_OK) {
        offer(s);
    }
    qs_trws_grid_marginals(&s->state, s->marginals, b->shares);
    memset(s->gaps, 0, sizeof *s->gaps * s->model.sites);
    for (uint32_t i = 0; i < s->visit_count; i++) {
        uint32_t c = s->visits[i];
        s->gaps[c] = qs_max_i64(qs_gap_at(&s->state, b->shares, b->trial, c), 0);
        bound += b->shares[c];
    }
    (void)qs_trws_grid_pass(&s->state, false);
    pay(s, 4);
    return bound + scaled(s, s->model.constant);
}

static int64_t gap_around(const search *s, uint32_t cell)
{
    uint32_t width = s->model.width, x = cell % width, y = cell / width;
    uint32_t left = x > AROUND ? x - AROUND : 0, top = y > AROUND ? y - AROUND : 0;
    int64_t sum = 0;
    for (uint32_t v = top; v <= y + AROUND && v < s->model.height; v++) {
        for (uint32_t h = left; h <= x + AROUND && h < width; h++) {
            sum += s->gaps[v * width + h];
        }
    }
    return sum;
}

/* The two labels with the least marginals. Returns the second marginal. */
static uint32_t second_least(const search *s, uint32_t cell, uint16_t *first)
{
    const uint32_t *more = s->marginals + (size_t)cell * s->model.labels;
    uint32_t least = UINT32_MAX, second = UINT32_MAX;
    *first = 0;
    for (uint32_t d = 0; d < s->model.labels; d++) {
        if (more[d] < least) {
            second = least;
            least = more[d];
            *first = (uint16_t)d;
        } else {
            second = qs_min_u32(second, more[d]);
        }
    }
    return second;
}

/* The cell to divide a part by: with a large gap around it, and two labels that are both good. If
 * no cell has two that may be below the limit, then one labelling at most may: it becomes the
 * trial. */
static uint32_t choose(search *s, int64_t bound)
{
    enum { FINE = 256 };
    uint32_t best = ROOT;
    int64_t best_score = -1, limit = limit_of(s);
    for (uint32_t i = 0; i < s->visit_count; i++) {
        uint32_t c = s->visits[i], second = second_least(s, c, &s->b->trial[c]);
        if (bound + second < limit) {
            int64_t score = gap_around(s, c) * FINE / (s->unit + second);
            best = score > best_score ? c : best;
            best_score = qs_max_i64(score, best_score);
        }
    }
    return best;
}

/* Cells without edges have their cheapest label. */
static void label_alone(search *s)
{
    for (uint32_t c = 0; c < s->model.sites; c++) {
        s->b->trial[c] =
            (uint16_t)qs_first_least(s->unary + (size_t)c * s->model.labels, s->model.labels);
    }
}

static void add_node(search *s, int64_t bound, uint32_t parent, uint32_t cell, uint32_t label)
{
    s->nodes[s->count++] = (node){bound, parent, cell, (uint16_t)label, true};
}

/* A part, divided: each label of a cell that may be below the limit makes a new one. */
static void divide(search *s, uint32_t at)
{
    int64_t bound = examine(s), own = s->nodes[at].bound;
    label_alone(s);
    uint32_t cell = choose(s, bound);
    s->nodes[at].open = false;
    if (cell == ROOT) {
        offer(s);
        return;
    }
    copy_messages(s, s->parent, s->state.messages);
    const uint32_t *more = s->marginals + (size_t)cell * s->model.labels;
    for (uint32_t d = 0; d < s->model.labels; d++) {
        int64_t least = qs_max_i64(own, bound + more[d]);
        if (least < limit_of(s) && s->work->left > 0) {
            lay(s, at);
            fix(s, cell, d);
            copy_messages(s, s->state.messages, s->parent);
            least = qs_max_i64(least, iterate(s));
        }
        if (least < limit_of(s)) {
            add_node(s, least, at, cell, d);
        }
    }
}

/* The open part with the lowest bound; ROOT = there is none. */
static uint32_t lowest(const search *s)
{
    uint32_t least = ROOT;
    for (uint32_t i = 0; i < s->count; i++) {
        if (s->nodes[i].open && (least == ROOT || s->nodes[i].bound < s->nodes[least].bound)) {
            least = i;
        }
    }
    return least;
}

/* The messages of a part, from those of the whole window. */
static void enter(search *s, uint32_t at)
{
    lay(s, at);
    copy_messages(s, s->state.messages, s->root);
    if (at != 0) {
        s->nodes[at].bound = qs_max_i64(s->nodes[at].bound, iterate(s));
    }
}

int64_t qs_window_search(qs_block *b, int64_t unit, qs_allowance *work)
{
    search s = {.b = b, .unit = unit, .work = work};
    if (!take(&s)) {
        return INT64_MIN;
    }
    begin(&s);
    lay(&s, 0);
    int64_t bound = iterate(&s);
    copy_messages(&s, s.root, s.state.messages);
    add_node(&s, bound, ROOT, 0, 0);
    uint32_t at = 0;
    while (at != ROOT && s.nodes[at].bound < limit_of(&s) && work->left > 0 &&
           s.count + s.model.labels < NODES) {
        int64_t before = s.nodes[at].bound;
        enter(&s, at);
        if (s.nodes[at].bound == before || lowest(&s) == at) {
            divide(&s, at);
        }
        at = lowest(&s);
    }
    int64_t least = at != ROOT ? s.nodes[at].bound : INT64_MAX;
    return qs_max_i64(bound, qs_min_i64(least, limit_of(&s)));
}
