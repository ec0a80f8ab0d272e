#include "../../include/qstereo/model.h"

#include "../base/minmax.h"
#include "../problem/pairwise.h"
#include "../qubo/sites.h"
#include "edge_value.h"

int64_t qs_model_pairwise(const qs_model *model, uint32_t a, uint32_t b)
{
    return qs_pairwise_value(&model->pairwise, model->labels, a, b);
}

int64_t qs_model_edge_pairwise(const qs_model *model, uint32_t edge, uint32_t a, uint32_t b)
{
    return qs_edge_value(model, edge, a, b);
}

static int64_t grid_energy(const qs_model *model, const uint16_t *labelling)
{
    int64_t energy = 0;
    for (uint32_t p = 0; p < model->sites; p++) {
        if (model->right[p] != 0) {
            energy += model->right[p] *
                      qs_edge_value(model, qs_cell_edge(p, false), labelling[p], labelling[p + 1]);
        }
        if (model->down[p] != 0) {
            energy += model->down[p] * qs_edge_value(model, qs_cell_edge(p, true), labelling[p],
                                                     labelling[p + model->width]);
        }
    }
    return energy;
}

int64_t qs_model_energy(const qs_model *model, const uint16_t *labelling)
{
    int64_t energy = model->constant;
    for (uint32_t p = 0; p < model->sites; p++) {
        energy += model->unary[(size_t)p * model->labels + labelling[p]];
    }
    if (model->width > 0) {
        return energy + grid_energy(model, labelling);
    }
    for (uint32_t p = 0; p < model->sites; p++) {
        for (uint32_t n = model->link_start[p]; n < model->link_start[p + 1]; n++) {
            const qs_link *link = &model->links[n];
            if (link->site > p) {
                energy += link->weight *
                          qs_edge_value(model, link->edge, labelling[p], labelling[link->site]);
            }
        }
    }
    return energy;
}

void qs_model_winner(const qs_model *model, uint16_t *labelling)
{
    for (uint32_t p = 0; p < model->sites; p++) {
        const int32_t *costs = model->unary + (size_t)p * model->labels;
        labelling[p] = (uint16_t)qs_first_least(costs, model->labels);
    }
}

void qs_model_sites(const qs_model *model, const uint16_t *labelling, uint16_t *out)
{
    uint32_t site = 0;
    for (uint32_t p = 0; p < model->sites; p++) {
        if (!qs_is_masked(model->mask, p)) {
            out[site++] = labelling[p];
        }
    }
}
