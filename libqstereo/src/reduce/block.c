#include "block.h"

#include <string.h>

#include "../base/minmax.h"
#include "../base/simd.h"
#include "../model/neighbours.h"
#include "parts.h"

enum {
    FINEST = 14, /* the scale of messages, as of TRW-S */
    STEPS = 4, /* of BETWEEN, 2 BETWEEN, 3 BETWEEN .. iterations */
    BETWEEN = 8,
    WORK_A_LABEL = 8 * (STEPS + 1) * STEPS / 2 * BETWEEN /* on parts: about as much as messages */
};

static uint32_t cells_of(qs_rectangle at)
{
    return at.width * at.height;
}

static void take_messages(qs_block *b, qs_arena *arena)
{
    uint64_t padding = qs_trws_padding(&b->model);
    int32_t *padded = qs_arena_take(arena, padding + qs_trws_messages(&b->model), sizeof *padded);
    b->state.messages = padded ? padded + padding : NULL;
    b->state.scratch = qs_arena_take(arena, qs_trws_scratch(&b->model), sizeof *b->state.scratch);
}

bool qs_block_take(qs_block *b, const qs_model *whole, qs_rectangle at, void *memory, size_t size)
{
    qs_arena arena = {.base = memory};
    uint64_t cells = cells_of(at), labels = whole->labels;
    *b = (qs_block){.at = at};
    if (whole->tables) {
        return false; /* edges of the window would have other numbers */
    }
    b->model = (qs_model){.sites = cells_of(at),
                          .labels = whole->labels,
                          .pairwise = whole->pairwise,
                          .pairwise_max = whole->pairwise_max,
                          .width = at.width,
                          .height = at.height};
    b->unary = qs_arena_take(&arena, cells * labels, sizeof *b->unary);
    b->right = qs_arena_take(&arena, cells, sizeof *b->right);
    b->down = qs_arena_take(&arena, cells, sizeof *b->down);
    b->kept = qs_arena_take(&arena, cells * labels, 1);
    b->kept_in = qs_arena_take(&arena, cells * labels, 1);
    b->labelling = qs_arena_take(&arena, cells, sizeof *b->labelling);
    b->trial = qs_arena_take(&arena, cells, sizeof *b->trial);
    qs_eliminate_take(&b->sets, &b->model, &arena);
    take_messages(b, &arena);
    b->shares = qs_arena_take(&arena, cells, sizeof *b->shares);
    size_t used = qs_arena_size(&arena);
    uint64_t least = qs_trws_marginal_numbers(&b->model) * sizeof *b->marginals;
    if (used > size || size - used < least) {
        return false;
    }
    b->parts_size = size - used;
    b->marginals = qs_arena_take(&arena, b->parts_size, 1);
    return true;
}

static bool is_inside(const qs_block *b, const qs_model *whole, uint32_t site)
{
    uint32_t x = site % whole->width, y = site / whole->width;
    return x >= b->at.x && x - b->at.x < b->at.width && y >= b->at.y && y - b->at.y < b->at.height;
}

static void copy_cell(qs_block *b, const qs_model *whole, uint32_t cell)
{
    uint32_t site = qs_block_site(b, whole, cell);
    size_t labels = whole->labels, from = site * labels, to = cell * labels;
    memcpy(b->unary + to, whole->unary + from, sizeof *b->unary * labels);
    memcpy(b->kept + to, whole->kept + from, labels);
    b->right[cell] = (cell + 1) % b->at.width != 0 ? whole->right[site] : 0;
    b->down[cell] = cell + b->at.width < b->model.sites ? whole->down[site] : 0;
    b->labelling[cell] = 0;
}

/* Adds what an edge to a site outside costs with the label that this one has. Returns false if a
 * cost would be too large. */
static bool add_edge(qs_block *b, const qs_model *whole, uint32_t cell, const qs_edge_seen *edge,
                     uint32_t other)
{
    int32_t *unary = b->unary + (size_t)cell * whole->labels;
    const uint8_t *kept = b->kept + (size_t)cell * whole->labels;
    for (uint32_t d = 0; d < whole->labels; d++) {
        int64_t cost = qs_seen_cost(whole, edge, d, other);
        if (kept[d] && cost > INT32_MAX - unary[d]) {
            return false;
        }
        unary[d] += kept[d] ? (int32_t)cost : 0;
    }
    return true;
}

int32_t qs_settle_costs(int32_t *unary, const uint8_t *kept, uint32_t labels)
{
    int32_t least = INT32_MAX;
    for (uint32_t d = 0; d < labels; d++) {
        least = kept[d] ? qs_min_i32(least, unary[d]) : least;
    }
    for (uint32_t d = 0; d < labels; d++) {
        unary[d] = kept[d] ? unary[d] - least : INT32_MAX;
    }
    return least;
}

/* A cell that is not of the window: it has no edges, and no label costs anything. */
static void leave_out(qs_block *b, uint32_t cell)
{
    size_t labels = b->model.labels;
    memset(b->unary + cell * labels, 0, sizeof *b->unary * labels);
    memset(b->kept + cell * labels, 1, labels);
    b->right[cell] = b->down[cell] = 0;
    b->labelling[cell] = 0;
}

static void clear_messages(qs_block *b)
{
    uint64_t padding = qs_trws_padding(&b->model);
    memset(b->state.messages - padding, 0,
           sizeof *b->state.messages * (size_t)(padding + qs_trws_messages(&b->model)));
}

/* The costs are there: the model gets them. */
static void complete(qs_block *b)
{
    b->model.unary = b->unary;
    b->model.right = b->right;
    b->model.down = b->down;
    b->model.kept = b->kept;
    b->energy = qs_model_energy(&b->model, b->labelling);
    b->bound = QS_NO_BOUND;
}

bool qs_block_hold(qs_block *b, const qs_model *whole, const uint16_t *labelling)
{
    size_t labels = whole->labels;
    b->model.constant = 0;
    for (uint32_t c = 0; c < b->model.sites; c++) {
        uint32_t site = qs_block_site(b, whole, c);
        qs_edge_seen edge;
        copy_cell(b, whole, c);
        for (uint32_t at = 0; qs_see_edge(whole, site, at, &edge); at++) {
            bool border = edge.weight > 0 && !is_inside(b, whole, edge.site);
            if (border && !add_edge(b, whole, c, &edge, labelling[edge.site])) {
                return false;
            }
        }
        b->model.constant +=
            qs_settle_costs(b->unary + labels * c, b->kept + labels * c, whole->labels);
        b->labelling[c] = labelling[site];
    }
    complete(b);
    return true;
}

void qs_block_cut(qs_block *b, const qs_trws_state *cut, const int64_t *base, const uint8_t *window,
                  uint8_t number, const uint16_t *labelling)
{
    const qs_model *whole = cut->model;
    size_t messages = 2 * (size_t)whole->labels;
    b->model.constant = 0;
    b->state.scale = cut->scale;
    clear_messages(b);
    for (uint32_t c = 0; c < b->model.sites; c++) {
        uint32_t site = qs_block_site(b, whole, c);
        if (window[site] != number) {
            leave_out(b, c);
            continue;
        }
        copy_cell(b, whole, c);
        b->model.constant += base[site];
        b->labelling[c] = labelling[site];
        memcpy(b->state.messages + messages * c, cut->messages + messages * site,
               sizeof *cut->messages * messages);
    }
    complete(b);
}

/* Takes the trial if it is better than the labelling. */
static void offer(qs_block *b)
{
    (void)qs_take_kept_everywhere(&b->sets.model, b->trial);
    int64_t energy = qs_model_energy(&b->sets.model, b->trial);
    if (energy < b->energy) {
        b->energy = energy;
        memcpy(b->labelling, b->trial, sizeof *b->trial * b->model.sites);
    }
}

/* The labels left, the messages and the bound, all at their beginning. Returns false if the costs
 * are too large for messages. */
static bool begin(qs_block *b)
{
    qs_eliminate_lay(&b->sets, &b->model, false, b->kept_in, b->labelling);
    qs_eliminate_begin(&b->sets);
    b->energy = qs_model_energy(&b->sets.model, b->labelling);
    b->state.model = &b->sets.model;
    b->state.visits = NULL;
    b->state.wide = qs_lanes_avx2();
    clear_messages(b);
    return qs_scale_choose(&b->sets.model, FINEST, &b->state.scale);
}

/* Takes out labels, and finds the bound. */
static void take_out(qs_block *b)
{
    int64_t room;
    qs_eliminate_restore(&b->sets);
    int64_t energy = qs_model_energy(&b->sets.model, b->labelling);
    qs_trws_marginals(&b->state, b->marginals, b->shares);
    int64_t gap =
        qs_eliminate_above(&b->sets, b->marginals, b->shares, b->state.scale.shift, &room);
    qs_eliminate_follow(&b->sets);
    b->bound = qs_max_i64(b->bound, energy - gap);
    b->energy = qs_model_energy(&b->sets.model, b->labelling);
    qs_trws_visit_only(&b->state, b->sets.left, b->sets.left_count);
}

/* Makes a labelling from the messages, as they are after a backward pass. */
static void try_messages(qs_block *b)
{
    qs_solution ended;
    qs_trws_grid_labels(&b->state, true, b->trial);
    if (qs_icm(&b->sets.model, NULL, NULL, 0, b->trial, &ended) == QS_OK) {
        offer(b);
    }
}

/* Returns false if the watch stops it. The marginals afterwards are not stopped: half of them would
 * be of no use. */
static bool iterate(qs_block *b, uint64_t times, qs_look *look)
{
    b->state.look = look;
    qs_trws_iterate(&b->state, times);
    b->state.look = NULL;
    return qs_look_up(look, 0);
}

void qs_block_solve(qs_block *b, qs_look *look)
{
    if (!begin(b)) {
        return;
    }
    for (uint32_t i = 1; i <= STEPS && b->energy > b->bound; i++) {
        if (!iterate(b, (uint64_t)i * BETWEEN, look)) {
            return;
        }
        take_out(b);
        try_messages(b);
    }
    qs_allowance work = {(uint64_t)b->model.sites * b->model.labels * WORK_A_LABEL, look};
    if (b->energy > b->bound &&
        qs_parts_solve(&b->sets, b->marginals, b->parts_size, &work, NULL)) {
        qs_trws_visit_only(&b->state, b->sets.left, b->sets.left_count);
        take_out(b);
    }
}
