#include "mover.h"

#include <string.h>

#include "../base/minmax.h"

#define RANGE ((int64_t)(QS_NUMBER_MAX / 2 + 1)) /* of any height: two differ by a number */

static uint64_t link_count(const qs_model *model)
{
    return qs_is_grid(model) ? 0 : 2 * (uint64_t)model->edges;
}

static uint64_t arc_count(const qs_model *model)
{
    return qs_is_grid(model) ? 4 * (uint64_t)model->sites : link_count(model);
}

static uint64_t padded_count(const qs_model *model)
{
    return model->sites + 2 * (uint64_t)model->width;
}

void qs_mover_take(qs_mover *mover, qs_arena *arena)
{
    const qs_model *model = mover->model;
    qs_cut *cut = &mover->cut;
    mover->padded = qs_arena_take(arena, padded_count(model), sizeof *mover->padded);
    cut->excess = qs_arena_take(arena, model->sites, sizeof *cut->excess);
    cut->residual = qs_arena_take(arena, arc_count(model), sizeof *cut->residual);
    cut->queue = qs_arena_take(arena, model->sites, sizeof *cut->queue);
    cut->orphan = qs_arena_take(arena, model->sites, sizeof *cut->orphan);
    mover->sister = qs_arena_take(arena, link_count(model), sizeof *mover->sister);
}

/* An edge's second link is met at its second site, in the order of the first ones: so one cursor a
 * site finds it. */
static void find_sisters(const qs_model *model, uint32_t *sister, uint32_t *cursor)
{
    memcpy(cursor, model->link_start, sizeof *cursor * model->sites);
    for (uint32_t p = 0; p < model->sites; p++) {
        for (uint32_t n = model->link_start[p]; n < model->link_start[p + 1]; n++) {
            uint32_t q = model->links[n].site;
            if (q > p) {
                sister[n] = cursor[q];
                sister[cursor[q]++] = n;
            }
        }
    }
}

void qs_mover_start(qs_mover *mover)
{
    const qs_model *model = mover->model;
    qs_cut *cut = &mover->cut;
    cut->nodes = model->sites;
    cut->node = mover->padded + model->width;
    cut->width = model->width;
    cut->start = model->link_start;
    cut->links = model->links;
    cut->sister = mover->sister;
    for (size_t i = 0; i < (size_t)padded_count(model); i++) {
        mover->padded[i] = (qs_cut_node){.parent = QS_CUT_UNLOADED};
    }
    memset(cut->residual, 0, sizeof *cut->residual * (size_t)arc_count(model));
    if (!qs_is_grid(model)) {
        find_sisters(model, mover->sister, cut->queue);
    }
    mover->energy = qs_model_energy(model, mover->x);
}

/* The sum of the weights of a site's edges. */
static int64_t incident_weight(const qs_model *model, uint32_t p)
{
    int64_t sum = 0;
    if (qs_is_grid(model)) {
        uint32_t width = model->width;
        return (int64_t)model->right[p] + model->down[p] + (p > 0 ? model->right[p - 1] : 0) +
               (p >= width ? model->down[p - width] : 0);
    }
    for (uint32_t n = model->link_start[p]; n < model->link_start[p + 1]; n++) {
        sum += model->links[n].weight;
    }
    return sum;
}

static int32_t largest_unary(const qs_model *model, uint32_t p)
{
    const int32_t *unary = model->unary + (size_t)p * model->labels;
    int32_t largest = 0;
    for (uint32_t a = 0; a < model->labels; a++) {
        largest = qs_max_i32(largest, unary[a]);
    }
    return largest;
}

int64_t qs_times_in_range(const qs_model *model)
{
    int64_t times = INT64_MAX;
    for (uint32_t p = 0; p < model->sites; p++) {
        int64_t unary = largest_unary(model, p), weight = incident_weight(model, p);
        if (unary >= RANGE || weight >= RANGE) {
            return 0;
        }
        if (weight > 0 && model->pairwise_max > 0) {
            times = qs_min_i64(times, (RANGE - 1 - unary) / weight / model->pairwise_max);
        }
    }
    return times;
}
