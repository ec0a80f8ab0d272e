/* TRW-S in 16 bits at work: what its rows share. */
#ifndef QS_TRWS16_STATE_H
#define QS_TRWS16_STATE_H

#include "../../include/qstereo/solve.h"
#include "progress.h"
#include "trws16_avx2.h"

enum { QS_TRWS16_RUN = 16 }; /* labels of a site stand in whole runs */

typedef struct qs_trws16_state {
    const qs_problem *problem;
    uint32_t width, height, sites, labels;
    uint32_t reach; /* labels further apart cost no more */
    unsigned shift; /* messages are in units of 1 / 2^shift */
    int64_t least_sum; /* what was subtracted from the costs */
    int64_t first_sum; /* of the costs of label 0 */
    size_t pitch; /* from a site to the next in what follows: the labels, in whole runs */
    uint8_t *costs;
    /* Messages to or from the right, and below. A site of zeros stands before each row of the
     * former, and a row of them before the latter, for the edges that end there. */
    int16_t *rows, *columns;
    uint32_t row_count; /* row y of `rows` is y % row_count */
    bool is_once; /* only one iteration is wanted. Then few rows stand in `rows`, and a pass back
                     makes those of the pass before again, which takes less time than to keep
                     them */
    uint32_t summed; /* the first row in which `columns` has sums for the labelling; only if
                        is_once */
    uint32_t reached; /* rows from 0 that a pass has been to */
    int16_t *scratch; /* of each part: QS_TRWS16_ROWS of qs_trws16_row labels */
    void *strip;
    size_t strip_size; /* of each part that reads costs */
    qs_look *look;
    bool wide; /* the processor has AVX2 */
    bool is_first; /* the pass in work is the first one */
} qs_trws16_state;

/* Sites of a row one after the other, as one part of a pass visits them. */
typedef struct qs_trws16_stretch {
    uint32_t y, begin, end;
    bool forward;
    bool again; /* only the messages along the row, as the pass forward made them */
    bool is_first;
    int16_t *scratch; /* of the part */
} qs_trws16_stretch;

/* Visits a stretch. Returns what it adds to the bound, in units of 1 / 2^shift; nothing if it is
 * done again. */
int64_t qs_trws16_pass_stretch(const qs_trws16_state *s, const qs_trws16_stretch *of);

/* Labels a stretch by the labels before and above it and the messages of the later sites. */
void qs_trws16_label_stretch(const qs_trws16_state *s, const qs_trws16_stretch *of,
                             uint16_t *labelling);

QS_KERNEL int32_t qs_trws16_weight(const qs_trws16_state *s, const int32_t *weights, uint32_t site)
{
    return weights ? weights[site] : s->problem->weight;
}

QS_KERNEL int32_t qs_trws16_right(const qs_trws16_state *s, uint32_t x, uint32_t site)
{
    return x + 1 < s->width ? qs_trws16_weight(s, s->problem->grid.right, site) : 0;
}

QS_KERNEL int32_t qs_trws16_below(const qs_trws16_state *s, uint32_t y, uint32_t site)
{
    return y + 1 < s->height ? qs_trws16_weight(s, s->problem->grid.down, site) : 0;
}

QS_KERNEL int32_t qs_trws16_left(const qs_trws16_state *s, uint32_t x, uint32_t site)
{
    return x > 0 ? qs_trws16_weight(s, s->problem->grid.right, site - 1) : 0;
}

QS_KERNEL int32_t qs_trws16_above(const qs_trws16_state *s, uint32_t y, uint32_t site)
{
    return y > 0 ? qs_trws16_weight(s, s->problem->grid.down, site - s->width) : 0;
}

#endif
