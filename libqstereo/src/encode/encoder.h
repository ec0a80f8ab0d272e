/* What the parts of qs_encode share. Each part plans a chunk (its size, its share of the sum of all
 * absolute terms) and puts it, in one pass over the problem. */
#ifndef QS_ENCODER_H
#define QS_ENCODER_H

#include "../../include/qstereo/encode.h"
#include "../base/arena.h"
#include "../base/hidden.h"
#include "../problem/edge_tables.h"
#include "penalty.h"
#include "qcf_writer.h"

typedef struct qs_encoder {
    const qs_problem *problem;
    /* What is asked for. */
    qs_encoding encoding;
    qs_penalty penalty;
    uint64_t alpha, gap;
    /* The workspace. */
    int64_t *sums; /* of qs_reach_visit_all; problems without a grid only */
    int32_t *largest; /* of a table: the largest cost of each row, then of each column */
    void *costs; /* of the strips */
#ifndef QS_SMALL
    /* Of tables of edges: */
    qs_table_strip strip; /* before the first one */
    int32_t *last_table; /* of the edge before */
    uint64_t *reach; /* of qs_table_reach_all */
#endif
    /* The plan. */
    qs_qcf qcf;
    int64_t block_max; /* the largest pairwise cost */
    uint64_t block_sum; /* sum of the absolute entries of the block */
    uint64_t weight_sum; /* over all edges */
    uint64_t edge_sum; /* what all edges can cost, saturated */
    int64_t weight; /* of every edge; -1 = they differ; QS_WEIGHT_UNSEEN = there is no edge yet */
    uint64_t magnitude; /* M of docs/FORMAT.md without the offset, saturated */
    int64_t *offset; /* set when the linear terms have been put */
} qs_encoder;

enum { QS_WEIGHT_UNSEEN = -2 };

static inline bool qs_is_sparse(const qs_encoder *e)
{
    return e->encoding == QS_ONE_HOT_SPARSE;
}

static inline bool qs_has_table(const qs_encoder *e)
{
    return e->problem->pairwise.smoothness == QS_TABLE;
}

/* With QS_SMALL the encoder has no code for tables of edges, which is a quarter of the whole. */
static inline bool qs_has_tables(const qs_encoder *e)
{
#ifdef QS_SMALL
    (void)e;
    return false;
#else
    return e->problem->pairwise.smoothness == QS_TABLES;
#endif
}

/* The sum of the weights times the band of V: what one-hot-sparse puts into the offset, and 0 in
 * one-hot. Saturated above QS_ENERGY_MAX. */
uint64_t qs_band_sum(const qs_encoder *e);

/* The block, V or minus the band of one-hot-sparse, or the tables of the edges; and the couplings
 * by them. Returns false if a table has an entry below 0. */
bool qs_plan_couplings(qs_encoder *e);
QS_HIDDEN void qs_put_the_block(qs_writer *writer, const void *encoder);
QS_HIDDEN void qs_put_the_runs(qs_writer *writer, const void *encoder);

/* The same of tables of edges alone. */
bool qs_plan_tables(qs_encoder *e);
void qs_put_the_tables(qs_writer *writer, const qs_encoder *e);
void qs_put_table_runs(qs_writer *writer, const qs_encoder *e);

/* The linear terms, and the paper's alpha. Needs the couplings' plan. */
void qs_plan_costs(qs_encoder *e);
/* Puts them, and the offset into *offset: it is known only when all costs have been made. */
QS_HIDDEN void qs_put_the_costs(qs_writer *writer, const void *encoder);

/* The penalties. Needs the couplings' plan, and alpha. */
void qs_plan_penalties(qs_encoder *e);
QS_HIDDEN void qs_put_the_penalties(qs_writer *writer, const void *encoder);

#endif
