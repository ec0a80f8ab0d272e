#include "spots.h"

#include <string.h>

#include "../base/minmax.h"
#include "../base/sets.h"
#include "../model/neighbours.h"

enum {
    LEAST_SHIFT = 4, /* of messages; half of it goes to the costs */
    ITERATIONS = 20, /* of messages on what has been cut */
    SHARE = 2, /* a window takes at most a SHARE-th of the work that is left, */
    HELD_SHARE = 4, /* and all windows with their neighbours held at most a HELD_SHARE-th */
    NUMBERS_A_LABEL = 8
};

/* The gap of a cell that has a window: no other one shall have it. */
#define TAKEN (-(INT64_C(1) << 44))

void qs_spots_take(qs_spots *s, const qs_model *model, qs_arena *arena)
{
    uint64_t sites = model->sites, labels = model->labels;
    uint64_t corners = (model->width + (uint64_t)1) * (model->height + (uint64_t)1);
    *s = (qs_spots){.count = 0};
    s->most_saved = (uint32_t)qs_min_u64(2 * sites, (uint64_t)QS_SPOTS * 4 * QS_SPOT_SIDE);
    s->unary = qs_arena_take(arena, sites * labels, sizeof *s->unary);
    s->right = qs_arena_take(arena, sites, sizeof *s->right);
    s->down = qs_arena_take(arena, sites, sizeof *s->down);
    s->base = qs_arena_take(arena, sites, sizeof *s->base);
    s->sums = qs_arena_take(arena, corners, sizeof *s->sums);
    s->window = qs_arena_take(arena, sites, sizeof *s->window);
    s->saved = qs_arena_take(arena, s->most_saved * labels, sizeof *s->saved);
    s->edges = qs_arena_take(arena, s->most_saved, sizeof *s->edges);
}

/* Finds the gap at each cell. It is noted where `sums` will be, one cell further right and down. */
static void find_gaps(qs_spots *s, const qs_spots_call *call)
{
    const qs_elimination *e = call->e;
    const qs_model *model = &e->model;
    size_t row = model->width + (size_t)1;
    qs_trws_state state = *call->state;
    state.look = NULL; /* half of the gaps would be of no use */
    memset(s->sums, 0, sizeof *s->sums * row * (model->height + (size_t)1));
    qs_trws_grid_marginals(&state, call->memory, call->shares);
    for (uint32_t i = 0; i < e->left_count; i++) {
        uint32_t p = e->left[i];
        if (!e->closed[p]) {
            size_t at = row * (p / model->width + 1) + p % model->width + 1;
            s->sums[at] = qs_gap_at(&state, call->shares, e->labelling, p);
        }
    }
    (void)qs_trws_grid_pass(&state, false);
}

/* From the gaps to their sums, and back. */
static void sum_up(qs_spots *s, const qs_model *model)
{
    size_t row = model->width + (size_t)1;
    for (size_t at = row; at < row * (model->height + (size_t)1); at++) {
        s->sums[at] +=
            at % row > 0 ? s->sums[at - 1] + s->sums[at - row] - s->sums[at - row - 1] : 0;
    }
}

static void take_apart(qs_spots *s, const qs_model *model)
{
    size_t row = model->width + (size_t)1;
    for (size_t at = row * (model->height + (size_t)1) - 1; at >= row; at--) {
        s->sums[at] -=
            at % row > 0 ? s->sums[at - 1] + s->sums[at - row] - s->sums[at - row - 1] : 0;
    }
}

static int64_t sum_of(const qs_spots *s, size_t row, uint32_t left, uint32_t top, uint32_t right,
                      uint32_t bottom)
{
    return s->sums[bottom * row + right] - s->sums[top * row + right] -
           s->sums[bottom * row + left] + s->sums[top * row + left];
}

/* How good a window is: by its gap, above all that in its middle. What is near the border of the
 * grid is in the middle, too. */
static int64_t score_of(const qs_spots *s, const qs_model *model, qs_rectangle at)
{
    enum { RIM = 4, MIDDLE = 4 };
    uint32_t right = at.x + at.width, bottom = at.y + at.height;
    uint32_t wide = at.width / RIM, high = at.height / RIM;
    size_t row = model->width + (size_t)1;
    int64_t all = sum_of(s, row, at.x, at.y, right, bottom);
    return all + MIDDLE * sum_of(s, row, at.x > 0 ? at.x + wide : 0, at.y > 0 ? at.y + high : 0,
                                 right < model->width ? right - wide : right,
                                 bottom < model->height ? bottom - high : bottom);
}

/* The best window that is left. Returns false if no gap in it is worth it. */
static bool find_window(const qs_spots *s, const qs_spots_call *call, qs_rectangle *best)
{
    const qs_model *model = &call->e->model;
    int64_t unit = (int64_t)1 << call->state->scale.shift;
    int64_t best_score = unit - 1;
    qs_rectangle at = {0, 0, qs_min_u32(call->side, model->width),
                       qs_min_u32(call->side, model->height)};
    for (at.y = 0; at.y + at.height <= model->height; at.y++) {
        for (at.x = 0; at.x + at.width <= model->width; at.x++) {
            int64_t score = score_of(s, model, at);
            if (score > best_score) {
                best_score = score;
                *best = at;
            }
        }
    }
    return best_score >= unit;
}

/* Notes the window's cells: those that are left, and not of closed parts. */
static void note_cells(qs_spots *s, const qs_elimination *e, qs_rectangle at, uint8_t number)
{
    size_t row = e->model.width + (size_t)1;
    for (uint32_t i = 0; i < e->left_count; i++) {
        uint32_t p = e->left[i], x = p % e->model.width, y = p / e->model.width;
        bool inside = x >= at.x && x - at.x < at.width && y >= at.y && y - at.y < at.height;
        if (inside && !e->closed[p]) {
            s->window[p] = number;
        }
    }
    for (uint32_t y = at.y + 1; y <= at.y + at.height; y++) {
        for (uint32_t x = at.x + 1; x <= at.x + at.width; x++) {
            s->sums[y * row + x] = TAKEN;
        }
    }
}

static void choose_windows(qs_spots *s, const qs_spots_call *call)
{
    const qs_model *model = &call->e->model;
    find_gaps(s, call);
    memset(s->window, 0, model->sites);
    sum_up(s, model);
    for (s->count = 0; s->count < QS_SPOTS; s->count++) {
        if (!find_window(s, call, &s->at[s->count])) {
            return;
        }
        take_apart(s, model);
        note_cells(s, call->e, s->at[s->count], (uint8_t)(s->count + 1));
        sum_up(s, model);
    }
}

/* The message of an edge becomes a cost of the earlier site. The later site pays back as much as
 * the edge lets it: for a label there, the largest n with
 *
 *     weight V(a, b) - m(a) + n(b) >= 0 for all labels a;
 *
 * so what is left of the edge costs 0 or more, and it is dropped.
 *
 * message  of the edge, to its earlier site; out: 0
 * coarser  a unit of the costs is 2^coarser numbers of a message */
static void cut_edge(qs_spots *s, const qs_edge_seen *edge, uint32_t site, int32_t *message,
                     unsigned coarser)
{
    uint32_t labels = s->cut.labels;
    const uint8_t *kept = s->cut.kept + (size_t)site * labels;
    int32_t *earlier = s->unary + (size_t)site * labels,
            *later = s->unary + (size_t)edge->site * labels;
    for (uint32_t b = 0; b < labels; b++) {
        int64_t most = INT64_MIN;
        for (uint32_t a = 0; a < labels; a++) {
            int64_t rest = (message[a] >> coarser) - qs_seen_cost(&s->cut, edge, a, b);
            most = kept[a] ? qs_max_i64(most, rest) : most;
        }
        later[b] -= (int32_t)most;
    }
    for (uint32_t a = 0; a < labels; a++) {
        earlier[a] += message[a] >> coarser;
    }
    memset(message, 0, sizeof *message * labels);
}

static void cut_edges_of(qs_spots *s, const qs_trws_state *state, uint32_t site, unsigned coarser)
{
    size_t labels = s->cut.labels;
    qs_edge_seen edge;
    for (uint32_t at = 0; qs_see_edge(&s->cut, site, at, &edge); at++) {
        bool cut = edge.weight > 0 && edge.first && s->window[site] != s->window[edge.site];
        if (!cut) {
            continue;
        }
        uint64_t place = labels * edge.edge; /* two edges a cell: messages lie in their order */
        int32_t *message = (int32_t *)state->messages + place;
        memcpy(s->saved + s->saved_count * labels, message, sizeof *message * labels);
        s->edges[s->saved_count++] = place;
        cut_edge(s, &edge, site, message, coarser);
        *(qs_is_vertical(&edge) ? &s->down[site] : &s->right[site]) = 0;
    }
}

/* The costs of the grid in parts of a unit. Labels that are out cost as much as any may. */
static void copy_costs(qs_spots *s, const qs_elimination *e, qs_scale scale, unsigned finer)
{
    size_t labels = e->model.labels;
    for (uint32_t p = 0; p < e->model.sites; p++) {
        s->right[p] = e->model.right[p] * ((int32_t)1 << finer);
        s->down[p] = e->model.down[p] * ((int32_t)1 << finer);
        s->base[p] = 0;
    }
    for (uint32_t i = 0; i < e->left_count; i++) {
        const int32_t *from = e->unary + labels * e->left[i];
        int32_t *to = s->unary + labels * e->left[i];
        for (size_t d = 0; d < labels; d++) {
            to[d] = qs_min_i32(from[d], (int32_t)scale.most) * ((int32_t)1 << finer);
        }
    }
}

/* Cuts the windows out. Returns the state of messages on what that makes. */
static qs_trws_state cut_out(qs_spots *s, const qs_spots_call *call)
{
    const qs_elimination *e = call->e;
    qs_trws_state state = *call->state;
    unsigned finer = state.scale.shift / 2;
    copy_costs(s, e, state.scale, finer);
    s->cut = e->model;
    s->cut.unary = s->unary;
    s->cut.right = s->right;
    s->cut.down = s->down;
    s->cut.constant = 0;
    s->saved_count = 0;
    state.scale.shift -= finer;
    state.scale.most *= (qs_number)1 << finer;
    state.model = &s->cut;
    for (uint32_t i = 0; i < e->left_count; i++) {
        cut_edges_of(s, &state, e->left[i], state.scale.shift);
    }
    for (uint32_t i = 0; i < e->left_count; i++) {
        uint32_t p = e->left[i];
        size_t at = (size_t)p * e->model.labels;
        s->base[p] += qs_settle_costs(s->unary + at, e->kept + at, e->model.labels);
    }
    qs_trws_visit_only(&state, e->left, e->left_count);
    return state;
}

static void put_messages_back(const qs_spots *s, const qs_trws_state *state)
{
    size_t labels = s->cut.labels;
    for (uint32_t i = 0; i < s->saved_count; i++) {
        memcpy(state->messages + s->edges[i], s->saved + i * labels, sizeof *s->saved * labels);
    }
}

/* Searches a window. Returns a bound of its labellings. */
static int64_t search_window(qs_block *b, unsigned shift, qs_allowance *work)
{
    uint64_t share = work->left / SHARE;
    qs_allowance own = {share, work->look};
    int64_t bound = qs_window_search(b, (int64_t)1 << shift, &own);
    qs_take_used(work, share, &own);
    return bound;
}

/* Whether the scale of what was left of a window when it was solved is one of the whole window,
 * too: edges that labels have closed may cost more than the others. */
static bool has_scale_of_whole(qs_block *b)
{
    unsigned shift = b->state.scale.shift;
    return qs_scale_choose(&b->model, shift, &b->state.scale) && b->state.scale.shift == shift;
}

/* Looks for a better labelling of a window with its neighbours held. */
static void improve_window(const qs_spots_call *call, qs_rectangle at, qs_allowance *work)
{
    qs_block b;
    qs_elimination *e = call->e;
    if (!qs_block_take(&b, &e->model, at, call->memory, call->size) ||
        !qs_block_hold(&b, &e->model, e->labelling)) {
        return;
    }
    int64_t before = b.energy;
    qs_block_solve(&b, work->look);
    if (b.bound != QS_NO_BOUND && b.energy > b.bound && has_scale_of_whole(&b)) {
        (void)search_window(&b, b.state.scale.shift, work);
    }
    for (uint32_t c = 0; c < b.model.sites && b.energy < before; c++) {
        e->labelling[qs_block_site(&b, &e->model, c)] = b.labelling[c];
    }
}

static void improve_windows(const qs_spots *s, const qs_spots_call *call)
{
    uint64_t share = call->work->left / HELD_SHARE;
    qs_allowance own = {share, call->work->look};
    for (uint32_t i = 0; i < s->count; i++) {
        improve_window(call, s->at[i], &own);
    }
    qs_take_used(call->work, share, &own);
}

static void search_windows(qs_spots *s, const qs_spots_call *call, const qs_trws_state *cut)
{
    for (uint32_t i = 0; i < s->count; i++) {
        qs_block b;
        s->value[i] = INT64_MIN;
        if (qs_block_take(&b, &s->cut, s->at[i], call->memory, call->size)) {
            qs_block_cut(&b, cut, s->base, s->window, (uint8_t)(i + 1), call->e->labelling);
            s->value[i] = search_window(&b, call->state->scale.shift, call->work);
        }
    }
}

/* How far the searches have raised the bounds of the windows above those of the messages. Shares
 * become those of the sites' costs as they were. */
static void find_rises(qs_spots *s, const qs_spots_call *call, unsigned shift)
{
    const qs_elimination *e = call->e;
    int64_t plain[QS_SPOTS] = {0};
    for (uint32_t i = 0; i < e->left_count; i++) {
        uint32_t p = e->left[i];
        call->shares[p] += s->base[p] * ((int64_t)1 << shift);
        if (s->window[p] > 0) {
            plain[s->window[p] - 1] += call->shares[p];
        }
    }
    for (uint32_t i = 0; i < s->count; i++) {
        s->rise[i] = qs_max_i64(s->value[i], plain[i]) - plain[i];
    }
}

/* Adds a window's rise to the share of its first site, and takes it from the marginals in it: they
 * are above the bound of messages alone. What it has of several parts becomes one part. */
static void add_rises(const qs_spots *s, const qs_spots_call *call)
{
    qs_elimination *e = call->e;
    size_t labels = e->model.labels;
    uint32_t first[QS_SPOTS], *marginals = call->memory;
    memset(first, 0xff, sizeof first);
    for (uint32_t i = 0; i < e->left_count; i++) {
        uint32_t p = e->left[i], w = s->window[p] - 1U;
        if (s->window[p] == 0) {
            continue;
        }
        if (first[w] == UINT32_MAX) {
            first[w] = p;
            call->shares[p] += s->rise[w];
        }
        qs_set_join(e->part, first[w], p);
        for (size_t at = p * labels; at < (p + (size_t)1) * labels; at++) {
            marginals[at] -= (uint32_t)qs_min_i64(marginals[at], s->rise[w]);
        }
    }
    for (uint32_t i = 0; i < e->left_count; i++) {
        e->part[e->left[i]] = qs_set_of(e->part, e->left[i]);
    }
}

static bool is_stopped(const qs_spots_call *call)
{
    const qs_look *look = call->state->look;
    return (look && look->stopped) || !qs_look_up(call->work->look, 1);
}

/* Searches the windows, and goes on with messages on what has been cut: then there are marginals.
 * Returns false if it was stopped. */
static bool bound_all(qs_spots *s, const qs_spots_call *call, qs_trws_state *cut)
{
    search_windows(s, call, cut);
    qs_trws_iterate(cut, ITERATIONS);
    if (is_stopped(call)) {
        return false;
    }
    cut->look = NULL; /* half of the marginals would be of no use */
    qs_trws_marginals(cut, call->memory, call->shares);
    return true;
}

bool qs_spots_take_out(qs_spots *s, const qs_spots_call *call, int64_t *gap)
{
    int64_t room;
    if (call->state->scale.shift < LEAST_SHIFT) {
        return false;
    }
    choose_windows(s, call);
    if (s->count == 0) {
        return false;
    }
    improve_windows(s, call);
    qs_eliminate_restore(call->e);
    qs_trws_state cut = cut_out(s, call);
    bool done = bound_all(s, call, &cut);
    put_messages_back(s, call->state);
    if (done) {
        find_rises(s, call, cut.scale.shift);
        qs_eliminate_find_parts(call->e);
        add_rises(s, call);
        *gap = qs_eliminate_above_in_parts(call->e, call->memory, call->shares,
                                           call->state->scale.shift, &room);
    }
    return done;
}
