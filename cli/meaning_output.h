/* Files of what labels stand for, all but maps of disparities: pictures, fields, lists; and of any
 * labels their numbers as an array. Each function that can fail returns an exit status and has
 * printed why. */
#ifndef MEANING_OUTPUT_H
#define MEANING_OUTPUT_H

#include "makers/boxes.h"
#include "meanings.h"
#include "output.h"

typedef enum meaning_format {
    MEANING_PICTURE,
    MEANING_FIELD,
    MEANING_ARRAY,
    MEANING_LIST
} meaning_format;

typedef struct meaning_output {
    meaning_format format;
    bool png; /* of pictures and fields */
    const box_file *boxes; /* those that are kept or dropped, to list them; NULL = their numbers */
} meaning_output;

/* Checks that the name of an output ends as files of such labels do, disparities too. Returns DONE
 * or BAD_USAGE. */
int meaning_ending_check(const char *name, const qs_labels *labels, const char *path);

/* What the name of an output asks for: .npy of any labels; of numbers, greys and classes .png or
 * .pgm; of displacements .flo or .png; of boxes .csv. `boxes` are
 * the caller's to set. Returns DONE or BAD_USAGE. */
int meaning_output_read(const char *name, const qs_labels *labels, const char *path,
                        meaning_output *asked);

/* Writes a labelling to an open output. Returns DONE, BAD_INPUT or NO_RESOURCE. */
int meaning_output_write(const char *name, const qs_labels *labels, const uint16_t *labelling,
                         const meaning_output *asked, budget *limit, output *to);

/* The ending of such a file if nobody has named one: "png". */
const char *meaning_output_ending(const qs_labels *labels);

#endif
