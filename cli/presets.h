/* Settings of matching under one name: the arguments of options that are not given. */
#ifndef PRESETS_H
#define PRESETS_H

#include <stddef.h>

/* Of linear costs lambda and truncation count labels, so half pixels halve one and double the
 * other. */
typedef struct preset_smoothness {
    const char *lambda, *truncation; /* NULL = none */
} preset_smoothness;

/* What depends on the range of disparities. */
typedef struct preset_range {
    const char *step; /* from one label to the next, in pixels */
    preset_smoothness strength[2]; /* [labels in a pixel - 1] */
    const char *potts_lambda; /* where --smoothness potts is given */
    /* Of match alone: */
    const char *iterations; /* NULL = the solver's own limit */
    const char *after;
} preset_range;

typedef struct preset {
    const char *name;
    const char *cost, *contrast, *border, *smoothness; /* contrast NULL = none */
    const char *solver; /* of match alone */
    preset_range ranges[2]; /* [the range has more than PRESET_WIDE pixels] */
} preset;

enum { PRESET_WIDE = 32, PRESETS = 3 };

extern const preset presets[PRESETS];

/* Reads the argument of --preset. Returns DONE or BAD_USAGE. */
int preset_read(const char *text, const preset **chosen);

/* The names, one by one; NULL after the last. */
const char *preset_at(size_t index);

#endif
