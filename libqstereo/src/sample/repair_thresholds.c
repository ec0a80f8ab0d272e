#include <string.h>

#include "../base/arena.h"
#include "../base/bits.h"
#include "../qubo/qubo_energy.h"
#include "repair.h"
#include "site_code.h"

/* The variables of site p say u_i = [w_p >= i] for i = 1 .. k - 1; take u_0 = 1 and u_k = 0. A step
 * up, u_i = 0 and u_i+1 = 1, is what no labelling has. Let U_i be the set of sites with u_i = 1.
 * There are two ways to shift the steps up by one threshold while the steps down stay:
 *
 *     to the left     u_i becomes u_i or u_i+1     A_i = the union of U_i and U_i+1
 *     to the right    u_i becomes u_i-1 and u_i    B_i = the intersection of U_i-1 and U_i
 *
 * The cost of the edges is that of the cuts of all U_i, which is submodular: A and B together cost
 * at most twice what U does. So one of them costs no more than U, and the same holds for going on
 * in that direction, until a step up meets a step down and both vanish, with what they cost
 * (docs/MATHS.md). Sites that have a label stay as they are. So each connected component of the
 * others can be shifted by itself. */

enum { LABELLED, WAITING, SHIFTING }; /* states of a site */

typedef struct search {
    const qs_index *index;
    const qs_labels *labels;
    bool cut; /* sites are chains of vertices, a group each; else each site is a group */
    uint32_t end; /* the first variable behind those of the sites */
    uint32_t *first; /* undecided sites + 1: first variable of each */
    uint32_t *queue; /* sites of a component */
    uint32_t shifting; /* their number */
    uint8_t *state; /* of each site */
    uint8_t *rows; /* of each site: the bits u_0 .. u_k */
    uint32_t row_bytes;
} search;

static search take_search(qs_arena *arena, const qs_index *index)
{
    const qs_labels *labels = &index->qubo->labels;
    uint32_t row_bytes = (uint32_t)qs_bit_bytes(labels->labels + 1ull);
    uint64_t sites = labels->undecided;
    return (search){
        .index = index,
        .labels = labels,
        .cut = qs_code_of(labels) == QS_CODE_CHAIN,
        .first = qs_arena_take(arena, sites + 1, sizeof(uint32_t)),
        .queue = qs_arena_take(arena, sites, sizeof(uint32_t)),
        .state = qs_arena_take(arena, sites, 1),
        .rows = qs_arena_take(arena, sites, row_bytes),
        .row_bytes = row_bytes,
    };
}

size_t qs_thresholds_workspace(const qs_index *index)
{
    qs_arena arena = {0};
    take_search(&arena, index);
    return qs_arena_size(&arena);
}

static search begin(const qs_index *index, void *workspace)
{
    qs_arena arena = {.base = workspace};
    search s = take_search(&arena, index);
    qs_site site = {.labels = s.labels};
    while (qs_site_next(&site)) {
        if (site.is_undecided) {
            s.first[site.number] = (uint32_t)site.variable;
        }
    }
    s.end = s.first[s.labels->undecided] = (uint32_t)site.next_variable;
    return s;
}

static uint8_t *row_of(const search *s, uint32_t site)
{
    return s->rows + (size_t)site * s->row_bytes;
}

/* ---- From and to a sample. ---- */

/* u_i is the variable of the first label left from i on. In a wall the first label left has none:
 * u is 1. */
static void read_row(const search *s, const qs_site *site, const uint8_t *bits)
{
    uint8_t *row = row_of(s, site->number);
    uint32_t i = 1, rank = 0, variable = (uint32_t)site->variable - !s->cut;
    memset(row, 0, s->row_bytes);
    qs_bit_set(row, 0, true);
    for (uint32_t d = qs_site_label_from(site, 0); d < s->labels->labels;
         d = qs_site_label_from(site, d + 1), rank++) {
        for (; i <= d; i++) {
            qs_bit_set(row, i, rank == 0 || qs_bit(bits, variable + rank));
        }
    }
}

static uint32_t steps_up(const search *s, uint32_t site)
{
    const uint8_t *row = row_of(s, site);
    uint32_t count = 0;
    for (uint32_t i = 0; i < s->labels->labels; i++) {
        count += !qs_bit(row, i) && qs_bit(row, i + 1);
    }
    return count;
}

static void write_row(const search *s, const qs_site *site, uint8_t *bits)
{
    uint32_t label = 0;
    while (qs_bit(row_of(s, site->number), label + 1)) {
        label++;
    }
    qs_site_write(site, qs_site_rank(site, label), bits);
}

/* ---- Shifting. ---- */

typedef enum direction { STAY, LEFT, RIGHT } direction;

/* A byte of a row after a shift, from the bytes of the row before it, at it and after it as they
 * were. */
static uint8_t shifted_byte(uint32_t before, uint32_t byte, uint32_t after, direction to)
{
    switch (to) {
    case LEFT: return (uint8_t)(byte | byte >> 1 | after << 7);
    case RIGHT: return (uint8_t)(byte & (byte << 1 | before >> 7));
    case STAY: break;
    }
    return (uint8_t)byte;
}

static uint8_t shifted(const search *s, const uint8_t *row, uint32_t byte, direction to)
{
    return shifted_byte(byte > 0 ? row[byte - 1] : UINT8_MAX, row[byte],
                        byte + 1 < s->row_bytes ? row[byte + 1] : 0, to);
}

/* How far the labels of two sites are apart after a shift: the number of thresholds at which they
 * differ. */
static uint64_t apart(const search *s, uint32_t p, uint32_t q, direction to)
{
    uint64_t count = 0;
    for (uint32_t byte = 0; byte < s->row_bytes; byte++) {
        count += qs_byte_count(
            (uint8_t)(shifted(s, row_of(s, p), byte, to) ^ shifted(s, row_of(s, q), byte, to)));
    }
    return count;
}

/* The site that a variable of the sites belongs to. */
static uint32_t site_of(const search *s, uint32_t variable)
{
    uint32_t low = 0, high = s->labels->undecided;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (s->first[middle] <= variable) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

/* The coupling of two groups of one variable each. */
static int64_t scalar(const qs_index *index, const qs_neighbour *near)
{
    return (int64_t)qs_near_entry(index, near, 0, 0) * near->weight;
}

static const uint32_t NONE = UINT32_MAX; /* no vertex, no site */

/* An arc, with the variable z = y_tail (1 - y_head). It is coupled with its tail by -2M and with
 * its head by +2M; its linear term is its cost + M. */
typedef struct arc {
    uint32_t tail, head;
    int64_t cost;
} arc;

static arc arc_of(const search *s, uint32_t z)
{
    const qs_index *index = s->index;
    arc found = {NONE, NONE, qs_qubo_linear(index->qubo, z)};
    for (uint32_t n = index->near_start[z]; n < index->near_start[z + 1]; n++) {
        int64_t coupling = scalar(index, &index->near[n]);
        if (coupling < 0) {
            found.tail = index->near[n].group;
            found.cost += coupling / 2;
        } else {
            found.head = index->near[n].group;
        }
    }
    return found;
}

static bool is_arc(const search *s, uint32_t variable)
{
    return s->labels->encoding == QS_ST_CUT_ARCS && variable >= s->end + 2;
}

/* The vertex of a cut that an edge joins to `vertex`, given one of the couplings of `vertex`: NONE
 * = it is no edge's. Where arcs have variables the edge is that of the arc. */
static uint32_t other_vertex(const search *s, uint32_t vertex, const qs_neighbour *near,
                             int64_t *weight)
{
    if (s->labels->encoding != QS_ST_CUT_ARCS) {
        *weight = -scalar(s->index, near);
        return near->group;
    }
    if (!is_arc(s, near->group)) {
        *weight = 0;
        return NONE;
    }
    arc along = arc_of(s, near->group);
    *weight = along.cost;
    return along.tail == vertex ? along.head : NONE;
}

/* The neighbour that an edge joins to a site, given one of the couplings of the site's group
 * `group`: NONE = it is no edge's. The weight is in a unit that is the same for all edges of the
 * file. */
static uint32_t other_site(const search *s, uint32_t site, uint32_t group, const qs_neighbour *near,
                           int64_t *weight)
{
    uint32_t other = near->group;
    if (s->cut) {
        uint32_t vertex = other_vertex(s, group, near, weight);
        other = vertex < s->end ? site_of(s, vertex) : NONE;
    } else {
        *weight = near->weight;
    }
    return other == site || other >= s->labels->undecided ? NONE : other;
}

static uint32_t first_group(const search *s, uint32_t site)
{
    return s->cut ? s->first[site] : site;
}

/* What the edges of the shifting sites cost after a shift; an edge between two of them counts once.
 * The sum may wrap if a file is not what it says. Then it means nothing, and nothing else
 * happens. */
static uint64_t edges_cost(const search *s, direction to)
{
    uint64_t cost = 0;
    for (uint32_t at = 0; at < s->shifting; at++) {
        uint32_t p = s->queue[at];
        for (uint32_t g = first_group(s, p); g < first_group(s, p + 1); g++) {
            for (uint32_t n = s->index->near_start[g]; n < s->index->near_start[g + 1]; n++) {
                int64_t weight;
                uint32_t q = other_site(s, p, g, &s->index->near[n], &weight);
                if (q != NONE && (s->state[q] != SHIFTING || q > p)) {
                    cost += (uint64_t)weight * apart(s, p, q, to);
                }
            }
        }
    }
    return cost;
}

/* Shifts all once; returns how many steps up are left. */
static uint64_t shift(const search *s, direction to)
{
    uint64_t steps = 0;
    for (uint32_t at = 0; at < s->shifting; at++) {
        uint8_t *row = row_of(s, s->queue[at]), before = UINT8_MAX;
        for (uint32_t byte = 0; byte < s->row_bytes; byte++) {
            uint8_t was = row[byte];
            row[byte] = shifted_byte(before, was, byte + 1 < s->row_bytes ? row[byte + 1] : 0, to);
            before = was;
        }
        steps += steps_up(s, s->queue[at]);
    }
    return steps;
}

/* Puts the component of a site into the queue: all that edges join to it by way of sites that have
 * no label. */
static void gather(search *s, uint32_t site)
{
    s->queue[0] = site;
    s->shifting = 1;
    s->state[site] = SHIFTING;
    for (uint32_t at = 0; at < s->shifting; at++) {
        uint32_t p = s->queue[at];
        for (uint32_t g = first_group(s, p); g < first_group(s, p + 1); g++) {
            for (uint32_t n = s->index->near_start[g]; n < s->index->near_start[g + 1]; n++) {
                int64_t weight;
                uint32_t q = other_site(s, p, g, &s->index->near[n], &weight);
                if (q != NONE && s->state[q] == WAITING) {
                    s->state[q] = SHIFTING;
                    s->queue[s->shifting++] = q;
                }
            }
        }
    }
}

/* Shifts the sites of the queue until each has a label. */
static void settle(search *s)
{
    uint64_t steps = 0;
    for (uint32_t at = 0; at < s->shifting; at++) {
        steps += steps_up(s, s->queue[at]);
    }
    while (steps > 0) {
        bool left_is_cheap = (int64_t)(edges_cost(s, LEFT) - edges_cost(s, STAY)) <= 0;
        uint64_t before = steps;
        while (steps == before) {
            steps = shift(s, left_is_cheap ? LEFT : RIGHT);
        }
    }
    for (uint32_t at = 0; at < s->shifting; at++) {
        s->state[s->queue[at]] = LABELLED;
    }
}

/* ---- The ends of the cuts' chains. ---- */

/* The cost of the arc from a vertex of a chain to the next one, less what is the same in all of the
 * file. */
static int64_t chain_cost(const search *s, uint32_t vertex)
{
    int64_t cost = 0;
    for (uint32_t n = s->index->near_start[vertex]; n < s->index->near_start[vertex + 1]; n++) {
        const qs_neighbour *near = &s->index->near[n];
        int64_t weight;
        if (other_vertex(s, vertex, near, &weight) == vertex + 1) {
            cost += weight;
        }
    }
    return cost;
}

/* The rank of a site's cheapest label. */
static uint32_t winner(const search *s, const qs_site *site)
{
    uint32_t best = 0;
    int64_t least = 0;
    for (uint32_t rank = 0; rank < site->count; rank++) {
        int64_t cost = chain_cost(s, (uint32_t)site->variable + rank);
        if (rank == 0 || cost < least) {
            best = rank;
            least = cost;
        }
    }
    return best;
}

/* A state in which source or sink is wrong costs more than the labelling in which each site takes
 * its cheapest label. */
static void take_winners(const search *s, uint8_t *bits)
{
    for (qs_site site = {.labels = s->labels}; qs_site_next(&site);) {
        if (site.is_undecided) {
            qs_site_write(&site, winner(s, &site), bits);
        }
    }
}

void qs_repair_thresholds(const qs_index *index, uint8_t *bits, void *workspace)
{
    search s = begin(index, workspace);
    if (s.cut && (!qs_bit(bits, s.end) || qs_bit(bits, s.end + 1))) {
        take_winners(&s, bits);
        return;
    }
    for (qs_site site = {.labels = s.labels}; qs_site_next(&site);) {
        if (site.is_undecided) {
            read_row(&s, &site, bits);
            s.state[site.number] = steps_up(&s, site.number) > 0 ? WAITING : LABELLED;
        }
    }
    for (uint32_t p = 0; p < s.labels->undecided; p++) {
        if (s.state[p] == WAITING) {
            gather(&s, p);
            settle(&s);
        }
    }
    for (qs_site site = {.labels = s.labels}; qs_site_next(&site);) {
        if (site.is_undecided) {
            write_row(&s, &site, bits);
        }
    }
}
