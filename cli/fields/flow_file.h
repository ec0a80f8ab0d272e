/* Fields of displacements (optical flow): as files, and in colours. Each function that can fail
 * returns an exit status and has printed why. */
#ifndef FLOW_FILE_H
#define FLOW_FILE_H

#include "output.h"
#include "pictures/picture.h"

/* height rows of width pairs (dx, dy), in pixels; NaN = unknown. The budget owns them. */
typedef struct flow_field {
    uint32_t width, height;
    float *vectors;
} flow_field;

/* Takes the memory of a field. Returns DONE or NO_RESOURCE. */
int flow_take(const char *name, uint32_t width, uint32_t height, budget *limit, flow_field *taken);

/* Reads a field: a .npy of floats, height x width x 2; a .flo (Baker et al., "A database and
 * evaluation methodology for optical flow", IJCV 92, 2011), or a PNG of KITTI (Menze and Geiger
 * 2015: 16 bits, (64 dx + 2^15, 64 dy + 2^15, 1 = known)). Returns DONE, BAD_INPUT
 * or NO_RESOURCE. */
int flow_read(const char *path, budget *limit, flow_field *read);

/* The option -o of a command that writes a field. */
#define FLOW_OUTPUT_OPTION(NAME)                                                                   \
    {"output",                                                                                     \
     'o',                                                                                          \
     true,                                                                                         \
     NAME,                                                                                         \
     NULL,                                                                                         \
     "field to write: .flo (Middlebury's), or .png (KITTI's); - is standard "                      \
     "output, as .flo"}

/* Reads its argument. Returns DONE or BAD_USAGE. */
int flow_format_read(const char *path, bool *png);

/* Writes a field to an open output. Returns DONE, BAD_INPUT (it does not fit a PNG) or
 * NO_RESOURCE. */
int flow_write(const flow_field *written, bool png, output *to);

/* Checks the name of the field in colours (NULL = none is asked for). Returns DONE or BAD_USAGE. */
int flow_colour_check(const char *path);

/* Writes the field in colours to an open output: the hue is the direction, the saturation the
 * length, white = 0, black = unknown; the longest displacement has full colour. (The colour wheel
 * of Baker et al. 2011, section 4.3.) Returns DONE or NO_RESOURCE. */
int flow_colour_write(const flow_field *shown, const char *path, output *to);

#endif
