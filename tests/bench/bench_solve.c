/* bench_solve PROBLEM.qcf SOLVER [ITERATIONS]: one solver on one problem, seconds of the solver
 * alone, bytes a site and label. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <qstereo.h>

static const struct {
    const char *name;
    qs_solver *solve;
    size_t (*workspace)(const qs_model *);
} solvers[] = {
#ifdef HAVE_MOVES
    {"expansion", qs_expansion, qs_expansion_workspace},
    {"swap", qs_swap, qs_swap_workspace},
#endif
#ifdef HAVE_CUT
    {"cut", qs_min_cut, qs_min_cut_workspace},
#endif
#ifdef HAVE_MESSAGES
    {"bp", qs_bp, qs_bp_workspace},
    {"trws", qs_trws, qs_trws_workspace},
#endif
#ifdef HAVE_OTHERS
    {"icm", qs_icm, qs_icm_workspace},
    {"anneal", qs_anneal, qs_anneal_workspace},
#endif
#if defined HAVE_MOVES && defined HAVE_MESSAGES && defined HAVE_OTHERS
    {"best", qs_best, qs_best_workspace},
#endif
};

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void demand(bool good, const char *what)
{
    if (!good) {
        fprintf(stderr, "bench_solve: %s\n", what);
        exit(3);
    }
}

static void *memory(size_t size)
{
    void *bytes = malloc(size + 1);
    demand(bytes, "no memory");
    memset(bytes, 0, size);
    return bytes;
}

int main(int argc, char **argv)
{
    demand(argc >= 3, "usage: bench_solve PROBLEM.qcf SOLVER [ITERATIONS]");
    FILE *file = fopen(argv[1], "rb");
    demand(file, "cannot open the problem");
    fseek(file, 0, SEEK_END);
    size_t size = (size_t)ftell(file);
    rewind(file);
    uint8_t *bytes = memory(size);
    demand(fread(bytes, 1, size, file) == size, "cannot read the problem");
    fclose(file);
    qs_qubo qubo;
    qs_index index;
    qs_model model;
    demand(qs_qubo_open(bytes, size, UINT64_MAX, &qubo, NULL) == QS_OK, "not a .qcf");
    demand(qs_index_build(&qubo, memory(qs_index_workspace(&qubo)), qs_index_workspace(&qubo),
                          &index) == QS_OK,
           "no index");
    demand(qs_model_build(&index, memory(qs_model_workspace(&qubo)), qs_model_workspace(&qubo),
                          &model) == QS_OK,
           "no model");
    uint16_t *labelling = memory(sizeof *labelling * model.sites);
    for (size_t i = 0; i < sizeof solvers / sizeof *solvers; i++) {
        if (strcmp(argv[2], solvers[i].name) != 0) {
            continue;
        }
        size_t needed = solvers[i].workspace(&model);
        void *workspace = memory(needed);
        qs_solution solution;
        qs_solve_options options = {.iterations = argc > 3 ? strtoull(argv[3], NULL, 10) : 0};
        qs_model_winner(&model, labelling);
        double begin = seconds();
        demand(solvers[i].solve(&model, &options, workspace, needed, labelling, &solution) == QS_OK,
               "the solver failed");
        double took = seconds() - begin;
        demand(qs_model_energy(&model, labelling) == solution.energy,
               "the energy is not that of the labelling");
        printf("%-9s energy %lld  bound %lld  iterations %llu  %.3f s  %.2f ms an iteration  %.1f "
               "bytes a site and label\n",
               argv[2], (long long)solution.energy, (long long)solution.lower_bound,
               (unsigned long long)solution.iterations, took,
               1e3 * took / (double)(solution.iterations ? solution.iterations : 1),
               (double)needed / model.sites / model.labels);
        return 0;
    }
    demand(false, "no such solver");
}
