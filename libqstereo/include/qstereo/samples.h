/* The samples file, .qsf: what an annealer answered (docs/FORMAT.md, section
 * 3).
 */
#ifndef QSTEREO_SAMPLES_H
#define QSTEREO_SAMPLES_H

#include "digest.h"
#include "status.h"
#include "stream.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The value of chain_breaks where no chains were used. */
#define QS_NO_CHAINS UINT32_MAX

/* What the solver says of a sample. */
typedef struct qs_record {
    int64_t energy; /* in integer units */
    uint32_t occurrences; /* how often it was found, at least 1 */
    uint32_t chain_breaks; /* share of broken chains in units of 1e-9, at most
                              10^9; or QS_NO_CHAINS */
} qs_record;

/* Samples to be written. Borrows all that it points to. */
typedef struct qs_samples {
    uint32_t variables, count;
    uint8_t problem[QS_DIGEST_SIZE]; /* digest of the .qcf that was solved */
    const char *solver; /* its name: UTF-8, 1 to 255 bytes without control
                           characters */
    size_t solver_size;
    const char *info; /* a JSON object, of any contents */
    size_t info_size;
    const qs_record *records; /* count */
    const uint8_t *bits; /* count x ceil(variables / 8) bytes: x_i is bit i % 8
                            of byte i / 8, spare bits are 0 */
} qs_samples;

/* Writes a .qsf in one pass.
 *
 * sink  NULL = nothing is written: a sizing pass
 * size  out, may be NULL: bytes of the file
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a field of `samples` is not as its comment says
 *   QS_E_IO        the sink refused bytes; it may have taken others before */
QS_MUST_CHECK qs_status qs_samples_write(const qs_samples *samples,
                                         const qs_sink *sink, uint64_t *size);

/* A .qsf in memory. It borrows the file's bytes. */
typedef struct qs_samples_view {
    uint32_t variables, count;
    const uint8_t *problem; /* QS_DIGEST_SIZE bytes */
    const char *solver; /* without a 0 at its end */
    size_t solver_size;
    const char *info; /* without a 0 at its end */
    size_t info_size;
    const uint8_t *records, *bits; /* for the functions below */
} qs_samples_view;

/* Opens a .qsf in memory and checks all of it.
 *
 * bytes    the whole file; the view borrows it
 * samples  out
 * fault    out if the file is refused, may be NULL
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT     a null pointer
 *   QS_E_FORMAT       not a .qsf
 *   QS_E_TRUNCATED    cut short
 *   QS_E_CORRUPT      damaged
 *   QS_E_UNSUPPORTED  of a newer version */
QS_MUST_CHECK qs_status qs_samples_open(const void *bytes, size_t size,
                                        qs_samples_view *samples,
                                        qs_fault *fault);

/* The record of a sample, 0 .. count - 1. */
qs_record qs_samples_record(const qs_samples_view *samples, uint32_t sample);

/* The bits of a sample, ceil(variables / 8) bytes in the file. */
const uint8_t *qs_samples_bits(const qs_samples_view *samples, uint32_t sample);

#ifdef __cplusplus
}
#endif

#endif
