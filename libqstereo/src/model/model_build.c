#include "../../include/qstereo/model.h"

#include <string.h>

#include "../base/bytes.h"
#include "neighbours.h"
#include "../base/saturate.h"
#include "model_check.h"
#include "../qubo/sites.h"

/* Parts of the workspace: 32-bit integers, at last bytes. */
typedef struct layout {
    uint64_t unary, right, down, link_start, cursor, links, table, site_of, kept, end;
} layout;

static bool is_grid(const qs_qubo *qubo)
{
    return qubo->has_labels && qubo->labels.width > 0;
}

/* Sites of the model. */
static uint32_t sites_of(const qs_qubo *qubo)
{
    return is_grid(qubo) ? qubo->labels.width * qubo->labels.height : qubo->labels.sites;
}

static layout lay_out(const qs_qubo *qubo)
{
    uint64_t sites = sites_of(qubo), labels = qubo->has_labels ? qubo->labels.labels : 0;
    bool grid = is_grid(qubo),
         table = qubo->has_labels && qubo->labels.pairwise.smoothness == QS_TABLE;
    layout l = {0};
    l.right = l.unary + 4 * sites * labels;
    l.down = l.right + (grid ? 4 * sites : 0);
    l.link_start = l.down + (grid ? 4 * sites : 0);
    l.cursor = l.link_start + (grid ? 0 : 4 * (sites + 1));
    l.links = l.cursor + (grid ? 0 : 4 * sites);
    l.table = l.links + (grid ? 0 : 2 * sizeof(qs_link) * qubo->couplings);
    l.site_of = l.table + (table ? 4 * labels * labels : 0);
    l.kept = l.site_of + 4 * (uint64_t)qubo->groups;
    l.end = l.kept + (qubo->labels.fixed_bytes > 0 ? sites * labels : 0);
    return l;
}

size_t qs_model_workspace(const qs_qubo *qubo)
{
    return qs_size(lay_out(qubo).end);
}

static qs_building begin(const qs_index *index, void *workspace)
{
    const qs_qubo *qubo = index->qubo;
    const qs_labels *labels = &qubo->labels;
    layout l = lay_out(qubo);
    char *base = workspace;
    qs_building b = {.index = index, .labels = labels};
    b.model = (qs_model){.sites = sites_of(qubo),
                         .labels = labels->labels,
                         .constant = qubo->offset,
                         .pairwise = labels->pairwise,
                         .width = labels->width,
                         .height = labels->height,
                         .mask = labels->mask};
    b.unary = (int32_t *)(void *)(base + l.unary);
    b.right = (int32_t *)(void *)(base + l.right);
    b.down = (int32_t *)(void *)(base + l.down);
    b.link_start = (uint32_t *)(void *)(base + l.link_start);
    b.cursor = (uint32_t *)(void *)(base + l.cursor);
    b.links = (qs_link *)(void *)(base + l.links);
    b.table = (int32_t *)(void *)(base + l.table);
    b.site_of = (uint32_t *)(void *)(base + l.site_of);
    b.kept = (uint8_t *)(base + l.kept);
    return b;
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
        if (site.is_open) {
            b->site_of[site.open] = at;
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

/* An edge is numbered at its first site. Its second site, coming later, finds the number by a
 * cursor that each first site keeps. */
static void copy_links(qs_building *b)
{
    enter_sites(b);
    for (uint32_t p = 0; p < b->model.sites; p++) {
        uint32_t n = b->link_start[p];
        for (; n < b->link_start[p + 1] && b->links[n].site < p; n++) {
            b->links[n].edge = b->links[b->cursor[b->links[n].site]++].edge;
        }
        b->cursor[p] = n;
        for (; n < b->link_start[p + 1]; n++) {
            b->links[n].edge = b->model.edges++;
        }
    }
}

static int64_t largest_pairwise(const qs_model *model)
{
    size_t labels = model->labels;
    if (model->pairwise.smoothness != QS_TABLE) {
        return qs_model_pairwise(model, 0,
                                 model->labels - 1); /* all others rise with the distance */
    }
    int64_t largest = 0;
    for (size_t i = 0; i < labels * labels; i++) {
        largest = model->pairwise.table[i] > largest ? model->pairwise.table[i] : largest;
    }
    return largest;
}

/* Whether no sum of costs leaves 64 bits, whatever the labels. The format's bound on all numbers
 * does not say so: it knows a weight times the entries of its block, and those of walls and of
 * bands may be 0 where V is not. */
static bool sums_fit(const qs_building *b)
{
    const qs_index *index = b->index;
    const uint64_t most = (uint64_t)1 << QS_MODEL_BITS;
    uint64_t sum = 0;
    qs_grow_to(&sum, b->model.sites, INT32_MAX, most + 1);
    for (uint32_t group = 0; group < index->qubo->groups; group++) {
        for (uint32_t n = index->near_start[group]; n < index->near_start[group + 1]; n++) {
            const qs_neighbour *near = &index->near[n];
            if (near->group > group) {
                qs_grow_to(&sum, (uint64_t)near->weight, (uint64_t)b->model.pairwise_max, most + 1);
            }
        }
    }
    return sum <= most;
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

/* Two passes over an open site's labels, the first for their least cost, which moves into the
 * constant; false where one does not fit. */
static bool copy_site(qs_building *b, uint32_t group, const uint8_t *excess)
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
            cost += excess
                        ? (int64_t)qs_load_unsigned(excess + (size_t)rank * b->labels->excess_bytes,
                                                    b->labels->excess_bytes)
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
    int64_t edges = qs_local_edges(model, site);
    return edges < INT32_MAX ? (int32_t)edges + 1 : INT32_MAX;
}

/* Costs of all sites: of those that are not open 0 for their one label. */
static bool copy_costs(qs_building *b)
{
    const qs_labels *l = b->labels;
    const uint8_t *excess = l->excess;
    size_t labels = l->labels;
    memset(b->unary, 0, sizeof *b->unary * b->model.sites * labels);
    for (uint32_t group = 0; group < b->index->qubo->groups; group++) {
        if (!copy_site(b, group, excess)) {
            return false;
        }
        if (excess) {
            excess += (size_t)qs_labels_left(b, group) * l->excess_bytes;
        }
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
        copy_links(b);
        model->link_start = b->link_start;
        model->links = b->links;
    }
    if (model->pairwise.smoothness == QS_TABLE && !qs_finish_table(b)) {
        return QS_E_CORRUPT;
    }
    model->pairwise_max = largest_pairwise(model);
    model->unary = b->unary;
    return sums_fit(b) && copy_costs(b) ? QS_OK : QS_E_OVERFLOW;
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
    if (workspace_size < lay_out(qubo).end) {
        return QS_E_WORKSPACE;
    }
    qs_building b = begin(index, workspace);
    qs_status status = build(&b);
    if (status == QS_OK) {
        *model = b.model;
    }
    return status;
}

int64_t qs_model_pairwise(const qs_model *model, uint32_t a, uint32_t b)
{
    return qs_pairwise_value(&model->pairwise, model->labels, a, b);
}

static int64_t grid_energy(const qs_model *model, const uint16_t *labelling)
{
    int64_t energy = 0;
    for (uint32_t p = 0; p < model->sites; p++) {
        if (model->right[p] != 0) {
            energy += model->right[p] * qs_model_pairwise(model, labelling[p], labelling[p + 1]);
        }
        if (model->down[p] != 0) {
            energy += model->down[p] *
                      qs_model_pairwise(model, labelling[p], labelling[p + model->width]);
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
                energy +=
                    link->weight * qs_model_pairwise(model, labelling[p], labelling[link->site]);
            }
        }
    }
    return energy;
}

void qs_model_winner(const qs_model *model, uint16_t *labelling)
{
    for (uint32_t p = 0; p < model->sites; p++) {
        const int32_t *costs = model->unary + (size_t)p * model->labels;
        uint16_t best = 0;
        for (uint16_t d = 1; d < model->labels; d++) {
            best = costs[d] < costs[best] ? d : best;
        }
        labelling[p] = best;
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
