#include "model_parts.h"

#include "../base/minmax.h"
#include "../base/saturate.h"
#include "edge_value.h"
#include "neighbours.h"

int64_t qs_largest_pairwise(const qs_model *model)
{
    size_t labels = model->labels;
    if (model->pairwise.smoothness < QS_TABLE) {
        /* All others rise with the distance of the labels. */
        return qs_model_pairwise(model, 0, model->labels - 1);
    }
    int32_t largest = 0;
    if (model->pairwise.smoothness == QS_TABLE) {
        for (size_t i = 0; i < labels * labels; i++) {
            largest = qs_max_i32(largest, model->pairwise.table[i]);
        }
        return largest;
    }
    uint32_t numbers = model->width > 0 ? 2 * model->sites : model->edges; /* of edges */
    for (uint32_t edge = 0; edge < numbers; edge++) {
        largest = qs_max_i32(largest, model->table_max[model->table_of[edge]]);
    }
    return largest;
}

void qs_find_table_max(const int32_t *tables, size_t count, uint32_t labels, int32_t *table_max)
{
    size_t entries = (size_t)labels * labels;
    for (size_t t = 0; t < count; t++) {
        table_max[t] = 0;
        for (size_t i = 0; i < entries; i++) {
            table_max[t] = qs_max_i32(table_max[t], tables[t * entries + i]);
        }
    }
}

int32_t qs_leave_out(const qs_model *model, const uint8_t *kept, uint32_t site, int32_t *unary)
{
    size_t labels = model->labels, first = site * labels;
    int64_t edges = qs_most_of_edges(model, site);
    int32_t out = edges < INT32_MAX ? (int32_t)edges + 1 : INT32_MAX, least = INT32_MAX;
    for (size_t at = first; at < first + labels; at++) {
        least = kept[at] ? qs_min_i32(least, unary[at]) : least;
    }
    for (size_t at = first; at < first + labels; at++) {
        unary[at] = kept[at] ? unary[at] - least : out;
    }
    return least;
}

/* Below 2^63: fewer than 2^32 edges of less than 2^31 each. */
static uint64_t sum_of_weights(const qs_model *model)
{
    uint64_t sum = 0;
    if (model->width > 0) {
        for (uint32_t p = 0; p < model->sites; p++) {
            sum += (uint32_t)model->right[p];
            sum += (uint32_t)model->down[p];
        }
        return sum;
    }
    for (size_t n = 0; n < model->link_start[model->sites]; n++) {
        sum += (uint32_t)model->links[n].weight;
    }
    return sum / 2; /* each edge has two links */
}

bool qs_sums_fit(const qs_model *model)
{
    const uint64_t most = (uint64_t)1 << QS_MODEL_BITS;
    uint64_t sum = 0;
    qs_grow_to(&sum, model->sites, INT32_MAX, most + 1);
    qs_grow_to(&sum, sum_of_weights(model), (uint64_t)model->pairwise_max, most + 1);
    return sum <= most;
}

/* An edge is numbered at its first site. Its second site, which comes later, finds the number by a
 * cursor that each first site keeps. */
uint32_t qs_number_links(const uint32_t *link_start, uint32_t sites, qs_link *links,
                         uint32_t *cursor)
{
    uint32_t edges = 0;
    for (uint32_t p = 0; p < sites; p++) {
        uint32_t n = link_start[p];
        for (; n < link_start[p + 1] && links[n].site < p; n++) {
            links[n].edge = links[cursor[links[n].site]++].edge;
        }
        cursor[p] = n;
        for (; n < link_start[p + 1]; n++) {
            links[n].edge = edges++;
        }
    }
    return edges;
}
