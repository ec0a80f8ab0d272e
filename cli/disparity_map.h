/* Disparity maps as files: integers (disparity * scale, 0 = no value) in .pgm and .png, or pixels
 * as floats in .pfm. */
#ifndef DISPARITY_MAP_H
#define DISPARITY_MAP_H

#include "picture.h"
#include "qstereo.h"

/* The scale at which the floats of a PFM are held. */
#define PFM_SCALE 65536u

/* Reads a map; `scale` is that of an integer one, a PFM is in pixels. Returns DONE, BAD_INPUT or
 * NO_RESOURCE, having said why. The values are to be freed. */
int map_read(const char *path, uint32_t scale, qs_map *map, int32_t **values);

typedef enum map_format { MAP_PGM, MAP_PNG, MAP_PFM } map_format;

/* The format that an output's name asks for; `straight`: it may have no ending, then PGM. Returns
 * DONE or BAD_USAGE. */
int map_format_of(const char *path, bool straight, map_format *format);

/* Disparities in pixels, row after row; MAP_NO_VALUE = none. */
#define MAP_NO_VALUE UINT32_MAX
typedef struct pixel_map {
    const uint32_t *disparities;
    uint32_t width, height;
    uint32_t least, most; /* the colours' range */
} pixel_map;

/* The map as the bytes of a file. Returns DONE, BAD_INPUT (a value does not fit) or NO_RESOURCE,
 * having said why. */
int map_encode(const pixel_map *map, map_format format, uint32_t scale, const char *path,
               file_bytes *file);

/* The map in colours, as a PNG where `png`, else as a PPM. */
int map_encode_colour(const pixel_map *map, bool png, const char *path, file_bytes *file);

#endif
