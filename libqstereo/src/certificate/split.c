#include "split.h"

#include <string.h>

#include "../base/bytes.h"
#include "../base/minmax.h"
#include "../base/sets.h"
#include "../qubo/qcf_runs.h"

#define NEVER ((int64_t)1 << 61) /* the cost of a label that has left: above all sums */

void qs_split_take(qs_split *split, const qs_stated *stated, qs_arena *arena)
{
    const qs_qubo *qubo = stated->index->qubo;
    uint64_t sites = qubo->groups, couplings = qubo->couplings, slots = sites + 2 * couplings,
             labels = 0;
    for (size_t run = 0; run < qubo->group_run_count; run++) {
        /* In a domain wall a site has one label more than variables. */
        labels = qs_max_u64(labels, (uint64_t)qs_group_run_at(qubo, run).size + 1);
    }
    *split = (qs_split){.stated = stated};
    split->sites = qs_arena_take(arena, sites, sizeof *split->sites);
    split->slot_start = qs_arena_take(arena, sites, sizeof *split->slot_start);
    split->slot_count = qs_arena_take(arena, sites, sizeof *split->slot_count);
    split->next_edge = qs_arena_take(arena, slots, sizeof *split->next_edge);
    split->before_edge = qs_arena_take(arena, slots, sizeof *split->before_edge);
    split->share_at = qs_arena_take(arena, sites, sizeof *split->share_at);
    split->part = qs_arena_take(arena, sites, sizeof *split->part);
    split->least = qs_arena_take(arena, sites, sizeof *split->least);
    split->along = qs_arena_take(arena, couplings, labels * sizeof *split->along);
    split->room = qs_arena_take(arena, sites, sizeof *split->room);
    split->work = qs_arena_take(arena, labels, 4 * sizeof *split->work);
    split->open = qs_arena_take(arena, labels, sizeof *split->open);
}

void qs_split_begin(qs_split *split, int64_t scale, const uint16_t *labelling)
{
    split->scale = scale;
    split->labelling = labelling;
    split->count = 0;
    for (uint32_t p = 0; p < split->stated->sites; p++) {
        if (!split->stated->settled[p]) {
            split->sites[split->count++] = p;
        }
    }
}

/* Goes through the edges that are alive, of each site in turn those to later sites. Begin with {0};
 * returns NULL after the last. */
typedef struct edge_walk {
    uint32_t site, near, number;
} edge_walk;

static const qs_stated_edge *next_of(const qs_split *split, edge_walk *walk)
{
    const qs_stated *stated = split->stated;
    for (; walk->site < split->count; walk->site++, walk->near = 0) {
        uint32_t p = split->sites[walk->site], start = stated->near_start[p];
        while (start + walk->near < stated->near_start[p + 1]) {
            walk->number = stated->near[start + walk->near++];
            const qs_stated_edge *edge = &stated->edges[walk->number];
            if (edge->first == p && edge->alive) {
                return edge;
            }
        }
    }
    return NULL;
}

uint64_t qs_split_count_edges(const qs_split *split)
{
    edge_walk walk = {0, 0, 0};
    uint64_t count = 0;
    while (next_of(split, &walk)) {
        count++;
    }
    return count;
}

/* ---- The slots. ---- */

/* The numbers of both slots of an edge. */
typedef struct slot_pair {
    uint32_t first, second;
} slot_pair;

static slot_pair slots_at(const uint8_t *slots, unsigned bytes, size_t n)
{
    const uint8_t *at = slots + 2 * bytes * n;
    return (slot_pair){(uint32_t)qs_load_unsigned(at, bytes),
                       (uint32_t)qs_load_unsigned(at + bytes, bytes)};
}

/* A site has the slot of that number. Returns false if the number is too large. */
static bool count_slot(const qs_split *split, uint32_t site, uint32_t number)
{
    const uint32_t *near = split->stated->near_start + site;
    split->slot_count[site] = qs_max_u32(split->slot_count[site], number + 1);
    return number < near[1] - near[0];
}

static bool count_slots(qs_split *split, const uint8_t *slots, unsigned bytes)
{
    for (uint32_t i = 0; i < split->count; i++) {
        split->slot_count[split->sites[i]] = 1;
    }
    edge_walk walk = {0, 0, 0};
    const qs_stated_edge *edge;
    for (size_t n = 0; (edge = next_of(split, &walk)) != NULL; n++) {
        slot_pair pair = slots_at(slots, bytes, n);
        if (!count_slot(split, edge->first, pair.first) ||
            !count_slot(split, edge->second, pair.second)) {
            return false;
        }
    }
    uint32_t all = 0;
    for (uint32_t i = 0; i < split->count; i++) {
        split->slot_start[split->sites[i]] = all;
        all += split->slot_count[split->sites[i]];
    }
    split->slots = all;
    return true;
}

bool qs_split_set_slots(qs_split *split, const uint8_t *slots, unsigned bytes)
{
    if (!count_slots(split, slots, bytes)) {
        return false;
    }
    size_t size = sizeof *split->next_edge * (size_t)split->slots;
    memset(split->next_edge, 0xff, size); /* QS_NO_EDGE */
    memset(split->before_edge, 0xff, size);
    for (uint32_t i = 0; i < split->count; i++) {
        split->part[split->sites[i]] = split->sites[i];
    }
    edge_walk walk = {0, 0, 0};
    const qs_stated_edge *edge;
    for (size_t n = 0; (edge = next_of(split, &walk)) != NULL; n++) {
        slot_pair pair = slots_at(slots, bytes, n);
        uint32_t *next = &split->next_edge[split->slot_start[edge->first] + pair.first],
                 *before = &split->before_edge[split->slot_start[edge->second] + pair.second];
        if (*next != QS_NO_EDGE || *before != QS_NO_EDGE) {
            return false;
        }
        *next = *before = walk.number;
        qs_set_join(split->part, edge->first, edge->second);
    }
    for (uint32_t i = 0; i < split->count; i++) {
        uint32_t p = split->sites[i];
        split->part[p] = qs_set_of(split->part, p); /* the first site of the part */
    }
    return true;
}

uint64_t qs_split_count_shares(qs_split *split)
{
    const qs_stated *stated = split->stated;
    uint64_t count = 0;
    for (uint32_t i = 0; i < split->count; i++) {
        uint32_t p = split->sites[i];
        split->share_at[p] = (size_t)count;
        count += (uint64_t)(split->slot_count[p] - 1) * stated->left[p];
    }
    return count;
}

/* ---- The chains. ---- */

static int64_t *along(const qs_split *split, uint32_t edge)
{
    return split->along + (size_t)edge * split->stated->most_labels;
}

/* What is left for the last slot, before any share has been subtracted. */
static void begin_rest(const qs_split *split, uint32_t site, int64_t *rest)
{
    const qs_stated *stated = split->stated;
    const int64_t *unary = stated->unary + stated->start[site];
    for (uint32_t a = 0; a < stated->count[site]; a++) {
        rest[a] = split->scale * unary[a];
    }
}

static int64_t given_share(const qs_split *split, size_t number)
{
    const uint8_t *at = split->shares + number * split->share_bytes;
    return split->share_bytes == 8 ? qs_load_i64(at) : qs_load_signed(at, split->share_bytes);
}

/* The share of a slot. Shares are asked for slot by slot; NEVER for a label that has left. */
static void take_share(const qs_split *split, uint32_t site, uint32_t slot, int64_t *rest,
                       int64_t *share)
{
    const qs_stated *stated = split->stated;
    const uint8_t *kept = stated->kept + stated->start[site];
    bool last = slot + 1 == split->slot_count[site];
    size_t number = split->share_at[site] + (size_t)slot * stated->left[site];
    for (uint32_t a = 0; a < stated->count[site]; a++) {
        if (!kept[a]) {
            share[a] = NEVER;
        } else if (last) {
            share[a] = rest[a];
        } else {
            share[a] = given_share(split, number);
            rest[a] -= share[a];
            number++;
        }
    }
}

/* Lists the labels left to a site. */
static uint32_t list_open(const qs_split *split, uint32_t site)
{
    const qs_stated *stated = split->stated;
    uint32_t count = 0;
    for (uint32_t a = 0; a < stated->count[site]; a++) {
        split->open[count] = (uint16_t)a;
        count += stated->kept[qs_stated_at(stated, site, a)];
    }
    return count;
}

/* The same as below to the labels left alone: there are few. */
static void send_to_open(const qs_split *split, const qs_stated_edge *edge, bool on,
                         const int64_t *from, int64_t *to)
{
    const qs_stated *stated = split->stated;
    const int64_t *table = qs_stated_table(stated, edge);
    uint32_t own = on ? edge->first : edge->second,
             left = list_open(split, on ? edge->second : edge->first);
    size_t columns = stated->count[edge->second], along = on ? 1 : columns,
           across = on ? columns : 1;
    int64_t weight = split->scale * edge->weight;
    for (uint32_t i = 0; i < left; i++) {
        const int64_t *line = table + split->open[i] * along;
        int64_t least = INT64_MAX;
        for (uint32_t a = 0; a < stated->count[own]; a++) {
            if (from[a] < NEVER) {
                least = qs_min_i64(least, from[a] + weight * line[a * across]);
            }
        }
        to[split->open[i]] = least;
    }
}

/* Half the labels of a site have left: then it is less work to go through the others. */
static bool has_few(const qs_stated *stated, uint32_t site)
{
    return stated->left[site] <= stated->count[site] / 2;
}

/* to[b] = min_a from[a] + what a and b cost on the edge, to the second site. */
static void send_on(const qs_split *split, const qs_stated_edge *edge, const int64_t *from,
                    int64_t *to)
{
    const qs_stated *stated = split->stated;
    if (has_few(stated, edge->second)) {
        send_to_open(split, edge, true, from, to);
        return;
    }
    const int64_t *table = qs_stated_table(stated, edge);
    uint32_t rows = stated->count[edge->first], columns = stated->count[edge->second];
    int64_t weight = split->scale * edge->weight;
    for (uint32_t b = 0; b < columns; b++) {
        to[b] = INT64_MAX;
    }
    for (uint32_t a = 0; a < rows; a++) {
        const int64_t *row = table + (size_t)a * columns;
        if (from[a] >= NEVER) {
            continue;
        }
        for (uint32_t b = 0; b < columns; b++) {
            to[b] = qs_min_i64(to[b], from[a] + weight * row[b]);
        }
    }
}

/* The same to the first site. */
static void send_back(const qs_split *split, const qs_stated_edge *edge, const int64_t *from,
                      int64_t *to)
{
    const qs_stated *stated = split->stated;
    if (has_few(stated, edge->first)) {
        send_to_open(split, edge, false, from, to);
        return;
    }
    const int64_t *table = qs_stated_table(stated, edge);
    uint32_t rows = stated->count[edge->first], columns = stated->count[edge->second];
    int64_t weight = split->scale * edge->weight;
    for (uint32_t a = 0; a < rows; a++) {
        const int64_t *row = table + (size_t)a * columns;
        int64_t least = INT64_MAX;
        for (uint32_t b = 0; b < columns; b++) {
            least = from[b] < NEVER ? qs_min_i64(least, from[b] + weight * row[b]) : least;
        }
        to[a] = least;
    }
}

/* Adds to costs; those of labels that have left stay NEVER. */
static void add_costs(int64_t *costs, const int64_t *more, uint32_t count)
{
    for (uint32_t a = 0; a < count; a++) {
        costs[a] = costs[a] < NEVER ? costs[a] + more[a] : NEVER;
    }
}

static int64_t least_of(const int64_t *costs, uint32_t count)
{
    int64_t least = costs[0];
    for (uint32_t a = 1; a < count; a++) {
        least = qs_min_i64(least, costs[a]);
    }
    return least;
}

/* What the labelling costs at a site, with its edges to later sites, adds to the room of the part.
 *
 * rest  the site's own costs */
static void add_room(const qs_split *split, uint32_t site, const int64_t *rest)
{
    const qs_stated *stated = split->stated;
    const uint16_t *label = split->labelling;
    int64_t *room = &split->room[split->part[site]];
    uint32_t begin = split->slot_start[site];
    if (!label) {
        return;
    }
    *room += rest[label[site]];
    for (uint32_t slot = begin; slot < begin + split->slot_count[site]; slot++) {
        if (split->next_edge[slot] != QS_NO_EDGE) {
            const qs_stated_edge *edge = &stated->edges[split->next_edge[slot]];
            *room += split->scale *
                     qs_stated_cost(stated, edge, label[edge->first], label[edge->second]);
        }
    }
}

static void go_through(qs_split *split, uint32_t site)
{
    const qs_stated *stated = split->stated;
    uint32_t count = stated->count[site], begin = split->slot_start[site];
    int64_t *rest = split->work, *costs = rest + stated->most_labels;
    begin_rest(split, site, rest);
    add_room(split, site, rest);
    for (uint32_t slot = begin; slot < begin + split->slot_count[site]; slot++) {
        uint32_t before = split->before_edge[slot], next = split->next_edge[slot];
        take_share(split, site, slot - begin, rest, costs);
        if (before != QS_NO_EDGE) {
            add_costs(costs, along(split, before), count);
        }
        if (next != QS_NO_EDGE) {
            send_on(split, &stated->edges[next], costs, along(split, next));
        } else {
            split->least[split->part[site]] += least_of(costs, count);
        }
    }
}

int64_t qs_split_bound(qs_split *split)
{
    int64_t bound = split->stated->constant;
    for (uint32_t i = 0; i < split->count; i++) {
        split->least[split->sites[i]] = split->room[split->sites[i]] = 0;
    }
    for (uint32_t i = 0; i < split->count; i++) {
        go_through(split, split->sites[i]);
    }
    for (uint32_t i = 0; i < split->count; i++) {
        uint32_t p = split->sites[i];
        int64_t least = split->least[p];
        if (split->part[p] == p) {
            split->room[p] -= least;
            bound += least / split->scale + (least % split->scale > 0);
        }
    }
    return bound;
}

/* Finds by how much the chains of a site cost more with each of its labels than at least. What came
 * up to the site is no longer needed once it has been added; what comes from it takes its place. */
static void come_back(qs_split *split, uint32_t site, int64_t *excess)
{
    const qs_stated *stated = split->stated;
    uint32_t count = stated->count[site], begin = split->slot_start[site];
    int64_t *rest = split->work, *costs = rest + stated->most_labels,
            *whole = costs + stated->most_labels;
    begin_rest(split, site, rest);
    memset(excess, 0, sizeof *excess * count);
    for (uint32_t slot = begin; slot < begin + split->slot_count[site]; slot++) {
        uint32_t before = split->before_edge[slot], next = split->next_edge[slot];
        take_share(split, site, slot - begin, rest, costs);
        if (next != QS_NO_EDGE) {
            add_costs(costs, along(split, next), count);
        }
        memcpy(whole, costs, sizeof *costs * count);
        if (before != QS_NO_EDGE) {
            add_costs(whole, along(split, before), count);
            send_back(split, &stated->edges[before], costs, along(split, before));
        }
        int64_t least = least_of(whole, count);
        for (uint32_t a = 0; a < count; a++) {
            excess[a] += whole[a] < NEVER ? whole[a] - least : 0;
        }
    }
}

bool qs_split_rules_out(qs_split *split, const uint8_t *claimed)
{
    const qs_stated *stated = split->stated;
    int64_t *excess = split->work + 3 * (size_t)stated->most_labels;
    bool out = true;
    for (uint32_t i = split->count; out && i-- > 0;) {
        uint32_t p = split->sites[i];
        come_back(split, p, excess);
        for (uint32_t a = 0; a < stated->count[p]; a++) {
            size_t at = qs_stated_at(stated, p, a);
            out = out &&
                  (!stated->kept[at] || claimed[at] || excess[a] > split->room[split->part[p]]);
        }
    }
    return out;
}
