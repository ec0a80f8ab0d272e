#include "makers/labelling.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "pictures/planes.h"
#include "smoothness.h"
#include "text/fail.h"
#include "text/names.h"
#include "text/numbers.h"

/* ---- The command line. ---- */

/* --scale and --lambda: the problem's units are so fine that floats rounded to 1/scale and lambda
 * are whole numbers of them. */
static int read_units(const char *const *values, labelling_request *asked)
{
    uint32_t scale, denominator;
    int32_t numerator;
    TRY(number_read("--scale", values[LABELLING_SCALE], 1, DECIMAL_DENOMINATOR_MAX, &scale));
    TRY(lambda_read(values[LABELLING_LAMBDA], DECIMAL_DENOMINATOR_MAX, &denominator, &numerator));
    asked->scale = scale;
    asked->whole_lambda = denominator == 1;
    uint64_t in_one = scale;
    while (in_one % denominator != 0) {
        in_one += scale;
    }
    uint64_t weight = (uint64_t)numerator * (in_one / denominator);
    if (in_one > INT32_MAX || weight > INT32_MAX) {
        return fail_usage("--scale %s and --lambda %s need units finer than 1/2147483647: choose "
                          "rounder numbers",
                          values[LABELLING_SCALE], values[LABELLING_LAMBDA]);
    }
    asked->factor = (uint32_t)(in_one / scale);
    asked->weight = (int32_t)weight;
    return DONE;
}

/* V comes from one of --smoothness, --pairwise and --tables. */
static int read_pairwise(const char *const *values, labelling_request *asked)
{
    const char *name = values[LABELLING_SMOOTHNESS], *pairwise = values[LABELLING_PAIRWISE],
               *tables = values[LABELLING_TABLES];
    if ((name != NULL) + (pairwise != NULL) + (tables != NULL) > 1) {
        return fail_usage("--smoothness, --pairwise and --tables each say what neighbours cost: "
                          "give one of them");
    }
    if (values[LABELLING_TRUNCATION] != NULL && name == NULL) {
        return fail_usage("--truncation goes with --smoothness linear or quadratic");
    }
    asked->pairwise.smoothness = pairwise != NULL ? QS_TABLE : QS_TABLES;
    if (pairwise != NULL || tables != NULL) {
        return DONE;
    }
    return smoothness_read(name != NULL ? name : "potts", values[LABELLING_TRUNCATION],
                           &asked->pairwise);
}

int labelling_read(const char *const *operands, const char *const *values, void *state)
{
    labelling_request *asked = state;
    memset(asked, 0, sizeof *asked);
    asked->costs_path = operands[0];
    asked->values = values;
    if (values[LABELLING_EDGES] != NULL && values[LABELLING_MASK] != NULL) {
        return fail_usage("--mask goes with grids, not with --edges: leave sites out of the arrays "
                          "instead");
    }
    TRY(read_pairwise(values, asked));
    return read_units(values, asked);
}

/* ---- Shapes. ---- */

static int fail_shape(const npy_array *array, const char *needed)
{
    char shape[NPY_TEXT];
    npy_shape_write(array, shape);
    return fail(BAD_INPUT, array->name, "has the shape %s, but %s", shape, needed);
}

/* Checks the first `dimensions` lengths, and that there are no more.
 *
 * what  "weights to the right" */
static int check_shape(const npy_array *array, const char *what, const uint64_t *shape,
                       unsigned dimensions)
{
    char needed[2 * NPY_TEXT], wanted[NPY_TEXT];
    npy_array like = {.dimensions = dimensions};
    memcpy(like.shape, shape, sizeof *shape * dimensions);
    if (array->dimensions == dimensions &&
        memcmp(array->shape, shape, sizeof *shape * dimensions) == 0) {
        return DONE;
    }
    npy_shape_write(&like, wanted);
    (void)snprintf(needed, sizeof needed, "%s of these costs are %s", what, wanted);
    return fail_shape(array, needed);
}

static int check_costs(const labelling_request *asked, qs_problem *problem)
{
    const npy_array *costs = &asked->costs;
    bool grid = asked->values[LABELLING_EDGES] == NULL;
    unsigned dimensions = grid ? 3 : 2;
    const uint64_t *shape = costs->shape;
    if (costs->dimensions != dimensions || costs->count == 0) {
        return fail_shape(costs, grid ? "costs of a grid are H x W x K, none of them 0 (of other "
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

/* ---- Costs. ---- */

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

static bool is_site(const qs_problem *problem, uint64_t cell)
{
    return problem->grid.mask == NULL || problem->grid.mask[cell] != 0;
}

/* Checks the costs of some cells, one after the other, and counts the infinite ones. */
static int check_cells(const labelling_request *asked, const qs_problem *problem, uint64_t first,
                       size_t count, int32_t *room, uint64_t *infinite)
{
    const npy_array *costs = &asked->costs;
    size_t labels = problem->labels;
    for (uint64_t cell = first; cell < first + count; cell++) {
        if (is_site(problem, cell)) {
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
        for (size_t d = 0; is_site(problem, from / labels) && d < labels; d++) {
            *allowed = !npy_is_infinite(costs, from + d);
            left += *allowed++;
        }
        if (is_site(problem, from / labels) && left == 0) {
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

static int open_costs(labelling_request *asked, budget *limit, qs_problem *problem)
{
    const npy_array *costs = &asked->costs;
    uint64_t infinite = 0;
    asked->cost_units = (units){{asked->scale, asked->factor}, "a cost", "--scale", true, true};
    if (!npy_is_plain(costs, asked->cost_units.by)) {
        TRY(check_all(asked, problem, limit, &infinite));
    }
    if (infinite > 0) {
        TRY(forbid(asked, problem, limit));
    }
    if (problem->grid.width == 0) {
        return units_read(costs, &asked->cost_units, limit, &problem->costs);
    }
    bool bytes = npy_is_plain(costs, asked->cost_units.by) && costs->kind == NPY_UNSIGNED &&
                 costs->bytes == 1;
    problem->source =
        (qs_cost_source){bytes ? make_byte_row : make_row, asked, bytes ? 1 : 4, NULL};
    return DONE;
}

/* ---- The mask. ---- */

/* Numbers of an array as bytes, 0 or 1. */
static int read_mask_array(const char *path, budget *limit, qs_image *mask)
{
    npy_array array;
    TRY(npy_open(path, limit, &array));
    if (array.dimensions != 2 || array.kind == NPY_FLOAT || array.count > QS_VARIABLES_MAX) {
        return fail_shape(&array, "a mask is H x W integers or logical values");
    }
    uint8_t *cells = budget_take(limit, array.name, (size_t)array.count);
    if (cells == NULL) {
        return NO_RESOURCE;
    }
    for (uint64_t i = 0; i < array.count; i++) {
        cells[i] = 0;
        for (unsigned b = 0; b < array.bytes; b++) {
            cells[i] |= array.data[i * array.bytes + b] != 0;
        }
    }
    *mask =
        (qs_image){cells, (size_t)array.shape[1], (size_t)array.shape[0], (size_t)array.shape[1]};
    return DONE;
}

static int open_mask(const labelling_request *asked, budget *limit, qs_problem *problem)
{
    const char *path = asked->values[LABELLING_MASK];
    qs_image mask;
    if (path == NULL) {
        return DONE;
    }
    size_t length = strlen(path), width = problem->grid.width, height = problem->grid.height;
    bool array = length > 4 && strcmp(path + length - 4, ".npy") == 0;
    TRY(array ? read_mask_array(path, limit, &mask) : numbers_picture_read(path, limit, &mask));
    if (mask.width != width || mask.height != height) {
        return fail(BAD_INPUT, input_name(path),
                    "is %zu columns x %zu rows, but the costs are of %zu columns x %zu rows",
                    (size_t)mask.width, (size_t)mask.height, width, height);
    }
    problem->grid.mask = mask.pixels;
    if (qs_problem_sites(problem) == 0) {
        return fail(BAD_INPUT, input_name(path), "is 0 everywhere: no site is left");
    }
    return DONE;
}

/* ---- Edges, weights and tables. ---- */

/* Opens the two arrays of "RIGHT.npy,DOWN.npy". */
static int open_two(const char *option, const char *text, budget *limit, npy_array *right,
                    npy_array *down)
{
    const char *comma = strchr(text, ',');
    size_t length = strlen(text) + 1;
    if (comma == NULL || comma == text || comma[1] == '\0' || strchr(comma + 1, ',') != NULL) {
        return fail_usage("%s %s is not RIGHT.npy,DOWN.npy, the names of two arrays", option, text);
    }
    char *names = budget_take(limit, NULL, length);
    if (names == NULL) {
        return NO_RESOURCE;
    }
    memcpy(names, text, length);
    names[comma - text] = '\0';
    TRY(npy_open(names, limit, right));
    return npy_open(names + (comma - text) + 1, limit, down);
}

/* Weights are lambda times what the array holds. */
static units weight_units(const labelling_request *asked)
{
    return (units){{(uint32_t)asked->weight, 1}, "a weight", "--lambda", false, false};
}

/* Spreads rows of `columns` weights over a grid's width. */
static int read_grid_weights(const npy_array *array, const units *as, const qs_grid *grid,
                             uint32_t columns, budget *limit, const int32_t **weights)
{
    size_t width = grid->width, count = width * grid->height, rows = (size_t)array->shape[0];
    int32_t *spread = budget_take(limit, array->name, count * sizeof *spread);
    if (spread == NULL) {
        return NO_RESOURCE;
    }
    memset(spread, 0, count * sizeof *spread);
    *weights = spread;
    for (size_t y = 0; y < rows; y++) {
        TRY(units_convert(array, as, y * columns, columns, spread + y * width));
    }
    return DONE;
}

static int open_grid_weights(const labelling_request *asked, budget *limit, qs_problem *problem)
{
    const char *text = asked->values[LABELLING_WEIGHTS];
    qs_grid *grid = &problem->grid;
    const units as = weight_units(asked);
    npy_array right, down;
    if (text == NULL) {
        return DONE;
    }
    const uint64_t of_right[] = {grid->height, grid->width - 1},
                   of_down[] = {grid->height - 1, grid->width};
    TRY(open_two("--weights", text, limit, &right, &down));
    TRY(check_shape(&right, "weights of edges to the right", of_right, 2));
    TRY(check_shape(&down, "weights of edges down", of_down, 2));
    TRY(read_grid_weights(&right, &as, grid, grid->width - 1, limit, &grid->right));
    return read_grid_weights(&down, &as, grid, grid->width, limit, &grid->down);
}

/* How tables of costs become units. Whole numbers leave the units to the weights; floats have them,
 * so that the weights must be whole. */
static int choose_table_units(const labelling_request *asked, const npy_array *array, units *as)
{
    bool floats = array->kind == NPY_FLOAT;
    *as = (units){{1, 1}, "a cost of two labels", "--scale", false, false};
    if (!floats) {
        return DONE;
    }
    if (!asked->whole_lambda || asked->values[LABELLING_WEIGHTS] != NULL) {
        return fail(BAD_INPUT, array->name,
                    "holds floats, which go with a whole --lambda and without --weights: multiply "
                    "them into the array");
    }
    as->by = (npy_scaling){asked->scale, asked->factor};
    return DONE;
}

/* The weight of all edges once it is known whether the tables are floats. */
static int32_t common_weight(const labelling_request *asked, bool float_tables)
{
    uint64_t units_in_one = (uint64_t)asked->scale * asked->factor;
    return float_tables ? (int32_t)((uint64_t)asked->weight / units_in_one) : asked->weight;
}

static int open_pairwise(labelling_request *asked, budget *limit, qs_problem *problem)
{
    const char *path = asked->values[LABELLING_PAIRWISE];
    npy_array array;
    if (path == NULL) {
        return DONE;
    }
    const uint64_t shape[] = {problem->labels, problem->labels};
    TRY(npy_open(path, limit, &array));
    TRY(check_shape(&array, "costs of two labels", shape, 2));
    TRY(choose_table_units(asked, &array, &asked->table_units));
    problem->weight = common_weight(asked, array.kind == NPY_FLOAT);
    return units_read(&array, &asked->table_units, limit, &problem->pairwise.table);
}

/* A qs_table_row. The tables have been checked. */
static void make_tables(void *context, uint32_t row, int32_t *right, int32_t *down)
{
    const labelling_request *asked = context;
    size_t entries = (size_t)(asked->costs.shape[2] * asked->costs.shape[2]),
           width = (size_t)asked->costs.shape[1];
    npy_scaling by = asked->table_units.by;
    uint64_t bad;
    if (right != NULL) {
        size_t count = (width - 1) * entries;
        (void)npy_convert(&asked->right_tables, row * count, count, by, false, right, &bad);
    }
    if (down != NULL) {
        size_t count = width * entries;
        (void)npy_convert(&asked->down_tables, row * count, count, by, false, down, &bad);
    }
}

static int open_grid_tables(labelling_request *asked, budget *limit, qs_problem *problem)
{
    const char *text = asked->values[LABELLING_TABLES];
    const qs_grid *grid = &problem->grid;
    npy_array *right = &asked->right_tables, *down = &asked->down_tables;
    if (text == NULL) {
        return DONE;
    }
    const uint64_t labels = problem->labels,
                   of_right[] = {grid->height, grid->width - 1, labels, labels},
                   of_down[] = {grid->height - 1, grid->width, labels, labels};
    TRY(open_two("--tables", text, limit, right, down));
    TRY(check_shape(right, "tables of edges to the right", of_right, 4));
    TRY(check_shape(down, "tables of edges down", of_down, 4));
    if ((right->kind == NPY_FLOAT) != (down->kind == NPY_FLOAT)) {
        return fail(BAD_INPUT, down->name,
                    "and %s hold floats and whole numbers: save both in one type", right->name);
    }
    TRY(choose_table_units(asked, right, &asked->table_units));
    TRY(units_check(right, &asked->table_units));
    TRY(units_check(down, &asked->table_units));
    problem->weight = common_weight(asked, right->kind == NPY_FLOAT);
    problem->table_source = (qs_table_source){make_tables, asked};
    return DONE;
}

/* ---- Edges of a graph. ---- */

static int fill_edge(const npy_array *array, const int32_t *ends, uint64_t e, uint32_t sites,
                     int32_t weight, qs_edge *edge)
{
    int32_t a = ends[2 * e], b = ends[2 * e + 1];
    char at[NPY_TEXT];
    npy_index_write(array, 2 * e, at);
    if ((uint32_t)a >= sites || (uint32_t)b >= sites) {
        return fail(BAD_INPUT, array->name,
                    "the edge at %s joins %" PRId32 " and %" PRId32 ", but the sites are 0 to "
                    "%" PRIu32,
                    at, a, b, sites - 1);
    }
    if (a == b) {
        return fail(BAD_INPUT, array->name,
                    "the edge at %s joins %" PRId32 " with itself: an edge joins two sites", at, a);
    }
    if (a > b) {
        return fail(BAD_INPUT, array->name,
                    "the edge at %s joins %" PRId32 " and %" PRId32
                    ": put the lower number first, and transpose a table of its own",
                    at, a, b);
    }
    *edge = (qs_edge){(uint32_t)a, (uint32_t)b, weight};
    return DONE;
}

static int open_edge_weights(const labelling_request *asked, uint64_t count, budget *limit,
                             const int32_t **weights)
{
    const units as = weight_units(asked);
    npy_array array;
    *weights = NULL;
    if (asked->values[LABELLING_WEIGHTS] == NULL) {
        return DONE;
    }
    TRY(npy_open(asked->values[LABELLING_WEIGHTS], limit, &array));
    TRY(check_shape(&array, "weights of the edges", &count, 1));
    return units_read(&array, &as, limit, weights);
}

static int open_edge_tables(labelling_request *asked, uint64_t count, budget *limit,
                            qs_problem *problem)
{
    npy_array *array = &asked->right_tables;
    if (asked->values[LABELLING_TABLES] == NULL) {
        return DONE;
    }
    const uint64_t shape[] = {count, problem->labels, problem->labels};
    TRY(npy_open(asked->values[LABELLING_TABLES], limit, array));
    TRY(check_shape(array, "tables of the edges", shape, 3));
    TRY(choose_table_units(asked, array, &asked->table_units));
    problem->weight = common_weight(asked, array->kind == NPY_FLOAT);
    return units_read(array, &asked->table_units, limit, &problem->tables);
}

static int open_edges(labelling_request *asked, budget *limit, qs_problem *problem)
{
    const units as = {{1, 1}, "a site", "number", false, false};
    npy_array array;
    const int32_t *ends, *weights;
    TRY(npy_open(asked->values[LABELLING_EDGES], limit, &array));
    if (array.dimensions != 2 || array.shape[1] != 2 || array.kind == NPY_FLOAT) {
        return fail_shape(&array, "edges are M x 2 whole numbers, the two sites of each");
    }
    uint64_t count = array.shape[0];
    if (count > QS_VARIABLES_MAX) {
        return fail(BAD_INPUT, array.name, "has more than %u edges", QS_VARIABLES_MAX);
    }
    TRY(units_read(&array, &as, limit, &ends));
    TRY(open_edge_weights(asked, count, limit, &weights));
    TRY(open_edge_tables(asked, count, limit, problem));
    qs_edge *edges = budget_take(limit, array.name, (size_t)count * sizeof *edges);
    if (edges == NULL) {
        return NO_RESOURCE;
    }
    for (uint64_t e = 0; e < count; e++) {
        int32_t weight = weights != NULL ? weights[e] : problem->weight;
        TRY(fill_edge(&array, ends, e, problem->sites, weight, &edges[e]));
    }
    problem->edges = edges;
    problem->edge_count = (size_t)count;
    return DONE;
}

/* ---- All of it. ---- */

static int open_graph(labelling_request *asked, budget *limit, qs_problem *problem)
{
    TRY(open_pairwise(asked, limit, problem));
    if (problem->grid.width == 0) {
        return open_edges(asked, limit, problem);
    }
    TRY(open_mask(asked, limit, problem));
    TRY(open_grid_weights(asked, limit, problem));
    return open_grid_tables(asked, limit, problem);
}

int labelling_open(void *state, budget *limit, made_problem *opened)
{
    labelling_request *asked = state;
    qs_problem *problem = &opened->problem;
    opened->name = input_name(asked->costs_path);
    opened->mend = "--scale, --lambda or --truncation";
    TRY(npy_open(asked->costs_path, limit, &asked->costs));
    *problem = (qs_problem){.scale = asked->scale * asked->factor,
                            .weight = asked->weight,
                            .pairwise = asked->pairwise,
                            .meaning = {.kind = QS_MEANS_NUMBER}};
    TRY(check_costs(asked, problem));
    TRY(open_graph(asked, limit, problem));
    TRY(open_costs(asked, limit, problem));
    qs_status status = qs_problem_check(problem);
    return status == QS_OK ? DONE : made_fail(opened, "choose fewer sites or labels", status);
}

const maker labelling_maker = {sizeof(labelling_request), labelling_read, labelling_open, NULL};
