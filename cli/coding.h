/* How a problem is to be written as a QUBO: the options, and what goes with what. */
#ifndef CODING_H
#define CODING_H

#include "inputs.h"
#include "qstereo/recode.h"

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

#endif
