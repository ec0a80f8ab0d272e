/* Stereo pairs one after the other: one pair of pictures, files with numbers, or streams; also both
 * pictures of a pair side by side in one. Each function that can fail returns an exit status and
 * has printed why. */
#ifndef FRAMES_H
#define FRAMES_H

#include "camera/numbered.h"
#include "camera/rectifier.h"
#include "pictures/picture_stream.h"
#include "qstereo.h"

typedef enum source_kind { SOURCE_PICTURE, SOURCE_NUMBERED, SOURCE_STREAM } source_kind;

typedef struct source {
    const char *path;
    source_kind kind;
    numbered files;
    picture_stream stream;
} source;

/* A pair of rectified pictures, in memory of the budget. */
typedef struct frame_pair {
    uint32_t number; /* of its files; in streams they count from 1 */
    const char *names[2]; /* of the left and the right picture, for messages */
    qs_image grey[2];
} frame_pair;

typedef struct frames {
    source sources[2];
    size_t count; /* of sources; 1 = its pictures are pairs side by side */
    bool is_sequence;
    unsigned bits; /* of the samples of a file of 16; 0 = all */
    calibration *by; /* of its cameras; NULL = none */
    rectifier table; /* if the pictures are to be rectified, made for the first pair */
    budget *whole; /* has the table: that of the command */
    uint32_t next; /* number of the next frame */
    bool any; /* there has been a frame */
} frames;

/* Opens the inputs. They are a sequence if one of them or the output has a number in its name, or
 * if pairs side by side come from standard input. Then an input without a number is a stream.
 * Strings are borrowed. Returns DONE, BAD_USAGE, BAD_INPUT or NO_RESOURCE.
 *
 * right  the second input; NULL = the first one has pairs side by side
 * to     the name of what is made of each frame: a sequence needs a number in it, or a pipe */
int frames_open(const char *left, const char *right, const char *to, frames *opened);

/* Reads the next pair into memory of the budget. Returns DONE, with *ended if there is none,
 * BAD_INPUT or NO_RESOURCE. */
int frames_next(frames *from, budget *limit, frame_pair *read, bool *ended);

void frames_close(frames *closed);

#endif
