#include "slow.h"

#include <string.h>

#include "base/bytes.h"
#include "files/crc32c.h"

enum { COUPLINGS = 4096, ARCS = 512 };

/* A coupling of two groups, its block a table. */
typedef struct coupling {
    uint32_t g, h, rows, columns;
    int32_t weight;
    int32_t table[TINY_LABELS * TINY_LABELS];
} coupling;

/* The problem over the labels left, and the QUBO made of it. */
typedef struct draft {
    const slow_request *request;
    uint32_t sites, labels, open;
    bool is_open[TINY_SITES];
    uint32_t group[TINY_SITES]; /* of an open site: its first group */
    uint32_t size[TINY_SITES], label[TINY_SITES][TINY_LABELS]; /* labels left */
    int64_t theta[TINY_SITES][TINY_LABELS]; /* by label, shifted */
    int64_t cut[TINY_SITES][TINY_LABELS]; /* by label: what truncation took */
    tiny_edge edges[TINY_EDGES];
    size_t edge_count;
    int64_t constant;
    /* The QUBO. */
    uint32_t groups, group_size[SLOW_VARIABLES], first[SLOW_VARIABLES + 1];
    int64_t a[SLOW_VARIABLES], b[SLOW_VARIABLES], linear[SLOW_VARIABLES], offset;
    coupling couplings[COUPLINGS];
    size_t coupling_count;
} draft;

static draft d;

static int64_t V(uint32_t a, uint32_t b)
{
    return qs_pairwise_cost(d.request->problem, a, b);
}

static int64_t larger(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

static int64_t tau(void)
{
    const qs_pairwise *pairwise = &d.request->problem->pairwise;
    int64_t most = d.labels - 1;
    if (pairwise->smoothness == QS_POTTS) {
        return 1;
    }
    return pairwise->truncation == 0 || pairwise->truncation > most ? most : pairwise->truncation;
}

static bool linear_cost(const qs_problem *problem)
{
    const qs_pairwise *pairwise = &problem->pairwise;
    return pairwise->smoothness == QS_TRUNCATED_LINEAR &&
           (pairwise->truncation == 0 || pairwise->truncation >= problem->labels - 1);
}

bool slow_fits(const qs_problem *problem, qs_encoding encoding)
{
    bool potts = problem->pairwise.smoothness == QS_POTTS;
    switch (encoding) {
    case QS_ONE_HOT_SPARSE:
    case QS_DOMAIN_WALL: return potts || problem->pairwise.smoothness == QS_TRUNCATED_LINEAR;
    case QS_MULTIWAY_CUT: return potts;
    case QS_ST_CUT:
    case QS_ST_CUT_ARCS: return linear_cost(problem);
    default: return true;
    }
}

void slow_choose_labels(slow_request *request, uint64_t *state)
{
    uint32_t labels = request->problem->labels, kind = tiny_random(state, 4);
    for (uint32_t p = 0; p < TINY_SITES; p++) {
        for (uint32_t l = 0; l < labels; l++) {
            request->kept[p][l] = kind == 0 || tiny_random(state, 4) < kind;
        }
        request->kept[p][tiny_random(state, labels)] = true;
    }
}

/* ---- The problem that is left. ---- */

static void fold_edges(void)
{
    tiny_edge all[TINY_EDGES];
    size_t count = tiny_edges(d.request->problem, all);
    for (size_t i = 0; i < count; i++) {
        uint32_t p = all[i].p, q = all[i].q;
        if (d.is_open[p] && d.is_open[q]) {
            d.edges[d.edge_count++] = all[i];
        } else if (!d.is_open[p] && !d.is_open[q]) {
            d.constant += all[i].weight * V(d.label[p][0], d.label[q][0]);
        }
        for (uint32_t l = 0; l < d.labels; l++) {
            d.theta[p][l] +=
                d.is_open[p] && !d.is_open[q] ? all[i].weight * V(l, d.label[q][0]) : 0;
            d.theta[q][l] +=
                d.is_open[q] && !d.is_open[p] ? all[i].weight * V(d.label[p][0], l) : 0;
        }
    }
}

/* The most that the edges of a site can cost. */
static int64_t reach(uint32_t p)
{
    int64_t most = 0;
    for (uint32_t i = 0; i < d.size[p]; i++) {
        int64_t sum = 0;
        for (size_t e = 0; e < d.edge_count; e++) {
            bool first = d.edges[e].p == p;
            uint32_t q = first ? d.edges[e].q : d.edges[e].p;
            int64_t largest = 0;
            for (uint32_t j = 0; j < d.size[q]; j++) {
                uint32_t own = d.label[p][i], other = d.label[q][j];
                largest = larger(largest, first ? V(own, other) : V(other, own));
            }
            sum += first || d.edges[e].q == p ? d.edges[e].weight * largest : 0;
        }
        most = larger(most, sum);
    }
    return most;
}

static int64_t weights(uint32_t p)
{
    int64_t sum = 0;
    for (size_t e = 0; e < d.edge_count; e++) {
        sum += d.edges[e].p == p || d.edges[e].q == p ? d.edges[e].weight : 0;
    }
    return sum;
}

static int64_t largest_cost(uint32_t p)
{
    int64_t most = 0;
    for (uint32_t i = 0; i < d.size[p]; i++) {
        most = larger(most, d.theta[p][d.label[p][i]]);
    }
    return most;
}

static void shift(uint32_t p)
{
    int64_t least = INT64_MAX;
    for (uint32_t i = 0; i < d.size[p]; i++) {
        int64_t cost = d.theta[p][d.label[p][i]];
        least = cost < least ? cost : least;
    }
    d.constant += least;
    for (uint32_t l = 0; l < d.labels; l++) {
        d.theta[p][l] -= least;
    }
}

static void truncate_costs(uint32_t p)
{
    int64_t most = reach(p) + 1;
    for (uint32_t l = 0; d.request->truncate && l < d.labels; l++) {
        d.cut[p][l] = larger(0, d.theta[p][l] - most);
        d.theta[p][l] -= d.cut[p][l];
    }
}

static void reduce(const slow_request *request)
{
    memset(&d, 0, sizeof d);
    d.request = request;
    d.sites = qs_problem_sites(request->problem);
    d.labels = request->problem->labels;
    for (uint32_t p = 0; p < d.sites; p++) {
        for (uint32_t l = 0; l < d.labels; l++) {
            d.theta[p][l] = request->problem->costs[p * d.labels + l];
            if (request->kept[p][l]) {
                d.label[p][d.size[p]++] = l;
            }
        }
        d.is_open[p] = d.size[p] > 1 || request->open_single;
        d.open += d.is_open[p];
    }
    fold_edges();
    for (uint32_t p = 0; p < d.sites; p++) {
        shift(p); /* a fixed site's cost is in the constant, too */
    }
    for (uint32_t p = 0; p < d.sites; p++) {
        truncate_costs(p);
    }
    d.offset = d.constant;
}

/* ---- Building the QUBO. ---- */

static uint32_t add_group(uint32_t size, int64_t a, int64_t b)
{
    uint32_t g = d.groups++;
    assert_true(d.first[g] + size <= SLOW_VARIABLES);
    d.group_size[g] = size;
    d.first[g + 1] = d.first[g] + size;
    d.a[g] = a;
    d.b[g] = b;
    return g;
}

static coupling *add_coupling(uint32_t g, uint32_t h, int64_t weight)
{
    assert_true(d.coupling_count < COUPLINGS && g <= h);
    coupling *c = &d.couplings[d.coupling_count++];
    *c = (coupling){.g = g,
                    .h = h,
                    .rows = d.group_size[g],
                    .columns = d.group_size[h],
                    .weight = (int32_t)weight};
    return c;
}

/* weight * x * y of two groups of one variable; those of the same two are added up. */
static void add_scalar(uint32_t u, uint32_t v, int64_t weight)
{
    for (size_t i = 0; i < d.coupling_count; i++) {
        coupling *c = &d.couplings[i];
        if ((c->g == u && c->h == v) || (c->g == v && c->h == u)) {
            c->weight += (int32_t)weight;
            return;
        }
    }
    add_coupling(u < v ? u : v, u < v ? v : u, weight)->table[0] = 1;
}

static void one_hot_groups(void)
{
    bool sparse = d.request->encoding == QS_ONE_HOT_SPARSE,
         minimal = d.request->penalty == QS_PENALTY_MINIMAL,
         potts = d.request->problem->pairwise.smoothness == QS_POTTS;
    int64_t gap = d.request->gap, row = 0;
    for (uint32_t i = 0; i < d.labels; i++) {
        int64_t sum = 0;
        for (int64_t j = 0; j < d.labels; j++) {
            sum += larger(0, tau() - (i > j ? i - j : j - i));
        }
        row = larger(row, sum);
    }
    for (uint32_t p = 0; p < d.sites; p++) {
        if (!d.is_open[p]) {
            continue;
        }
        int64_t W = weights(p), a = sparse ? gap : reach(p) + gap;
        int64_t b = !sparse    ? a + gap
                    : !minimal ? a + (potts ? W : row * W) + gap
                    : potts    ? a + (W + 1) / 2 + gap
                               : a + ((6 * tau() - 3) * W + 3) / 4 + gap;
        d.group[p] = add_group(d.size[p], a, b);
        for (uint32_t i = 0; i < d.size[p]; i++) {
            d.linear[d.first[d.group[p]] + i] = d.theta[p][d.label[p][i]];
        }
    }
}

static void one_hot_edges(void)
{
    bool sparse = d.request->encoding == QS_ONE_HOT_SPARSE;
    for (size_t e = 0; e < d.edge_count; e++) {
        uint32_t p = d.edges[e].p, q = d.edges[e].q;
        coupling *c = add_coupling(d.group[p], d.group[q], d.edges[e].weight);
        d.offset += sparse ? d.edges[e].weight * tau() : 0;
        for (uint32_t i = 0; i < d.size[p]; i++) {
            for (uint32_t j = 0; j < d.size[q]; j++) {
                int64_t cost = V(d.label[p][i], d.label[q][j]);
                c->table[i * d.size[q] + j] = (int32_t)(sparse ? cost - tau() : cost);
            }
        }
    }
}

static void walls(void)
{
    qs_smoothness smoothness = d.request->problem->pairwise.smoothness;
    for (uint32_t p = 0; p < d.sites; p++) {
        if (!d.is_open[p]) {
            continue;
        }
        int64_t most = 0, W = weights(p);
        for (uint32_t i = 1; i + 1 < d.size[p]; i++) {
            most = larger(most, d.theta[p][d.label[p][i]]);
        }
        int64_t kappa = most + d.request->gap +
                        (smoothness == QS_POTTS            ? W
                         : linear_cost(d.request->problem) ? 0
                                                           : (3 * tau() * W + 1) / 2);
        uint32_t g = d.group[p] = add_group(d.size[p] - 1, 0, 0);
        coupling *chain = d.size[p] > 2 ? add_coupling(g, g, kappa) : NULL;
        d.offset += d.theta[p][d.label[p][0]];
        for (uint32_t i = 0; i + 1 < d.size[p]; i++) {
            d.linear[d.first[g] + i] += d.theta[p][d.label[p][i + 1]] - d.theta[p][d.label[p][i]];
            if (i > 0) {
                d.linear[d.first[g] + i] += kappa;
                chain->table[(i - 1) * (d.size[p] - 1) + i] = -1;
            }
        }
    }
    for (size_t e = 0; e < d.edge_count; e++) {
        uint32_t p = d.edges[e].p, q = d.edges[e].q, *a = d.label[p], *b = d.label[q];
        int64_t l = d.edges[e].weight;
        coupling *c = add_coupling(d.group[p], d.group[q], l);
        d.offset += l * V(a[0], b[0]);
        for (uint32_t i = 1; i < d.size[p]; i++) {
            d.linear[d.first[d.group[p]] + i - 1] += l * (V(a[i], b[0]) - V(a[i - 1], b[0]));
            for (uint32_t j = 1; j < d.size[q]; j++) {
                int64_t entry =
                    V(a[i], b[j]) - V(a[i - 1], b[j]) - V(a[i], b[j - 1]) + V(a[i - 1], b[j - 1]);
                c->table[(i - 1) * (d.size[q] - 1) + j - 1] = (int32_t)entry;
            }
        }
        for (uint32_t j = 1; j < d.size[q]; j++) {
            d.linear[d.first[d.group[q]] + j - 1] += l * (V(a[0], b[j]) - V(a[0], b[j - 1]));
        }
    }
}

static void multiway(void)
{
    int64_t near[TINY_LABELS] = {0}, gap = d.request->gap;
    for (uint32_t p = 0; p < d.sites; p++) {
        if (!d.is_open[p]) {
            continue;
        }
        int64_t K = largest_cost(p) + 1, sum = 0;
        for (uint32_t i = 0; i < d.size[p]; i++) {
            int64_t C = K - d.theta[p][d.label[p][i]];
            sum += C;
            near[d.label[p][i]] += C;
        }
        d.group[p] = add_group(d.size[p], weights(p) + sum + gap, weights(p) + sum + 2 * gap);
        d.offset -= sum - K;
    }
    for (size_t e = 0; e < d.edge_count; e++) {
        uint32_t p = d.edges[e].p, q = d.edges[e].q;
        coupling *c = add_coupling(d.group[p], d.group[q], d.edges[e].weight);
        for (uint32_t i = 0; i < d.size[p] * d.size[q]; i++) {
            c->table[i] = d.label[p][i / d.size[q]] != d.label[q][i % d.size[q]];
        }
    }
    for (uint32_t t = 0; t < d.labels; t++) {
        uint32_t g = add_group(d.labels, near[t] + gap, near[t] + 2 * gap);
        for (uint32_t e = 0; e < d.labels; e++) {
            d.linear[d.first[g] + e] = e == t ? 0 : near[t] + gap;
        }
        for (uint32_t p = 0; p < d.sites; p++) {
            if (!d.is_open[p] || !d.request->kept[p][t]) {
                continue;
            }
            coupling *c = add_coupling(d.group[p], g, largest_cost(p) + 1 - d.theta[p][t]);
            for (uint32_t i = 0; i < d.size[p] * d.labels; i++) {
                c->table[i] = d.label[p][i / d.labels] != i % d.labels;
            }
        }
    }
}

typedef struct arc {
    uint32_t u, v;
    int64_t cost;
} arc;

static arc arcs[ARCS];
static size_t arc_count;

/* An edge of the graph: its two arcs. The same edge again adds to them. */
static void add_edge(uint32_t u, uint32_t v, int64_t there, int64_t back)
{
    for (size_t i = 0; i < arc_count; i++) {
        if ((arcs[i].u == u && arcs[i].v == v) || (arcs[i].u == v && arcs[i].v == u)) {
            arcs[i].cost += arcs[i].u == u ? there : back;
            arcs[i ^ 1].cost += arcs[i].u == u ? back : there;
            return;
        }
    }
    assert_true(arc_count + 2 <= ARCS);
    arcs[arc_count++] = (arc){u, v, there};
    arcs[arc_count++] = (arc){v, u, back};
}

/* The vertex at a threshold: the first label left from it on. */
static uint32_t vertex(uint32_t p, uint32_t threshold)
{
    uint32_t i = 0;
    while (i < d.size[p] && d.label[p][i] < threshold) {
        i++;
    }
    return d.group[p] + i;
}

static void graph(uint32_t source)
{
    for (uint32_t p = 0; p < d.sites; p++) {
        for (uint32_t i = 0; d.is_open[p] && i < d.size[p]; i++) {
            add_edge(d.group[p] + i, d.group[p] + i + 1, d.theta[p][d.label[p][i]], d.request->gap);
        }
    }
    for (size_t e = 0; e < d.edge_count; e++) {
        for (uint32_t i = 0; i <= d.labels; i++) {
            add_edge(vertex(d.edges[e].p, i), vertex(d.edges[e].q, i), d.edges[e].weight,
                     d.edges[e].weight);
        }
    }
    for (uint32_t p = 0; p < d.sites; p++) {
        if (d.is_open[p]) {
            uint32_t n = d.size[p];
            add_edge(source, d.group[p], d.theta[p][d.label[p][0]] + reach(p) + d.request->gap, 0);
            add_edge(d.group[p] + n, source + 1,
                     d.theta[p][d.label[p][n - 1]] + reach(p) + d.request->gap, 0);
        }
    }
}

/* Above the energy of the labelling of cheapest labels. */
static int64_t source_penalty(void)
{
    uint32_t best[TINY_SITES] = {0};
    int64_t energy = d.request->gap;
    for (uint32_t p = 0; p < d.sites; p++) {
        for (uint32_t i = 1; i < d.size[p]; i++) {
            best[p] = d.theta[p][d.label[p][i]] < d.theta[p][d.label[p][best[p]]] ? i : best[p];
        }
        energy += d.is_open[p] ? d.theta[p][d.label[p][best[p]]] : 0;
    }
    for (size_t e = 0; e < d.edge_count; e++) {
        uint32_t p = d.edges[e].p, q = d.edges[e].q;
        energy += d.edges[e].weight * V(d.label[p][best[p]], d.label[q][best[q]]);
    }
    return energy;
}

static void cuts(void)
{
    arc_count = 0;
    for (uint32_t p = 0; p < d.sites; p++) {
        d.group[p] = d.groups;
        for (uint32_t i = 0; d.is_open[p] && i <= d.size[p]; i++) {
            add_group(1, 0, 0);
        }
    }
    uint32_t source = add_group(1, 0, 0);
    add_group(1, 0, 0);
    int64_t M = source_penalty(), most = d.request->gap;
    d.offset += M;
    d.linear[source] -= M;
    d.linear[source + 1] += M;
    graph(source);
    for (size_t i = 0; i < arc_count; i++) {
        most = larger(most, arcs[i].cost + d.request->gap);
    }
    for (size_t i = 0; i < arc_count; i++) {
        uint32_t u = arcs[i].u, v = arcs[i].v;
        if (d.request->encoding == QS_ST_CUT) {
            d.linear[u] += arcs[i].cost;
            add_scalar(u, v, -arcs[i].cost);
            continue;
        }
        uint32_t z =
            add_group(1, 0, 0); /* most [y_u (1 - y_v) - 2 y_u z - 2 (1 - y_v) z + 3 z] + cost z */
        d.linear[u] += most;
        d.linear[z] += arcs[i].cost + most;
        add_scalar(u, v, -most);
        add_scalar(u, z, -2 * most);
        add_scalar(v, z, 2 * most);
    }
}

/* ---- Writing it. ---- */

typedef struct out {
    uint8_t *file;
    size_t at, chunk;
    uint32_t chunks;
} out;

static void put(out *o, uint64_t value, unsigned bytes)
{
    for (unsigned i = 0; i < bytes; i++) {
        assert_true(o->at < SLOW_FILE);
        o->file[o->at++] = (uint8_t)(value >> 8 * i);
    }
}

static void begin(out *o, const char *type)
{
    o->chunk = o->at;
    o->chunks++;
    memcpy(o->file + o->at, type, 4);
    memset(o->file + o->at + 4, 0, 12);
    o->at += 16;
}

static void end(out *o)
{
    qs_store_u64(o->file + o->chunk + 8, o->at - o->chunk - 16);
    put(o, qs_crc32c_portable(0, o->file + o->chunk, o->at - o->chunk), 4);
}

static void put_groups(out *o)
{
    begin(o, "GRPS");
    for (uint32_t g = 0, next; g < d.groups; g = next) {
        for (next = g + 1; next < d.groups && d.group_size[next] == d.group_size[g]; next++) {
        }
        put(o, next - g, 4);
        put(o, d.group_size[g], 4);
    }
    end(o);
}

static void put_couplings(out *o)
{
    begin(o, "BLKS");
    put(o, d.coupling_count, 4);
    for (size_t i = 0; i < d.coupling_count; i++) {
        const coupling *c = &d.couplings[i];
        put(o, c->rows, 4);
        put(o, c->columns, 4);
        put(o, 0, 4);
        for (uint32_t j = 0; j < c->rows * c->columns; j++) {
            put(o, (uint32_t)c->table[j], 4);
        }
    }
    end(o);
    begin(o, "CPLS");
    put(o, d.coupling_count, 4);
    for (size_t i = 0; i < d.coupling_count; i++) {
        const coupling *c = &d.couplings[i];
        uint32_t head[9] = {(uint32_t)i, 1, 4, 0, 0, 0, 1, 1, 0};
        for (int j = 0; j < 9; j++) {
            put(o, head[j], 4);
        }
        put(o, c->g, 4);
        put(o, c->h, 4);
        put(o, (uint32_t)c->weight, 4);
    }
    end(o);
}

static void put_terms(out *o)
{
    uint32_t variables = d.first[d.groups];
    int64_t base = 0, most = 0;
    for (uint32_t i = 0; i < variables; i++) {
        base = d.linear[i] < base ? d.linear[i] : base;
    }
    begin(o, "LINR");
    put(o, (uint64_t)base, 8);
    put(o, 8, 4);
    put(o, 0, 4);
    for (uint32_t i = 0; i < variables; i++) {
        put(o, (uint64_t)(d.linear[i] - base), 8);
    }
    end(o);
    for (uint32_t g = 0; g < d.groups; g++) {
        most = larger(most, larger(d.a[g], d.b[g]));
    }
    unsigned bytes = qs_bytes_of((uint64_t)most);
    begin(o, "PNLT");
    put(o, bytes, 4);
    put(o, 0, 4);
    for (uint32_t g = 0, next; g < d.groups; g = next) {
        for (next = g + 1; next < d.groups && d.a[next] == d.a[g] && d.b[next] == d.b[g]; next++) {
        }
        put(o, next - g, 4);
        put(o, (uint64_t)d.a[g], bytes);
        put(o, (uint64_t)d.b[g], bytes);
    }
    end(o);
    begin(o, "OFFS");
    put(o, (uint64_t)d.offset, 8);
    end(o);
}

static void put_bits(out *o, const bool *bits, uint32_t count)
{
    for (uint32_t at = 0; at < count; at += 8) {
        uint8_t byte = 0;
        for (uint32_t i = at; i < count && i < at + 8; i++) {
            byte |= (uint8_t)(bits[i] << (i - at));
        }
        put(o, byte, 1);
    }
}

static void put_labl(out *o)
{
    const qs_problem *problem = d.request->problem;
    const qs_grid *grid = &problem->grid;
    uint32_t cells = grid->width * grid->height;
    bool truncates = problem->pairwise.smoothness == QS_TRUNCATED_LINEAR ||
                     problem->pairwise.smoothness == QS_TRUNCATED_QUADRATIC;
    uint32_t fields[16] = {d.request->encoding,
                           problem->pairwise.smoothness,
                           truncates ? problem->pairwise.truncation : 0,
                           d.labels,
                           problem->scale,
                           d.request->penalty,
                           (uint32_t)d.request->gap,
                           UINT32_MAX,
                           grid->width,
                           cells ? grid->height : 0,
                           grid->width,
                           cells ? grid->height : 0,
                           0,
                           0,
                           0,
                           grid->mask != NULL};
    begin(o, "labl");
    for (int i = 0; i < 16; i++) {
        put(o, fields[i], 4);
    }
    bool mask[TINY_SITES] = {false};
    for (uint32_t c = 0; grid->mask && c < cells; c++) {
        mask[c] = grid->mask[c] != 0;
    }
    put_bits(o, mask, grid->mask ? cells : 0);
    end(o);
}

static void put_kept(out *o)
{
    bool all = true;
    for (uint32_t p = 0; p < d.sites; p++) {
        all = all && d.is_open[p] && d.size[p] == d.labels;
    }
    if (all && d.request->encoding <= QS_ONE_HOT_SPARSE) {
        return;
    }
    begin(o, "kept");
    put(o, d.sites, 4);
    put(o, all ? 0 : 1, 4);
    for (uint32_t p = 0; !all && p < d.sites; p++) {
        put(o, d.is_open[p] ? UINT8_MAX : d.label[p][0], 1);
    }
    for (uint32_t p = 0; !all && p < d.sites; p++) {
        put_bits(o, d.request->kept[p], d.is_open[p] ? d.labels : 0);
    }
    end(o);
}

static void put_trnc(out *o)
{
    bool any = false;
    for (uint32_t p = 0; p < d.sites; p++) {
        for (uint32_t i = 0; i < d.size[p]; i++) {
            any = any || (d.is_open[p] && d.cut[p][d.label[p][i]] > 0);
        }
    }
    if (!any) {
        return;
    }
    begin(o, "trnc");
    put(o, 4, 4);
    put(o, 0, 4);
    for (uint32_t p = 0; p < d.sites; p++) {
        for (uint32_t i = 0; d.is_open[p] && i < d.size[p]; i++) {
            put(o, (uint64_t)d.cut[p][d.label[p][i]], 4);
        }
    }
    end(o);
}

/* Labels are numbered among those of the site that are left. */
static void put_best(out *o)
{
    const slow_request *request = d.request;
    if (!request->best) {
        return;
    }
    begin(o, "best");
    put(o, (uint64_t)request->lower_bound, 8);
    put(o, 1, 4);
    put(o, 0, 4);
    for (uint32_t p = 0; p < d.sites; p++) {
        uint32_t number = 0;
        for (uint32_t label = 0; label < request->best[p]; label++) {
            number += request->kept[p][label];
        }
        put(o, number, d.is_open[p] ? 1 : 0);
    }
    end(o);
}

void slow_write(const slow_request *request, slow_qubo *q)
{
    reduce(request);
    if (d.open > 0) {
        switch (request->encoding) {
        case QS_DOMAIN_WALL: walls(); break;
        case QS_MULTIWAY_CUT: multiway(); break;
        case QS_ST_CUT:
        case QS_ST_CUT_ARCS: cuts(); break;
        default:
            one_hot_groups();
            one_hot_edges();
            break;
        }
    }
    out o = {q->file, 64, 0, 0};
    put_groups(&o);
    put_couplings(&o);
    put_terms(&o);
    put_labl(&o);
    put_kept(&o);
    put_trnc(&o);
    put_best(&o);
    memset(q->file, 0, 64);
    memcpy(q->file, "\x89QCF\r\n\x1a\n", 8);
    qs_store_u32(q->file + 8, 1);
    qs_store_u32(q->file + 12, o.chunks);
    qs_store_u64(q->file + 16, o.at);
    qs_store_u32(q->file + 24, d.first[d.groups]);
    qs_store_u32(q->file + 28, d.groups);
    qs_store_u64(q->file + 32, d.coupling_count);
    qs_store_u32(q->file + 60, qs_crc32c_portable(0, q->file, 60));
    q->size = o.at;
}

void slow_encode(const slow_request *request, slow_qubo *q)
{
    slow_write(request, q);
    slow_open(q);
}

void slow_open(slow_qubo *q)
{
    assert_int_equal(qs_qubo_open(q->file, q->size, SLOW_INDEX, &q->qubo, NULL), QS_OK);
    assert_int_equal(qs_index_build(&q->qubo, q->memory, qs_index_workspace(&q->qubo), &q->index),
                     QS_OK);
}

/* ---- Labellings. ---- */

int64_t slow_energy(const qs_problem *problem, const uint16_t *labelling)
{
    int64_t energy;
    assert_int_equal(qs_problem_energy(problem, labelling, NULL, 0, &energy), QS_OK);
    return energy;
}

static uint16_t next_kept(const slow_request *request, uint32_t site, uint32_t label)
{
    while (label < request->problem->labels && !request->kept[site][label]) {
        label++;
    }
    return (uint16_t)label;
}

void slow_first(const slow_request *request, uint16_t *labelling)
{
    for (uint32_t p = 0; p < qs_problem_sites(request->problem); p++) {
        labelling[p] = next_kept(request, p, 0);
    }
}

bool slow_next(const slow_request *request, uint16_t *labelling)
{
    for (uint32_t p = 0; p < qs_problem_sites(request->problem); p++) {
        labelling[p] = next_kept(request, p, labelling[p] + 1u);
        if (labelling[p] < request->problem->labels) {
            return true;
        }
        labelling[p] = next_kept(request, p, 0);
    }
    return false;
}

bool slow_is_kept(const qs_model *model, uint32_t site, uint32_t label)
{
    return !model->kept || model->kept[site * model->labels + label];
}

void slow_random_labels(const qs_model *model, uint64_t *state, uint16_t *labelling)
{
    for (uint32_t p = 0; p < model->sites; p++) {
        do {
            labelling[p] = (uint16_t)tiny_random(state, model->labels);
        } while (!slow_is_kept(model, p, labelling[p]));
    }
}
