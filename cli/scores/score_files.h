/* Two files beside each other, as what they are said to hold. */
#ifndef SCORE_FILES_H
#define SCORE_FILES_H

#include "command.h"

/* Compares the operands of the command, all but disparity maps, and prints the scores.
 *
 * as    labels, picture, flow or boxes
 * hole  of pictures: the name of the mask of a hole, NULL = none
 * Returns DONE, BAD_USAGE, BAD_INPUT, NO_RESOURCE, or ANSWER_NO if nothing can be compared. */
int score_files(job *at, const char *as, const char *hole);

#endif
