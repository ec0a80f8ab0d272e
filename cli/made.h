/* A labelling problem that a command makes from its inputs: what encode and the commands that solve
 * in one go do with it. Each function that can fail returns an exit status and has printed why. */
#ifndef MADE_H
#define MADE_H

#include "solving.h"

typedef struct made_problem {
    const char *name; /* of the first input, for messages */
    const char *mend; /* the options that coefficients grow with, for messages */
    qs_problem problem; /* borrows from the budget */
} made_problem;

/* A maker of problems: one for each argument of encode --problem. The budget owns its
 * memory. */
typedef struct maker {
    size_t size; /* of its state */
    /* Reads the command line; strings are borrowed. `values` begins at the maker's rows. Returns
     * DONE or BAD_USAGE. */
    int (*read)(const char *const *operands, const char *const *values, void *state);
    /* Reads the inputs and makes the problem. Returns DONE, BAD_INPUT or NO_RESOURCE. */
    int (*open)(void *state, budget *limit, made_problem *opened);
    /* Fills in labels, scale and pairwise, so that options which do not go with them are refused
     * before the inputs are read. NULL = only the inputs say it. */
    void (*plan)(const void *state, qs_problem *planned);
} maker;

/* Writes the problem as a .qcf; size may be NULL. Returns DONE, BAD_INPUT or NO_RESOURCE. It is no
 * failure here if the sink refuses bytes: the owner of the sink knows it.
 *
 * mend  the options that coefficients grow with, for the message */
int made_encode(const made_problem *encoded, const qs_encode_options *options, const char *mend,
                budget *limit, const qs_sink *sink, uint64_t *size);

/* Prints what the library refused when it made a problem. Returns BAD_INPUT or NO_RESOURCE.
 *
 * fewer  what makes the problem smaller: "choose a smaller --roi" */
int made_fail(const made_problem *failed, const char *fewer, qs_status status);

/* Refuses before the work what would be far over the memory limit, and names about how much the
 * model, the solver and after them the output need. laid_out_need, when the model is there, knows
 * it exactly. Return DONE or NO_RESOURCE.
 *
 * iterations  as in a search
 * output      bytes that are taken when the solver's work is freed */
int made_need(const made_problem *whole, const solver *by, uint64_t output, const budget *limit);
int laid_out_need(const laid_out *problem, const solver *by, uint64_t iterations, uint64_t output,
                  const budget *limit);

/* Lays the problem out; straight: without a model. Returns DONE, BAD_INPUT or NO_RESOURCE. */
int made_lay_out(const made_problem *whole, bool straight, budget *limit, laid_out *laid);

/* Solves the problem without a file between. What was found stays in memory of the budget. Returns
 * DONE, BAD_INPUT (also if the solver refuses) or NO_RESOURCE. */
int made_solve(const made_problem *solved_one, const solver *by, const search *how, budget *limit,
               laid_out *laid, solved *found);

#endif
