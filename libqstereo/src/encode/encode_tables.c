/* The couplings of a problem whose edges have tables of their own. Edges that cost nothing, of
 * weight 0 or with a table that is all 0, are left out. Of the others those one after another with
 * the same table share a block. Of a grid no run goes on over an edge that is left out, nor from
 * one row into the next. */
#ifndef QS_SMALL
#include <string.h>

#include "../base/minmax.h"
#include "../base/saturate.h"
#include "encoder.h"

/* A run of edges of a strip that have the same table: all that cost anything from place `from` to
 * before place `end`. */
typedef struct table_run {
    uint32_t from, end, count;
    const int32_t *table;
    bool is_new; /* the edge before it has another table */
    uint64_t table_sum, weight_sum;
    int32_t largest, weight; /* the largest weight, and the first */
    bool same; /* all weights are the same */
} table_run;

/* Goes over all runs of a problem. */
typedef struct walk {
    qs_encoder *e;
    qs_table_strip strip;
    bool has_strip, has_last;
    uint32_t at; /* the place in the strip behind the last run */
    uint32_t block; /* the number of the next block */
} walk;

static size_t entries_of(const qs_encoder *e)
{
    return (size_t)e->problem->labels * e->problem->labels;
}

static walk walk_first(const qs_encoder *e)
{
    return (walk){.e = (qs_encoder *)e, .strip = e->strip};
}

/* The edge at a place of the strip; of weight 0 where it costs nothing. */
static qs_table_edge edge_at(const walk *w, uint32_t at)
{
    qs_table_edge edge = qs_table_edge_at(&w->strip, at);
    size_t entries = entries_of(w->e), i = 0;
    while (edge.weight != 0 && i < entries && edge.table[i] == 0) {
        i++;
    }
    edge.weight = i == entries ? 0 : edge.weight;
    return edge;
}

static void add_edge(table_run *run, int32_t weight)
{
    if (run->count++ == 0) {
        run->weight = run->largest = weight;
        run->same = true;
    }
    run->same &= weight == run->weight;
    run->largest = qs_max_i32(run->largest, weight);
    run->weight_sum += (uint64_t)weight;
}

/* Takes edges into the run as long as they have its table. In a grid they also follow one
 * another. */
static void extend(const walk *w, table_run *run)
{
    size_t size = entries_of(w->e) * sizeof *run->table;
    bool list = w->e->problem->grid.width == 0;
    for (run->end = run->from; run->end < w->strip.count; run->end++) {
        qs_table_edge edge = edge_at(w, run->end);
        if (edge.weight == 0 && list) {
            continue;
        }
        if (edge.weight == 0 || memcmp(edge.table, run->table, size) != 0) {
            break;
        }
        add_edge(run, edge.weight);
    }
}

/* Moves to the next place with an edge that costs anything. Returns false after the last strip. */
static bool find_edge(walk *w)
{
    for (;;) {
        for (; w->has_strip && w->at < w->strip.count; w->at++) {
            if (edge_at(w, w->at).weight != 0) {
                return true;
            }
        }
        w->has_strip = qs_table_strip_next(&w->strip);
        w->at = 0;
        if (!w->has_strip) {
            return false;
        }
    }
}

static uint64_t sum_of(const qs_encoder *e, const int32_t *table)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < entries_of(e); i++) {
        qs_grow(&sum, 1, (uint64_t)qs_max_i32(table[i], 0));
    }
    return sum;
}

/* The next run. Returns false after the last. */
static bool next_run(walk *w, table_run *run)
{
    if (!find_edge(w)) {
        return false;
    }
    size_t size = entries_of(w->e) * sizeof *run->table;
    *run = (table_run){.from = w->at, .table = edge_at(w, w->at).table};
    run->is_new = !w->has_last || memcmp(w->e->last_table, run->table, size) != 0;
    run->table_sum = sum_of(w->e, run->table);
    memcpy(w->e->last_table, run->table, size);
    w->has_last = true;
    w->block += run->is_new;
    extend(w, run);
    w->at = run->end;
    return true;
}

static qs_run head_of(const walk *w, const table_run *run)
{
    qs_table_edge edge = edge_at(w, run->from);
    bool list = w->e->problem->grid.width == 0;
    return (qs_run){
        .block = w->block - 1,
        .is_list = list,
        .weight_bytes = run->same ? 0 : qs_weight_bytes((uint32_t)run->largest),
        .weight = run->same ? run->weight : 0,
        .first = list ? 0 : edge.first,
        .second = list ? 0 : edge.second,
        .count = run->count,
        .repeat = 1,
    };
}

/* ---- Planning. ---- */

/* Returns false if an entry is below 0. */
static bool survey_table(qs_encoder *e, const table_run *run)
{
    int32_t largest = 0;
    for (size_t i = 0; i < entries_of(e); i++) {
        if (run->table[i] < 0) {
            return false;
        }
        largest = qs_max_i32(largest, run->table[i]);
    }
    e->block_max = qs_max_i64(e->block_max, largest);
    qs_grow(&e->edge_sum, run->weight_sum, (uint64_t)largest);
    return true;
}

bool qs_plan_tables(qs_encoder *e)
{
    walk w = walk_first(e);
    for (table_run run; next_run(&w, &run);) {
        if (!survey_table(e, &run)) {
            return false;
        }
        e->weight_sum += run.weight_sum;
        qs_run head = head_of(&w, &run);
        e->qcf.runs++;
        e->qcf.runs_size += qs_run_size(&head);
        e->qcf.couplings += run.count;
        qs_grow(&e->magnitude, run.weight_sum, run.table_sum);
    }
    e->qcf.blocks = w.block;
    e->qcf.blocks_size = w.block * (QS_TABLE_HEAD + 4 * (uint64_t)entries_of(e));
    return true;
}

/* ---- Putting. ---- */

void qs_put_the_tables(qs_writer *writer, const qs_encoder *e)
{
    uint32_t labels = e->problem->labels;
    walk w = walk_first(e);
    for (table_run run; next_run(&w, &run);) {
        if (!run.is_new) {
            continue;
        }
        qs_put_table_head(writer, labels, labels);
        for (size_t i = 0; i < entries_of(e); i++) {
            qs_put_entry(writer, run.table[i]);
        }
    }
}

void qs_put_table_runs(qs_writer *writer, const qs_encoder *e)
{
    walk w = walk_first(e);
    for (table_run run; next_run(&w, &run);) {
        qs_run head = head_of(&w, &run);
        qs_put_run_head(writer, &head);
        for (uint32_t at = run.from; head.is_list && at < run.end; at++) {
            qs_table_edge edge = edge_at(&w, at);
            if (edge.weight != 0) {
                qs_put_pair(writer, edge.first, edge.second);
            }
        }
        for (uint32_t at = run.from; head.weight_bytes > 0 && at < run.end; at++) {
            int32_t weight = edge_at(&w, at).weight;
            if (weight != 0) {
                qs_put_unsigned(writer, (uint32_t)weight, head.weight_bytes);
            }
        }
    }
}

#else

/* A file in C is not empty. */
typedef int qs_no_tables_here;

#endif
