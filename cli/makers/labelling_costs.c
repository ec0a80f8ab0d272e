#include "makers/labelling_parts.h"

#include <inttypes.h>
#include <string.h>

#include "text/fail.h"

int labelling_check_costs(const labelling_request *asked, qs_problem *problem)
{
    const npy_array *costs = &asked->costs;
    bool grid = asked->values[LABELLING_EDGES] == NULL;
    unsigned dimensions = grid ? 3 : 2;
    const uint64_t *shape = costs->shape;
    if (costs->dimensions != dimensions || costs->count == 0) {
        return labelling_fail_shape(
            costs, grid ? "costs of a grid are H x W x K, none of them 0 (of other "
                          "graphs give --edges)"
                        : "costs with --edges are N x K, none of them 0");
    }
    if (shape[dimensions - 1] > QS_LABELS_MAX) {
        return fail(BAD_INPUT, costs->name, "has %" PRIu64 " labels: %u is the most",
                    shape[dimensions - 1], QS_LABELS_MAX);
    }
    if (costs->count > QS_VARIABLES_MAX) {
        return fail(BAD_INPUT, costs->name, "sites x labels is more than %u variables",
                    QS_VARIABLES_MAX);
    }
    problem->labels = (uint32_t)shape[dimensions - 1];
    problem->sites = grid ? 0 : (uint32_t)shape[0];
    problem->grid.height = grid ? (uint32_t)shape[0] : 0;
    problem->grid.width = grid ? (uint32_t)shape[1] : 0;
    return DONE;
}

/* A qs_cost_row of bytes that need no scaling. */
static void make_byte_row(void *context, uint32_t row, void *costs, int32_t *least)
{
    const labelling_request *asked = context;
    size_t width = (size_t)asked->costs.shape[1], labels = (size_t)asked->costs.shape[2];
    const uint8_t *from = asked->costs.data + row * width * labels;
    uint8_t *to = costs;
    for (size_t x = 0; x < width; x++, from += labels, to += labels) {
        uint8_t lowest = from[0];
        for (size_t d = 1; d < labels; d++) {
            lowest = from[d] < lowest ? from[d] : lowest;
        }
        for (size_t d = 0; d < labels; d++) {
            to[d] = (uint8_t)(from[d] - lowest);
        }
        least[x] = lowest;
    }
}

/* A qs_cost_row of all others. They have been checked, but for masked cells, which nobody looks
 * at. */
static void make_row(void *context, uint32_t row, void *costs, int32_t *least)
{
    const labelling_request *asked = context;
    size_t width = (size_t)asked->costs.shape[1], labels = (size_t)asked->costs.shape[2],
           count = width * labels;
    const int32_t *from = npy_words(&asked->costs, asked->cost_units.by);
    uint32_t *to = costs;
    uint64_t bad;
    if (from != NULL) {
        from += row * count;
    } else {
        (void)npy_convert(&asked->costs, row * count, count, asked->cost_units.by, true, costs,
                          &bad);
        from = costs;
    }
    for (size_t x = 0; x < width; x++, from += labels, to += labels) {
        int32_t lowest = from[0];
        for (size_t d = 1; d < labels; d++) {
            lowest = from[d] < lowest ? from[d] : lowest;
        }
        for (size_t d = 0; d < labels; d++) {
            to[d] = (uint32_t)from[d] - (uint32_t)lowest;
        }
        least[x] = lowest;
    }
}

/* Checks the costs of some cells, one after the other, and counts the infinite ones. */
static int check_cells(const labelling_request *asked, const qs_problem *problem, uint64_t first,
                       size_t count, int32_t *room, uint64_t *infinite)
{
    const npy_array *costs = &asked->costs;
    size_t labels = problem->labels;
    for (uint64_t cell = first; cell < first + count; cell++) {
        if (labelling_is_site(problem, cell)) {
            TRY(units_convert(costs, &asked->cost_units, cell * labels, labels, room));
            for (size_t d = 0; d < labels; d++) {
                *infinite += npy_is_infinite(costs, cell * labels + d);
            }
        }
    }
    return DONE;
}

/* Checks the costs of all sites. Where some cells together have no fault, none of them is looked at
 * by itself. */
static int check_all(const labelling_request *asked, const qs_problem *problem, budget *limit,
                     uint64_t *infinite)
{
    enum { TOGETHER = 64 };
    const npy_array *costs = &asked->costs;
    size_t labels = problem->labels;
    uint64_t cells = costs->count / labels, bad;
    int32_t *room = budget_take(limit, costs->name, TOGETHER * labels * sizeof *room);
    if (room == NULL) {
        return NO_RESOURCE;
    }
    for (uint64_t first = 0; first < cells; first += TOGETHER) {
        size_t count = cells - first < TOGETHER ? (size_t)(cells - first) : TOGETHER;
        npy_fault any = npy_convert(costs, first * labels, count * labels, asked->cost_units.by,
                                    false, room, &bad);
        if (any != NPY_FITS) {
            TRY(check_cells(asked, problem, first, count, room, infinite));
        }
    }
    return DONE;
}

/* The labels whose costs are infinite are forbidden. */
static int forbid(const labelling_request *asked, qs_problem *problem, budget *limit)
{
    const npy_array *costs = &asked->costs;
    size_t labels = problem->labels;
    uint8_t *allowed = budget_take(limit, costs->name, (size_t)costs->count);
    if (allowed == NULL) {
        return NO_RESOURCE;
    }
    problem->allowed = allowed;
    for (uint64_t from = 0; from < costs->count; from += labels) {
        size_t left = 0;
        for (size_t d = 0; labelling_is_site(problem, from / labels) && d < labels; d++) {
            *allowed = !npy_is_infinite(costs, from + d);
            left += *allowed++;
        }
        if (labelling_is_site(problem, from / labels) && left == 0) {
            char at[NPY_TEXT];
            npy_array cells = {.dimensions = costs->dimensions - 1};
            memcpy(cells.shape, costs->shape, sizeof cells.shape);
            npy_index_write(&cells, from / labels, at);
            return fail(BAD_INPUT, costs->name,
                        "all costs of %s are inf, so no label is left to it: give it one", at);
        }
    }
    return DONE;
}

int labelling_open_costs(labelling_request *asked, budget *limit, qs_problem *problem)
{
    const npy_array *costs = &asked->costs;
    uint64_t infinite = 0;
    asked->cost_units =
        (units){{asked->scale, asked->factor}, "a cost", labelling_mend(asked), true, true};
    if (!npy_is_plain(costs, asked->cost_units.by)) {
        TRY(check_all(asked, problem, limit, &infinite));
    }
    labelling_warn_rounding(asked, problem, costs, asked->cost_units.by, asked->scale);
    if (infinite > 0) {
        TRY(forbid(asked, problem, limit));
    }
    if (problem->grid.width == 0) {
        return units_read(costs, &asked->cost_units, limit, &problem->costs);
    }
    bool bytes = npy_is_plain(costs, asked->cost_units.by) && costs->kind == NPY_UNSIGNED &&
                 costs->bytes == 1;
    problem->source =
        (qs_cost_source){bytes ? make_byte_row : make_row, asked, bytes ? 1 : 4, 0, 0, NULL};
    return DONE;
}
