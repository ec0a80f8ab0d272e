/* The least energy of a part by search, for parts that are too wide for tables (exact.h): Russian
 * doll search (Verfaillie, Lemaitre and Schiex 1996) with costs of the sites looked at ahead.
 *
 * The sites stand in an order. A suffix of them, from site k on, is searched when all shorter ones
 * are known: sites get labels one by one, and a labelling of the first of them is given up if its
 * bound is not below the least energy of the suffix that is known. From the cost of each edge the
 * least one is taken away, so that edges cost nothing or more. Then with sites up to d labelled the
 * rest costs, for every t, at least
 *     - of each site from d to t, the least of its own costs and its edges to labelled sites, and
 *     - of those from t on, the least energy of that suffix, and the least of each site's edges to
 *       labelled sites. */
#ifndef QS_SEARCH_H
#define QS_SEARCH_H

#include "exact.h"

enum {
    QS_SEARCH_SITES = 256, /* of a part at most */
    QS_SEARCH_LABELS = 1 << 11, /* left to all of them */
    QS_SEARCH_EDGES = 1 << 15
};
/* Labellings that are looked at, each as often as its part has labels: of all of a certificate. */
#define QS_SEARCH_WORK ((uint64_t)1 << 27)

/* An edge to a site that stands later in the order. */
typedef struct qs_search_edge {
    uint32_t edge; /* its number in the problem */
    uint32_t to; /* the place of that site */
    int64_t least; /* that it costs */
} qs_search_edge;

typedef struct qs_search {
    qs_exact *part; /* its sites, in their order */
    int64_t *least; /* of the suffix from each place on, edges less their least; one more: 0 */
    int64_t edges_least; /* of all edges together */
    uint32_t *label_start, *edge_start; /* of each place, and one more */
    uint16_t *name; /* of each label that is left: its number at its site */
    int64_t *unary; /* of each of these labels, */
    int64_t *ahead; /* and what its edges to labelled sites cost */
    qs_search_edge *edge;
    uint32_t *label; /* of each place: the one that is being tried */
    int64_t *cost; /* of the sites before each place */
    uint64_t work; /* that is still allowed */
    bool ended; /* it was enough */
} qs_search;

/* Hands out the memory, or counts it. `part` is of the same problem. */
void qs_search_take(qs_search *search, qs_exact *part, qs_arena *arena);

/* Lays out the part whose sites the caller has filled in. Returns false if it is too large, or no
 * part. */
bool qs_search_lay(qs_search *search);

/* Finds the least energy of the suffix from a place on, if that is below least[place]; else leaves
 * this number. All later ones are right, or lower. Returns false if there is too much work. */
bool qs_search_suffix(qs_search *search, uint32_t place);

/* Puts the sites, QS_SEARCH_SITES at most, into an order that is mostly searched quickly: those
 * first whose labels are worth most (search_order.c). */
void qs_search_order(qs_search *search);

#endif
