/* A problem that has been laid out, written again as a QUBO in memory. */
#ifndef RECODING_H
#define RECODING_H

#include "coding.h"
#include "solving.h"

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
