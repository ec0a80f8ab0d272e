#include "cost_strips.h"

#include <string.h>

#include "../base/bytes.h"
#include "../base/minmax.h"

/* Costs in a strip from an array: so many that calls are rare, so few that they stay in the first
 * cache. */
enum { STRIP_COSTS = 2048 };

static uint32_t strip_sites(const qs_problem *problem)
{
    if (!problem->costs) {
        return problem->grid.width;
    }
    return problem->labels < STRIP_COSTS ? STRIP_COSTS / problem->labels : 1;
}

static size_t least_size(const qs_problem *problem)
{
    return sizeof(int32_t) * strip_sites(problem);
}

static unsigned cost_bytes(const qs_problem *problem)
{
    return problem->costs ? 4 : problem->source.bytes;
}

size_t qs_costs_workspace(const qs_problem *problem)
{
    return qs_size(least_size(problem) +
                   (uint64_t)cost_bytes(problem) * strip_sites(problem) * problem->labels);
}

qs_strip qs_strip_first(const qs_problem *problem, void *workspace)
{
    qs_strip strip = {.problem = problem, .bytes = cost_bytes(problem), .least = workspace};
    strip.costs = (char *)workspace + least_size(problem);
    strip.total = problem->costs ? qs_problem_sites(problem) : problem->grid.height;
    return strip;
}

/* The next sites of an array. */
static void shift_sites(qs_strip *strip)
{
    const qs_problem *problem = strip->problem;
    uint32_t labels = problem->labels, *out = strip->costs;
    const int32_t *in = problem->costs + (size_t)strip->next * labels;
    strip->sites = qs_min_u32(strip->total - strip->next, strip_sites(problem));
    strip->least_sum = 0;
    for (uint32_t p = 0; p < strip->sites; p++, in += labels, out += labels) {
        int32_t least = in[0];
        for (uint32_t d = 1; d < labels; d++) {
            least = qs_min_i32(least, in[d]);
        }
        for (uint32_t d = 0; d < labels; d++) {
            out[d] = (uint32_t)in[d] - (uint32_t)least;
        }
        strip->least[p] = least;
        strip->least_sum += least;
    }
    strip->next += strip->sites;
}

/* Moves the costs of the cells of a row that are not masked together. */
static void drop_masked(qs_strip *strip, const uint8_t *mask)
{
    size_t each = strip->bytes * (size_t)strip->problem->labels;
    char *costs = strip->costs;
    uint32_t kept = 0;
    for (uint32_t x = 0; x < strip->problem->grid.width; x++) {
        if (mask[x] != 0) {
            memmove(costs + kept * each, costs + x * each, each);
            strip->least[kept++] = strip->least[x];
        }
    }
    strip->sites = kept;
}

static void make_row(qs_strip *strip)
{
    const qs_problem *problem = strip->problem;
    const qs_grid *grid = &problem->grid;
    strip->sites = grid->width;
    problem->source.row(problem->source.context, strip->next, strip->costs, strip->least);
    if (grid->mask) {
        drop_masked(strip, grid->mask + (size_t)strip->next * grid->width);
    }
    int64_t sum = 0;
    for (uint32_t x = 0; x < strip->sites; x++) {
        sum += strip->least[x];
    }
    strip->least_sum = sum;
    strip->next++;
}

bool qs_strip_next(qs_strip *strip)
{
    if (strip->next == strip->total) {
        return false;
    }
    if (strip->problem->costs) {
        shift_sites(strip);
    } else {
        make_row(strip);
    }
    return true;
}

int64_t qs_strip_cost(const qs_strip *strip, size_t at)
{
    return strip->bytes == 1 ? ((const uint8_t *)strip->costs)[at]
                             : ((const uint32_t *)strip->costs)[at];
}
