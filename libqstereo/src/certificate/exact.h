/* The exact solution of parts of a problem, by elimination (docs/MATHS.md, section 19).
 *
 * The sites of a part are taken out one by one. The table of a site is over itself and the later
 * sites that it is joined to then; its least costs over the site's own labels are a table of the
 * others, and go to the table of the first of them. So the costs of all labellings of the part are
 * minimised, and a second pass, back, finds what each label costs at least. */
#ifndef QS_EXACT_H
#define QS_EXACT_H

#include "stated_problem.h"

enum {
    QS_EXACT_SITES = 4096, /* of a part at most */
    QS_EXACT_SIDES = 24, /* sites that a table may be over: more than 23 have too many costs */
    QS_EXACT_CELLS = 1 << 23, /* costs in all tables of a part */
    QS_EXACT_ALL_CELLS = 1 << 26 /* and of all parts of a certificate */
};

typedef struct qs_exact {
    qs_stated *stated;
    uint32_t *sites; /* of a part, in the order in which they are taken out */
    uint32_t count;
    uint32_t *place; /* of each site of the problem: 1 + its place in that order; 0 = not there */
    uint32_t *side; /* of each site of the part: the places that its table is over, rising. Its own
                       is the first. QS_EXACT_SIDES numbers */
    uint32_t *sides; /* how many */
    size_t *table_at; /* of each, and one more: where its table begins */
    int64_t *tables;
    int64_t *sent; /* at the half of that place: what the table has sent on, which is no more than
                      half as large */
    int64_t *one; /* a table for a moment */
    uint32_t *names; /* the labels left to two sites, most_labels each */
    uint64_t capacity; /* of the tables */
    int64_t value; /* what the part costs at least, edges and all */
} qs_exact;

/* Hands out the memory, or counts it. */
void qs_exact_take(qs_exact *exact, qs_stated *stated, qs_arena *arena);

/* Lays out the part of `sites` and `count`, which the caller has filled in. */
typedef enum qs_exact_laid {
    QS_EXACT_LAID,
    QS_EXACT_NO_PART, /* a site twice, a settled one, or an edge to a site outside */
    QS_EXACT_TOO_WIDE /* the tables are too large */
} qs_exact_laid;
qs_exact_laid qs_exact_lay(qs_exact *exact);

/* Gives each site its place, 1 for the first. Returns false if they are no part. Whatever it
 * returns, qs_exact_forget takes the places away. */
bool qs_exact_place(qs_exact *exact);
void qs_exact_forget(qs_exact *exact);

/* The number of costs in the tables of the part that is laid out. */
static inline uint64_t qs_exact_cells(const qs_exact *exact)
{
    return exact->table_at[exact->count];
}

/* Finds the value of the part. */
void qs_exact_solve(qs_exact *exact);

/* After that: settles the part. Labels that no labelling of this value has leave, the value goes to
 * the constant, and the sites and edges are no longer of the problem. */
void qs_exact_settle(qs_exact *exact);

/* Settles the part, whatever its labels: its value is a bound, and goes to the constant. */
void qs_exact_close(qs_exact *exact);

#endif
