#include "../../include/qstereo/model.h"

#include <string.h>

#include "../base/arena.h"
#include "../base/bytes.h"
#include "../base/saturate.h"
#include "../qubo/sites.h"
#include "model_check.h"
#include "model_parts.h"
#include "neighbours.h"

static bool is_grid(const qs_qubo *qubo)
{
    return qubo->has_labels && qubo->labels.width > 0;
}

/* Sites of the model. */
static uint32_t sites_of(const qs_qubo *qubo)
{
    return is_grid(qubo) ? qubo->labels.width * qubo->labels.height : qubo->labels.sites;
}

/* Hands out the workspace, or counts it. Returns its size. */
static size_t take_parts(qs_building *b, const qs_qubo *qubo, void *workspace)
{
    const qs_labels *l = &qubo->labels;
    qs_arena arena = {.base = workspace};
    uint64_t sites = sites_of(qubo), labels = qubo->has_labels ? l->labels : 0;
    bool grid = is_grid(qubo), table = qubo->has_labels && l->pairwise.smoothness == QS_TABLE;
    b->unary = qs_arena_take(&arena, sites * labels, sizeof *b->unary);
    b->right = qs_arena_take(&arena, grid ? sites : 0, sizeof *b->right);
    b->down = qs_arena_take(&arena, grid ? sites : 0, sizeof *b->down);
    b->link_start = qs_arena_take(&arena, grid ? 0 : sites + 1, sizeof *b->link_start);
    b->cursor = qs_arena_take(&arena, grid ? 0 : sites, sizeof *b->cursor);
    b->links = qs_arena_take(&arena, grid ? 0 : qubo->couplings, 2 * sizeof *b->links);
    b->table = qs_arena_take(&arena, table ? labels * labels : 0, sizeof *b->table);
    b->site_of = qs_arena_take(&arena, qubo->groups, sizeof *b->site_of);
    b->kept = qs_arena_take(&arena, l->fixed_bytes > 0 ? sites * labels : 0, sizeof *b->kept);
    return qs_arena_size(&arena);
}

size_t qs_model_workspace(const qs_qubo *qubo)
{
    qs_building b;
    return take_parts(&b, qubo, NULL);
}

static qs_building begin(const qs_index *index)
{
    const qs_qubo *qubo = index->qubo;
    const qs_labels *labels = &qubo->labels;
    return (qs_building){.index = index,
                         .labels = labels,
                         .model = {.sites = sites_of(qubo),
                                   .labels = labels->labels,
                                   .constant = qubo->offset,
                                   .pairwise = labels->pairwise,
                                   .width = labels->width,
                                   .height = labels->height,
                                   .mask = labels->mask}};
}

/* ---- Sites and their labels. ---- */

/* Notes of each group its site, and of each site its labels. */
static void place_sites(const qs_building *b)
{
    uint32_t at = 0, labels = b->labels->labels;
    if (b->model.kept) {
        memset(b->kept, 1, (size_t)b->model.sites * labels); /* masked cells, too */
    }
    for (qs_site site = {.labels = b->labels}; qs_site_next(&site); at++) {
        while (is_grid(b->index->qubo) && qs_is_masked(b->labels->mask, at)) {
            at++;
        }
        for (uint32_t d = 0; b->model.kept && d < labels; d++) {
            b->kept[(size_t)at * labels + d] = qs_site_has(&site, d);
        }
        if (site.is_undecided) {
            b->site_of[site.number] = at;
        }
    }
}

/* ---- The edges. ---- */

/* Weights of a grid's edges: of a site with its right and its lower neighbour. */
static bool copy_grid(const qs_building *b)
{
    const qs_index *index = b->index;
    memset(b->right, 0, sizeof *b->right * b->model.sites);
    memset(b->down, 0, sizeof *b->down * b->model.sites);
    for (uint32_t group = 0; group < index->qubo->groups; group++) {
        for (uint32_t n = index->near_start[group]; n < index->near_start[group + 1]; n++) {
            const qs_neighbour *near = &index->near[n];
            if (near->group <= group) {
                continue;
            }
            uint32_t cell = b->site_of[group], other = b->site_of[near->group];
            bool to_right = other == cell + 1 && other % b->model.width != 0,
                 to_below = other == cell + b->model.width;
            int32_t *weight = to_right ? &b->right[cell] : &b->down[cell];
            if ((!to_right && !to_below) || near->weight > INT32_MAX - *weight) {
                return false;
            }
            *weight += near->weight;
        }
    }
    return true;
}

/* Each site, in order, is entered in the lists of its neighbours: so the lists are sorted. */
static void enter_sites(const qs_building *b)
{
    const qs_index *index = b->index;
    memset(b->link_start, 0, sizeof *b->link_start * (b->model.sites + (size_t)1));
    for (uint32_t g = 0; g < index->qubo->groups; g++) {
        for (uint32_t n = index->near_start[g]; n < index->near_start[g + 1]; n++) {
            b->link_start[b->site_of[g] + 1] += index->near[n].group != g;
        }
    }
    for (uint32_t p = 0; p < b->model.sites; p++) {
        b->cursor[p] = b->link_start[p];
        b->link_start[p + 1] += b->link_start[p];
    }
    for (uint32_t g = 0; g < index->qubo->groups; g++) {
        for (uint32_t n = index->near_start[g]; n < index->near_start[g + 1]; n++) {
            const qs_neighbour *near = &index->near[n];
            if (near->group != g) {
                b->links[b->cursor[b->site_of[near->group]]++] =
                    (qs_link){b->site_of[g], 0, near->weight};
            }
        }
    }
}

/* ---- The costs. ---- */

/* What the edges and the chain have put into the linear terms of a wall's variable, which is 1 from
 * label d on; `before` is the label left before d. */
static int64_t wall_share(const qs_building *b, uint32_t group, uint32_t rank, uint32_t before,
                          uint32_t d)
{
    const qs_index *index = b->index;
    int64_t share = 0;
    for (uint32_t n = index->near_start[group]; n < index->near_start[group + 1]; n++) {
        const qs_neighbour *near = &index->near[n];
        if (near->group == group) {
            share -= rank > 1 ? (int64_t)qs_index_block(index, near->block, rank - 2, rank - 1) *
                                    near->weight
                              : 0;
        } else {
            uint32_t lowest = qs_next_label(b, near->group, 0);
            share += near->weight * (qs_value(b, d, lowest) - qs_value(b, before, lowest));
        }
    }
    return share;
}

/* What the encoding has put into the offset for the edges: in a sparse block the most that they
 * cost, in a wall what the lowest labels do. */
static int64_t edges_share(const qs_building *b, uint32_t group)
{
    const qs_index *index = b->index;
    int64_t share = 0;
    for (uint32_t n = index->near_start[group]; n < index->near_start[group + 1]; n++) {
        const qs_neighbour *near = &index->near[n];
        if (near->group > group && b->labels->encoding != QS_ONE_HOT) {
            int64_t most = qs_has_walls(b) ? qs_value(b, qs_next_label(b, group, 0),
                                                      qs_next_label(b, near->group, 0))
                                           : b->tau;
            share += near->weight * most;
        }
    }
    return share;
}

/* Two passes over an undecided site's labels, the first for their least cost, which moves into the
 * constant; false where one does not fit. */
static bool copy_site(qs_building *b, uint32_t group, const uint8_t *trimmed)
{
    const qs_index *index = b->index;
    uint32_t labels = b->labels->labels, from = index->start[group];
    int32_t *costs = b->unary + (size_t)b->site_of[group] * labels;
    int64_t least = 0;
    for (int pass = 0; pass < 2; pass++) {
        uint32_t rank = 0, before = 0;
        int64_t wall = 0;
        for (uint32_t d = qs_next_label(b, group, 0); d < labels;
             before = d, d = qs_next_label(b, group, d + 1), rank++) {
            if (qs_has_walls(b) && rank > 0) {
                wall += qs_qubo_linear(index->qubo, from + rank - 1) -
                        wall_share(b, group, rank, before, d);
            }
            int64_t cost = qs_has_walls(b) ? wall : qs_qubo_linear(index->qubo, from + rank);
            cost +=
                trimmed
                    ? (int64_t)qs_load_unsigned(trimmed + (size_t)rank * b->labels->trimmed_bytes,
                                                b->labels->trimmed_bytes)
                    : 0;
            if (pass == 0) {
                least = rank == 0 || cost < least ? cost : least;
            } else if (cost - least > INT32_MAX) {
                return false;
            } else {
                costs[d] = (int32_t)(cost - least);
            }
        }
    }
    b->model.constant += least - edges_share(b, group);
    return true;
}

/* What a label that is not left costs: one more than all edges of its site can. */
static int32_t cost_out(const qs_model *model, uint32_t site)
{
    int64_t edges = qs_most_of_edges(model, site);
    return edges < INT32_MAX ? (int32_t)edges + 1 : INT32_MAX;
}

/* Costs of all sites: of those that are fixed 0 for their one label. */
static bool copy_costs(qs_building *b)
{
    const qs_labels *l = b->labels;
    const uint8_t *trimmed = l->trimmed;
    size_t labels = l->labels;
    memset(b->unary, 0, sizeof *b->unary * b->model.sites * labels);
    for (uint32_t group = 0; group < b->index->qubo->groups; group++) {
        if (!copy_site(b, group, trimmed)) {
            return false;
        }
        trimmed += trimmed ? (size_t)qs_labels_left(b, group) * l->trimmed_bytes : 0;
    }
    for (uint32_t p = 0; b->model.kept && p < b->model.sites; p++) {
        int32_t out = cost_out(&b->model, p);
        for (uint32_t d = 0; d < labels; d++) {
            b->unary[p * labels + d] = b->kept[p * labels + d] ? b->unary[p * labels + d] : out;
        }
    }
    return true;
}

static qs_status build(qs_building *b)
{
    qs_model *model = &b->model;
    if (!qs_encoding_fits(b)) {
        return QS_E_CORRUPT;
    }
    if (b->labels->fixed_bytes > 0) {
        model->kept = b->kept;
    }
    if (model->pairwise.smoothness == QS_TABLE) {
        memset(b->table, 0xff, 4 * (size_t)model->labels * model->labels); /* -1: not seen yet */
        model->pairwise.table = b->table;
    } else {
        b->tau = model->pairwise.smoothness == QS_POTTS ? 1 : qs_value(b, 0, model->labels - 1);
    }
    place_sites(b);
    if (!qs_couplings_agree(b) || (model->width > 0 && !copy_grid(b))) {
        return QS_E_CORRUPT;
    }
    if (model->width > 0) {
        model->right = b->right;
        model->down = b->down;
    } else {
        enter_sites(b);
        model->edges = qs_number_links(b->link_start, model->sites, b->links, b->cursor);
        model->link_start = b->link_start;
        model->links = b->links;
    }
    if (model->pairwise.smoothness == QS_TABLE && !qs_finish_table(b)) {
        return QS_E_CORRUPT;
    }
    model->pairwise_max = qs_largest_pairwise(model);
    model->unary = b->unary;
    return qs_sums_fit(model) && copy_costs(b) ? QS_OK : QS_E_OVERFLOW;
}

qs_status qs_model_build(const qs_index *index, void *workspace, size_t workspace_size,
                         qs_model *model)
{
    if (!index || !workspace || !model) {
        return QS_E_ARGUMENT;
    }
    const qs_qubo *qubo = index->qubo;
    if (!qubo->has_labels) {
        return QS_E_UNSUPPORTED;
    }
    if (qubo->labels.encoding > QS_DOMAIN_WALL) {
        return QS_E_ENCODING;
    }
    qs_building b = begin(index);
    if (workspace_size < take_parts(&b, qubo, workspace)) {
        return QS_E_WORKSPACE;
    }
    qs_status status = build(&b);
    if (status == QS_OK) {
        *model = b.model;
    }
    return status;
}
