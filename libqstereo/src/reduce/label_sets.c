#include "label_sets.h"

#include <string.h>

#include "../base/minmax.h"
#include "../base/sets.h"
#include "../model/edge_value.h"
#include "../model/neighbours.h"
#include "../qubo/sites.h"

enum { DUE = 1, UNSETTLED = 2 }; /* qs_elimination.due */

void qs_eliminate_take(qs_elimination *e, const qs_model *model, qs_arena *arena)
{
    uint64_t labels = model->labels, sites = model->sites, cells = model->width > 0 ? sites : 0;
    *e = (qs_elimination){.model = *model};
    e->saved = qs_arena_take(arena, labels, sizeof *e->saved);
    e->room = qs_arena_take(arena, sites, sizeof *e->room);
    e->links = qs_arena_take(arena, model->edges, 2 * sizeof *e->links);
    e->unary = qs_arena_take(arena, sites * labels, sizeof *e->unary);
    e->right = qs_arena_take(arena, cells, sizeof *e->right);
    e->down = qs_arena_take(arena, cells, sizeof *e->down);
    e->left = qs_arena_take(arena, sites, sizeof *e->left);
    e->part = qs_arena_take(arena, sites, sizeof *e->part);
    e->due = qs_arena_take(arena, sites, sizeof *e->due);
    e->closed = qs_arena_take(arena, sites, sizeof *e->closed);
    e->closed_label = qs_arena_take(arena, sites, sizeof *e->closed_label);
}

/* Brings a site's costs in order after they, or its set, have changed: the cheapest kept label
 * costs 0, and labels that are out cost more than any kept one. */
static void settle(qs_elimination *e, uint32_t site)
{
    uint32_t labels = e->model.labels;
    const uint8_t *kept = e->kept + (size_t)site * labels;
    int32_t *unary = e->unary + (size_t)site * labels, least = INT32_MAX, highest = 0;
    for (uint32_t d = 0; d < labels; d++) {
        least = kept[d] ? qs_min_i32(least, unary[d]) : least;
        highest = kept[d] ? qs_max_i32(highest, unary[d]) : highest;
    }
    int64_t above = (int64_t)highest - least + qs_most_of_edges(&e->model, site) + 1;
    int32_t out = (int32_t)qs_min_i64(above, INT32_MAX);
    for (uint32_t d = 0; d < labels; d++) {
        unary[d] = kept[d] ? unary[d] - least : out;
    }
    e->model.constant += least;
    e->due[site] = DUE;
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

/* Removes edge `at` of a site (see qs_see_edge). */
static void remove_edge(qs_elimination *e, uint32_t site, uint32_t at)
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

/* A site has one label left. Adds the cost of one of its edges to the costs of the other site.
 * Returns false if these would be too large. */
static bool add_edge(qs_elimination *e, const qs_edge_seen *edge, uint32_t label)
{
    uint32_t labels = e->model.labels;
    const uint8_t *kept = e->kept + (size_t)edge->site * labels;
    int32_t *unary = e->unary + (size_t)edge->site * labels;
    int64_t largest = qs_edge_most(&e->model, edge->edge);
    for (uint32_t d = 0; d < labels; d++) {
        int64_t most = INT32_MAX - (kept[d] ? unary[d] : 0);
        if (kept[d] && largest > 0 && edge->weight > most / largest) {
            return false;
        }
    }
    for (uint32_t d = 0; d < labels; d++) {
        unary[d] += kept[d] ? (int32_t)qs_seen_cost(&e->model, edge, label, d) : 0;
    }
    return true;
}

void qs_eliminate_follow_set(qs_elimination *e, uint32_t site)
{
    settle(e, site);
    qs_take_kept_label(&e->model, e->labelling, site);
    qs_edge_seen edge;
    for (uint32_t at = 0; qs_see_edge(&e->model, site, at, &edge); at++) {
        e->due[edge.site] = DUE;
    }
}

uint32_t qs_eliminate_count(const qs_elimination *e, uint32_t site)
{
    const uint8_t *kept = e->kept + (size_t)site * e->model.labels;
    uint32_t count = 0;
    for (uint32_t d = 0; d < e->model.labels; d++) {
        count += kept[d];
    }
    return count;
}

/* Turns the edges of a site with one label left into costs of its neighbours, which are not in
 * order then: to bring them in order each time would take as long as all edges of a neighbour.
 * Returns true if there were any. */
static bool fold(qs_elimination *e, uint32_t site)
{
    bool changed = false;
    qs_edge_seen edge;
    if (qs_eliminate_count(e, site) > 1) {
        return false;
    }
    for (uint32_t at = 0; qs_see_edge(&e->model, site, at, &edge); at++) {
        if (edge.weight > 0 && add_edge(e, &edge, e->labelling[site])) {
            remove_edge(e, site, at);
            e->due[edge.site] = UNSETTLED;
            changed = true;
        }
    }
    return changed;
}

/* How much less than with the site's cheapest label the edges can cost with each label, at most. Of
 * Potts costs only the edges to neighbours that can have the label, too, can cost less. */
static void find_savings(const qs_elimination *e, uint32_t site)
{
    uint32_t labels = e->model.labels;
    bool potts = e->model.pairwise.smoothness == QS_POTTS;
    int64_t edges = potts ? 0 : qs_most_of_edges(&e->model, site);
    for (uint32_t d = 0; d < labels; d++) {
        e->saved[d] = edges;
    }
    if (!potts) {
        return;
    }
    qs_edge_seen edge;
    for (uint32_t at = 0; qs_see_edge(&e->model, site, at, &edge); at++) {
        const uint8_t *kept = e->kept + (size_t)edge.site * labels;
        for (uint32_t d = 0; d < labels; d++) {
            e->saved[d] += kept[d] ? edge.weight : 0;
        }
    }
}

/* Goldstein's criterion (1994; docs/MATHS.md): a label leaves if its site's cheapest one is better
 * whatever labels of their sets the neighbours have. Returns true if any leaves. */
static bool apply_criterion(qs_elimination *e, uint32_t site)
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

/* The criterion at all sites that are due. Returns true if any label leaves. */
static bool apply_everywhere(qs_elimination *e)
{
    bool changed = false;
    for (uint32_t p = 0; p < e->model.sites; p++) {
        uint64_t numbers = (uint64_t)e->model.labels * (1 + qs_edges_at(&e->model, p));
        if (!qs_look_up(e->look, e->due[p] != 0 ? numbers : 1)) {
            return false;
        }
        if (e->due[p] != 0) {
            e->due[p] = 0;
            if (apply_criterion(e, p)) {
                qs_eliminate_follow_set(e, p);
                changed = true;
            }
        }
    }
    return changed;
}

static bool fold_everywhere(qs_elimination *e)
{
    bool changed = false;
    for (uint32_t p = 0; p < e->model.sites; p++) {
        changed |= fold(e, p);
    }
    for (uint32_t p = 0; changed && p < e->model.sites; p++) {
        if (e->due[p] == UNSETTLED) {
            settle(e, p);
        }
    }
    return changed;
}

/* The criterion again and again, until nothing changes or the watch stops it. Edges are folded only
 * when it has nothing more to say: before that there may be labels in the sets whose costs leave no
 * room for more. */
static void goldstein(qs_elimination *e)
{
    bool again = true;
    while (again) {
        again = apply_everywhere(e);
        again = again || fold_everywhere(e);
    }
}

bool qs_eliminate_has_edges(const qs_elimination *e, uint32_t site)
{
    qs_edge_seen edge;
    for (uint32_t at = 0; qs_see_edge(&e->model, site, at, &edge); at++) {
        if (edge.weight > 0) {
            return true;
        }
    }
    return false;
}

/* Lists the sites with edges, and counts what is undecided. */
static void list_left(qs_elimination *e)
{
    e->left_count = e->undecided = 0;
    e->variables = 0;
    for (uint32_t p = 0; p < e->model.sites; p++) {
        uint32_t count = qs_eliminate_count(e, p);
        e->undecided += count > 1;
        e->variables += count > 1 ? count - e->walls : 0;
        if (qs_eliminate_has_edges(e, p)) {
            e->left[e->left_count++] = p;
        }
    }
}

/* Copies what will change. */
static void copy_model(qs_elimination *e, const qs_model *model)
{
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

/* The model's own sets; of masked cells label 0 alone. */
static void copy_sets(qs_elimination *e, const qs_model *model)
{
    size_t labels = model->labels;
    if (model->kept) {
        memcpy(e->kept, model->kept, model->sites * labels);
    } else {
        memset(e->kept, 1, model->sites * labels);
    }
    for (uint32_t p = 0; p < model->sites; p++) {
        if (qs_is_masked(model->mask, p)) {
            memset(e->kept + p * labels, 0, labels);
            e->kept[p * labels] = 1;
        }
    }
    e->model.kept = e->kept;
}

void qs_eliminate_lay(qs_elimination *e, const qs_model *model, bool walls, uint8_t *kept,
                      uint16_t *labelling)
{
    e->walls = walls;
    e->kept = kept;
    e->labelling = labelling;
    memset(e->closed, 0, sizeof *e->closed * model->sites);
    e->model = *model;
    copy_sets(e, model);
}

void qs_eliminate_follow(qs_elimination *e)
{
    goldstein(e);
    list_left(e);
}

void qs_eliminate_begin(qs_elimination *e)
{
    const qs_model given = e->model;
    copy_model(e, &given);
    for (uint32_t p = 0; p < given.sites; p++) {
        qs_eliminate_follow_set(e, p);
    }
    list_left(e); /* for who looks on the way */
    qs_eliminate_follow(e);
}

/* A part: sites that edges join, directly or by way of others. */
void qs_eliminate_find_parts(qs_elimination *e)
{
    for (uint32_t i = 0; i < e->left_count; i++) {
        uint32_t p = e->left[i];
        e->part[p] = p;
        qs_edge_seen edge;
        for (uint32_t at = 0; qs_see_edge(&e->model, p, at, &edge); at++) {
            if (edge.weight > 0 && !edge.first) {
                qs_set_join(e->part, p, edge.site);
            }
        }
    }
    for (uint32_t i = 0; i < e->left_count; i++) {
        e->part[e->left[i]] = qs_set_of(e->part, e->left[i]);
    }
}

int64_t qs_eliminate_cost_at(const qs_elimination *e, uint32_t site)
{
    int64_t cost = e->unary[(size_t)site * e->model.labels + e->labelling[site]];
    qs_edge_seen edge;
    for (uint32_t at = 0; qs_see_edge(&e->model, site, at, &edge); at++) {
        uint16_t other = e->labelling[edge.site];
        cost += edge.first ? 0 : qs_seen_cost(&e->model, &edge, e->labelling[site], other);
    }
    return cost;
}

void qs_eliminate_restore(qs_elimination *e)
{
    for (uint32_t i = 0; i < e->left_count; i++) {
        uint32_t p = e->left[i];
        if (e->closed[p]) {
            e->labelling[p] = e->closed_label[p];
        }
    }
}

int64_t qs_eliminate_find_rooms(qs_elimination *e, const int64_t *shares, unsigned shift,
                                int64_t *room)
{
    int64_t gap = 0;
    *room = 0;
    for (uint32_t i = 0; i < e->left_count; i++) {
        e->room[e->left[i]] = 0;
    }
    for (uint32_t i = 0; i < e->left_count; i++) {
        uint32_t p = e->left[i];
        int64_t own = qs_eliminate_cost_at(e, p) * ((int64_t)1 << shift) - shares[p];
        e->room[e->part[p]] += own;
        *room += own;
    }
    for (uint32_t i = 0; i < e->left_count; i++) {
        uint32_t p = e->left[i];
        gap += e->part[p] == p && !e->closed[p] ? e->room[p] >> shift : 0;
    }
    return gap;
}
