/* A samples file of one sample. */
#ifndef SAMPLES_OUTPUT_H
#define SAMPLES_OUTPUT_H

#include "inputs.h"
#include "output.h"

typedef struct one_sample {
    const uint8_t *bits;
    int64_t energy; /* H of them */
    const char *solver;
    const char *info; /* what the file says about the solver: a JSON object */
} one_sample;

/* Writes it as samples of the problem. job_commit reports refused bytes. Returns DONE or
 * NO_RESOURCE. */
int samples_output_write(const problem_file *problem, const one_sample *sample, output *out);

/* The same for a labelling of the problem's sites; the problem has been indexed. The sample is made
 * in memory of the budget. */
int samples_output_labelling(const problem_file *problem, const uint16_t *labelling,
                             const char *solver, const char *info, budget *limit, output *out);

#endif
