/* CPU time of one iteration of the TRW-S solvers: of those from FIRST to LAST, after which no
 * labellings are made. One core, the least of RUNS. Prints a JSON list. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "bench.h"

enum { RUNS = 3, FIRST = 2, LAST = 7, WEIGHT = 20, NOISE = 60, WRONG = 15 };

typedef struct kind {
    const char *name;
    uint32_t labels;
    qs_pairwise pairwise;
} kind;

/* When the iterations FIRST and LAST had been done, in CPU time. */
typedef struct moments {
    clock_t first, last;
} moments;

static bool note(void *context, const qs_progress *progress)
{
    moments *m = context;
    m->first = progress->iteration <= FIRST ? clock() : m->first;
    m->last = progress->iteration < LAST ? m->last : m->last == 0 ? clock() : m->last;
    return true;
}

static double milliseconds(const qs_problem *problem, const qs_model *model)
{
    size_t size = model ? qs_trws_workspace(model) : qs_trws16_workspace(problem, LAST + 1);
    void *workspace = memory(size);
    uint16_t *labelling = memory(sizeof *labelling * problem->grid.width * problem->grid.height);
    double least = 1e9;
    for (int i = 0; i < RUNS; i++) {
        moments m = {0};
        qs_solve_options options = {.iterations = LAST + 1, .watch = note, .context = &m};
        qs_solution solution;
        demand(model ? qs_trws(model, &options, workspace, size, labelling, &solution)
                     : qs_trws16(problem, &options, workspace, size, labelling, &solution));
        double each = 1e3 * (double)(m.last - m.first) / CLOCKS_PER_SEC / (LAST - FIRST);
        least = each < least ? each : least;
    }
    free(labelling);
    free(workspace);
    return least;
}

/* A slanted surface under noise: labellings are made from it quickly. */
static void bench(uint32_t width, uint32_t height, const kind *of, bool last)
{
    uint32_t labels = of->labels;
    size_t count = (size_t)width * height * labels;
    int32_t *costs = memory(sizeof *costs * count);
    for (size_t i = 0; i < count; i++) {
        size_t right = i / labels % width * labels / width;
        costs[i] = (rand() >> 8) % NOISE + (i % labels != right ? WRONG : 0);
    }
    qs_problem problem = {.labels = labels,
                          .scale = 1,
                          .weight = WEIGHT,
                          .pairwise = of->pairwise,
                          .grid = {.width = width, .height = height},
                          .costs = costs};
    size_t size = qs_model_of_problem_workspace(&problem);
    void *workspace = memory(size);
    qs_model model;
    demand(qs_model_of_problem(&problem, workspace, size, &model, NULL));
    double wide = milliseconds(&problem, &model), narrow = milliseconds(&problem, NULL);
    printf("  {\"smoothness\": \"%s\", \"truncation\": %u, \"width\": %u, \"height\": %u, "
           "\"labels\": %u, \"trws_ms\": %.1f, \"trws16_ms\": %.1f}%s\n",
           of->name, of->pairwise.truncation, width, height, labels, wide, narrow, last ? "" : ",");
    free(workspace);
    free(costs);
}

int main(void)
{
    static const kind kinds[] = {
        {"potts", 20, {.smoothness = QS_POTTS}},
        {"potts", 74, {.smoothness = QS_POTTS}},
        {"linear", 20, {.smoothness = QS_TRUNCATED_LINEAR, .truncation = 2}},
        {"linear", 20, {.smoothness = QS_TRUNCATED_LINEAR, .truncation = 7}},
        {"linear", 74, {.smoothness = QS_TRUNCATED_LINEAR}}};
    enum { COUNT = sizeof kinds / sizeof *kinds, SITES = 636000 * 20, HEIGHT = 766 };
    printf("[\n");
    for (int i = 0; i < COUNT; i++) {
        bench(SITES / HEIGHT / kinds[i].labels, HEIGHT, &kinds[i], i + 1 == COUNT);
        fflush(stdout);
    }
    printf("]\n");
    return 0;
}
