/* Two files beside each other, as what they are said to hold. */
#ifndef SCORE_FILES_H
#define SCORE_FILES_H

#include "command.h"

/* Names of further files; NULL = none. */
typedef struct score_options {
    const char *hole; /* of pictures: the mask of a hole */
    const char *boxes; /* of boxes: those of which the first operand, a list, says which are kept */
} score_options;

/* Compares the operands of the command, all but disparity maps, and prints the scores.
 *
 * as  labels, picture, flow or boxes
 * Returns DONE, BAD_USAGE, BAD_INPUT, NO_RESOURCE, or ANSWER_NO if nothing can be compared. */
int score_files(job *at, const char *as, const score_options *options);

#endif
