/* The two files of qstereo, opened under one memory budget, which owns all that is read. Each
 * function that can fail returns an exit status and has printed why. */
#ifndef INPUTS_H
#define INPUTS_H

#include "files.h"
#include "qstereo.h"

typedef struct problem_file {
    const char *name; /* for messages */
    file_bytes file;
    qs_qubo qubo;
    uint32_t scale; /* integer units in one real unit; 1 if the file does not say */
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

/* Reads a .qcf and checks it; problem_index then prepares it for samples and solvers, and checks
 * what needs that: blocks beside their groups, the bound stated beside the labelling. Return DONE,
 * BAD_INPUT or NO_RESOURCE. */
int problem_open(const char *path, budget *limit, problem_file *opened);
int problem_index(problem_file *problem, budget *limit);

/* Reads the samples of a problem that is open, and checks that they belong to it. Returns DONE,
 * BAD_INPUT or NO_RESOURCE. */
int answer_open_samples(answer *both, const char *samples_path, budget *limit);

/* The same for the bytes of a samples file that was read. */
int answer_take_samples(answer *both, const char *samples_path, file_bytes file);

/* The same for the bytes of a file that was read, which stay the caller's. */
int problem_check(const char *path, file_bytes file, const budget *limit, problem_file *opened);
int samples_check(const char *path, file_bytes file, samples_file *opened);

/* The same for a certificate. Its view borrows the bytes. */
int certificate_check(const char *path, file_bytes file, qs_certificate *opened);

/* Prints what is wrong with a certificate that does not fit its problem. Returns BAD_INPUT or
 * NO_RESOURCE. */
int certificate_fail(const char *path, file_bytes file, qs_status status, const qs_fault *fault);

/* Says that a file is not of the kinds `wanted`, such as ".qcf or .qsf", and of which kind it is.
 * Returns BAD_INPUT. */
int fail_kind(const char *name, const file_bytes *file, const char *wanted);

/* Return true if the bytes begin as those of a .qcf, or a .qsf. */
bool problem_is(const file_bytes *file);
bool samples_are(const file_bytes *file);

/* The number of labels that are left to all sites together; a fixed site has one. */
uint64_t labels_left(const qs_labels *labels);

#endif
