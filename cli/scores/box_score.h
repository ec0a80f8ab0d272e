/* Boxes of detections beside the true ones. */
#ifndef BOX_SCORE_H
#define BOX_SCORE_H

#include "makers/boxes.h"

/* A box is right if it overlaps a true one of its picture by an IoU of 0.5 or more. Boxes are taken
 * by falling score; each takes the true box that it overlaps most, unless that one has been taken.
 * ap is the area under the curve of precision over recall, each precision raised to the largest one
 * of a higher recall (Everingham et al., "The PASCAL visual object classes challenge", IJCV 88,
 * 2010, section 4.1, with all points since 2010). */
typedef struct box_score {
    uint32_t boxes, truths, right;
    double precision, recall, ap;
} box_score;

/* Returns DONE, or NO_RESOURCE after a message. */
int box_score_find(const box_file *boxes, const box_file *truth, budget *limit, box_score *found);

/* Print the scores: keys of JSON, and a line for people. */
void box_score_json(const box_score *shown);
void box_score_print(const box_score *shown);

#endif
