#include "cut_levels.h"

#include <string.h>

#include "../base/arena.h"
#include "../base/minmax.h"
#include "../base/simd.h"
#include "../model/edge_value.h"
#include "../model/neighbours.h"
#include "flow_split.h"
#include "min_cut.h"
#include "progress.h"
#include "trws.h"

#define RANGE                                                                                      \
    ((int64_t)(QS_NUMBER_MAX / 2 + 1)) /* of an excess, whatever flows, and of capacities */

enum { FINEST = 12, PASSES = 20, LABEL_EVERY = 5 };

/* Levels i of an edge's first site and j of its second that gain by being 1 together. */
typedef struct product {
    uint32_t i, j;
    int64_t gain; /* minus the mixed second difference of V: above 0. 0 = each edge has a table,
                     and load_product finds it */
} product;

typedef struct levels {
    const qs_model *model;
    const qs_solve_options *options;
    qs_solution *solution;
    qs_reporter reporter; /* of the solution, in these looks: */
    qs_look look;
    uint32_t count; /* of levels */
    bool layered; /* products join equal levels of a grid: the graph is a grid for each level */
    qs_cut cut;
    qs_cut_node *padded; /* cut.node with the nodes around it */
    product *products;
    size_t product_count;
    uint32_t *start, *sister; /* of the graph, if it is not layered */
    qs_link *links;
    /* Messages go before the flow: NULL = none do. */
    qs_number *messages, *scratch;
    qs_scale scale; /* of all costs, so that what the messages say is a flow */
    qs_flow_split split;
    int64_t base; /* F where each site has label 0, scaled, less the model's constant */
} levels;

/* ---- The products. ---- */

/* Without tables the edge may be any. */
static int64_t gain_of(const qs_model *model, uint32_t edge, uint32_t i, uint32_t j)
{
    return qs_edge_value(model, edge, i + 1, j) + qs_edge_value(model, edge, i, j + 1) -
           qs_edge_value(model, edge, i, j) - qs_edge_value(model, edge, i + 1, j + 1);
}

/* The next product from levels i, j on. Linear costs have products on the diagonal only. */
static bool next_product(const qs_model *model, product *next)
{
    bool diagonal = model->pairwise.smoothness == QS_TRUNCATED_LINEAR;
    uint32_t count = model->labels - 1;
    if (model->tables) { /* of two labels: there is one level */
        next->gain = 0;
        return next->j == 0;
    }
    for (; next->i < count; next->i++, next->j = 0) {
        next->j = diagonal ? qs_max_u32(next->i, next->j) : next->j;
        for (; next->j < (diagonal ? next->i + 1 : count); next->j++) {
            next->gain = gain_of(model, 0, next->i, next->j);
            if (next->gain != 0) {
                return true;
            }
        }
    }
    return false;
}

static uint64_t count_products(const qs_model *model, bool *diagonal)
{
    uint64_t count = 0;
    *diagonal = true;
    for (product next = {0}; next_product(model, &next); next.j++) {
        count++;
        *diagonal = *diagonal && next.i == next.j;
    }
    return count;
}

/* ---- Memory. ---- */

static uint64_t count_edges(const qs_model *model)
{
    uint64_t edges = 0;
    qs_edge_seen edge;
    for (uint32_t p = 0; p < model->sites; p++) {
        for (uint32_t at = 0; qs_see_edge(model, p, at, &edge); at++) {
            edges += edge.first && edge.weight > 0;
        }
    }
    return edges;
}

/* Messages of linear costs are flows (take_message). With few labels the flow alone is faster. */
bool qs_levels_send(const qs_model *model)
{
    return model->width > 0 && model->labels > 3 &&
           model->pairwise.smoothness == QS_TRUNCATED_LINEAR;
}

static size_t lay_out(levels *l, const qs_model *model, void *workspace)
{
    qs_arena arena = {.base = workspace};
    bool diagonal;
    uint64_t products = count_products(model, &diagonal);
    l->model = model;
    l->count = model->labels - 1;
    l->layered = diagonal && model->width > 0;
    l->product_count = (size_t)products;
    uint64_t nodes = (uint64_t)model->sites * l->count, arcs = 6 * nodes;
    if (!l->layered) {
        uint64_t edges = count_edges(model);
        if (products > 0 && edges > UINT32_MAX / 2 / products) {
            return SIZE_MAX;
        }
        arcs = 2 * nodes + 2 * edges * products;
    }
    if (nodes >= QS_CUT_ORPHAN || (!l->layered && arcs > UINT32_MAX)) {
        return SIZE_MAX;
    }
    uint64_t around = l->layered ? 2 * (uint64_t)model->sites : 0;
    l->padded = qs_arena_take(&arena, nodes + around, sizeof *l->padded);
    l->cut.excess = qs_arena_take(&arena, nodes, sizeof *l->cut.excess);
    l->cut.residual = qs_arena_take(&arena, arcs, sizeof *l->cut.residual);
    l->cut.queue = qs_arena_take(&arena, nodes, sizeof *l->cut.queue);
    l->cut.orphan = qs_arena_take(&arena, nodes, sizeof *l->cut.orphan);
    l->products = qs_arena_take(&arena, products, sizeof *l->products);
    bool sends = qs_levels_send(model);
    l->messages = qs_arena_take(
        &arena, sends ? qs_trws_padding(model) + qs_trws_messages(model) : 0, sizeof *l->messages);
    l->scratch = qs_arena_take(&arena, sends ? qs_trws_scratch(model) : 0, sizeof *l->scratch);
    l->start = qs_arena_take(&arena, l->layered ? 0 : nodes + 1, sizeof *l->start);
    l->sister = qs_arena_take(&arena, l->layered ? 0 : arcs, sizeof *l->sister);
    l->links = qs_arena_take(&arena, l->layered ? 0 : arcs, sizeof *l->links);
    qs_flow_split_take(&l->split, model, &arena);
    return qs_arena_size(&arena);
}

size_t qs_levels_workspace(const qs_model *model)
{
    levels l;
    return lay_out(&l, model, NULL);
}

static uint32_t node_of(const levels *l, uint32_t level, uint32_t site)
{
    return level * l->model->sites + site;
}

/* ---- Range. ---- */

/* largest_sum where each edge has a table of two labels: two entries of it at most. */
static int64_t largest_of_tables(const qs_model *model)
{
    int64_t largest = 0;
    qs_edge_seen edge;
    for (uint32_t p = 0; p < model->sites; p++) {
        for (uint32_t at = 0; qs_see_edge(model, p, at, &edge); at++) {
            if (edge.weight > 0) {
                largest = qs_max_i64(largest, 2 * qs_edge_most(model, edge.edge));
            }
        }
    }
    return largest;
}

/* The most that one level of an edge of weight 1 has in capacities, or in what V adds to its
 * excess. */
static int64_t largest_sum(const qs_model *model)
{
    uint32_t last = model->labels - 1, row = 0;
    int64_t largest = 0, sum = 0;
    if (model->tables) {
        return largest_of_tables(model);
    }
    for (product next = {0}; next_product(model, &next); next.j++) { /* row by row */
        sum = next.i == row ? sum + next.gain : next.gain;
        row = next.i;
        largest = qs_max_i64(largest, sum);
    }
    for (uint32_t j = 0; j < last; j++) { /* columns: they telescope */
        int64_t low = qs_model_pairwise(model, 0, j + 1) - qs_model_pairwise(model, 0, j);
        int64_t high = qs_model_pairwise(model, last, j + 1) - qs_model_pairwise(model, last, j);
        largest = qs_max_i64(largest, low - high);
        largest = qs_max_i64(largest, low > 0 ? low : -low);
        int64_t other = qs_model_pairwise(model, j + 1, 0) - qs_model_pairwise(model, j, 0);
        largest = qs_max_i64(largest, other > 0 ? other : -other);
    }
    return largest;
}

/* What a level at 1 above one at 0 costs: more than everything else at the site can gain by it.
 * RANGE where the costs are too large. */
static int64_t wall_of(const qs_model *model, qs_scale scale, uint32_t site, int64_t largest)
{
    int64_t weights = 0, unary = 0, count = qs_max_i64(1, model->labels - 1);
    int64_t most = RANGE / 4 / count; /* of each level */
    qs_edge_seen edge;
    for (uint32_t at = 0; qs_see_edge(model, site, at, &edge); at++) {
        weights += qs_scaled_weight(scale, edge.weight);
    }
    for (uint32_t a = 0; a < model->labels; a++) {
        size_t at = (size_t)site * model->labels + a;
        unary = qs_max_i64(unary, qs_scaled_cost(model, scale, at));
    }
    if (unary > most || (largest > 0 && weights > most / 3 / largest)) {
        return RANGE;
    }
    /* Of each level: its excess by unary costs, by V and by products, and the capacities. */
    return 1 + count * (unary + 3 * weights * largest);
}

static bool in_range(const qs_model *model, qs_scale scale, int64_t largest)
{
    for (uint32_t p = 0; p < model->sites; p++) {
        /* A level has two walls and, counted in them, an excess and capacities. */
        if (wall_of(model, scale, p, largest) >= RANGE / 4) {
            return false;
        }
    }
    return true;
}

/* Chooses the finest scale at which messages, if any are sent, and flow fit. Returns false if there
 * is none.
 *
 * sends  out: whether messages are sent */
static bool choose_scale(const qs_model *model, qs_scale *scale, bool *sends)
{
    int64_t largest = largest_sum(model);
    *sends = qs_levels_send(model) && qs_scale_choose(model, FINEST, scale);
    if (!*sends && (QS_BITS == 32 || !qs_scale_choose(model, 0, scale))) {
        *scale = (qs_scale){0, QS_NUMBER_MAX};
    }
    while (scale->shift > 0 && !in_range(model, *scale, largest)) {
        scale->shift--;
    }
    return in_range(model, *scale, largest);
}

bool qs_levels_fit(const qs_model *model)
{
    qs_scale scale;
    bool sends;
    return choose_scale(model, &scale, &sends);
}

/* ---- The graph. ---- */

/* Where the residual of the arc to the next or the previous level is; in a graph that to the
 * previous one comes first. */
static size_t arc_above(const levels *l, uint32_t node)
{
    return l->layered ? (size_t)QS_CUT_ABOVE * l->cut.nodes + node
                      : (size_t)l->start[node] + (node >= l->model->sites);
}

static size_t arc_below(const levels *l, uint32_t node)
{
    return l->layered ? (size_t)QS_CUT_BELOW * l->cut.nodes + node : l->start[node];
}

/* Adds the arcs between two nodes of a graph; the queue holds how many each has so far. */
static void add_arcs(levels *l, uint32_t from, uint32_t to, qs_number out, qs_number in)
{
    uint32_t there = l->start[from] + l->cut.queue[from]++;
    uint32_t back = l->start[to] + l->cut.queue[to]++;
    l->links[there].site = to;
    l->links[back].site = from;
    l->sister[there] = back;
    l->sister[back] = there;
    l->cut.residual[there] = out;
    l->cut.residual[back] = in;
}

/* An edge of sites p and q, p < q, in a graph: counts its arcs at start[node + 1]. */
static void count_arcs(const levels *l, uint32_t p, uint32_t q)
{
    for (size_t n = 0; n < l->product_count; n++) {
        l->start[node_of(l, l->products[n].i, p) + 1]++;
        l->start[node_of(l, l->products[n].j, q) + 1]++;
    }
}

/* The two arcs cost what the product does, less a half of it at each of its levels. */
static void load_product(levels *l, uint32_t p, const qs_edge_seen *edge, qs_number weight,
                         const product *gained)
{
    const qs_model *model = l->model;
    int64_t gain_of_edge = model->tables ? gain_of(model, edge->edge, 0, 0) : gained->gain;
    uint32_t from = node_of(l, gained->i, p), to = node_of(l, gained->j, edge->site);
    qs_number gain = (qs_number)(weight * gain_of_edge), in = gain / 2, out = gain - in;
    l->cut.excess[from] += out;
    l->cut.excess[to] += in;
    if (!l->layered) {
        add_arcs(l, from, to, out, in);
        return;
    }
    uint32_t way = qs_cut_way(edge);
    l->cut.residual[(size_t)way * l->cut.nodes + from] = out;
    l->cut.residual[(size_t)(way ^ 1) * l->cut.nodes + to] = in;
}

static void load_edge(levels *l, uint32_t p, const qs_edge_seen *seen, qs_number weight)
{
    const qs_model *model = l->model;
    uint32_t edge = seen->edge;
    l->base += weight * qs_edge_value(model, edge, 0, 0);
    for (uint32_t i = 0; i < l->count; i++) {
        l->cut.excess[node_of(l, i, p)] -=
            (qs_number)(weight *
                        (qs_edge_value(model, edge, i + 1, 0) - qs_edge_value(model, edge, i, 0)));
        l->cut.excess[node_of(l, i, seen->site)] -=
            (qs_number)(weight *
                        (qs_edge_value(model, edge, 0, i + 1) - qs_edge_value(model, edge, 0, i)));
    }
    for (size_t n = 0; n < l->product_count; n++) {
        load_product(l, p, seen, weight, &l->products[n]);
    }
}

/* Room for the arcs of each node: first those to the levels beside it, then those of the edges. */
static void make_room(levels *l)
{
    const qs_model *model = l->model;
    uint32_t nodes = l->cut.nodes;
    qs_edge_seen edge;
    memset(l->start, 0, sizeof *l->start * ((size_t)nodes + 1));
    memset(l->cut.queue, 0, sizeof *l->cut.queue * nodes);
    for (uint32_t v = 0; v < nodes; v++) {
        l->start[v + 1] = (uint32_t)(v >= model->sites) + (v < nodes - model->sites);
    }
    for (uint32_t p = 0; p < model->sites; p++) {
        for (uint32_t at = 0; qs_see_edge(model, p, at, &edge); at++) {
            if (edge.first && edge.weight > 0) {
                count_arcs(l, p, edge.site);
            }
        }
    }
    for (uint32_t v = 0; v < nodes; v++) {
        l->start[v + 1] += l->start[v];
    }
}

/* In loops that load a site at all levels: false if the watch stops them. */
static bool go_on(levels *l, uint32_t site)
{
    enum { LEVEL_WORK = 8 }; /* in numbers computed: levels lie far apart in memory */
    return qs_look_up(&l->look, LEVEL_WORK * (uint64_t)l->count * qs_edges_at(l->model, site));
}

static void load_walls(levels *l)
{
    const qs_model *model = l->model;
    int64_t largest = largest_sum(model);
    for (uint32_t p = 0; p < model->sites && go_on(l, p); p++) {
        qs_number wall = (qs_number)wall_of(model, l->scale, p, largest); /* in range */
        for (uint32_t v = p; v + model->sites < l->cut.nodes; v += model->sites) {
            if (l->layered) {
                l->cut.residual[arc_below(l, v + model->sites)] = wall;
            } else {
                add_arcs(l, v, v + model->sites, 0, wall);
            }
        }
    }
}

static qs_number cost_of(const levels *l, uint32_t site, uint32_t label)
{
    return qs_scaled_cost(l->model, l->scale, (size_t)site * l->model->labels + label);
}

static void load_costs(levels *l)
{
    const qs_model *model = l->model;
    l->base = 0;
    for (uint32_t p = 0; p < model->sites && go_on(l, p); p++) {
        l->base += cost_of(l, p, 0);
        for (uint32_t i = 0; i < l->count; i++) {
            l->cut.node[node_of(l, i, p)] = (qs_cut_node){.parent = QS_CUT_FREE};
            l->cut.excess[node_of(l, i, p)] = cost_of(l, p, i) - cost_of(l, p, i + 1);
        }
    }
}

static void load_edges(levels *l)
{
    const qs_model *model = l->model;
    qs_edge_seen edge;
    for (uint32_t p = 0; p < model->sites && go_on(l, p); p++) {
        for (uint32_t at = 0; qs_see_edge(model, p, at, &edge); at++) {
            if (edge.first && edge.weight > 0) {
                load_edge(l, p, &edge, qs_scaled_weight(l->scale, edge.weight));
            }
        }
    }
}

static void clear_nodes(levels *l)
{
    uint32_t around = l->layered ? l->model->sites : 0;
    size_t all = l->cut.nodes + 2 * (size_t)around;
    for (size_t i = 0; i < all && qs_look_at(&l->look, (uint32_t)i, 1); i++) {
        l->padded[i] = (qs_cut_node){.parent = QS_CUT_UNLOADED};
    }
}

/* Returns false if the watch stops it. */
static bool load(levels *l)
{
    clear_nodes(l);
    if (l->layered) {
        size_t all = sizeof *l->cut.residual * 6 * (size_t)l->cut.nodes;
        (void)qs_clear(&l->look, l->cut.residual, all);
    } else {
        make_room(l);
    }
    load_walls(l);
    load_costs(l);
    load_edges(l);
    return !l->look.stopped;
}

/* ---- The flow. ---- */

/* Sends flow between the levels of each site, from each excess to the nearest levels that have a
 * want. First all of it goes down, as far as there are wants. Then what is left goes back. */
static void settle_sites(levels *l)
{
    uint32_t sites = l->model->sites;
    qs_number *excess = l->cut.excess, *residual = l->cut.residual;
    for (uint32_t v = l->cut.nodes; v-- > sites;) {
        qs_number flow = qs_max_number(excess[v], 0);
        residual[arc_below(l, v)] -= flow;
        residual[arc_above(l, v - sites)] += flow;
        excess[v] -= flow;
        excess[v - sites] += flow;
    }
    for (uint32_t v = 0; v + sites < l->cut.nodes; v++) {
        qs_number back = qs_min_number(qs_max_number(excess[v], 0), residual[arc_above(l, v)]);
        residual[arc_above(l, v)] -= back;
        residual[arc_below(l, v + sites)] += back;
        excess[v] -= back;
        excess[v + sites] += back;
    }
}

/* Turns a message m of an edge from q back to p, p < q, into a flow. The message adds m(a) to the
 * cost of p and takes it from that of q. For level i of p this means an excess that is larger by
 * m(i) - m(i + 1): so much flows there from level i of q. With linear costs the arc always holds
 * that much. */
static void take_message(levels *l, const qs_number *message, uint32_t p, uint32_t way)
{
    size_t nodes = l->cut.nodes;
    uint32_t step = way == QS_CUT_RIGHT ? 1 : l->model->width;
    for (uint32_t i = 0; i < l->count; i++) {
        uint32_t to = node_of(l, i, p), from = to + step;
        qs_number *out = &l->cut.residual[way * nodes + to],
                  *in = &l->cut.residual[(way ^ 1) * nodes + from];
        qs_number flow = qs_max_number(qs_min_number(message[i] - message[i + 1], *in), -*out);
        *in -= flow;
        *out += flow;
        l->cut.excess[from] -= flow;
        l->cut.excess[to] += flow;
    }
}

/* What the messages say of the labels, where that is better: a stopped solver has it. */
static void take_messages_labelling(levels *l, const qs_trws_state *state, uint16_t *labelling)
{
    uint16_t *trial = (uint16_t *)l->cut.queue; /* not in use yet, and twice as long or more */
    qs_trws_grid_labels(state, false, trial);
    if (state->look->stopped) {
        return;
    }
    int64_t energy = qs_model_energy(l->model, trial);
    energy -= qs_take_kept_everywhere(l->model, trial);
    if (energy < l->solution->energy) {
        memcpy(labelling, trial, sizeof *trial * l->model->sites);
        l->solution->energy = energy;
    }
}

/* Sends messages as TRW-S does. Returns false if the watch stops it. */
static bool send_messages(levels *l, uint16_t *labelling)
{
    const qs_model *model = l->model;
    size_t padding = (size_t)qs_trws_padding(model);
    qs_trws_state state = {.model = model,
                           .scale = l->scale,
                           .messages = l->messages + padding,
                           .scratch = l->scratch,
                           .wide = qs_lanes_avx2(),
                           .look = &l->look};
    size_t numbers = padding + (size_t)qs_trws_messages(model);
    bool go = qs_clear(&l->look, l->messages, sizeof *l->messages * numbers);
    for (int i = 1; go && i <= PASSES; i++) {
        qs_trws_iterate(&state, 1);
        if (!l->look.stopped && (i == 1 || i % LABEL_EVERY == 0)) {
            take_messages_labelling(l, &state, labelling);
        }
        go = !l->look.stopped && qs_report_progress(l->options, l->solution);
    }
    return go;
}

/* What they come to is a flow that is nearly the maximum. */
static void take_messages(levels *l)
{
    const qs_model *model = l->model;
    size_t labels = model->labels;
    for (uint32_t p = 0; p < model->sites && go_on(l, p); p++) {
        const qs_number *own = l->messages + (size_t)qs_trws_padding(model) + 2 * labels * p;
        if (model->right[p] != 0) {
            take_message(l, own, p, QS_CUT_RIGHT);
        }
        if (model->down[p] != 0) {
            take_message(l, own + labels, p, QS_CUT_DOWN);
        }
    }
}

/* The flow so far: no labelling is lower than F at label 0 less what may still flow. */
static int64_t bound_of(const levels *l)
{
    int64_t bound = l->base, unit = (int64_t)1 << l->scale.shift;
    for (uint32_t v = 0; v < l->cut.nodes; v++) {
        bound -= qs_max_number(l->cut.excess[v], 0);
    }
    return l->model->constant + bound / unit + (bound % unit > 0);
}

static void begin(levels *l)
{
    const qs_model *model = l->model;
    uint32_t around = l->layered ? model->sites : 0;
    l->cut.nodes = model->sites * l->count;
    l->cut.node = l->padded + around;
    l->cut.width = l->layered ? model->width : 0;
    l->cut.layer = l->layered ? model->sites : 0;
    l->cut.start = l->start;
    l->cut.links = l->links;
    l->cut.sister = l->sister;
    l->cut.look = &l->look;
    size_t n = 0;
    for (product next = {0}; next_product(model, &next); next.j++) {
        l->products[n++] = next;
    }
}

/* The graph is loaded. */
static bool flow(levels *l)
{
    qs_cut_begin(&l->cut);
    if (l->messages) {
        take_messages(l);
    }
    settle_sites(l);
    if (!l->messages) {
        qs_cut_spread(&l->cut);
        settle_sites(l);
    }
    l->solution->lower_bound = bound_of(l);
    for (uint32_t v = 0; v < l->cut.nodes; v++) {
        if (l->cut.excess[v] > 0) {
            qs_cut_source(&l->cut, v);
        }
    }
    bool done =
        !l->look.stopped && qs_report_progress(l->options, l->solution) && qs_cut_run(&l->cut);
    l->solution->lower_bound = bound_of(l);
    return done;
}

/* ---- The flow as a split. ---- */

/* What the arc along edge `at` of a site still takes, from a node of the site to one of the other
 * site. No two edges join the same sites. The search ends at once with two labels: there a node of
 * a graph has its arcs in the order of its edges, without those of weight 0. */
static qs_number residual_to(const levels *l, uint32_t at, const qs_edge_seen *edge, uint32_t from,
                             uint32_t to)
{
    if (l->layered) {
        return l->cut.residual[(size_t)qs_cut_way(edge) * l->cut.nodes + from];
    }
    uint32_t first = l->start[from], last = l->start[from + 1] - 1,
             arc = qs_min_u32(first + at, last);
    while (l->links[arc].site != to) {
        arc = arc > first ? arc - 1 : last;
    }
    return l->cut.residual[arc];
}

/* An edge's excess at level i is what V rises by there while the other site has label 0, and what
 * the arcs of the level still take. */
static void take_level_excess(const void *context, uint32_t site, uint32_t at,
                              const qs_edge_seen *edge, int64_t *sum)
{
    const levels *l = context;
    const qs_model *model = l->model;
    int64_t weight = qs_scaled_weight(l->scale, edge->weight), all = 0;
    for (uint32_t i = 0; i < l->count; i++) {
        int64_t rise = edge->first ? qs_edge_value(model, edge->edge, i + 1, 0) -
                                         qs_edge_value(model, edge->edge, i, 0)
                                   : qs_edge_value(model, edge->edge, 0, i + 1) -
                                         qs_edge_value(model, edge->edge, 0, i);
        all -= weight * rise;
        for (size_t n = 0; n < l->product_count; n++) {
            const product *gained = &l->products[n];
            uint32_t own = edge->first ? gained->i : gained->j,
                     other = edge->first ? gained->j : gained->i;
            if (own == i) {
                all += residual_to(l, at, edge, node_of(l, i, site), node_of(l, other, edge->site));
            }
        }
        sum[i + 1] += all;
    }
}

/* A site's label is the number of its levels on the side of the source. */
static void take_labels(const levels *l, uint16_t *labelling)
{
    memset(labelling, 0, sizeof *labelling * l->model->sites);
    for (uint32_t i = 0; i < l->count; i++) {
        for (uint32_t p = 0; p < l->model->sites; p++) {
            labelling[p] =
                (uint16_t)(labelling[p] + qs_cut_in_tree(&l->cut.node[node_of(l, i, p)]));
        }
    }
}

qs_status qs_levels(const qs_model *model, const qs_solve_options *options, void *workspace,
                    uint16_t *labelling, qs_solution *solution)
{
    levels l = {.options = options, .solution = solution, .reporter = {options, solution}};
    l.look = (qs_look){.going = qs_report_now, .context = &l.reporter};
    (void)lay_out(&l, model, workspace);
    begin(&l);
    bool sends;
    if (!choose_scale(model, &l.scale, &sends)) {
        return QS_E_OVERFLOW;
    }
    l.messages = sends ? l.messages : NULL;
    (void)qs_take_kept_everywhere(model, labelling);
    *solution =
        (qs_solution){.energy = qs_model_energy(model, labelling), .lower_bound = QS_NO_BOUND};
    if ((l.messages && !send_messages(&l, labelling)) || !load(&l)) {
        qs_flow_split_none(model, options ? options->witness : NULL, labelling);
        return QS_OK;
    }
    if (flow(&l)) {
        take_labels(&l, labelling);
        solution->energy = qs_model_energy(model, labelling);
        solution->iterations = 1;
        (void)qs_report_progress(options, solution);
    }
    solution->converged = solution->energy == solution->lower_bound;
    qs_flow_split_tell(&l.split, options, l.scale.shift, labelling, take_level_excess, &l);
    return QS_OK;
}
