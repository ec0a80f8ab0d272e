/* How a problem is to be written as a QUBO: the options, and what goes with what. */
#ifndef CODING_H
#define CODING_H

#include "qstereo.h"
#include "qstereo/recode.h"

/* Rows for a table of options, one behind the other. */
enum { CODING_PENALTY, CODING_GAP, CODING_TRUNCATE, CODING_OPTIONS };
#define CODING_OPTION_ROWS                                                                                             \
    {"penalty", 0, false, "NAME", "local",                                                                             \
     "local or minimal (proven by site), paper (one alpha for all) or your own alpha"},                                 \
        {"gap", 0, false, "G", NULL,                                                                                   \
         "integer units from the optimum to any infeasible state, of local and minimal (default 1)"},                  \
    {                                                                                                                  \
        "truncate", 0, false, NULL, NULL,                                                                              \
            "cut costs that no optimum pays: the same optima, smaller coefficients; energies stay F's"              \
    }

/* What the coefficients are to hold. */
typedef struct coded_problem {
    const char *file; /* what the problem was read from; NULL = it is of the command line */
    qs_pairwise pairwise;
    uint32_t labels, scale;
    qs_encoding preset; /* the encoding where none is asked for */
} coded_problem;

/* Reads the arguments of --encoding (NULL = none) and of the rows. Returns DONE, BAD_USAGE, or BAD_INPUT where the smoothness of a
 * file does not allow them, having said why. */
int coding_read(const char *encoding, const char *const *values, const coded_problem *of, qs_recode_options *asked);

/* Whether an encoding can hold a pairwise cost (docs/MATHS.md). */
bool encoding_holds(qs_encoding encoding, const qs_pairwise *pairwise, uint32_t labels);

/* "linear truncated at 3". */
#define SMOOTHNESS_SIZE 48
void smoothness_write(const qs_pairwise *pairwise, char text[SMOOTHNESS_SIZE]);

#endif
