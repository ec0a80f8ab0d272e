#include "label_from_messages.h"

#include "../base/simd.h"

#if QS_HAVE_AVX2

enum { AHEAD = 8 };

QS_WIDE uint16_t label_of(const qs_message_reader *reader, uint32_t site, uint32_t labels,
                          qs_loose *costs)
{
    const int32_t *unary = reader->model->unary + (size_t)labels * site;
    const int32_t *row = reader->row + site * reader->stride,
                  *column = reader->column + site * reader->stride;
    if (site + AHEAD < reader->model->sites) {
        qs_lanes_fetch(unary + AHEAD * labels, labels);
        qs_lanes_fetch(row + AHEAD * reader->stride, labels);
        qs_lanes_fetch(column + AHEAD * reader->stride, labels);
    }
    qs_lanes most = qs_lanes_all(reader->scale.most), least = qs_lanes_all(INT32_MAX);
    for (uint32_t run = 0; run < qs_lanes_runs(labels); run++) {
        qs_lanes cost = qs_lanes_min(qs_lanes_load(unary, run, labels), most)
                        << (int)reader->scale.shift;
        cost = cost + qs_lanes_load(row, run, labels) + qs_lanes_load(column, run, labels);
        least = qs_lanes_min(least, cost);
        costs[run] = cost;
    }
    return qs_lanes_first(costs, labels, least);
}

QS_AVX2 static void some_labels(const qs_message_reader *reader, uint32_t first, uint32_t end,
                                uint16_t *labelling)
{
    enum { TSUKUBA = 16, VENUS = 20, RUNS = 3 };
    qs_loose costs[RUNS];
    uint32_t labels = reader->model->labels;
    for (uint32_t p = first; p < end; p++) {
        switch (labels) {
        case TSUKUBA: labelling[p] = label_of(reader, p, TSUKUBA, costs); break;
        case VENUS: labelling[p] = label_of(reader, p, VENUS, costs); break;
        default: labelling[p] = label_of(reader, p, labels, (qs_loose *)reader->scratch); break;
        }
    }
}

void qs_label_alone_avx2(const qs_message_reader *reader, uint32_t first, uint32_t count,
                         uint16_t *labelling)
{
    some_labels(reader, first, first + count, labelling);
}

#endif
