/* Where the gap of a grid sits, windows are cut out of it and searched.
 *
 * TRW-S may be at its end, and its bound still below the optimum. Mostly the gap is due to a few
 * spots. A window around each is made a problem of its own: the messages of the edges that lead out
 * of it become costs of their sites, and the edges themselves then cost nothing (docs/MATHS.md,
 * section 20). So the bounds of the windows and that of the rest make a bound of the whole, and a
 * search of a window may raise its bound up to its optimum. */
#ifndef QS_SPOTS_H
#define QS_SPOTS_H

#include "../solve/trws.h"
#include "label_sets.h"
#include "rectangle.h"
#include "window_search.h"

enum {
    QS_SPOTS = 32, /* windows at most */
    QS_SPOT_SIDE_LEAST = 24, /* cells of a side, */
    QS_SPOT_SIDE = 48 /* and at most */
};

/* Memory, of qs_spots_take. Messages of 32 bits only. */
typedef struct qs_spots {
    qs_model cut; /* the grid without the edges that lead out of windows; these are its costs, in
                     parts of a unit: */
    int32_t *unary, *right, *down;
    int64_t *base; /* of each site: what its costs are above those */
    int64_t *sums; /* of gaps: each of the cells to the left and above, in all */
    uint8_t *window; /* of each site left: the number of its window, from 1; 0 = none */
    int32_t *saved; /* messages of the edges that lead out */
    uint64_t *edges; /* their places among the messages */
    uint32_t saved_count, most_saved;
    qs_rectangle at[QS_SPOTS];
    int64_t value[QS_SPOTS]; /* bounds of the windows, */
    int64_t rise[QS_SPOTS]; /* and how far they are above those of the messages */
    uint32_t count;
} qs_spots;

/* Takes the memory. */
void qs_spots_take(qs_spots *s, const qs_model *model, qs_arena *arena);

/* What a call works with. */
typedef struct qs_spots_call {
    qs_elimination *e;
    qs_trws_state *state; /* between two iterations */
    uint32_t side; /* of windows */
    void *memory; /* at least that of marginals, aligned for any type */
    size_t size;
    int64_t *shares;
    qs_allowance *work;
} qs_spots_call;

/* Searches windows: first with their neighbours held, for a better labelling, and then cut out.
 * Takes out the labels that the bound then rules out: qs_eliminate_follow has to come next.
 * Messages go on a little.
 *
 * gap  out: how far the bound is below the energy of the labelling, in units, rounded down in each
 *      part
 * Returns false if there is nothing to search, or if it was stopped: then nothing has left. The
 * labelling may be better. */
bool qs_spots_take_out(qs_spots *s, const qs_spots_call *call, int64_t *gap);

#endif
