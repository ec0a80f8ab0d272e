/* Branch and bound over a small problem (tables.h), with elimination (bucket.h) for what is left
 * where that is narrow enough. */
#ifndef QS_BRANCH_H
#define QS_BRANCH_H

#include "bucket.h"

enum { QS_BRANCH_LEVELS = 64 };

/* Its caller fills in what comes before `level`. */
typedef struct qs_branch {
    const qs_tables *t;
    int64_t unit; /* S: S F of every labelling is a multiple of it */
    int64_t best; /* S F of the best labelling known */
    uint32_t *labels; /* that labelling; out: a better one */
    qs_table_costs level[QS_BRANCH_LEVELS]; /* 0 = the problem; the caller fills in its costs */
    uint32_t levels; /* that there is memory for */
    qs_table_costs trial;
    qs_bucket bucket;
    uint32_t *found; /* a labelling */
    int64_t *score; /* of each node: how far the bound rose at the last trial with it */
} qs_branch;

/* Takes memory, for so many levels, and for so many numbers in the tables of an elimination. t is
 * set. */
void qs_branch_take(qs_branch *b, uint32_t levels, size_t cells, qs_arena *arena);

/* Takes out labels at level 0 with which no labelling is as good as the best one known; labels of
 * labellings as good as that one stay. Finds them by passes over the problem, and over the problem
 * with one label fixed.
 *
 * work  less by the numbers looked at; it ends when that is used up */
void qs_branch_probe(qs_branch *b, qs_allowance *work);

/* Finds the least S F by elimination alone. Returns false if there is no room for its tables. */
bool qs_branch_eliminate(qs_branch *b, qs_allowance *work);

/* Searches for better labellings than the best one known. Returns the bound: no labelling has S F
 * below it. It is equal to `best` when the search has come to its end. */
int64_t qs_branch_search(qs_branch *b, qs_allowance *work);

#endif
