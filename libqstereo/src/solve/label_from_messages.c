#include "label_from_messages.h"

#include "../base/minmax.h"
#include "../base/simd.h"
#include "../model/edge_value.h"

/* What a label of a site costs by the later messages alone. */
static qs_number cost_alone(const qs_message_reader *reader, uint32_t site, uint32_t label)
{
    size_t unary = (size_t)site * reader->model->labels + label;
    size_t at = site * reader->stride + label;
    return qs_scaled_cost(reader->model, reader->scale, unary) + reader->row[at] +
           reader->column[at];
}

void qs_label_alone(const qs_message_reader *reader, uint32_t first, uint32_t count,
                    uint16_t *labelling)
{
    for (uint32_t p = first; p < first + count; p++) {
        qs_number least = QS_NUMBER_MAX;
        for (uint32_t d = 0; d < reader->model->labels; d++) {
            qs_number cost = cost_alone(reader, p, d);
            labelling[p] = cost < least ? (uint16_t)d : labelling[p];
            least = qs_min_number(least, cost);
        }
    }
}

/* The edges to a site's earlier neighbours; where there is none the weight is 0. */
typedef struct earlier {
    qs_number row_weight, column_weight;
    uint32_t row_edge, column_edge; /* their numbers */
    uint16_t row, column; /* the labels of the neighbours */
} earlier;

static earlier earlier_of(const qs_message_reader *reader, uint32_t site, const uint16_t *labelling)
{
    const qs_model *model = reader->model;
    uint32_t width = model->width, back = reader->forward ? 1 : 0;
    bool along = reader->forward ? site > 0 : site + 1 < model->sites,
         across = reader->forward ? site >= width : site + width < model->sites;
    earlier e = {0};
    if (along) {
        e.row_edge = qs_cell_edge(site - back, false);
        e.row_weight = qs_scaled_weight(reader->scale, model->right[site - back]);
        e.row = labelling[back ? site - 1 : site + 1];
    }
    if (across) {
        e.column_edge = qs_cell_edge(site - back * width, true);
        e.column_weight = qs_scaled_weight(reader->scale, model->down[site - back * width]);
        e.column = labelling[back ? site - width : site + width];
    }
    return e;
}

/* With Potts costs only the label that is the best alone, or one of the earlier neighbours', can be
 * the best. Takes `label` if it is better than the best so far. */
static void consider(const qs_message_reader *reader, uint32_t site, const earlier *e,
                     uint16_t label, uint16_t *best, qs_number *least)
{
    qs_number cost = cost_alone(reader, site, label) + (label == e->row ? 0 : e->row_weight) +
                     (label == e->column ? 0 : e->column_weight);
    *best = cost < *least || (cost == *least && label < *best) ? label : *best;
    *least = qs_min_number(cost, *least);
}

static void label_alone(const qs_message_reader *reader, uint32_t first, uint32_t count,
                        uint16_t *labelling)
{
#if QS_HAVE_AVX2 && QS_BITS == 32
    if (reader->wide && reader->model->labels >= QS_LANES) {
        qs_label_alone_avx2(reader, first, count, labelling);
        return;
    }
#endif
    qs_label_alone(reader, first, count, labelling);
}

/* A row at a time, so that its messages are still in the cache when its labels are chosen. */
static void label_potts(const qs_message_reader *reader, uint16_t *labelling)
{
    const qs_model *model = reader->model;
    uint32_t width = model->width;
    for (uint32_t at = 0; at < model->sites && qs_look_at(reader->look, at, model->labels); at++) {
        uint32_t p = reader->forward ? at : model->sites - 1 - at;
        if (at % width == 0) {
            label_alone(reader, p / width * width, width, labelling);
        }
        earlier e = earlier_of(reader, p, labelling);
        uint16_t alone = labelling[p];
        qs_number least = QS_NUMBER_MAX;
        consider(reader, p, &e, alone, &labelling[p], &least);
        consider(reader, p, &e, e.row, &labelling[p], &least);
        consider(reader, p, &e, e.column, &labelling[p], &least);
    }
}

static void label_others(const qs_message_reader *reader, uint16_t *labelling)
{
    const qs_model *model = reader->model;
    qs_number *costs = reader->scratch;
    for (uint32_t at = 0; at < model->sites && qs_look_at(reader->look, at, model->labels); at++) {
        uint32_t p = reader->forward ? at : model->sites - 1 - at;
        earlier e = earlier_of(reader, p, labelling);
        for (uint32_t d = 0; d < model->labels; d++) {
            costs[d] = cost_alone(reader, p, d);
        }
        qs_message_pay(model, e.row_edge, e.row_weight, reader->forward, e.row, costs);
        qs_message_pay(model, e.column_edge, e.column_weight, reader->forward, e.column, costs);
        labelling[p] = (uint16_t)qs_least_at(costs, model->labels);
    }
}

void qs_label_grid(const qs_message_reader *reader, uint16_t *labelling)
{
    if (reader->model->pairwise.smoothness == QS_POTTS) {
        label_potts(reader, labelling);
    } else {
        label_others(reader, labelling);
    }
}
