#include <string.h>

#include "../base/bits.h"
#include "../qubo/qubo_energy.h"
#include "repair.h"
#include "site_code.h"

/* Site p's variables say u_i = [w_p >= i] for i = 1 .. k - 1; with u_0 = 1 and u_k = 0 a step up,
 * u_i = 0 and u_i+1 = 1, is what a labelling has not. With U_i the sites at 1 let A_i be the union
 * of U_i and U_i+1, and B_i the intersection of U_i-1 and U_i: A moves each step up one to the
 * left, B one to the right, and no step down moves. The edges' cost is that of the cuts of all U_i,
 * which is submodular: A and B together cost at most twice what U does. So one of them does not
 * cost more, and neither does going on that way until a step up meets a step down and both vanish,
 * with what they cost (docs/MATHS.md). Sites that are labellings stay as they are, so that each
 * connected component of the others goes its own way. */

enum { FINE, WAITING, MOVING };

typedef struct moves {
    const qs_index *index;
    const qs_labels *labels;
    uint32_t end; /* the first variable behind the sites' */
    uint32_t *first; /* sites + 1: first variable of each site */
    uint32_t *queue; /* sites of a component */
    uint32_t moving; /* their number */
    uint8_t *state; /* of each site, as above */
    uint8_t *rows; /* of each site: u_0 .. u_k */
    uint32_t row_bytes;
} moves;

static uint32_t row_bytes(const qs_labels *l)
{
    return (l->labels + 8) / 8;
}

uint64_t qs_steps_workspace(const qs_index *index)
{
    const qs_labels *l = &index->qubo->labels;
    return (l->undecided + 1) * (uint64_t)(2 * sizeof(uint32_t) + 1 + row_bytes(l));
}

static moves lay_out(const qs_index *index, void *workspace)
{
    moves m = {.index = index,
               .labels = &index->qubo->labels,
               .first = workspace,
               .row_bytes = row_bytes(&index->qubo->labels)};
    uint32_t sites = m.labels->undecided;
    m.queue = m.first + sites + 1;
    m.state = (uint8_t *)(m.queue + sites + 1);
    m.rows = m.state + sites + 1;
    qs_site site = {.labels = m.labels};
    while (qs_site_next(&site)) {
        if (site.is_undecided) {
            m.first[site.number] = (uint32_t)site.variable;
        }
    }
    m.end = m.first[sites] = (uint32_t)site.next_variable;
    return m;
}

static uint8_t *row_of(const moves *m, uint32_t site)
{
    return m->rows + (size_t)site * m->row_bytes;
}

/* ---- From and to a sample. ---- */

/* Threshold i is the variable of the first label left from i on. */
static void read_row(const moves *m, const qs_site *site, const uint8_t *bits)
{
    uint8_t *row = row_of(m, site->number);
    uint32_t i = 1, rank = 0, first = (uint32_t)site->variable;
    bool cut = qs_is_cut(m->labels->encoding);
    memset(row, 0, m->row_bytes);
    qs_bit_set(row, 0, true);
    for (uint32_t d = qs_site_label(site, 0); d < m->labels->labels;
         d = qs_site_label(site, d + 1), rank++) {
        for (; i <= d; i++) {
            qs_bit_set(row, i, rank == 0 || qs_bit(bits, cut ? first + rank : first + rank - 1));
        }
    }
}

static uint32_t steps_up(const moves *m, uint32_t site)
{
    const uint8_t *row = row_of(m, site);
    uint32_t count = 0;
    for (uint32_t i = 0; i < m->labels->labels; i++) {
        count += !qs_bit(row, i) && qs_bit(row, i + 1);
    }
    return count;
}

static void write_row(const moves *m, const qs_site *site, uint8_t *bits)
{
    uint32_t label = 0;
    while (qs_bit(row_of(m, site->number), label + 1)) {
        label++;
    }
    qs_site_write(site, qs_site_rank(site, label), bits);
}

/* ---- Moving. ---- */

typedef enum direction { BACK = -1, STAY = 0, ON = 1 } direction;

/* A byte of a row after a move, from the bytes of the row beside it as they were: ON = A, BACK = B.
 */
static uint8_t moved_byte(uint32_t before, uint32_t byte, uint32_t after, direction to)
{
    return (uint8_t)(to == ON     ? byte | byte >> 1 | after << 7
                     : to == BACK ? byte & (byte << 1 | before >> 7)
                                  : byte);
}

static uint8_t moved(const moves *m, const uint8_t *row, uint32_t byte, direction to)
{
    return moved_byte(byte > 0 ? row[byte - 1] : UINT8_MAX, row[byte],
                      byte + 1 < m->row_bytes ? row[byte + 1] : 0, to);
}

static uint64_t apart(const moves *m, uint32_t p, uint32_t q, direction to)
{
    uint64_t count = 0;
    for (uint32_t byte = 0; byte < m->row_bytes; byte++) {
        count += qs_byte_count(
            (uint8_t)(moved(m, row_of(m, p), byte, to) ^ moved(m, row_of(m, q), byte, to)));
    }
    return count;
}

/* The site that a variable belongs to. */
static uint32_t site_of(const moves *m, uint32_t variable)
{
    uint32_t low = 0, high = m->labels->undecided;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (m->first[middle] <= variable) {
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

/* An arc's variable z = y_tail (1 - y_head) is coupled with its tail by -2M and with its head by
 * +2M; its linear term is its cost + M. */
typedef struct arc {
    uint32_t tail, head;
    int64_t cost;
} arc;

static arc arc_of(const qs_index *index, uint32_t z)
{
    arc found = {UINT32_MAX, UINT32_MAX, qs_qubo_linear(index->qubo, z)};
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

/* An edge between a site and another, of which `variable` sees one coupling: UINT32_MAX = it is
 * something else. The weight is in a unit that is the same for all edges of the file. */
static uint32_t other_end(const moves *m, uint32_t site, uint32_t variable,
                          const qs_neighbour *near, int64_t *weight)
{
    uint32_t other = near->group;
    bool cut = qs_is_cut(m->labels->encoding);
    *weight = cut ? -scalar(m->index, near) : near->weight;
    if (m->labels->encoding == QS_ST_CUT_ARCS) {
        arc along = other < m->end + 2 ? (arc){UINT32_MAX, UINT32_MAX, 0} : arc_of(m->index, other);
        other = along.tail == variable ? along.head : UINT32_MAX;
        *weight = along.cost;
    }
    if (other >= (cut ? m->end : m->labels->undecided)) {
        return UINT32_MAX;
    }
    other = cut ? site_of(m, other) : other;
    return other == site ? UINT32_MAX : other;
}

static uint32_t first_group(const moves *m, uint32_t site)
{
    return qs_is_cut(m->labels->encoding) ? m->first[site] : site;
}

/* What the edges of the moving sites cost after a move, those between two of them once. The sum may
 * wrap where a file is not what it says, and is then merely useless. */
static uint64_t edges_cost(const moves *m, direction to)
{
    uint64_t cost = 0;
    for (uint32_t at = 0; at < m->moving; at++) {
        uint32_t p = m->queue[at];
        for (uint32_t g = first_group(m, p); g < first_group(m, p + 1); g++) {
            for (uint32_t n = m->index->near_start[g]; n < m->index->near_start[g + 1]; n++) {
                int64_t weight;
                uint32_t q = other_end(m, p, g, &m->index->near[n], &weight);
                if (q != UINT32_MAX && (m->state[q] != MOVING || q > p)) {
                    cost += (uint64_t)weight * apart(m, p, q, to);
                }
            }
        }
    }
    return cost;
}

/* Moves all once; how many steps up are left. */
static uint64_t move(const moves *m, direction to)
{
    uint64_t steps = 0;
    for (uint32_t at = 0; at < m->moving; at++) {
        uint8_t *row = row_of(m, m->queue[at]), before = UINT8_MAX;
        for (uint32_t byte = 0; byte < m->row_bytes; byte++) {
            uint8_t was = row[byte];
            row[byte] = moved_byte(before, was, byte + 1 < m->row_bytes ? row[byte + 1] : 0, to);
            before = was;
        }
        steps += steps_up(m, m->queue[at]);
    }
    return steps;
}

static void gather(moves *m, uint32_t site)
{
    m->queue[0] = site;
    m->moving = 1;
    m->state[site] = MOVING;
    for (uint32_t at = 0; at < m->moving; at++) {
        uint32_t p = m->queue[at];
        for (uint32_t g = first_group(m, p); g < first_group(m, p + 1); g++) {
            for (uint32_t n = m->index->near_start[g]; n < m->index->near_start[g + 1]; n++) {
                int64_t weight;
                uint32_t q = other_end(m, p, g, &m->index->near[n], &weight);
                if (q != UINT32_MAX && m->state[q] == WAITING) {
                    m->state[q] = MOVING;
                    m->queue[m->moving++] = q;
                }
            }
        }
    }
}

static void settle(moves *m)
{
    uint64_t steps = 0;
    for (uint32_t at = 0; at < m->moving; at++) {
        steps += steps_up(m, m->queue[at]);
    }
    while (steps > 0) {
        direction to = (int64_t)(edges_cost(m, ON) - edges_cost(m, STAY)) <= 0 ? ON : BACK;
        uint64_t before = steps;
        while (steps == before) {
            steps = move(m, to);
        }
    }
    for (uint32_t at = 0; at < m->moving; at++) {
        m->state[m->queue[at]] = FINE;
    }
}

/* ---- The ends of the cuts' chains. ---- */

/* What the arc from a chain's vertex to the next one costs, but for what is the same in all of the
 * file. */
static int64_t chain_cost(const moves *m, uint32_t vertex)
{
    int64_t cost = 0;
    for (uint32_t n = m->index->near_start[vertex]; n < m->index->near_start[vertex + 1]; n++) {
        const qs_neighbour *near = &m->index->near[n];
        if (m->labels->encoding == QS_ST_CUT) {
            cost -= near->group == vertex + 1 ? scalar(m->index, near) : 0;
        } else if (near->group >= m->end + 2) {
            arc along = arc_of(m->index, near->group);
            cost += along.tail == vertex && along.head == vertex + 1 ? along.cost : 0;
        }
    }
    return cost;
}

/* With source or sink wrong a state costs more than the labelling in which each site takes its
 * cheapest label. */
static void take_winners(const moves *m, uint8_t *bits)
{
    for (qs_site site = {.labels = m->labels}; qs_site_next(&site);) {
        uint32_t best = 0;
        int64_t least = 0;
        for (uint32_t rank = 0; site.is_undecided && rank < site.count; rank++) {
            int64_t cost = chain_cost(m, (uint32_t)site.variable + rank);
            best = rank == 0 || cost < least ? rank : best;
            least = rank == 0 || cost < least ? cost : least;
        }
        if (site.is_undecided) {
            qs_site_write(&site, best, bits);
        }
    }
}

void qs_repair_steps(const qs_index *index, uint8_t *bits, void *workspace)
{
    moves m = lay_out(index, workspace);
    bool cut = qs_is_cut(m.labels->encoding);
    if (cut && (!qs_bit(bits, m.end) || qs_bit(bits, m.end + 1))) {
        take_winners(&m, bits);
        return;
    }
    for (qs_site site = {.labels = m.labels}; qs_site_next(&site);) {
        if (site.is_undecided) {
            read_row(&m, &site, bits);
            m.state[site.number] = steps_up(&m, site.number) > 0 ? WAITING : FINE;
        }
    }
    for (uint32_t p = 0; p < m.labels->undecided; p++) {
        if (m.state[p] == WAITING) {
            gather(&m, p);
            settle(&m);
        }
    }
    for (qs_site site = {.labels = m.labels}; qs_site_next(&site);) {
        if (site.is_undecided) {
            write_row(&m, &site, bits);
        }
    }
}
