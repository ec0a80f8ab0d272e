/* The certificate of what a solver or a reduction proves: solve and reduce --certificate. */
#ifndef CERTIFYING_H
#define CERTIFYING_H

#include "output.h"
#include "solving.h"

/* A row for a table of options. */
#define CERTIFICATE_OPTION                                                                         \
    {                                                                                              \
        "certificate", 0,                                                                          \
        false,         "C.qpf",                                                                    \
        NULL,          "write the proof of the lower bound to a file that qstereo verify checks"}

typedef struct certifying {
    const laid_out *problem;
    budget *limit;
    output *out;
    qs_recorder recorder;
    qs_witness witness; /* for the solver */
    qs_sink sink;
    growing_file stages;
} certifying;

/* The bytes that a solver or a reduction with a certificate takes, but for what it proves.
 *
 * work  of the solver or the reduction alone */
uint64_t certifying_bytes(const laid_out *problem, uint64_t work);

/* Begins. The problem is a file. Returns DONE, BAD_INPUT or NO_RESOURCE. */
int certifying_begin(const laid_out *problem, budget *limit, output *out, certifying *made);

/* Writes the certificate. Warns if without it the bound is higher, or may be.
 *
 * by           the name of the solver, for messages
 * labelling    of the problem's sites
 * energy       of it
 * lower_bound  what the solver has found; out: what the certificate proves, which is what it
 *              states
 *
 * Returns DONE, BAD_INPUT if the solver has no proof to write, or NO_RESOURCE. */
int certifying_end(certifying *made, const char *by, const uint16_t *labelling, int64_t energy,
                   int64_t *lower_bound);

/* Frees what no budget owns, where certifying_end was not reached. */
void certifying_abandon(certifying *made);

#endif
