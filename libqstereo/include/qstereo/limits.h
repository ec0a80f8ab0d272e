/* The limits of every problem and file (docs/FORMAT.md). */
#ifndef QSTEREO_LIMITS_H
#define QSTEREO_LIMITS_H

/* Labels of a problem. */
#define QS_LABELS_MAX 65535u

/* Variables of a QUBO, and pairs of groups that it couples: 2^31 - 1. */
#define QS_VARIABLES_MAX 2147483647u

/* The largest energy of a QUBO, positive or negative: 2^53. A double holds each
 * integer up to it exactly. */
#define QS_ENERGY_MAX 9007199254740992

/* In the place of a lower bound: there is none. */
#define QS_NO_BOUND INT64_MIN

#endif
