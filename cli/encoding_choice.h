/* How a problem is written as a QUBO: the options, which of them go together, and the writing. */
#ifndef ENCODING_CHOICE_H
#define ENCODING_CHOICE_H

#include "inputs.h"
#include "qstereo/recode.h"
#include "solving.h"

/* How a problem is to be written as a QUBO: the options, and what goes with what. */

/* Rows for a table of options, one behind the other; of each the words for its default. */
enum { CODING_PENALTY, CODING_GAP, CODING_TRUNCATE, CODING_OPTIONS };
#define CODING_OPTION_ROWS(penalty, gap, truncate)                                                   \
    {"penalty", 0,    false,                                                                         \
     "NAME",    NULL, "local or minimal (proven), paper (one alpha) or your own alpha" penalty},     \
        {"gap", 0,                                                                                   \
         false, "G",                                                                                 \
         NULL,  "integer units from the optimum to any infeasible state, of local and minimal" gap}, \
    {                                                                                                \
        "truncate", 0, false, NULL, NULL,                                                            \
            "cut costs no optimum pays: smaller coefficients, same optima and energies" truncate     \
    }

/* What the coefficients are to hold. */
typedef struct coded_problem {
    const char *file; /* what the problem was read from; NULL = it is of the command line */
    qs_pairwise pairwise;
    uint32_t labels, scale;
    /* Where nothing else is asked for: */
    qs_encoding encoding;
    qs_penalty penalty; /* local if the encoding has it not, or if it is an alpha that was given:
                           that is not known again */
    uint32_t gap;
    bool truncate;
} coded_problem;

/* A problem that was read, with the defaults that its file gives. */
coded_problem coded_in_file(const problem_file *problem);

/* Reads the arguments of --encoding (NULL = none) and of the rows. Returns DONE, BAD_USAGE, or
 * BAD_INPUT where the smoothness of a file does not allow them, having said why. */
int coding_read(const char *encoding, const char *const *values, const coded_problem *of,
                qs_recode_options *asked);

/* Whether an encoding can hold a pairwise cost (docs/MATHS.md). */
bool encoding_holds(qs_encoding encoding, const qs_pairwise *pairwise, uint32_t labels);

/* "linear truncated at 3". */
#define SMOOTHNESS_SIZE 48
void smoothness_write(const qs_pairwise *pairwise, char text[SMOOTHNESS_SIZE]);

/* A problem that has been laid out, written again as a QUBO in memory. */

/* Writes the problem as `options` say and opens what was written, under the name of the problem.
 *
 * mend  what the user can make smaller where coefficients overflow, for the message
 * Returns DONE, BAD_INPUT or NO_RESOURCE, having said why. problem_close frees what was allocated
 * in any case. */
int recode_problem(const laid_out *problem, const qs_recode_options *options, const char *mend,
                   budget *limit, problem_file *made);

/* The same without a word where it does not fit: the library's status; QS_E_LIMIT also where the
 * budget or memory ends. */
qs_status recode_quietly(const laid_out *problem, const qs_recode_options *options, budget *limit,
                         file_bytes *made);

#endif
