/* The reduced problem that reduce writes where the command line does not say how. */
#ifndef CORE_MADE_H
#define CORE_MADE_H

#include "encoding_choice.h"
#include "reducing.h"

/* How much of what has been decided the file says. */
typedef enum core_detail {
    CORE_LABELS, /* all: each label that has left */
    CORE_SITES, /* sites that are decided; the others have all labels that they came with */
    CORE_NOTHING /* the problem as it came */
} core_detail;

/* Writes the reduced problem, in memory of the budget.
 *
 * Where V is not Potts, in the encoding that holds it with the fewest quadratic terms; else in that
 * of the problem. And, if it is above 1 MiB, never in more bytes than
 * the problem has: label sets without a pattern need a block for each two of them, and rather than
 * that, fewer labels leave.
 *
 * coding  how the problem came; its label sets are those of `smaller`
 * detail  out
 * Returns DONE, BAD_INPUT or NO_RESOURCE, and has printed why. */
int core_make(const laid_out *problem, const qs_recode_options *coding, const reduced *smaller,
              budget *limit, problem_file *made, core_detail *detail);

#endif
