/* A labelling of a grid from messages (Kolmogorov 2006, section 3.4). Each site in turn takes its
 * cheapest label, given the labels of its earlier neighbours and the messages from its later ones;
 * of equals the lowest. Where the messages are exact, as on a chain, so is the labelling. */
#ifndef QS_LABEL_FROM_MESSAGES_H
#define QS_LABEL_FROM_MESSAGES_H

#include "messages.h"
#include "progress.h"

/* Where the messages are. For site p the one from its later neighbour along the row is at
 * row + p * stride, the one along the column at column + p * stride. */
typedef struct qs_message_reader {
    const qs_model *model;
    qs_scale scale;
    bool wide; /* the processor has AVX2 */
    bool forward; /* in the order of the sites; else in reverse, and the later neighbours are the
                     left and the upper one */
    const qs_number *row, *column;
    size_t stride;
    qs_number *scratch; /* `labels` numbers */
    qs_look *look; /* NULL = nothing stops it */
} qs_message_reader;

/* Labels all sites, unless it is stopped. */
void qs_label_grid(const qs_message_reader *reader, uint16_t *labelling);

/* The cheapest label of each of `count` sites by its later messages alone, as if it had no earlier
 * neighbours. The second one is for at least 8 labels and computes the same by AVX2. */
void qs_label_alone(const qs_message_reader *reader, uint32_t first, uint32_t count,
                    uint16_t *labelling);
void qs_label_alone_avx2(const qs_message_reader *reader, uint32_t first, uint32_t count,
                         uint16_t *labelling);

#endif
