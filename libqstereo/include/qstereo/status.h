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

/* The values are part of the ABI. */
typedef enum qs_status {
    QS_OK = 0,
    QS_E_ARGUMENT = 1, /* the caller's bug: a null pointer, or a value outside
                          its documented range */
    QS_E_WORKSPACE =
        2, /* the workspace is smaller than its ..._workspace() says */
    QS_E_LIMIT = 3, /* over a stated limit: 2^31 - 1 variables, or the memory
                       limit of the call */
    QS_E_OVERFLOW = 4, /* a cost, a coefficient or their sum does not fit
                          (docs/FORMAT.md: sum at most 2^53) */
    QS_E_FORMAT = 5, /* not this format at all */
    QS_E_UNSUPPORTED =
        6, /* a newer version, or a feature that this version does not know */
    QS_E_CORRUPT = 7, /* this format, but damaged */
    QS_E_TRUNCATED = 8, /* this format, but cut short */
    QS_E_IO = 9, /* the sink refused bytes */
    QS_E_GEOMETRY = 10, /* pictures, window and labels do not fit each other */
    QS_E_ENCODING = 11, /* the encoding cannot hold this pairwise cost */
    QS_E_INFEASIBLE = 12 /* the sample is no labelling: some group has not
                            exactly one variable at 1 */
} qs_status;

/* One line of English for a status, without a full stop. Static; never NULL,
 * whatever the value. */
const char *qs_status_text(qs_status status);

/* Where reading failed and why: the first fault found. */
typedef struct qs_fault {
    uint64_t offset; /* byte of the file */
    const char
        *what; /* static text, such as "CRC of chunk LINR"; NULL = no fault */
} qs_fault;

#ifdef __cplusplus
}
#endif

#endif
