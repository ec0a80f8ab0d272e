/* Files of every encoding, written plainly from the definitions of docs/MATHS.md and
 * docs/FORMAT.md: a second opinion on what the library writes and reads. */
#ifndef SLOW_H
#define SLOW_H

#include "tiny.h"

enum { SLOW_FILE = 1 << 16, SLOW_INDEX = 1 << 16, SLOW_VARIABLES = 256 };

/* What is to be written. */
typedef struct slow_request {
    const qs_problem *problem;
    qs_encoding encoding;
    qs_penalty penalty; /* local or minimal */
    int64_t gap;
    bool truncate;
    bool open_single; /* against the rules: sites of one label have variables, too */
    bool kept[TINY_SITES][TINY_LABELS]; /* labels left, at least one a site */
    const uint16_t *best; /* labels left, of the sites: the labelling that the file carries; NULL =
                             none */
    int64_t lower_bound; /* that it states beside it */
} slow_request;

/* A file, opened. */
typedef struct slow_qubo {
    uint8_t file[SLOW_FILE];
    size_t size;
    uint64_t memory[SLOW_INDEX / 8];
    qs_qubo qubo;
    qs_index index;
} slow_qubo;

/* Whether the encoding can hold the problem's pairwise cost. */
bool slow_fits(const qs_problem *problem, qs_encoding encoding);

/* A random set of labels for each site; now and then all. */
void slow_choose_labels(slow_request *request, uint64_t *state);

/* Writes; and opens. */
void slow_write(const slow_request *request, slow_qubo *q);
void slow_encode(const slow_request *request, slow_qubo *q);

/* Opens what `q` holds. */
void slow_open(slow_qubo *q);

/* F of a labelling. */
int64_t slow_energy(const qs_problem *problem, const uint16_t *labelling);

/* The next labelling of the labels left; false after the last. */
bool slow_next(const slow_request *request, uint16_t *labelling);
void slow_first(const slow_request *request, uint16_t *labelling);

/* Whether a site of a model has the label. */
bool slow_is_kept(const qs_model *model, uint32_t site, uint32_t label);

/* Random labels, of those that the sites of a model have. */
void slow_random_labels(const qs_model *model, uint64_t *state, uint16_t *labelling);

#endif
