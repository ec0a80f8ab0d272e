#include "makers/labelling_parts.h"

#include "text/fail.h"

/* How tables of costs become units. Whole numbers leave the units to the weights; floats have them,
 * so that the weights must be whole. */
static int choose_table_units(const labelling_request *asked, const npy_array *array, units *as)
{
    bool floats = array->kind == NPY_FLOAT;
    *as = (units){{1, 1}, "a cost of two labels", labelling_mend(asked), false, false};
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

int labelling_open_pairwise(labelling_request *asked, budget *limit, qs_problem *problem)
{
    const char *path = asked->values[LABELLING_PAIRWISE];
    npy_array array;
    if (path == NULL) {
        return DONE;
    }
    const uint64_t shape[] = {problem->labels, problem->labels};
    TRY(npy_open(path, limit, &array));
    TRY(labelling_check_shape(&array, "costs of two labels", shape, 2));
    TRY(choose_table_units(asked, &array, &asked->table_units));
    problem->weight = common_weight(asked, array.kind == NPY_FLOAT);
    TRY(units_read(&array, &asked->table_units, limit, &problem->pairwise.table));
    labelling_warn_rounding(asked, problem, &array, asked->table_units.by, asked->scale);
    return DONE;
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

int labelling_open_grid_tables(labelling_request *asked, budget *limit, qs_problem *problem)
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
    TRY(labelling_open_two("--tables", text, limit, right, down));
    TRY(labelling_check_shape(right, "tables of edges to the right", of_right, 4));
    TRY(labelling_check_shape(down, "tables of edges down", of_down, 4));
    const npy_array *some = right->count > 0 ? right : down;
    if (right->count > 0 && down->count > 0 &&
        (right->kind == NPY_FLOAT) != (down->kind == NPY_FLOAT)) {
        return fail(BAD_INPUT, down->name,
                    "and %s hold floats and whole numbers: save both in one type", right->name);
    }
    TRY(choose_table_units(asked, some, &asked->table_units));
    TRY(units_check(right, &asked->table_units));
    TRY(units_check(down, &asked->table_units));
    labelling_warn_rounding(asked, problem, right, asked->table_units.by, asked->scale);
    labelling_warn_rounding(asked, problem, down, asked->table_units.by, asked->scale);
    problem->weight = common_weight(asked, some->kind == NPY_FLOAT);
    problem->table_source = (qs_table_source){make_tables, asked};
    return DONE;
}

int labelling_open_edge_tables(labelling_request *asked, uint64_t count, budget *limit,
                               qs_problem *problem)
{
    npy_array *array = &asked->right_tables;
    if (asked->values[LABELLING_TABLES] == NULL) {
        return DONE;
    }
    const uint64_t shape[] = {count, problem->labels, problem->labels};
    TRY(labelling_open_one("--tables", asked->values[LABELLING_TABLES], limit, array));
    TRY(labelling_check_shape(array, "tables of the edges", shape, 3));
    TRY(choose_table_units(asked, array, &asked->table_units));
    problem->weight = common_weight(asked, array->kind == NPY_FLOAT);
    TRY(units_read(array, &asked->table_units, limit, &problem->tables));
    labelling_warn_rounding(asked, problem, array, asked->table_units.by, asked->scale);
    return DONE;
}
