/* What can go wrong, told apart by who can mend it. */
#ifndef QSTEREO_STATUS_H
#define QSTEREO_STATUS_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define QS_MUST_CHECK __attribute__((warn_unused_result))
#else
#define QS_MUST_CHECK
#endif

/* The values never change. */
typedef enum qs_status {
    QS_OK = 0,
    /* The caller's mistake: a null pointer, or a value outside the range that
     * its comment states. */
    QS_E_ARGUMENT = 1,
    /* The workspace is smaller than its ..._workspace() says. */
    QS_E_WORKSPACE = 2,
    /* Over a stated limit (limits.h), or the memory limit of the call. */
    QS_E_LIMIT = 3,
    /* A cost, a coefficient or a sum of them does not fit. */
    QS_E_OVERFLOW = 4,
    /* Not a file of this format. */
    QS_E_FORMAT = 5,
    /* A file of a newer version, or with a feature that this version does not
     * know. */
    QS_E_UNSUPPORTED = 6,
    /* A file of this format, but damaged. */
    QS_E_CORRUPT = 7,
    /* A file of this format, but cut short. */
    QS_E_TRUNCATED = 8,
    /* The sink refused bytes. */
    QS_E_IO = 9,
    /* Pictures, window and labels do not fit each other. */
    QS_E_GEOMETRY = 10,
    /* The encoding, or the solver, cannot handle this pairwise cost. */
    QS_E_ENCODING = 11,
    /* The sample is not a labelling. */
    QS_E_INFEASIBLE = 12
} qs_status;

/* A status in words, without a full stop at the end. Static text; never NULL,
 * whatever the value. */
const char *qs_status_text(qs_status status);

/* Where reading a file failed and why: the first fault that was found. */
typedef struct qs_fault {
    uint64_t offset; /* byte of the file */
    const char *what; /* what is wrong there, such as "CRC of a chunk"; static
                         text */
} qs_fault;

#ifdef __cplusplus
}
#endif

#endif
