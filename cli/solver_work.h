/* A solver at work on a problem that is laid out, in three steps, so that two of them can work at
 * the same time: what takes memory or prints is done before and after by the thread that the
 * command began with. Each function that can fail returns an exit status and has printed why. */
#ifndef SOLVER_WORK_H
#define SOLVER_WORK_H

#include "halves.h"
#include "progress_line.h"
#include "solving.h"
#include "threads.h"

typedef struct solver_work {
    const laid_out *problem;
    const solver *by;
    const search *how;
    solved *found;
    halves *finer; /* made of the labelling in the same step; NULL = not wanted */
    budget memory; /* of the work alone; another work may take what is left of it */
    void *workspace, *check; /* for the solver, and to compute the energy again */
    size_t size, check_size;
    int64_t limit; /* microseconds; 0 = none */
    bool hidden; /* it draws no line on the terminal */
    team *team; /* helps in this work; NULL = none */
    uint32_t workers; /* the team and the thread of the work */
    progress watched;
    qs_status ran, checked;
    int64_t energy; /* as the problem gives it to the labelling */
} solver_work;

/* Takes the memory: what is found stays in that of `limit`. All is borrowed until work_end; finer
 * may be NULL, else it is begun.
 * Returns DONE or NO_RESOURCE; then, too, work_end follows. */
int work_begin(const laid_out *problem, const solver *by, const search *how, halves *finer,
               budget *limit, solved *found, solver_work *begun);

/* Solves the problem. Any thread may: it takes no memory and prints no message. */
void work_do(void *work);

/* Compares the energy with what the solver says. Returns DONE, also if the solver refused,
 * BAD_INPUT or NO_RESOURCE. */
int work_check(solver_work *done);

/* Frees the memory of the work. A second time does nothing. */
void work_end(solver_work *ended);

/* All steps one after the other: solve_problem with half pixels. */
int work_whole(const laid_out *problem, const solver *by, const search *how, halves *finer,
               budget *limit, solved *found);

#endif
