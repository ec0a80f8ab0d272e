/* The two files of qstereo, opened under one memory budget. Each function returns DONE, BAD_INPUT
 * or NO_RESOURCE, having said why. */
#ifndef INPUTS_H
#define INPUTS_H

#include "files.h"
#include "qstereo.h"

typedef struct problem_file {
    const char *name; /* for messages */
    file_bytes file;
    qs_qubo qubo;
    uint32_t scale; /* integer units in one real unit; 1 where the file does not say */
    void *workspace;
    qs_index index; /* after problem_index */
} problem_file;

typedef struct samples_file {
    const char *name;
    file_bytes file;
    qs_samples_view view;
} samples_file;

/* A problem and the samples that answer it. */
typedef struct answer {
    problem_file problem;
    samples_file samples;
} answer;

/* Take over the bytes of `file`, on failure too. */
int problem_take(const char *path, file_bytes file, const budget *limit, problem_file *opened);
int samples_take(const char *path, file_bytes file, samples_file *opened);

int problem_open(const char *path, budget *limit, problem_file *opened);
int problem_index(problem_file *problem, budget *limit);
void problem_close(problem_file *closed);

/* The labels that are left to all sites together; a fixed site has one. */
uint64_t labels_left(const qs_labels *labels);

/* Opens both files, checks that they belong together, and indexes the problem. */
int answer_open(const char *problem_path, const char *samples_path, budget *limit, answer *opened);
/* Opens the samples only, for the problem that is there already. */
int answer_open_samples(answer *both, const char *samples_path, budget *limit);
void answer_close_samples(answer *both);
void answer_close(answer *closed);

/* Whether the bytes, as many as there are, begin as those of a .qcf and a .qsf. */
bool problem_is(const file_bytes *file);
bool samples_are(const file_bytes *file);

#endif
