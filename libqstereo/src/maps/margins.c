#include "../../include/qstereo/maps.h"
#include "../base/arena.h"
#include "../base/minmax.h"
#include "../model/edge_value.h"
#include "../model/neighbours.h"
#include "../solve/messages.h"

/* One row or column of the grid. */
typedef struct chain {
    uint32_t first, stride, count; /* its sites: first, first + stride, ... */
    bool down; /* a column */
} chain;

typedef struct work {
    const qs_model *model;
    const uint16_t *labelling;
    uint32_t apart;
    int32_t *so_far; /* of each label of each site: the costs up to the site */
    int32_t *came; /* the part of them that the message from the site before brought */
    int32_t *later, *costs, *scratch;
} work;

static size_t take(qs_arena *arena, const qs_model *model, work *made)
{
    uint64_t longest = model->width > model->height ? model->width : model->height;
    uint64_t labels = model->labels, all = longest * labels;
    made->so_far = qs_arena_take(arena, all, sizeof *made->so_far);
    made->came = qs_arena_take(arena, all, sizeof *made->came);
    made->later = qs_arena_take(arena, labels, sizeof *made->later);
    made->costs = qs_arena_take(arena, labels, sizeof *made->costs);
    made->scratch = qs_arena_take(arena, qs_message_scratch(model), sizeof *made->scratch);
    return qs_arena_size(arena);
}

size_t qs_margins_workspace(const qs_model *model)
{
    qs_arena count = {NULL, 0, false};
    work counted;
    return take(&count, model, &counted);
}

static int32_t weight_from(const work *w, uint32_t cell, bool down)
{
    return (down ? w->model->down : w->model->right)[cell];
}

static void forward(const work *w, const chain *of)
{
    uint32_t labels = w->model->labels;
    for (uint32_t i = 0; i < of->count; i++) {
        uint32_t cell = of->first + i * of->stride;
        int32_t *so_far = w->so_far + (size_t)i * labels, *came = w->came + (size_t)i * labels;
        for (uint32_t d = 0; d < labels; d++) {
            came[d] = i > 0 ? came[d] : 0;
            so_far[d] = w->model->unary[(size_t)cell * labels + d] + came[d];
        }
        if (i + 1 < of->count) {
            for (uint32_t d = 0; d < labels; d++) {
                w->costs[d] = so_far[d];
            }
            (void)qs_message_send(w->model, qs_cell_edge(cell, of->down),
                                  weight_from(w, cell, of->down), true, w->costs, came + labels,
                                  w->scratch);
        }
    }
}

/* The least cost of another answer less that of the label. */
static uint32_t margin_of(const work *w, const int32_t *so_far, uint32_t label)
{
    int64_t own = (int64_t)so_far[label] + w->later[label], least = INT64_MAX;
    for (uint32_t d = 0; d < w->model->labels; d++) {
        uint32_t off = d > label ? d - label : label - d;
        int64_t cost = (int64_t)so_far[d] + w->later[d];
        least = off > w->apart && cost < least ? cost : least;
    }
    if (least == INT64_MAX) {
        return UINT32_MAX;
    }
    return least > own ? (uint32_t)(least - own) : 0;
}

static void back(const work *w, const chain *of, uint32_t *margins)
{
    uint32_t labels = w->model->labels;
    for (uint32_t d = 0; d < labels; d++) {
        w->later[d] = 0;
    }
    for (uint32_t i = of->count; i-- > 0;) {
        uint32_t cell = of->first + i * of->stride, before = cell - of->stride;
        const int32_t *so_far = w->so_far + (size_t)i * labels,
                      *came = w->came + (size_t)i * labels;
        uint32_t margin = margin_of(w, so_far, w->labelling[cell]);
        margins[cell] = margin < margins[cell] ? margin : margins[cell];
        if (i > 0) {
            for (uint32_t d = 0; d < labels; d++) {
                w->costs[d] = so_far[d] - came[d] + w->later[d];
            }
            (void)qs_message_send(w->model, qs_cell_edge(before, of->down),
                                  weight_from(w, before, of->down), false, w->costs, w->later,
                                  w->scratch);
        }
    }
}

/* A message is at most what its edge can cost, so a sum is at most a unary cost and two edges; one
 * more edge is added while a message is made. */
static bool fits(const qs_model *model)
{
    int64_t unary = 0, weight = 0;
    for (size_t i = 0; i < (size_t)model->sites * model->labels; i++) {
        unary = qs_max_i64(unary, model->unary[i]);
    }
    for (uint32_t p = 0; p < model->sites; p++) {
        weight = qs_max_i64(weight, qs_max_i64(model->right[p], model->down[p]));
    }
    return weight == 0 || (INT32_MAX - unary) / 3 / weight >= model->pairwise_max;
}

qs_status qs_margins(const qs_model *model, const uint16_t *labelling, uint32_t apart,
                     void *workspace, size_t workspace_size, uint32_t *margins)
{
    if (!model || !labelling || !workspace || !margins || !qs_labels_in_range(model, labelling)) {
        return QS_E_ARGUMENT;
    }
    if (model->width == 0) {
        return QS_E_GEOMETRY;
    }
    if (workspace_size < qs_margins_workspace(model)) {
        return QS_E_WORKSPACE;
    }
    if (!fits(model)) {
        return QS_E_OVERFLOW;
    }
    qs_arena arena = {workspace, 0, false};
    work w = {.model = model, .labelling = labelling, .apart = apart};
    (void)take(&arena, model, &w);
    for (uint32_t p = 0; p < model->sites; p++) {
        margins[p] = UINT32_MAX;
    }
    for (uint32_t y = 0; y < model->height; y++) {
        const chain row = {y * model->width, 1, model->width, false};
        forward(&w, &row);
        back(&w, &row, margins);
    }
    for (uint32_t x = 0; x < model->width; x++) {
        const chain column = {x, model->width, model->height, true};
        forward(&w, &column);
        back(&w, &column, margins);
    }
    return QS_OK;
}
