#include "../include/qstereo/model.h"

#include <string.h>

#include "blocks.h"
#include "bytes.h"
#include "pairwise.h"

/* Parts of the workspace, all of 32-bit integers. */
typedef struct layout {
    uint64_t unary, right, down, link_start, cursor, links, table, end;
} layout;

static bool is_grid(const qs_qubo *qubo)
{
    return qubo->has_labels && qubo->labels.width > 0;
}

/* Sites of the model. */
static uint32_t sites_of(const qs_qubo *qubo)
{
    return is_grid(qubo) ? qubo->labels.width * qubo->labels.height : qubo->groups;
}

static layout lay_out(const qs_qubo *qubo)
{
    uint64_t sites = sites_of(qubo), labels = qubo->has_labels ? qubo->labels.labels : 0;
    bool grid = is_grid(qubo), table = qubo->has_labels && qubo->labels.pairwise.smoothness == QS_TABLE;
    layout l = {0};
    l.right = l.unary + 4 * sites * labels;
    l.down = l.right + (grid ? 4 * sites : 0);
    l.link_start = l.down + (grid ? 4 * sites : 0);
    l.cursor = l.link_start + (grid ? 0 : 4 * (sites + 1));
    l.links = l.cursor + (grid ? 0 : 4 * sites);
    l.table = l.links + (grid ? 0 : 2 * sizeof(qs_link) * qubo->couplings);
    l.end = l.table + (table ? 4 * labels * labels : 0);
    return l;
}

size_t qs_model_workspace(const qs_qubo *qubo)
{
    return qs_size(lay_out(qubo).end);
}

static bool is_masked(const qs_labels *labels, uint32_t cell)
{
    return labels->mask && (labels->mask[cell / 8] >> cell % 8 & 1) == 0;
}

/* The costs of the groups' variables, each site's less its least; false where one does not fit. */
static bool copy_costs(const qs_index *index, qs_model *model, int32_t *unary)
{
    const qs_qubo *qubo = index->qubo;
    uint32_t labels = model->labels, group = 0;
    for (uint32_t p = 0; p < model->sites; p++) {
        int32_t *costs = unary + (size_t)p * labels;
        if (is_grid(qubo) && is_masked(&qubo->labels, p)) {
            memset(costs, 0, sizeof *costs * labels);
            continue;
        }
        uint32_t first = index->start[group++];
        int64_t least = INT64_MAX;
        for (uint32_t d = 0; d < labels; d++) {
            int64_t cost = qs_qubo_linear(qubo, first + d);
            least = cost < least ? cost : least;
        }
        for (uint32_t d = 0; d < labels; d++) {
            int64_t cost = qs_qubo_linear(qubo, first + d) - least;
            if (cost > INT32_MAX) {
                return false;
            }
            costs[d] = (int32_t)cost;
        }
        model->constant += least;
    }
    return true;
}

/* The cell of each group in turn: groups are the unmasked cells in raster order. */
static uint32_t next_cell(const qs_labels *labels, uint32_t cell)
{
    while (is_masked(labels, cell)) {
        cell++;
    }
    return cell;
}

/* Whether a coupling is what the encodings make of a grid's edge. */
static bool is_edge(const qs_neighbour *near)
{
    return near->block == 0 && near->weight >= 0;
}

/* Weights of a grid's edges. A group's later neighbours can only be the group of the next cell and that of the cell below. */
static bool copy_grid(const qs_index *index, const qs_model *model, int32_t *right, int32_t *down, int64_t *weights)
{
    const qs_qubo *qubo = index->qubo;
    const qs_labels *labels = &qubo->labels;
    memset(right, 0, sizeof *right * model->sites);
    memset(down, 0, sizeof *down * model->sites);
    uint32_t group_below = 0, cell_below = 0; /* group_below = the number of sites before cell_below */
    for (uint32_t group = 0, cell = 0; group < qubo->groups; group++, cell++) {
        cell = next_cell(labels, cell);
        while (cell_below < cell + model->width && cell_below < model->sites) {
            group_below += !is_masked(labels, cell_below++);
        }
        for (uint32_t n = index->near_start[group]; n < index->near_start[group + 1]; n++) {
            const qs_neighbour *near = &index->near[n];
            if (near->group <= group) {
                continue;
            }
            bool to_right = near->group == group + 1 && (cell + 1) % model->width != 0 && !is_masked(labels, cell + 1);
            bool to_below = near->group == group_below && cell + model->width < model->sites && !is_masked(labels, cell + model->width);
            int32_t *weight = to_right ? &right[cell] : &down[cell];
            if (!is_edge(near) || (!to_right && !to_below) || near->weight > INT32_MAX - *weight) {
                return false;
            }
            *weight += near->weight;
            *weights += near->weight;
        }
    }
    return true;
}

/* Each site, in order, is entered in the lists of its neighbours: so the lists are sorted. */
static bool enter_sites(const qs_index *index, const qs_model *model, uint32_t *cursor, qs_link *links)
{
    memcpy(cursor, index->near_start, sizeof *cursor * model->sites);
    for (uint32_t p = 0; p < model->sites; p++) {
        for (uint32_t n = index->near_start[p]; n < index->near_start[p + 1]; n++) {
            const qs_neighbour *near = &index->near[n];
            if (near->group == p || (near->block & ~QS_TRANSPOSED) != 0 || near->weight < 0) {
                return false;
            }
            links[cursor[near->group]++] = (qs_link){p, 0, near->weight};
        }
    }
    return true;
}

/* An edge is numbered at its first site. Its second site, coming later, finds the number by a cursor that each first site keeps. */
static bool copy_links(const qs_index *index, qs_model *model, uint32_t *start, uint32_t *cursor, qs_link *links, int64_t *weights)
{
    memcpy(start, index->near_start, sizeof *start * (model->sites + (size_t)1));
    if (!enter_sites(index, model, cursor, links)) {
        return false;
    }
    for (uint32_t p = 0; p < model->sites; p++) {
        uint32_t n = start[p];
        for (; n < start[p + 1] && links[n].site < p; n++) {
            links[n].edge = links[cursor[links[n].site]++].edge;
        }
        cursor[p] = n;
        for (; n < start[p + 1]; n++) {
            links[n].edge = model->edges++;
            *weights += links[n].weight;
        }
    }
    return true;
}

/* The block must be the pairwise cost that the labels' chunk names. Of a Toeplitz block the first row and column say all. */
static bool block_agrees(const qs_index *index, const qs_model *model)
{
    const qs_qubo *qubo = index->qubo;
    bool sparse = qubo->labels.encoding == QS_ONE_HOT_SPARSE, table = model->pairwise.smoothness == QS_TABLE;
    if (qubo->couplings == 0) {
        return true;
    }
    const uint8_t *block = qubo->blocks + index->block_at[0];
    if (qubo->block_count != 1 || qs_block_is_table(block) != table || (sparse && model->pairwise.smoothness != QS_POTTS)) {
        return false;
    }
    for (uint32_t d = 0; !table && d < model->labels; d++) {
        int64_t cost = sparse ? -(int64_t)(d == 0) : qs_model_pairwise(model, 0, d);
        if (qs_index_block(index, 0, 0, d) != cost || qs_index_block(index, 0, d, 0) != cost) {
            return false;
        }
    }
    return true;
}

static bool copy_table(const qs_index *index, const qs_model *model, int32_t *table)
{
    for (uint32_t a = 0; index->qubo->couplings > 0 && a < model->labels; a++) {
        for (uint32_t b = 0; b < model->labels; b++) {
            int32_t entry = qs_index_block(index, 0, a, b);
            if (entry < 0) {
                return false;
            }
            table[(size_t)a * model->labels + b] = entry;
        }
    }
    return true;
}

static int64_t largest_pairwise(const qs_model *model)
{
    size_t labels = model->labels;
    if (model->pairwise.smoothness != QS_TABLE) {
        return qs_model_pairwise(model, 0, model->labels - 1); /* all others rise with the distance */
    }
    int64_t largest = 0;
    for (size_t i = 0; i < labels * labels; i++) {
        largest = model->pairwise.table[i] > largest ? model->pairwise.table[i] : largest;
    }
    return largest;
}

qs_status qs_model_build(const qs_index *index, void *workspace, size_t workspace_size, qs_model *model)
{
    if (!index || !workspace || !model) {
        return QS_E_ARGUMENT;
    }
    const qs_qubo *qubo = index->qubo;
    layout l = lay_out(qubo);
    if (!qubo->has_labels) {
        return QS_E_UNSUPPORTED;
    }
    if (workspace_size < l.end) {
        return QS_E_WORKSPACE;
    }
    char *base = workspace;
    qs_model built = {.sites = sites_of(qubo), .labels = qubo->labels.labels, .constant = qubo->offset, .pairwise = qubo->labels.pairwise,
                      .width = qubo->labels.width, .height = qubo->labels.height, .mask = qubo->labels.mask};
    int32_t *unary = (int32_t *)(void *)(base + l.unary), *table = (int32_t *)(void *)(base + l.table);
    int32_t *right = (int32_t *)(void *)(base + l.right), *down = (int32_t *)(void *)(base + l.down);
    uint32_t *start = (uint32_t *)(void *)(base + l.link_start), *cursor = (uint32_t *)(void *)(base + l.cursor);
    qs_link *links = (qs_link *)(void *)(base + l.links);
    int64_t weights = 0;
    if (built.pairwise.smoothness == QS_TABLE) {
        memset(table, 0, 4 * (size_t)built.labels * built.labels);
        built.pairwise.table = table;
    }
    bool grid = built.width > 0;
    if (!block_agrees(index, &built) || (built.pairwise.table && !copy_table(index, &built, table)) ||
        !(grid ? copy_grid(index, &built, right, down, &weights) : copy_links(index, &built, start, cursor, links, &weights))) {
        return QS_E_CORRUPT;
    }
    if (grid) {
        built.right = right;
        built.down = down;
    } else {
        built.link_start = start;
        built.links = links;
    }
    built.pairwise_max = largest_pairwise(&built);
    built.unary = unary;
    if (!copy_costs(index, &built, unary)) {
        return QS_E_OVERFLOW;
    }
    /* In one-hot-sparse the edges' weights stand in the offset. */
    built.constant -= qubo->labels.encoding == QS_ONE_HOT_SPARSE ? weights : 0;
    *model = built;
    return QS_OK;
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
            energy += model->down[p] * qs_model_pairwise(model, labelling[p], labelling[p + model->width]);
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
                energy += link->weight * qs_model_pairwise(model, labelling[p], labelling[link->site]);
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
        bool masked = model->mask && (model->mask[p / 8] >> p % 8 & 1) == 0;
        if (!masked) {
            out[site++] = labelling[p];
        }
    }
}
