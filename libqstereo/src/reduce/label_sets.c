#include "label_sets.h"

#include <string.h>

#include "../base/simd.h"
#include "../model/neighbours.h"
#include "../qubo/sites.h"

/* Parts of the workspace, in bytes, those of 64 bits first. */
typedef struct layout {
    uint64_t room, links, unary, right, down, left, part, due, end;
} layout;

static layout lay_out(const qs_model *model)
{
    uint64_t labels = model->labels, sites = model->sites, cells = model->width > 0 ? sites : 0;
    layout l = {.room = sizeof(int64_t) * labels};
    l.links = l.room + sizeof(int64_t) * sites;
    l.unary = l.links + 2 * sizeof(qs_link) * (uint64_t)model->edges;
    l.right = l.unary + sizeof(int32_t) * sites * labels;
    l.down = l.right + sizeof(int32_t) * cells;
    l.left = l.down + sizeof(int32_t) * cells;
    l.part = l.left + sizeof(uint32_t) * sites;
    l.due = l.part + sizeof(uint32_t) * sites;
    l.end = l.due + sites;
    return l;
}

uint64_t qs_eliminate_workspace(const qs_model *model)
{
    return lay_out(model).end;
}

/* After a site's costs or its set have changed. */
static void settle(qs_elimination *e, uint32_t site)
{
    uint32_t labels = e->model.labels;
    const uint8_t *kept = e->kept + (size_t)site * labels;
    int32_t *unary = e->unary + (size_t)site * labels, least = INT32_MAX, highest = 0;
    for (uint32_t d = 0; d < labels; d++) {
        least = kept[d] ? qs_min32(least, unary[d]) : least;
        highest = kept[d] && unary[d] > highest ? unary[d] : highest;
    }
    int64_t above = (int64_t)highest - least + qs_local_edges(&e->model, site) + 1;
    int32_t out = above < INT32_MAX ? (int32_t)above : INT32_MAX;
    for (uint32_t d = 0; d < labels; d++) {
        unary[d] = kept[d] ? unary[d] - least : out;
    }
    e->model.constant += least;
    e->due[site] = 1;
}

/* The other site's link of the same edge: links are sorted by site, and edges between the same two
 * sites by number. */
static qs_link *sister_of(const qs_elimination *e, uint32_t site, const qs_link *link)
{
    uint32_t low = e->model.link_start[link->site], high = e->model.link_start[link->site + 1];
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        const qs_link *there = &e->links[middle];
        bool beyond = there->site > site || (there->site == site && there->edge > link->edge);
        low = beyond ? low : middle;
        high = beyond ? middle : high;
    }
    return &e->links[low];
}

static void cut(qs_elimination *e, uint32_t site, uint32_t at)
{
    if (e->model.width == 0) {
        qs_link *link = &e->links[e->model.link_start[site] + at];
        sister_of(e, site, link)->weight = 0;
        link->weight = 0;
        return;
    }
    switch (at) {
    case 0: e->right[site] = 0; break;
    case 1: e->down[site] = 0; break;
    case 2: e->right[site - 1] = 0; break;
    default: e->down[site - e->model.width] = 0; break;
    }
}

/* Adds an edge to a site of one label to the costs of its other site; false where they would be too
 * large. */
static bool add_edge(qs_elimination *e, const qs_beside *beside, uint32_t label)
{
    uint32_t labels = e->model.labels;
    const uint8_t *kept = e->kept + (size_t)beside->site * labels;
    int32_t *unary = e->unary + (size_t)beside->site * labels;
    for (uint32_t d = 0; d < labels; d++) {
        int64_t most = INT32_MAX - (kept[d] ? unary[d] : 0);
        if (kept[d] && e->model.pairwise_max > 0 && beside->weight > most / e->model.pairwise_max) {
            return false;
        }
    }
    for (uint32_t d = 0; d < labels; d++) {
        int64_t cost = beside->weight * (beside->first ? qs_model_pairwise(&e->model, label, d)
                                                       : qs_model_pairwise(&e->model, d, label));
        unary[d] += kept[d] ? (int32_t)cost : 0;
    }
    return true;
}

/* Labels of a site have left. */
static void leave(qs_elimination *e, uint32_t site)
{
    settle(e, site);
    qs_local_mend(&e->model, e->labelling, site);
    qs_beside beside;
    for (uint32_t at = 0; qs_local_neighbour(&e->model, site, at, &beside); at++) {
        e->due[beside.site] = 1;
    }
}

static uint32_t count_labels(const qs_elimination *e, uint32_t site)
{
    const uint8_t *kept = e->kept + (size_t)site * e->model.labels;
    uint32_t count = 0;
    for (uint32_t d = 0; d < e->model.labels; d++) {
        count += kept[d];
    }
    return count;
}

/* Where a site has one label left its edges become costs of the neighbours. Whether any did. */
static bool fold(qs_elimination *e, uint32_t site)
{
    bool changed = false;
    qs_beside beside;
    for (uint32_t at = 0;
         count_labels(e, site) == 1 && qs_local_neighbour(&e->model, site, at, &beside); at++) {
        if (beside.weight > 0 && add_edge(e, &beside, e->labelling[site])) {
            cut(e, site, at);
            settle(e, beside.site);
            changed = true;
        }
    }
    return changed;
}

/* What its edges can save a label at most, beside what they cost with the label that costs 0: of
 * Potts costs those to neighbours that can have it, too. */
static void find_savings(const qs_elimination *e, uint32_t site)
{
    uint32_t labels = e->model.labels;
    bool potts = e->model.pairwise.smoothness == QS_POTTS;
    int64_t edges = potts ? 0 : qs_local_edges(&e->model, site);
    for (uint32_t d = 0; d < labels; d++) {
        e->saved[d] = edges;
    }
    qs_beside beside;
    for (uint32_t at = 0; potts && qs_local_neighbour(&e->model, site, at, &beside); at++) {
        const uint8_t *kept = e->kept + (size_t)beside.site * labels;
        for (uint32_t d = 0; d < labels; d++) {
            e->saved[d] += kept[d] ? beside.weight : 0;
        }
    }
}

/* Goldstein's criterion (1994; docs/MATHS.md): a label leaves that the cheapest of its site is
 * better than, whatever labels of their sets the neighbours have. A neighbour that has one label
 * left is no neighbour any more. Whether any leaves. */
static bool look(qs_elimination *e, uint32_t site)
{
    uint32_t labels = e->model.labels;
    const int32_t *unary = e->unary + (size_t)site * labels;
    uint8_t *kept = e->kept + (size_t)site * labels, changed = 0;
    find_savings(e, site);
    for (uint32_t d = 0; d < labels; d++) {
        uint8_t leaves = kept[d] && unary[d] > e->saved[d];
        kept[d] ^= leaves;
        changed |= leaves;
    }
    return changed != 0;
}

/* Again until nothing changes. Edges wait until then: before that a label's costs may be as large
 * as there are. */
static void goldstein(qs_elimination *e)
{
    for (bool again = true; again;) {
        again = false;
        for (uint32_t p = 0; p < e->model.sites; p++) {
            if (e->due[p] == 0) {
                continue;
            }
            e->due[p] = 0;
            if (look(e, p)) {
                leave(e, p);
                again = true;
            }
        }
        for (uint32_t p = 0, still = !again; still && p < e->model.sites; p++) {
            again = fold(e, p) || again;
        }
    }
}

static bool has_edges(const qs_elimination *e, uint32_t site)
{
    qs_beside beside;
    bool has = false;
    for (uint32_t at = 0; !has && qs_local_neighbour(&e->model, site, at, &beside); at++) {
        has = beside.weight > 0;
    }
    return has;
}

static void list_left(qs_elimination *e)
{
    e->left_count = e->open = 0;
    e->variables = 0;
    for (uint32_t p = 0; p < e->model.sites; p++) {
        uint32_t count = count_labels(e, p);
        e->open += count > 1;
        e->variables += count > 1 ? count - e->walls : 0;
        if (has_edges(e, p)) {
            e->left[e->left_count++] = p;
        }
    }
}

static void copy_model(qs_elimination *e, const qs_model *model, char *base)
{
    layout l = lay_out(model);
    e->model = *model;
    e->saved = (int64_t *)(void *)base;
    e->room = (int64_t *)(void *)(base + l.room);
    e->links = (qs_link *)(void *)(base + l.links);
    e->unary = (int32_t *)(void *)(base + l.unary);
    e->right = (int32_t *)(void *)(base + l.right);
    e->down = (int32_t *)(void *)(base + l.down);
    e->left = (uint32_t *)(void *)(base + l.left);
    e->part = (uint32_t *)(void *)(base + l.part);
    e->due = (uint8_t *)base + l.due;
    memcpy(e->unary, model->unary, sizeof *e->unary * model->sites * model->labels);
    e->model.unary = e->unary;
    if (model->width > 0) {
        memcpy(e->right, model->right, sizeof *e->right * model->sites);
        memcpy(e->down, model->down, sizeof *e->down * model->sites);
        e->model.right = e->right;
        e->model.down = e->down;
    } else {
        memcpy(e->links, model->links, sizeof *e->links * 2 * model->edges);
        e->model.links = e->links;
    }
}

void qs_eliminate_begin(qs_elimination *e, const qs_model *model, bool walls, void *workspace,
                        uint8_t *kept, uint16_t *labelling)
{
    size_t labels = model->labels;
    *e = (qs_elimination){.kept = kept, .labelling = labelling, .walls = walls};
    copy_model(e, model, workspace);
    e->model.kept = kept;
    if (model->kept) {
        memcpy(kept, model->kept, model->sites * labels);
    } else {
        memset(kept, 1, model->sites * labels);
    }
    qs_model_winner(model, labelling);
    for (uint32_t p = 0; p < model->sites; p++) {
        if (qs_is_masked(model->mask, p)) {
            memset(kept + p * labels, 0, labels);
            kept[p * labels] = 1;
        }
    }
    for (uint32_t p = 0; p < model->sites; p++) {
        leave(e, p);
    }
    goldstein(e);
    list_left(e);
}

/* The first site of a part as far as is known, found in half as many steps the next time. */
static uint32_t first_of(uint32_t *part, uint32_t site)
{
    while (part[site] != site) {
        part[site] = part[part[site]];
        site = part[site];
    }
    return site;
}

/* Joins sites that an edge joins. */
static void find_parts(qs_elimination *e)
{
    for (uint32_t i = 0; i < e->left_count; i++) {
        uint32_t p = e->left[i];
        e->part[p] = p;
        qs_beside beside;
        for (uint32_t at = 0; qs_local_neighbour(&e->model, p, at, &beside); at++) {
            if (beside.weight > 0 && !beside.first) {
                uint32_t a = first_of(e->part, p), b = first_of(e->part, beside.site);
                e->part[a > b ? a : b] = a > b ? b : a;
            }
        }
    }
    for (uint32_t i = 0; i < e->left_count; i++) {
        e->part[e->left[i]] = first_of(e->part, e->left[i]);
    }
}

/* What the labelling costs at a site, each edge at its second one. */
static int64_t cost_at(const qs_elimination *e, uint32_t site)
{
    int64_t cost = e->unary[(size_t)site * e->model.labels + e->labelling[site]];
    qs_beside beside;
    for (uint32_t at = 0; qs_local_neighbour(&e->model, site, at, &beside); at++) {
        cost += beside.first
                    ? 0
                    : beside.weight * qs_model_pairwise(&e->model, e->labelling[beside.site],
                                                        e->labelling[site]);
    }
    return cost;
}

static int64_t find_room(qs_elimination *e, const int64_t *shares, unsigned shift, int64_t *room)
{
    int64_t gap = 0;
    *room = 0;
    for (uint32_t i = 0; i < e->left_count; i++) {
        e->room[e->left[i]] = 0;
    }
    for (uint32_t i = 0; i < e->left_count; i++) {
        uint32_t p = e->left[i];
        int64_t own = cost_at(e, p) * ((int64_t)1 << shift) - shares[p];
        e->room[e->part[p]] += own;
        *room += own;
    }
    for (uint32_t i = 0; i < e->left_count; i++) {
        gap += e->part[e->left[i]] == e->left[i] ? e->room[e->left[i]] >> shift : 0;
    }
    return gap;
}

int64_t qs_eliminate_above(qs_elimination *e, const uint32_t *excess, const int64_t *shares,
                           unsigned shift, int64_t *room)
{
    uint32_t labels = e->model.labels;
    find_parts(e);
    int64_t gap = find_room(e, shares, shift, room);
    for (uint32_t i = 0; i < e->left_count; i++) {
        uint32_t p = e->left[i];
        int64_t most = e->room[e->part[p]];
        const uint32_t *more = excess + (size_t)p * labels;
        uint8_t *kept = e->kept + (size_t)p * labels, changed = 0;
        for (uint32_t d = 0; d < labels; d++) {
            uint8_t leaves = kept[d] & (more[d] > most);
            kept[d] ^= leaves;
            changed |= leaves;
        }
        if (changed) {
            leave(e, p);
        }
    }
    goldstein(e);
    list_left(e);
    return gap;
}
