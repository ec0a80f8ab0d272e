#include "../../include/qstereo/problem.h"

#include <stdbool.h>

/* Returns true if no value is below 0. */
static bool in_range(const int32_t *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (values[i] < 0) {
            return false;
        }
    }
    return true;
}

/* A table of its own for each edge of a list, or a source of them for a grid. */
static bool tables_in_range(const qs_problem *problem)
{
    size_t entries = (size_t)problem->labels * problem->labels, edges = problem->edge_count;
    if (problem->grid.width > 0) {
        return problem->table_source.row && !problem->tables;
    }
    if (edges == 0) {
        return true;
    }
    return problem->tables && edges <= SIZE_MAX / sizeof(int32_t) / entries &&
           in_range(problem->tables, edges * entries);
}

static bool pairwise_in_range(const qs_problem *problem)
{
    const qs_pairwise *pairwise = &problem->pairwise;
    size_t labels = problem->labels;
    switch (pairwise->smoothness) {
    case QS_POTTS:
    case QS_TRUNCATED_LINEAR:
    case QS_TRUNCATED_QUADRATIC: return true;
    case QS_TABLE: return pairwise->table && in_range(pairwise->table, labels * labels);
    case QS_TABLES: return tables_in_range(problem);
    }
    return false;
}

/* Returns true if a label is left to each site. */
static bool sites_have_labels(const qs_problem *problem, uint32_t sites)
{
    size_t labels = problem->labels;
    for (uint32_t p = 0; problem->allowed && p < sites; p++) {
        const uint8_t *allowed = problem->allowed + p * labels;
        size_t d = 0;
        while (d < labels && allowed[d] == 0) {
            d++;
        }
        if (d == labels) {
            return false;
        }
    }
    return true;
}

static qs_status check_grid(const qs_problem *problem)
{
    const qs_grid *grid = &problem->grid;
    uint64_t cells = (uint64_t)grid->width * grid->height;
    if (grid->height == 0 || problem->weight < 0 || problem->edges || !grid->right != !grid->down) {
        return QS_E_ARGUMENT;
    }
    if (cells > QS_VARIABLES_MAX) {
        return QS_E_LIMIT;
    }
    if (grid->right &&
        (!in_range(grid->right, (size_t)cells) || !in_range(grid->down, (size_t)cells))) {
        return QS_E_ARGUMENT;
    }
    const qs_frame *frame = &problem->frame;
    bool framed = frame->picture_width > 0;
    if (framed ? frame->x > frame->picture_width || grid->width > frame->picture_width - frame->x ||
                     frame->y > frame->picture_height ||
                     grid->height > frame->picture_height - frame->y
               : frame->picture_height > 0 || frame->x > 0 || frame->y > 0) {
        return QS_E_ARGUMENT;
    }
    return QS_OK;
}

static qs_status check_edges(const qs_problem *problem)
{
    const qs_frame *frame = &problem->frame;
    bool framed =
        frame->picture_width > 0 || frame->picture_height > 0 || frame->x > 0 || frame->y > 0;
    if ((problem->edge_count > 0 && !problem->edges) || framed) {
        return QS_E_ARGUMENT;
    }
    if (problem->edge_count > QS_VARIABLES_MAX) {
        return QS_E_LIMIT;
    }
    for (size_t e = 0; e < problem->edge_count; e++) {
        const qs_edge *edge = &problem->edges[e];
        if (edge->first >= edge->second || edge->second >= problem->sites || edge->weight < 0) {
            return QS_E_ARGUMENT;
        }
    }
    return QS_OK;
}

static bool has_costs(const qs_problem *problem)
{
    const qs_cost_source *source = &problem->source;
    return problem->costs ||
           (source->row && problem->grid.width > 0 && (source->bytes == 1 || source->bytes == 4));
}

static bool first_is_valid(const qs_problem *problem)
{
    int32_t least = problem->meaning.kind == QS_MEANS_DISPARITY ? -INT32_MAX : 0;
    return problem->frame.first >= least;
}

qs_status qs_problem_check(const qs_problem *problem)
{
    if (!problem || problem->labels < 1 || problem->labels > QS_LABELS_MAX || problem->scale < 1 ||
        !has_costs(problem) || !first_is_valid(problem) ||
        !qs_meaning_is_valid(&problem->meaning)) {
        return QS_E_ARGUMENT;
    }
    qs_status status = problem->grid.width > 0 ? check_grid(problem) : check_edges(problem);
    if (status != QS_OK) {
        return status;
    }
    uint32_t sites = qs_problem_sites(problem);
    if (sites == 0) {
        return QS_E_ARGUMENT;
    }
    if ((uint64_t)sites * problem->labels > QS_VARIABLES_MAX) {
        return QS_E_LIMIT;
    }
    return pairwise_in_range(problem) && sites_have_labels(problem, sites) ? QS_OK : QS_E_ARGUMENT;
}

uint32_t qs_problem_sites(const qs_problem *problem)
{
    const qs_grid *grid = &problem->grid;
    if (grid->width == 0) {
        return problem->sites;
    }
    uint32_t cells = grid->width * grid->height, masked = 0;
    if (!grid->mask) {
        return cells;
    }
    for (uint32_t i = 0; i < cells; i++) {
        masked += grid->mask[i] == 0;
    }
    return cells - masked;
}
