#include "min_cut.h"

#include "../base/minmax.h"
#include "../base/simd.h"

/* The functions below are compiled three times: `ways`, the arcs of each node of a grid (0 = a
 * graph), is a constant wherever they are called. */
enum { GRAPH = 0, FLAT = 4, LAYERED = 6 };

enum {
    ARC_WORK = 4, /* what a look along an arc counts as, in numbers computed (qs_look_up) */
    BETWEEN = 1 << 16 /* how much of that is done without asking for the watch */
};

/* Where the residual of arc `a` of node `p` is. */
QS_KERNEL size_t index_of(const qs_cut *cut, uint32_t ways, uint32_t p, uint32_t a)
{
    return ways > 0 ? (size_t)a * cut->nodes + p : (size_t)cut->start[p] + a;
}

QS_KERNEL uint32_t arcs(const qs_cut *cut, uint32_t ways, uint32_t p)
{
    return ways > 0 ? ways : cut->start[p + 1] - cut->start[p];
}

/* The node at the other end of arc `a` of a node. In a grid it may lie outside; the nodes there
 * are in no tree. */
QS_KERNEL ptrdiff_t head(const qs_cut *cut, uint32_t ways, uint32_t node, uint32_t a)
{
    ptrdiff_t p = (ptrdiff_t)node;
    if (ways == GRAPH) {
        return (ptrdiff_t)cut->links[cut->start[node] + a].site;
    }
    ptrdiff_t step = a < QS_CUT_DOWN    ? 1
                     : a < QS_CUT_ABOVE ? (ptrdiff_t)cut->width
                                        : (ptrdiff_t)cut->layer;
    return a & 1 ? p - step : p + step;
}

/* Where the residual of the opposite arc is, from its head q back to p. */
QS_KERNEL size_t sister(const qs_cut *cut, uint32_t ways, uint32_t p, uint32_t a, uint32_t q)
{
    return ways > 0 ? (size_t)(a ^ 1) * cut->nodes + q : cut->sister[cut->start[p] + a];
}

/* The number of the opposite arc among those of q. */
QS_KERNEL uint32_t opposite(const qs_cut *cut, uint32_t ways, uint32_t p, uint32_t a, uint32_t q)
{
    return ways > 0 ? a ^ 1 : cut->sister[cut->start[p] + a] - cut->start[q];
}

QS_KERNEL void activate(qs_cut *cut, uint32_t p)
{
    qs_cut_node *node = &cut->node[p];
    if (!node->active) {
        size_t at = cut->queue_first + cut->queue_count++;
        node->active = 1;
        cut->queue[at < cut->nodes ? at : at - cut->nodes] = p;
    }
}

QS_KERNEL uint32_t next_active(qs_cut *cut)
{
    uint32_t p = cut->queue[cut->queue_first];
    cut->queue_first = cut->queue_first + 1 < cut->nodes ? cut->queue_first + 1 : 0;
    cut->queue_count--;
    cut->node[p].active = 0;
    return p;
}

QS_KERNEL void make_orphan(qs_cut *cut, uint32_t p)
{
    cut->node[p].parent = QS_CUT_ORPHAN;
    cut->orphan[cut->orphan_count++] = p;
}

/* Counts work. Returns false if the watch stops it. */
QS_KERNEL bool goes_on(qs_cut *cut, uint64_t work)
{
    cut->work += work;
    if (cut->work < BETWEEN) {
        return true;
    }
    work = cut->work;
    cut->work = 0;
    return qs_look_up(cut->look, work);
}

QS_KERNEL uint16_t farther(uint16_t distance)
{
    return (uint16_t)(distance + (distance < UINT16_MAX));
}

/* Pushes as much flow as the path from the root through p to q takes. q has a want. */
QS_KERNEL void augment(qs_cut *cut, uint32_t ways, uint32_t p, uint32_t a, uint32_t q)
{
    const qs_cut_node *node = cut->node;
    qs_number *residual = cut->residual, *excess = cut->excess;
    size_t last = index_of(cut, ways, p, a);
    qs_number most = residual[last] < -excess[q] ? residual[last] : -excess[q];
    uint32_t i = p;
    while (node[i].parent != QS_CUT_ROOT) {
        uint32_t up = (uint32_t)head(cut, ways, i, node[i].parent);
        qs_number r = residual[sister(cut, ways, i, node[i].parent, up)];
        most = r < most ? r : most;
        i = up;
    }
    most = excess[i] < most ? excess[i] : most;
    residual[last] -= most;
    residual[sister(cut, ways, p, a, q)] += most;
    excess[q] += most;
    i = p;
    while (node[i].parent != QS_CUT_ROOT) {
        uint32_t arc = node[i].parent, up = (uint32_t)head(cut, ways, i, arc);
        qs_number *r = &residual[sister(cut, ways, i, arc, up)];
        residual[index_of(cut, ways, i, arc)] += most;
        *r -= most;
        if (*r == 0) {
            make_orphan(cut, i);
        }
        i = up;
    }
    excess[i] -= most;
    if (excess[i] == 0) {
        make_orphan(cut, i);
    }
}

/* The distance of q from its root; UINT32_MAX if its path ends at an orphan. */
QS_KERNEL uint32_t origin(qs_cut *cut, uint32_t ways, uint32_t q)
{
    qs_cut_node *node = cut->node;
    uint32_t steps = 0, i = q;
    for (;; steps++) {
        if (node[i].stamp == cut->time) {
            steps += node[i].distance;
            break;
        }
        if (node[i].parent == QS_CUT_ORPHAN) {
            return UINT32_MAX;
        }
        if (node[i].parent == QS_CUT_ROOT) {
            node[i].stamp = cut->time;
            node[i].distance = 0;
            break;
        }
        i = (uint32_t)head(cut, ways, i, node[i].parent);
    }
    uint32_t distance = steps;
    for (i = q; node[i].stamp != cut->time; i = (uint32_t)head(cut, ways, i, node[i].parent)) {
        node[i].stamp = cut->time;
        node[i].distance = (uint16_t)(steps < UINT16_MAX ? steps : UINT16_MAX);
        steps--;
    }
    return distance;
}

/* No parent was found: p leaves the tree, its children become orphans, and nodes from which flow
 * could reach it are active again. */
QS_KERNEL void set_free(qs_cut *cut, uint32_t ways, uint32_t p)
{
    qs_cut_node *node = cut->node;
    node[p].parent = QS_CUT_FREE;
    for (uint32_t a = 0; a < arcs(cut, ways, p); a++) {
        ptrdiff_t to = head(cut, ways, p, a);
        if (!qs_cut_in_tree(&node[to])) {
            continue;
        }
        uint32_t q = (uint32_t)to;
        if (node[q].parent == opposite(cut, ways, p, a, q)) {
            make_orphan(cut, q);
        }
        if (cut->residual[sister(cut, ways, p, a, q)] > 0) {
            activate(cut, q);
        }
    }
}

/* Finds an orphan the parent that is nearest to a root. */
QS_KERNEL void adopt(qs_cut *cut, uint32_t ways, uint32_t p)
{
    qs_cut_node *node = cut->node;
    uint32_t nearest = UINT32_MAX, parent = 0;
    cut->work += ARC_WORK * (uint64_t)arcs(cut, ways, p);
    for (uint32_t a = 0; a < arcs(cut, ways, p); a++) {
        ptrdiff_t q = head(cut, ways, p, a);
        if (!qs_cut_in_tree(&node[q]) || node[q].parent == QS_CUT_ORPHAN ||
            cut->residual[sister(cut, ways, p, a, (uint32_t)q)] == 0) {
            continue;
        }
        uint32_t distance = origin(cut, ways, (uint32_t)q);
        if (distance < nearest) {
            nearest = distance;
            parent = a;
        }
    }
    if (nearest == UINT32_MAX) {
        set_free(cut, ways, p);
        return;
    }
    node[p].parent = parent;
    node[p].stamp = cut->time;
    node[p].distance = (uint16_t)(nearest + 1 < UINT16_MAX ? nearest + 1 : UINT16_MAX);
}

/* The counter is at its end: the tree starts again from its roots. */
static void restart(qs_cut *cut)
{
    cut->time = 0;
    for (uint32_t p = 0; p < cut->nodes; p++) {
        qs_cut_node *node = &cut->node[p];
        if (qs_cut_in_tree(node)) {
            node->parent = cut->excess[p] > 0 ? QS_CUT_ROOT : QS_CUT_FREE;
        }
        node->stamp = 0;
        node->distance = 0;
        if (node->parent == QS_CUT_ROOT) {
            activate(cut, p);
        }
    }
}

/* Adopts first the orphans of the path, from the root down, then their children as they come. No
 * node becomes an orphan twice, for the paths of adopted nodes are sound. */
QS_KERNEL void adopt_all(qs_cut *cut, uint32_t ways)
{
    cut->time++;
    for (size_t i = 0, j = cut->orphan_count; i + 1 < j; i++) {
        uint32_t orphan = cut->orphan[--j];
        cut->orphan[j] = cut->orphan[i];
        cut->orphan[i] = orphan;
    }
    for (size_t i = 0; i < cut->orphan_count; i++) {
        adopt(cut, ways, cut->orphan[i]);
    }
    cut->orphan_count = 0;
    if (cut->time == UINT32_MAX) {
        restart(cut);
    }
}

/* Looks along arc `a` of p, which is in the tree. The node there may have a want. Or it may
 * enter the tree. Or it is in the tree, and its way to a root gets shorter through p. */
QS_KERNEL void grow(qs_cut *cut, uint32_t ways, uint32_t p, uint32_t a)
{
    qs_cut_node *node = cut->node;
    const qs_number *residual = &cut->residual[index_of(cut, ways, p, a)], *excess = cut->excess;
    if (*residual == 0) {
        return;
    }
    uint32_t q = (uint32_t)head(cut, ways, p, a);
    if (node[q].parent == QS_CUT_UNLOADED) {
        cut->load(cut->context, q);
    }
    if (node[q].parent != QS_CUT_FREE) {
        if (node[q].parent < QS_CUT_ORPHAN && node[q].stamp <= node[p].stamp &&
            node[q].distance > farther(node[p].distance)) {
            node[q].parent = opposite(cut, ways, p, a, q);
            node[q].stamp = node[p].stamp;
            node[q].distance = farther(node[p].distance);
        }
        return;
    }
    while (excess[q] < 0 && node[q].parent == QS_CUT_FREE && *residual > 0 &&
           qs_cut_in_tree(&node[p])) {
        augment(cut, ways, p, a, q);
        adopt_all(cut, ways);
    }
    if (excess[q] == 0 && node[q].parent == QS_CUT_FREE && *residual > 0 &&
        qs_cut_in_tree(&node[p])) {
        node[q].parent = opposite(cut, ways, p, a, q);
        node[q].stamp = node[p].stamp;
        node[q].distance = farther(node[p].distance);
        activate(cut, q);
    }
}

QS_KERNEL bool run(qs_cut *cut, uint32_t ways)
{
    bool go = true;
    while (go && cut->queue_count > 0) {
        uint32_t p = next_active(cut);
        for (uint32_t a = 0; go && a < arcs(cut, ways, p) && qs_cut_in_tree(&cut->node[p]); a++) {
            grow(cut, ways, p, a);
            go = goes_on(cut, ARC_WORK);
        }
    }
    return go;
}

/* How much of a flow an edge takes. `most` below 0 is a flow in the other direction.
 *
 * in, out  the residuals of its two arcs */
QS_KERNEL qs_number clamp(qs_number most, qs_number in, qs_number out)
{
    return qs_max_number(qs_min_number(most, out), -in);
}

/* Shares the excess or want of p out to its later neighbours, or to its earlier ones. */
QS_KERNEL void spread_node(qs_cut *cut, uint32_t ways, uint32_t p, bool forward)
{
    uint32_t count = arcs(cut, ways, p), left = 0;
    cut->work += 2 * ARC_WORK * (uint64_t)count;
    for (uint32_t a = 0; a < count; a++) {
        left += (head(cut, ways, p, a) > (ptrdiff_t)p) == forward;
    }
    for (uint32_t a = 0; a < count; a++) {
        ptrdiff_t to = head(cut, ways, p, a);
        if ((to > (ptrdiff_t)p) == forward) {
            qs_number share = cut->excess[p] / (qs_number)left--;
            if (cut->node[to].parent != QS_CUT_UNLOADED) {
                uint32_t q = (uint32_t)to;
                qs_number *out = &cut->residual[index_of(cut, ways, p, a)],
                          *in = &cut->residual[sister(cut, ways, p, a, q)];
                qs_number flow = clamp(share, *in, *out);
                *out -= flow;
                *in += flow;
                cut->excess[p] -= flow;
                cut->excess[q] += flow;
            }
        }
    }
}

/* Along a row: half of what each node has goes to the next one. */
static void spread_along(qs_number *excess, qs_number *out, qs_number *in, uint32_t count,
                         ptrdiff_t step)
{
    qs_number flow = 0;
    for (uint32_t i = 1; i < count; i++, excess += step, out += step, in += step) {
        qs_number here = *excess + flow;
        flow = clamp(here / 2, in[step], *out);
        *out -= flow;
        in[step] += flow;
        *excess = here - flow;
    }
    *excess += flow;
}

/* All that is left of a row goes to the next row, as far as the edges take it. */
static void spread_across(qs_number *restrict excess, qs_number *restrict next,
                          qs_number *restrict out, qs_number *restrict in, uint32_t count)
{
    for (uint32_t x = 0; x < count; x++) {
        qs_number flow = clamp(excess[x], in[x], out[x]);
        excess[x] -= flow;
        next[x] += flow;
        out[x] -= flow;
        in[x] += flow;
    }
}

/* The rows of nodes begin .. end - 1, a grid or a layer of one. */
static void spread_rows(qs_cut *cut, size_t begin, size_t end)
{
    size_t width = cut->width, nodes = cut->nodes;
    qs_number *right = cut->residual, *left = right + nodes, *down = left + nodes,
              *up = down + nodes, *excess = cut->excess;
    for (size_t row = begin; row < end && goes_on(cut, ARC_WORK * width); row += width) {
        spread_along(excess + row, right + row, left + row, cut->width, 1);
        if (row + width < end) {
            spread_across(excess + row, excess + row + width, down + row, up + row + width,
                          cut->width);
        }
    }
    for (size_t row = end; row > begin && goes_on(cut, ARC_WORK * width); row -= width) {
        spread_along(excess + row - 1, left + row - 1, right + row - 1, cut->width, -1);
        if (row > begin + width) {
            size_t at = row - width;
            spread_across(excess + at, excess + at - width, up + at, down + at - width, cut->width);
        }
    }
}

static void spread_graph(qs_cut *cut)
{
    for (uint32_t p = 0; p < cut->nodes && goes_on(cut, 1); p++) {
        spread_node(cut, GRAPH, p, true);
    }
    for (uint32_t p = cut->nodes; p-- > 0 && goes_on(cut, 1);) {
        spread_node(cut, GRAPH, p, false);
    }
}

void qs_cut_spread(qs_cut *cut)
{
    for (int round = 0; round < 2; round++) { /* more cost more than they save */
        size_t layer = cut->layer > 0 ? cut->layer : cut->nodes;
        for (size_t begin = 0; cut->width > 0 && begin < cut->nodes; begin += layer) {
            spread_rows(cut, begin, begin + layer);
        }
        if (cut->width == 0) {
            spread_graph(cut);
        }
    }
}

QS_KERNEL void spread_some(qs_cut *cut, uint32_t ways, const uint32_t *list, uint32_t count)
{
    for (uint32_t i = 0; i < count && goes_on(cut, 1); i++) {
        spread_node(cut, ways, list[i], true);
    }
    for (uint32_t i = count; i-- > 0 && goes_on(cut, 1);) {
        spread_node(cut, ways, list[i], false);
    }
}

void qs_cut_spread_some(qs_cut *cut, const uint32_t *list, uint32_t count)
{
    if (cut->width > 0) {
        spread_some(cut, FLAT, list, count);
    } else {
        spread_some(cut, GRAPH, list, count);
    }
}

void qs_cut_begin(qs_cut *cut)
{
    cut->queue_first = 0;
    cut->queue_count = 0;
    cut->orphan_count = 0;
    cut->time = 0;
    cut->work = 0;
}

void qs_cut_source(qs_cut *cut, uint32_t node)
{
    cut->node[node].parent = QS_CUT_ROOT;
    activate(cut, node);
}

bool qs_cut_run(qs_cut *cut)
{
    if (cut->width == 0) {
        return run(cut, GRAPH);
    }
    return cut->layer > 0 ? run(cut, LAYERED) : run(cut, FLAT);
}
