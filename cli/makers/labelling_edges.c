#include "makers/labelling_parts.h"

#include <inttypes.h>

#include "text/fail.h"

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

int labelling_open_edges(labelling_request *asked, budget *limit, qs_problem *problem)
{
    const units as = {{1, 1}, "a site", "give the number of a site", false, false};
    npy_array array;
    const int32_t *ends, *weights;
    TRY(npy_open(asked->values[LABELLING_EDGES], limit, &array));
    TRY(labelling_check_whole(&array, "edges are the numbers of sites"));
    if (array.dimensions != 2 || array.shape[1] != 2) {
        return labelling_fail_shape(&array, "edges are M x 2 whole numbers, the two sites of each");
    }
    uint64_t count = array.shape[0];
    if (count > QS_VARIABLES_MAX) {
        return fail(BAD_INPUT, array.name, "has more than %u edges", QS_VARIABLES_MAX);
    }
    TRY(units_read(&array, &as, limit, &ends));
    TRY(labelling_open_edge_weights(asked, problem, count, limit, &weights));
    TRY(labelling_open_edge_tables(asked, count, limit, problem));
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
