/* Pictures of classes beside the truth. */
#ifndef LABEL_SCORE_H
#define LABEL_SCORE_H

#include "arrays/npy.h"
#include "files.h"
#include "pictures/picture.h"

/* A map of labels or classes: the pixels of a picture, or the elements of an array. */
typedef struct label_map {
    const char *name;
    uint64_t count;
    int32_t *values; /* -1 = no label. The budget owns them */
    char shape[NPY_TEXT]; /* "256 x 160" */
} label_map;

/* Reads a grey picture, or a .npy of whole numbers up to 65535, -1 = no label. Returns DONE,
 * BAD_INPUT or NO_RESOURCE, and has printed why. */
int label_map_read(const char *path, budget *limit, label_map *read);

/* The map of a picture in memory. `name` is for messages. Returns what label_map_read does. */
int label_map_of(const picture *from, const char *name, budget *limit, label_map *made);

/* Checks that two maps have one size. Returns DONE or BAD_INPUT. */
int label_map_check(const label_map *map, const label_map *truth);

enum { LABEL_VALUES = 65536 };

/* Over all pixels that have a label in both. The intersection over union of a class is the pixels
 * that have it in both, over those that have it in either (Everingham et al., "The PASCAL visual
 * object classes challenge", IJCV 88, 2010, section 4.2). */
typedef struct label_score {
    uint64_t pixels, wrong;
    uint64_t *both, *either; /* pixels, by the value of the class; the budget owns them */
} label_score;

/* Compares two maps of one size. Returns DONE or NO_RESOURCE. */
int label_score_find(const label_map *map, const label_map *truth, budget *limit,
                     label_score *found);

/* Print the scores: keys of JSON, and lines for people. */
void label_score_json(const label_score *shown);
void label_score_print(const label_score *shown);

#endif
