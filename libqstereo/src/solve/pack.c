#include "pack.h"

#include <string.h>

#include "../base/arena.h"
#include "../base/minmax.h"
#include "../base/sort.h"
#include "../model/neighbours.h"
#include "progress.h"

/* With label 0 everywhere the energy is some constant. Then taking site p (giving it label 1) costs
 * m_p, and two taken neighbours cost w_pq >= 0 more. A site with m_p >= 0 is never taken: what the
 * others can add is not below 0. So the rest falls into components, each solved by itself.
 *
 * Branch and bound: a site of least m is taken or left. If it is taken, each neighbour's m rises by
 * w. The bound is that of a cover by cliques in which w_pq >= -max(m_p, m_q) for all pairs: of such
 * a clique, with m_1 <= m_2 <= ..., taking any set costs
 *     sum m_i + sum w_ij  >=  m_1 + sum_{j > 1} (m_j + w_1j)  >=  m_1,
 * so that no set is better than its best site alone. (The bound by a colouring that is usual for
 * largest cliques: Tomita and Seki 2003, with weights.) */

enum { LEFT = 0, TAKEN = 1, UNDECIDED = 2 };
static const uint32_t none = UINT32_MAX;

/* A site that has been decided. */
typedef struct decision {
    uint32_t site;
    bool taken; /* it can still be left */
} decision;

typedef struct packer {
    const qs_model *model;
    const qs_solve_options *options;
    uint16_t *labelling; /* the best */
    qs_solution solution;
    bool stopped;
    int64_t *cost; /* sites: m, with what is taken */
    uint8_t *state; /* sites */
    uint8_t *best; /* sites: the best state of the component */
    uint32_t *member; /* sites: those of the component, by rising m at the start */
    uint32_t *seen; /* sites: the component that each is of, from 1; 0 = none yet */
    uint32_t *clique; /* sites: the clique of a site in the cover; none = it is in none */
    uint32_t *size, *met; /* of each clique: its sites, and how many of them a site meets */
    int64_t *least; /* of each clique: its least m */
    decision *path;
    uint32_t count; /* members */
} packer;

static size_t take_parts(packer *p, void *workspace)
{
    qs_arena arena = {.base = workspace};
    uint64_t sites = p->model->sites;
    p->cost = qs_arena_take(&arena, sites, sizeof *p->cost);
    p->least = qs_arena_take(&arena, sites, sizeof *p->least);
    p->path = qs_arena_take(&arena, sites, sizeof *p->path);
    p->member = qs_arena_take(&arena, sites, sizeof *p->member);
    p->seen = qs_arena_take(&arena, sites, sizeof *p->seen);
    p->clique = qs_arena_take(&arena, sites, sizeof *p->clique);
    p->size = qs_arena_take(&arena, sites, sizeof *p->size);
    p->met = qs_arena_take(&arena, sites, sizeof *p->met);
    p->state = qs_arena_take(&arena, sites, sizeof *p->state);
    p->best = qs_arena_take(&arena, sites, sizeof *p->best);
    return qs_arena_size(&arena);
}

size_t qs_pack_workspace(const qs_model *model)
{
    packer p = {.model = model};
    return take_parts(&p, NULL);
}

/* V(1, 1) + V(0, 0) - V(0, 1) - V(1, 0), without the weight. */
static int64_t excess(const qs_model *model)
{
    return qs_model_pairwise(model, 1, 1) + qs_model_pairwise(model, 0, 0) -
           qs_model_pairwise(model, 0, 1) - qs_model_pairwise(model, 1, 0);
}

bool qs_can_pack(const qs_model *model)
{
    return model->labels == 2 && model->pairwise.smoothness != QS_TABLES && excess(model) >= 0;
}

/* w of an edge. */
static int64_t both_cost(const packer *p, const qs_edge_seen *edge)
{
    return edge->weight == 0 ? 0 : edge->weight * excess(p->model);
}

/* m of a site while all others have label 0. */
static int64_t cost_alone(const qs_model *model, uint32_t site)
{
    const int32_t *unary = model->unary + (size_t)2 * site;
    int64_t cost = (int64_t)unary[1] - unary[0];
    qs_edge_seen edge;
    for (uint32_t at = 0; qs_see_edge(model, site, at, &edge); at++) {
        cost += qs_seen_cost(model, &edge, 1, 0) - qs_seen_cost(model, &edge, 0, 0);
    }
    return cost;
}

/* ---- a component ---- */

/* Numbers the sites of a component, beginning with one of them; they become the members. */
static void gather(packer *p, uint32_t from, uint32_t number)
{
    p->member[0] = from;
    p->count = 1;
    p->seen[from] = number;
    for (uint32_t done = 0; done < p->count; done++) {
        qs_edge_seen edge;
        for (uint32_t at = 0; qs_see_edge(p->model, p->member[done], at, &edge); at++) {
            if (both_cost(p, &edge) > 0 && p->cost[edge.site] < 0 && p->seen[edge.site] == 0) {
                p->seen[edge.site] = number;
                p->member[p->count++] = edge.site;
            }
        }
    }
}

static bool is_open(const packer *p, uint32_t site)
{
    return p->state[site] == UNDECIDED && p->cost[site] < 0;
}

/* Counts in `met` how many sites of each clique a site may not be taken with, or puts 0 there
 * again. */
static void meet(packer *p, uint32_t site, bool count)
{
    qs_edge_seen edge;
    for (uint32_t at = 0; qs_see_edge(p->model, site, at, &edge); at++) {
        int64_t both = both_cost(p, &edge);
        if (both == 0 || !is_open(p, edge.site) || p->clique[edge.site] == none) {
            continue;
        }
        uint32_t *met = &p->met[p->clique[edge.site]];
        bool apart = both >= -qs_max_i64(p->cost[site], p->cost[edge.site]);
        *met = count ? *met + apart : 0;
    }
}

/* The first clique that a site meets all of; `cliques`, a new one, if there is none. */
static uint32_t find_clique(packer *p, uint32_t site, uint32_t cliques)
{
    uint32_t found = cliques;
    meet(p, site, true);
    qs_edge_seen edge;
    for (uint32_t at = 0; qs_see_edge(p->model, site, at, &edge); at++) {
        uint32_t clique = is_open(p, edge.site) ? p->clique[edge.site] : none;
        if (clique != none && both_cost(p, &edge) > 0 && p->met[clique] == p->size[clique]) {
            found = qs_min_u32(found, clique);
        }
    }
    meet(p, site, false);
    return found;
}

/* The least that the open members can add. Returns in *next one of least m; none = none is open. */
static int64_t bound(packer *p, uint32_t *next)
{
    int64_t sum = 0, least = 0;
    uint32_t cliques = 0;
    *next = none;
    for (uint32_t i = 0; i < p->count; i++) {
        p->clique[p->member[i]] = none;
    }
    for (uint32_t i = 0; i < p->count; i++) {
        uint32_t site = p->member[i];
        if (!is_open(p, site)) {
            continue;
        }
        uint32_t clique = find_clique(p, site, cliques);
        if (clique == cliques) {
            p->size[cliques] = p->met[cliques] = 0;
            p->least[cliques++] = 0;
        }
        p->clique[site] = clique;
        p->size[clique]++;
        p->least[clique] = qs_min_i64(p->least[clique], p->cost[site]);
        *next = p->cost[site] < least ? site : *next;
        least = qs_min_i64(least, p->cost[site]);
    }
    for (uint32_t i = 0; i < cliques; i++) {
        sum += p->least[i];
    }
    return sum;
}

/* Takes a site (sign 1), or undoes that (sign -1). */
static void take(packer *p, uint32_t site, int sign)
{
    qs_edge_seen edge;
    for (uint32_t at = 0; qs_see_edge(p->model, site, at, &edge); at++) {
        p->cost[edge.site] += sign * both_cost(p, &edge);
    }
}

/* Goes back to the last site that was taken, and leaves it. Returns false if there is none. */
static bool leave_last(packer *p, uint32_t *depth, int64_t *value)
{
    while (*depth > 0) {
        decision *last = &p->path[*depth - 1];
        if (last->taken) {
            take(p, last->site, -1);
            *value -= p->cost[last->site];
            p->state[last->site] = LEFT;
            last->taken = false;
            return true;
        }
        p->state[last->site] = UNDECIDED;
        --*depth;
    }
    return false;
}

static bool goes_on(packer *p)
{
    p->solution.iterations++;
    p->stopped = !qs_report_progress(p->options, &p->solution) ||
                 qs_limit_reached(p->options, &p->solution, 0);
    return !p->stopped;
}

static void keep_best(packer *p)
{
    for (uint32_t i = 0; i < p->count; i++) {
        p->best[p->member[i]] = p->state[p->member[i]];
    }
}

/* Solves the component. Returns what its best sites cost; `lowest` is a bound of that. */
static int64_t search(packer *p, int64_t *lowest)
{
    int64_t best = 0, value = 0;
    uint32_t depth = 0;
    *lowest = INT64_MIN;
    keep_best(p);
    do {
        uint32_t next;
        int64_t rest = bound(p, &next);
        *lowest = *lowest == INT64_MIN ? rest : *lowest;
        if (value < best) {
            best = value;
            keep_best(p);
        }
        while (next != none && value + rest < best) {
            p->path[depth++] = (decision){next, true};
            p->state[next] = TAKEN;
            value += p->cost[next];
            take(p, next, 1);
            if (value < best) {
                best = value;
                keep_best(p);
            }
            rest = bound(p, &next);
        }
    } while (leave_last(p, &depth, &value) && goes_on(p));
    *lowest = p->stopped ? *lowest : best;
    return best;
}

/* ---- all of them ---- */

static void label_component(packer *p)
{
    for (uint32_t i = 0; i < p->count; i++) {
        p->labelling[p->member[i]] = p->best[p->member[i]] == TAKEN;
    }
}

static bool is_cheaper(const void *context, uint32_t a, uint32_t b)
{
    const packer *p = context;
    return p->cost[a] < p->cost[b];
}

static void solve(packer *p)
{
    uint32_t sites = p->model->sites, number = 0;
    int64_t bounds = p->solution.energy;
    for (uint32_t site = 0; site < sites; site++) {
        p->labelling[site] = 0;
        p->cost[site] = cost_alone(p->model, site);
        p->state[site] = UNDECIDED;
        p->seen[site] = 0;
        p->clique[site] = none;
        bounds += qs_min_i64(p->cost[site], 0);
    }
    p->solution.lower_bound = bounds;
    for (uint32_t site = 0; site < sites && !p->stopped; site++) {
        if (p->cost[site] >= 0 || p->seen[site] != 0) {
            continue;
        }
        int64_t lowest, before = 0;
        gather(p, site, ++number);
        for (uint32_t i = 0; i < p->count; i++) {
            before += p->cost[p->member[i]];
        }
        qs_sort(p->member, p->size, p->count, is_cheaper, p);
        p->solution.energy += search(p, &lowest);
        p->solution.lower_bound += lowest - before;
        label_component(p);
    }
}

qs_status qs_pack(const qs_model *model, const qs_solve_options *options, void *workspace,
                  size_t workspace_size, uint16_t *labelling, qs_solution *solution)
{
    if (!model || !workspace || !labelling || !solution) {
        return QS_E_ARGUMENT;
    }
    if (!qs_can_pack(model)) {
        return QS_E_ENCODING;
    }
    packer p = {.model = model, .options = options, .labelling = labelling};
    size_t size = take_parts(&p, workspace);
    if (size == SIZE_MAX || workspace_size < size) {
        return QS_E_WORKSPACE;
    }
    memset(labelling, 0, sizeof *labelling * model->sites);
    p.solution.energy = qs_model_energy(model, labelling);
    solve(&p);
    p.solution.energy -= model->kept ? qs_take_kept_everywhere(model, labelling) : 0;
    p.solution.converged = !p.stopped;
    *solution = p.solution;
    return QS_OK;
}
