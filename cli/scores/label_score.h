/* Pictures of classes beside the truth. */
#ifndef LABEL_SCORE_H
#define LABEL_SCORE_H

#include "files.h"
#include "qstereo.h"

enum { LABEL_VALUES = 256 };

/* Over all pixels. The intersection over union of a class is the pixels that have it in both, over
 * those that have it in either (Everingham et al., "The PASCAL visual object classes challenge",
 * IJCV 88, 2010, section 4.2). */
typedef struct label_score {
    uint64_t pixels, wrong;
    uint64_t both[LABEL_VALUES], either[LABEL_VALUES]; /* pixels, by the value of the class */
} label_score;

/* Compares two pictures of one size. */
void label_score_find(const qs_image *map, const qs_image *truth, label_score *found);

/* The mean over the classes that are in either picture. */
double label_score_iou(const label_score *of);

/* Print the scores: keys of JSON, and lines for people. */
void label_score_json(const label_score *shown);
void label_score_print(const label_score *shown);

#endif
