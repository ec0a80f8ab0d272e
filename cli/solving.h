/* Solving the problem of a .qcf with the library's solvers. */
#ifndef SOLVING_H
#define SOLVING_H

#include "inputs.h"
#include "search.h"
#include "solvers.h"

/* A problem laid out for the solvers. */
typedef struct laid_out {
    const problem_file *problem;
    qs_model model;
    void *workspace;
} laid_out;

/* Indexes an open problem and lays it out. Returns DONE, BAD_INPUT or NO_RESOURCE, having said why;
 * laid_out_close frees what was allocated in any case. */
int laid_out_open(problem_file *problem, budget *limit, laid_out *opened);
void laid_out_close(laid_out *closed);

/* What a solver found. */
typedef struct solved {
    const char *solver;
    qs_status refusal; /* QS_OK, or why the solver cannot be used; then nothing else is set */
    qs_solution solution;
    int64_t microseconds; /* of the solver alone */
    bool out_of_time; /* the time limit stopped it */
    bool own_limit; /* no limit of iterations was asked for */
    uint16_t *labelling; /* of the problem's sites; to be freed */
    uint8_t *bits; /* the sample of it; to be freed */
    int64_t qubo_energy; /* H of the sample: less than the solution's energy where the costs were
                            truncated */
} solved;

/* Solves; the energy has been recomputed from the sample. The limit is for the solver's work and
 * what it found. Returns DONE, also where the solver refuses, or NO_RESOURCE, having said why. */
int solve_problem(const laid_out *problem, const solver *by, const search *how, budget limit,
                  solved *found);
void solved_free(solved *freed);

/* Says why the solver cannot be used. Returns DONE where it can, else BAD_INPUT. */
int solved_check(const laid_out *problem, const solved *found);

bool solved_has_bound(const solved *found);
bool solved_is_proven(const solved *found);

/* The keys of JSON, and lines for people: how good the energy is, and what it took. */
void solved_json(const solved *found, uint32_t scale);
void solved_print(const solved *found, uint32_t scale);

#endif
