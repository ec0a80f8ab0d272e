/* The samples file, .qsf (docs/FORMAT.md, section 3). */
#ifndef QSTEREO_SAMPLES_H
#define QSTEREO_SAMPLES_H

#include "digest.h"
#include "status.h"
#include "stream.h"

#ifdef __cplusplus
extern "C" {
#endif

#define QS_NO_CHAINS UINT32_MAX

typedef struct qs_record {
    int64_t energy; /* as the solver found it, in integer units */
    uint32_t occurrences; /* at least 1 */
    uint32_t chain_breaks; /* share of broken chains in 1e-9; QS_NO_CHAINS =
                              none were used */
} qs_record;

/* The samples to be written. Borrows all that it points to. */
typedef struct qs_samples {
    uint32_t variables, count;
    uint8_t problem[QS_DIGEST_SIZE]; /* of the .qcf that was solved */
    const char *solver; /* UTF-8, 1 to 255 bytes without control characters */
    size_t solver_size;
    const char *info; /* a JSON object */
    size_t info_size;
    const qs_record *records; /* count */
    const uint8_t *bits; /* count x ceil(variables / 8) bytes, x_i is bit i % 8
                            of byte i / 8; spare bits 0 */
} qs_samples;

/* Writes a .qsf in one pass. sink NULL = a sizing pass; size may be NULL.
 * Returns QS_OK, QS_E_ARGUMENT, QS_E_IO. */
QS_MUST_CHECK qs_status qs_samples_write(const qs_samples *samples,
                                         const qs_sink *sink, uint64_t *size);

/* A .qsf in memory; it borrows the file's bytes. */
typedef struct qs_samples_view {
    uint32_t variables, count;
    const uint8_t *problem; /* QS_DIGEST_SIZE bytes */
    const char *solver; /* not terminated */
    size_t solver_size;
    const char *info; /* not terminated */
    size_t info_size;
    const uint8_t *records, *bits; /* for the functions below */
} qs_samples_view;

/* Opens a .qsf in memory and checks it whole.
 * Returns QS_OK, QS_E_ARGUMENT, QS_E_FORMAT, QS_E_TRUNCATED, QS_E_CORRUPT,
 * QS_E_UNSUPPORTED. */
QS_MUST_CHECK qs_status qs_samples_open(const void *bytes, size_t size,
                                        qs_samples_view *samples,
                                        qs_fault *fault);

/* The record of sample 0 .. count - 1. */
qs_record qs_samples_record(const qs_samples_view *samples, uint32_t sample);

/* Its bits, ceil(variables / 8) bytes in the file. */
const uint8_t *qs_samples_bits(const qs_samples_view *samples, uint32_t sample);

#ifdef __cplusplus
}
#endif

#endif
