#include "label_from_messages.h"

#include "../base/simd.h"

/* A label of a site, from the messages of later ones. */
static int32_t cost_alone(const qs_decoder *decoder, uint32_t site, uint32_t label)
{
    int32_t unary = qs_min32(decoder->model->unary[(size_t)site * decoder->model->labels + label],
                             decoder->scale.most);
    size_t at = site * decoder->stride + label;
    return (unary << decoder->scale.shift) + decoder->row[at] + decoder->column[at];
}

void qs_decode_alone(const qs_decoder *decoder, uint32_t first, uint32_t count, uint16_t *labelling)
{
    for (uint32_t p = first; p < first + count; p++) {
        int32_t least = INT32_MAX;
        for (uint32_t d = 0; d < decoder->model->labels; d++) {
            int32_t cost = cost_alone(decoder, p, d);
            labelling[p] = cost < least ? (uint16_t)d : labelling[p];
            least = qs_min32(least, cost);
        }
    }
}

/* The edges to a site's earlier neighbours; where there is none the weight is 0. */
typedef struct earlier {
    int32_t row_weight, column_weight;
    uint16_t row, column;
} earlier;

static earlier earlier_of(const qs_decoder *decoder, uint32_t site, const uint16_t *labelling)
{
    const qs_model *model = decoder->model;
    uint32_t width = model->width, back = decoder->forward ? 1 : 0;
    bool along = decoder->forward ? site > 0 : site + 1 < model->sites,
         across = decoder->forward ? site >= width : site + width < model->sites;
    earlier e = {0};
    if (along) {
        e.row_weight = model->right[site - back] << decoder->scale.shift;
        e.row = labelling[back ? site - 1 : site + 1];
    }
    if (across) {
        e.column_weight = model->down[site - back * width] << decoder->scale.shift;
        e.column = labelling[back ? site - width : site + width];
    }
    return e;
}

/* Beside Potts costs only the earlier neighbours' labels can be better than the best label alone.
 */
static void consider(const qs_decoder *decoder, uint32_t site, const earlier *e, uint16_t label,
                     uint16_t *best, int32_t *least)
{
    int32_t cost = cost_alone(decoder, site, label) + (label == e->row ? 0 : e->row_weight) +
                   (label == e->column ? 0 : e->column_weight);
    *best = cost < *least || (cost == *least && label < *best) ? label : *best;
    *least = qs_min32(cost, *least);
}

static void decode_alone(const qs_decoder *decoder, uint32_t first, uint32_t count,
                         uint16_t *labelling)
{
#if QS_HAVE_AVX2
    if (decoder->wide && decoder->model->labels >= QS_LANES) {
        qs_decode_wide(decoder, first, count, labelling);
        return;
    }
#endif
    qs_decode_alone(decoder, first, count, labelling);
}

/* A row at a time, so that its messages are still near when its labels are chosen. */
static void decode_potts(const qs_decoder *decoder, uint16_t *labelling)
{
    const qs_model *model = decoder->model;
    uint32_t width = model->width;
    for (uint32_t at = 0; at < model->sites; at++) {
        uint32_t p = decoder->forward ? at : model->sites - 1 - at;
        if (at % width == 0) {
            decode_alone(decoder, p / width * width, width, labelling);
        }
        earlier e = earlier_of(decoder, p, labelling);
        uint16_t alone = labelling[p];
        int32_t least = INT32_MAX;
        consider(decoder, p, &e, alone, &labelling[p], &least);
        consider(decoder, p, &e, e.row, &labelling[p], &least);
        consider(decoder, p, &e, e.column, &labelling[p], &least);
    }
}

void qs_decode_grid(const qs_decoder *decoder, uint16_t *labelling)
{
    const qs_model *model = decoder->model;
    if (model->pairwise.smoothness == QS_POTTS) {
        decode_potts(decoder, labelling);
        return;
    }
    for (uint32_t at = 0; at < model->sites; at++) {
        uint32_t p = decoder->forward ? at : model->sites - 1 - at;
        earlier e = earlier_of(decoder, p, labelling);
        for (uint32_t d = 0; d < model->labels; d++) {
            decoder->scratch[d] = cost_alone(decoder, p, d);
        }
        qs_message_pay(model, e.row_weight, decoder->forward, e.row, decoder->scratch);
        qs_message_pay(model, e.column_weight, decoder->forward, e.column, decoder->scratch);
        labelling[p] = 0;
        for (uint32_t d = 1; d < model->labels; d++) {
            labelling[p] =
                decoder->scratch[d] < decoder->scratch[labelling[p]] ? (uint16_t)d : labelling[p];
        }
    }
}
