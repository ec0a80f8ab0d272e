#include "merge.h"

#include "../base/minmax.h"
#include "../base/sets.h"
#include "../model/neighbours.h"

void qs_merger_take(qs_merger *merger, const qs_model *model, qs_arena *arena)
{
    merger->model = model;
    merger->part = qs_arena_take(arena, model->sites, sizeof *merger->part);
    merger->rise = qs_arena_take(arena, model->sites, sizeof *merger->rise);
}

/* Joins the parts of a site to those of its earlier neighbours. */
static void join_site(qs_merger *m, const uint16_t *x, const uint16_t *y, uint32_t p)
{
    qs_edge_seen edge;
    m->part[p] = p;
    m->rise[p] = 0;
    for (uint32_t at = 0; qs_see_edge(m->model, p, at, &edge); at++) {
        if (edge.weight > 0 && !edge.first && x[edge.site] != y[edge.site]) {
            qs_set_join(m->part, p, edge.site);
        }
    }
}

/* What F rises by if a site, and the neighbours that differ too, take the other label. An edge of
 * two such sites counts at the first one. */
static int64_t rise_at(const qs_model *model, const uint16_t *x, const uint16_t *y, uint32_t p)
{
    const int32_t *unary = model->unary + (size_t)p * model->labels;
    int64_t rise = (int64_t)unary[y[p]] - unary[x[p]];
    qs_edge_seen edge;
    for (uint32_t at = 0; qs_see_edge(model, p, at, &edge); at++) {
        uint32_t q = edge.site;
        if (edge.weight > 0 && (edge.first || x[q] == y[q])) {
            rise += qs_seen_cost(model, &edge, y[p], y[q]) - qs_seen_cost(model, &edge, x[p], x[q]);
        }
    }
    return rise;
}

int64_t qs_merge(qs_merger *m, const uint32_t *sites, uint32_t count, uint16_t *labelling,
                 const uint16_t *other)
{
    uint32_t all = sites ? count : m->model->sites;
    int64_t gain = 0;
    for (uint32_t i = 0; i < all; i++) {
        uint32_t p = sites ? sites[i] : i;
        if (labelling[p] != other[p]) {
            join_site(m, labelling, other, p);
        }
    }
    for (uint32_t i = 0; i < all; i++) {
        uint32_t p = sites ? sites[i] : i;
        if (labelling[p] != other[p]) {
            m->part[p] = qs_set_of(m->part, p);
            m->rise[m->part[p]] += rise_at(m->model, labelling, other, p);
        }
    }
    for (uint32_t i = 0; i < all; i++) {
        uint32_t p = sites ? sites[i] : i;
        if (labelling[p] != other[p] && m->rise[m->part[p]] <= 0) {
            gain -= m->part[p] == p ? m->rise[p] : 0;
            labelling[p] = other[p];
        }
    }
    return gain;
}
