/* A labelling of a grid from messages: each site in turn takes its best label beside the labels of
 * its earlier neighbours and the messages of its later ones, the lowest of equals (Kolmogorov 2006,
 * section 3.4). Exact where the later messages are, so on any chain. */
#ifndef QS_LABEL_FROM_MESSAGES_H
#define QS_LABEL_FROM_MESSAGES_H

#include "messages.h"

/* Of site p: the message from its later neighbour along the row is at row + p * stride, that along
 * the column at column + p * stride. */
typedef struct qs_decoder {
    const qs_model *model;
    qs_scale scale;
    bool wide; /* AVX2 */
    bool forward; /* in the order of the sites; else against it: the later neighbours are the left
                     and the upper one */
    const int32_t *row, *column;
    size_t stride;
    int32_t *scratch; /* `labels` numbers */
} qs_decoder;

void qs_decode_grid(const qs_decoder *decoder, uint16_t *labelling);

/* The best label of each of `count` sites from the messages of later ones alone. */
void qs_decode_alone(const qs_decoder *decoder, uint32_t first, uint32_t count,
                     uint16_t *labelling);
void qs_decode_wide(const qs_decoder *decoder, uint32_t first, uint32_t count,
                    uint16_t *labelling); /* the same of at least 8 labels by AVX2 */

#endif
