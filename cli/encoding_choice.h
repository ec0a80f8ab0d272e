/* How a problem is written as a QUBO: the options, which of them go together, and the writing. */
#ifndef ENCODING_CHOICE_H
#define ENCODING_CHOICE_H

#include "solving.h"

/* Rows for a table of options, one behind the other. Each takes the words for its default. */
enum { CODING_PENALTY, CODING_GAP, CODING_TRUNCATE, CODING_OPTIONS };
#define CODING_OPTION_ROWS(penalty, gap, truncate)                                                 \
    {"penalty", 0,    false,                                                                       \
     "NAME",    NULL, "local or minimal (proven), paper (one alpha), or your own alpha" penalty},  \
        {"gap",                                                                                    \
         0,                                                                                        \
         false,                                                                                    \
         "G",                                                                                      \
         NULL,                                                                                     \
         "integer units between the optimum and any infeasible state, for the penalties local "    \
         "and minimal" gap},                                                                       \
    {                                                                                              \
        "truncate", 0, false, NULL, NULL,                                                          \
            "lower the costs that no optimum pays: smaller coefficients, same optima and "         \
            "energies" truncate                                                                    \
    }

/* The problem that the coefficients are to hold, and what is chosen for it if the command line says
 * nothing else. */
typedef struct coded_problem {
    const char *file; /* that it was read from; NULL = it comes from the command line */
    qs_pairwise pairwise;
    uint32_t labels, scale;
    qs_encoding encoding;
    qs_penalty penalty; /* local is taken instead if the encoding does not have it, or if it is
                           an alpha that was given, which a file does not hold */
    uint32_t gap;
    bool truncate;
} coded_problem;

/* A problem that was read, with the defaults that its file gives. */
coded_problem coded_in_file(const problem_file *problem);

/* Reads the arguments of --encoding (NULL = none) and of the rows. Returns DONE or
 * BAD_USAGE. */
int coding_read(const char *encoding, const char *const *values, const coded_problem *of,
                qs_recode_options *asked);

/* Writes "linear, truncated at 3". */
#define SMOOTHNESS_SIZE 48
void smoothness_write(const qs_pairwise *pairwise, char text[SMOOTHNESS_SIZE]);

/* Writes the problem again as `options` say, in memory of the budget, and opens what was written
 * under the name of the problem.
 *
 * mend  what the user can make smaller if coefficients overflow, for the message
 * Returns DONE, BAD_INPUT or NO_RESOURCE, and has printed why. */
int recode_problem(const laid_out *problem, const qs_recode_options *options, const char *mend,
                   budget *limit, problem_file *made);

/* The same without messages, and without opening it. Returns the library's status, and QS_E_LIMIT
 * also if it is over the budget, QS_E_IO if there is no memory. file_free frees what was made. */
qs_status recode_quietly(const laid_out *problem, const qs_recode_options *options,
                         const budget *limit, file_bytes *made);

#endif
