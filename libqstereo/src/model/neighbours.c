#include "neighbours.h"

#include "../base/minmax.h"
#include "edge_value.h"

/* Beyond the border the weight is 0, and the site itself stands for the other one. */
static bool see_grid_edge(const qs_model *model, uint32_t site, uint32_t at, qs_edge_seen *edge)
{
    uint32_t width = model->width;
    switch (at) {
    case 0: *edge = (qs_edge_seen){site + 1, model->right[site], 0, true}; break;
    case 1: *edge = (qs_edge_seen){site + width, model->down[site], 0, true}; break;
    case 2:
        *edge = (qs_edge_seen){site - 1, site > 0 ? model->right[site - 1] : 0, 0, false};
        break;
    case 3:
        *edge =
            (qs_edge_seen){site - width, site >= width ? model->down[site - width] : 0, 0, false};
        break;
    default: return false;
    }
    if (edge->weight == 0) {
        edge->site = site;
        return true;
    }
    edge->edge = qs_cell_edge(edge->first ? site : edge->site, at % 2 == 1);
    return true;
}

bool qs_see_edge(const qs_model *model, uint32_t site, uint32_t at, qs_edge_seen *edge)
{
    if (model->width > 0) {
        return see_grid_edge(model, site, at, edge);
    }
    uint32_t n = model->link_start[site] + at;
    if (n >= model->link_start[site + 1]) {
        return false;
    }
    const qs_link *link = &model->links[n];
    *edge = (qs_edge_seen){link->site, link->weight, link->edge, link->site > site};
    return true;
}

int64_t qs_most_of_edges(const qs_model *model, uint32_t site)
{
    int64_t most = 0;
    qs_edge_seen edge;
    for (uint32_t at = 0; qs_see_edge(model, site, at, &edge); at++) {
        most += edge.weight > 0 ? edge.weight * qs_edge_most(model, edge.edge) : 0;
    }
    return most;
}

int64_t qs_seen_cost(const qs_model *model, const qs_edge_seen *edge, uint32_t label,
                     uint32_t other)
{
    if (edge->weight == 0) {
        return 0;
    }
    return edge->weight * (edge->first ? qs_edge_value(model, edge->edge, label, other)
                                       : qs_edge_value(model, edge->edge, other, label));
}

bool qs_has_many_neighbours(const qs_model *model, uint32_t site)
{
    return model->width == 0 && qs_edges_at(model, site) > model->labels;
}

bool qs_labels_in_range(const qs_model *model, const uint16_t *labelling)
{
    for (uint32_t p = 0; p < model->sites; p++) {
        if (labelling[p] >= model->labels) {
            return false;
        }
    }
    return true;
}

int64_t qs_label_cost(const qs_model *model, const uint16_t *labelling, uint32_t site,
                      uint16_t label)
{
    int64_t cost = model->unary[(size_t)site * model->labels + label];
    qs_edge_seen edge;
    for (uint32_t at = 0; qs_see_edge(model, site, at, &edge); at++) {
        cost += qs_seen_cost(model, &edge, label, labelling[edge.site]);
    }
    return cost;
}

/* The best label so far. */
typedef struct candidate {
    uint16_t label;
    int64_t cost;
} candidate;

/* Takes a label if it is cheaper than the best so far; of equals the lower one. */
static void offer(candidate *best, uint16_t label, int64_t cost)
{
    if (cost < best->cost || (cost == best->cost && label < best->label)) {
        *best = (candidate){label, cost};
    }
}

/* With Potts costs only two kinds of label can be the best: that of a neighbour, and the cheapest
 * one by itself. */
static uint16_t best_of_potts(const qs_model *model, const uint16_t *labelling, uint32_t site)
{
    const int32_t *unary = model->unary + (size_t)site * model->labels;
    uint16_t winner = (uint16_t)qs_first_least(unary, model->labels);
    candidate best = {winner, qs_label_cost(model, labelling, site, winner)};
    qs_edge_seen edge;
    for (uint32_t at = 0; qs_see_edge(model, site, at, &edge); at++) {
        uint16_t label = labelling[edge.site];
        offer(&best, label, qs_label_cost(model, labelling, site, label));
    }
    return best.label;
}

uint16_t qs_best_label(const qs_model *model, const uint16_t *labelling, uint32_t site)
{
    if (model->pairwise.smoothness == QS_POTTS && !qs_has_many_neighbours(model, site)) {
        return best_of_potts(model, labelling, site);
    }
    candidate best = {0, INT64_MAX};
    for (uint16_t d = 0; d < model->labels; d++) {
        offer(&best, d, qs_label_cost(model, labelling, site, d));
    }
    return best.label;
}

bool qs_take_kept_label(const qs_model *model, uint16_t *labelling, uint32_t site)
{
    const uint8_t *kept = model->kept + (size_t)site * model->labels;
    if (kept[labelling[site]]) {
        return false;
    }
    candidate best = {0, INT64_MAX};
    for (uint16_t d = 0; d < model->labels; d++) {
        if (kept[d]) {
            offer(&best, d, qs_label_cost(model, labelling, site, d));
        }
    }
    labelling[site] = best.label;
    return true;
}

int64_t qs_take_kept_everywhere(const qs_model *model, uint16_t *labelling)
{
    int64_t gain = 0;
    if (!model->kept) {
        return 0;
    }
    for (uint32_t p = 0; p < model->sites; p++) {
        uint16_t was = labelling[p];
        if (qs_take_kept_label(model, labelling, p)) {
            gain += qs_label_cost(model, labelling, p, was) -
                    qs_label_cost(model, labelling, p, labelling[p]);
        }
    }
    return gain;
}
