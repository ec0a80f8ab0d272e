#include "reducer.h"

#include <string.h>

#include "../base/arena.h"
#include "../base/minmax.h"
#include "../base/random.h"
#include "../model/neighbours.h"
#include "../solve/flow_split.h"
#include "../solve/kicks.h"
#include "../solve/merge.h"
#include "../solve/messages_and_moves.h"
#include "../solve/trws_split.h"
#include "label_sets.h"
#include "hand_over.h"
#include "parts.h"
#include "probes.h"
#include "spots.h"
#include "windows.h"

enum {
    FIRST = 8, /* the first iteration to find marginals after */
    /* No marginal is above WIDEST times the largest cost: on its chains a label costs no more than
     * that above the others. So with a larger gap no label can leave. */
    WIDEST = 4,
    /* After the proof, marginals are found every BETWEEN iterations, and one iteration later for
     * each BETWEEN done before. */
    BETWEEN = 8,
    /* Where fewer than one site in FEW is left, passes go by the list of them; else two rows at
     * once. */
    FEW = 2,
    TRIALS = 256, /* labels that leave after a trial, at most: each takes a stage of a proof */
    NUMBERS_A_LABEL = 8, /* that two passes of messages look at */
    LEAST_WORK = 1 << 27, /* on parts that is allowed each time, */
    AT_ONCE = 1 << 28, /* and the most */
    SEARCH_SHARE = 4, /* a search for a labelling alone takes this part of it */
    /* Searches of spots look at so many times the numbers that messages do, and take about as long:
     * their memory is small. */
    SPOTS_TIMES = 6,
    FIRST_SPOT = 36, /* cells of a side */
    SPOT_STEP = 4, /* by which they get larger if work was left, else smaller */
    /* A round of kicks looks at as many numbers as an iteration of messages, and takes so many
     * times as long. */
    KICKS_SLOWER = 16,
    KICKS_WORK = 1 << 20, /* numbers that kicks may look at for each iteration */
    /* Windows of a grid are solved for the first time after the iteration FIRST_WINDOWS, and then
     * whenever half as many more have been done: squares of SIDE cells, at most ROUNDS times. Where
     * fewer than one site in MANY is left, parts and messages are quicker. */
    FIRST_WINDOWS = 256,
    MANY = 8,
    SIDE = 48,
    IN_VAIN = 4, /* rounds in turn that gain nothing before they end */
    ROUNDS = 12
};

/* A restart: where the bound stalls, messages begin anew on what is left of the problem, and often
 * get further. If they do not in due time, the old ones come back. */
typedef struct restart {
    int64_t bound; /* the best bound at iteration `since`, */
    uint64_t since;
    bool trying; /* the old messages are in the memory of the marginals */
    uint32_t failed; /* sites that were left when it was of no use last */
} restart;

enum {
    STALL = 128, /* iterations in which at least a STALL_PART-th of the gap must go */
    STALL_PART = 32,
    TRY = 256, /* iterations that a restart may take, or half of all so far */
    FEWER = 16 /* after a failure a FEWER-th of the sites must have gone */
};

/* The last gain: then the gap became smaller by a NO_GAIN-th, or a site was settled. When as many
 * iterations as had been done by then, and at least IDLE, have gained nothing more, nor have the
 * moves, windows and parts among them, which come whenever the iterations have doubled, there is no
 * more to come. */
typedef struct last_gain {
    int64_t gap;
    uint32_t left;
    uint64_t iterations;
    bool is_long_ago;
} last_gain;

enum { NO_GAIN = 1000, IDLE = 512 };

/* The guest of qs_messages_and_moves. */
typedef struct reducer {
    qs_elimination sets;
    const qs_reduce_options *options;
    qs_reduce_aim aim;
    uint64_t iterations, target; /* of the options */
    qs_natural *marginals; /* and the memory of parts: parts_size bytes */
    size_t parts_size;
    uint64_t work; /* what parts may still look at, */
    uint32_t trials; /* labels that may yet leave after a trial */
    uint64_t parts_at; /* and the iteration that it was counted at */
    int64_t *shares;
    void *others; /* workspace of qs_messages_and_moves */
    size_t others_size;
    uint16_t *trial; /* a labelling */
    qs_merger merger;
    qs_kicks kicks;
    uint64_t next_kicks; /* the iteration to search by kicks after */
    uint64_t random; /* what the places of windows are drawn with */
    int64_t windowed; /* the best energy when windows were done last */
    uint64_t next_windows; /* the iteration to solve windows after */
    qs_spots spots;
    uint64_t next_spots, spots_at; /* the iteration to search spots after, and the last one */
    uint64_t spots_work; /* numbers that this may still look at */
    uint32_t spots_side; /* of the windows */
    uint64_t next; /* without a target: the iteration to find marginals after */
    int64_t looked; /* the gap after that was done last, */
    uint64_t looked_at; /* and the iteration */
    bool stopped; /* by the watch, */
    qs_look look; /* in which what is no message is done */
    bool begun; /* the costs are the reduction's own, and labels may leave */
    restart again;
    last_gain gain;
    qs_reduction so_far;
} reducer;

static void count(reducer *r)
{
    r->so_far.undecided = r->sets.undecided;
    r->so_far.variables = r->sets.variables;
}

static bool tell(void *context, const qs_progress *progress)
{
    reducer *r = context;
    r->so_far.upper_bound = progress->energy;
    r->so_far.lower_bound = progress->lower_bound;
    r->so_far.iterations = progress->iteration;
    r->stopped = r->stopped || (r->options && r->options->watch &&
                                !r->options->watch(r->options->context, &r->so_far));
    return !r->stopped;
}

/* NULL = nobody asks for a proof. */
static const qs_witness *witness_of(const reducer *r)
{
    return r->options ? r->options->witness : NULL;
}

/* Whether no label can leave: no marginal is above the gap. */
static bool is_gap_too_wide(const qs_trws_state *state, const qs_solution *so_far)
{
    return (so_far->energy - so_far->lower_bound) / WIDEST > state->scale.most;
}

/* Returns true if it is time to find marginals: always at the end, unless only the answer counts;
 * before it only if a marginal can be above the gap. With a target then whenever the gap has
 * narrowed; without, ever less often. */
static bool is_due(reducer *r, const qs_trws_state *state, const qs_solution *so_far, bool stopped)
{
    int64_t gap = so_far->energy - so_far->lower_bound;
    bool answered = r->aim.answer && !witness_of(r);
    if (stopped) {
        return !answered && r->looked_at != so_far->iterations;
    }
    if (qs_is_proven(so_far)) {
        return !answered;
    }
    if (so_far->iterations >= r->iterations || r->gain.is_long_ago) {
        return true;
    }
    if (is_gap_too_wide(state, so_far)) {
        return false;
    }
    if (r->target > 0) {
        return gap < r->looked;
    }
    if (so_far->iterations < r->next) {
        return false;
    }
    r->next = 2 * so_far->iterations;
    return true;
}

/* Tells the witness, if there is one, of the split that the marginals will be of. The messages stay
 * as they are: they wait in the memory of the marginals. */
static void tell_split(reducer *r, const qs_trws_state *state)
{
    const qs_witness *witness = witness_of(r);
    if (witness) {
        size_t size = sizeof *state->messages * (size_t)qs_trws_messages(state->model);
        memcpy(r->marginals, state->messages, size);
        qs_trws_split(state, r->sets.labelling, witness);
        memcpy(state->messages, r->marginals, size);
    }
}

static void tell_end(reducer *r)
{
    const qs_witness *witness = witness_of(r);
    if (witness) {
        witness->end(witness->context, r->sets.kept);
    }
}

/* Passes go by the list of what is left where that is little. */
static void list_visits(reducer *r, qs_trws_state *state)
{
    if (r->sets.left_count < state->model->sites / FEW) {
        qs_trws_visit_only(state, r->sets.left, r->sets.left_count);
    }
}

/* Finds the marginals and takes out the labels that they rule out. Returns how far the scaled bound
 * was below the best energy. */
static int64_t take_out(reducer *r, qs_trws_state *state, qs_solution *so_far)
{
    int64_t room;
    qs_eliminate_restore(&r->sets);
    int64_t energy = qs_model_energy(&r->sets.model, r->sets.labelling);
    qs_look *look = state->look;
    state->look = NULL; /* half of the marginals would be of no use */
    tell_split(r, state);
    qs_trws_marginals(state, r->marginals, r->shares);
    state->look = look;
    int64_t gap = qs_eliminate_above(&r->sets, r->marginals, r->shares, state->scale.shift, &room);
    so_far->lower_bound = qs_max_i64(so_far->lower_bound, energy - gap);
    tell_end(r);
    qs_eliminate_follow(&r->sets);
    tell_end(r);
    so_far->energy = qs_model_energy(&r->sets.model, r->sets.labelling);
    list_visits(r, state);
    count(r);
    return room;
}

/* The numbers that an iteration of messages looks at. */
static uint64_t iteration_work(const qs_trws_state *state)
{
    const qs_model *model = state->model;
    uint64_t labels = model->labels, visits = qs_trws_visits(state),
             edges = model->width > 0 ? 2 * visits : model->edges;
    bool tables = model->pairwise.smoothness >= QS_TABLE;
    return 1 + visits * labels * NUMBERS_A_LABEL + (tables ? 2 * labels * labels * edges : 0);
}

/* Solves parts. All of them together may take as much work as the messages did up to now, and a
 * little more, less what parts have taken before. Returns true if anything has changed. */
static bool solve_parts(reducer *r, const qs_trws_state *state, const qs_solution *so_far)
{
    uint64_t iterations = so_far->iterations - r->parts_at;
    r->parts_at = so_far->iterations;
    r->work += qs_max_u64(iterations * iteration_work(state), LEAST_WORK);
    uint64_t share = qs_min_u64(r->work, AT_ONCE);
    qs_allowance work = {share, &r->look};
    const qs_witness *witness = witness_of(r);
    bool changed = qs_parts_solve(&r->sets, r->marginals, r->parts_size, &work, witness);
    r->work -= share - work.left;
    return changed;
}

/* Whether the bound has hardly risen for a while, so that it is time to begin anew. */
static bool has_stalled(const reducer *r, const qs_solution *so_far)
{
    int64_t rise = so_far->lower_bound - r->again.bound, gap = so_far->energy - so_far->lower_bound;
    return so_far->iterations - r->again.since >= STALL && rise < gap / STALL_PART + 1;
}

/* Where messages get no further, and parts are too wide for a witness to solve, labels are tried.
 * All trials together may take as much work as parts. Where they take nothing out, parts are
 * searched for better labellings alone. Returns true if anything has changed. */
static bool try_labels(reducer *r, qs_trws_state *state, const qs_solution *so_far)
{
    if (!witness_of(r) || !has_stalled(r, so_far)) {
        return false; /* without a witness, branch and bound of parts does more */
    }
    uint64_t share = qs_min_u64(r->work, AT_ONCE);
    qs_allowance work = {share, &r->look};
    qs_probes probes = {&r->sets,      state, r->marginals, r->parts_size,
                        witness_of(r), &work, r->trials};
    bool changed = qs_probes_take_out(&probes);
    r->work -= share - work.left;
    r->trials = probes.most;
    if (changed) {
        return true;
    }
    share = qs_min_u64(r->work, share / SEARCH_SHARE);
    work.left = share;
    changed = qs_parts_improve(&r->sets, r->marginals, r->parts_size, &work);
    r->work -= share - work.left;
    return changed;
}

/* Takes out what it can. Returns how far the scaled bound was below the best energy. */
static int64_t tighten(reducer *r, qs_trws_state *state, qs_solution *so_far)
{
    int64_t room = take_out(r, state, so_far);
    bool open = so_far->energy > so_far->lower_bound && r->target == 0 && !r->stopped &&
                so_far->iterations >= FIRST; /* before, messages do more in the same time */
    if (open && solve_parts(r, state, so_far)) {
        list_visits(r, state);
        room = take_out(r, state, so_far);
    }
    if (open && so_far->energy > so_far->lower_bound && try_labels(r, state, so_far)) {
        list_visits(r, state);
        room = take_out(r, state, so_far);
    }
    r->looked = so_far->energy - so_far->lower_bound;
    r->looked_at = so_far->iterations;
    return room;
}

/* Whether there is memory for windows around the spots where the gap sits: on wide grids without
 * tables of their own for the edges, in messages of 32 bits. It does not depend on the height, so
 * that the memory of a grid can be foreseen from that of a few rows. */
static bool has_spots(const qs_model *model)
{
    return QS_BITS == 32 && model->width > QS_SPOT_SIDE && !model->tables;
}

static bool at_target(const reducer *r)
{
    return r->target > 0 && r->so_far.variables <= r->target;
}

/* The iterations up to the next time. Returns false if the limit is reached, or if the watch has
 * stopped it. */
static bool go_on(reducer *r, qs_trws_state *state, qs_solution *so_far)
{
    uint64_t end = so_far->iterations + BETWEEN + so_far->iterations / BETWEEN;
    bool more = true;
    while (more && so_far->iterations < end && so_far->iterations < r->iterations) {
        qs_trws_iterate(state, 1);
        so_far->iterations++;
        qs_progress now = {so_far->energy, so_far->lower_bound, so_far->iterations};
        more = tell(r, &now);
    }
    return more && so_far->iterations < r->iterations;
}

/* Returns true if there is something left to take out, and `room` shrinks by a sixteenth. */
static bool is_worth_more(const reducer *r, int64_t before, int64_t room)
{
    return room > 0 && room <= before / 16 * 15 && r->so_far.undecided > 0 && !at_target(r);
}

/* The best labelling is proven as soon as the bound is above its energy less 1. But as long as the
 * bound is below the energy at all, by `room`, some labels stay that are in no optimum. So this
 * goes on while `room` shrinks; when it is 0 only labels of equal optima are left. */
static void finish(reducer *r, qs_trws_state *state, qs_solution *so_far, int64_t room)
{
    int64_t before = INT64_MAX;
    bool more = so_far->iterations < r->iterations;
    while (more && is_worth_more(r, before, room)) {
        before = room;
        more = go_on(r, state, so_far);
        room = tighten(r, state, so_far);
    }
}

/* Where there are no messages, the watch is only asked whether to stop. */
static bool watch_on_the_way(void *context)
{
    reducer *r = context;
    count(r);
    r->stopped = r->stopped || (r->options && r->options->watch &&
                                !r->options->watch(r->options->context, &r->so_far));
    return !r->stopped;
}

/* Rounds, each with the windows at another place, until IN_VAIN in turn gain nothing. After each,
 * parts that are better in the best labelling are taken over: so a window has the best neighbours
 * that are known. */
static void go_round(reducer *r)
{
    uint32_t idle = 0;
    for (uint32_t i = 0; i < ROUNDS && idle < IN_VAIN && !r->stopped; i++) {
        qs_rectangle first = {.width = SIDE, .height = SIDE};
        first.x = qs_draw_below(&r->random, SIDE);
        first.y = qs_draw_below(&r->random, SIDE);
        int64_t gain =
            qs_windows_improve(&r->sets, first, r->trial, r->marginals, r->parts_size, &r->look);
        gain += qs_merge(&r->merger, NULL, 0, r->trial, r->sets.labelling);
        idle = gain > 0 ? 0 : idle + 1;
    }
}

/* A labelling to begin with: the best one if it is new, else that of the messages. This one begins
 * higher but may end lower, for windows only lead to a low place nearby. Returns false if there is
 * none. */
static bool choose_start(reducer *r, const qs_trws_state *state, const qs_solution *so_far)
{
    const qs_model *model = &r->sets.model;
    qs_solution ended;
    if (so_far->energy < r->windowed) {
        memcpy(r->trial, r->sets.labelling, sizeof *r->trial * model->sites);
        return true;
    }
    qs_trws_state whole = *state;
    whole.look = NULL; /* a half of the labels would be of no use */
    qs_trws_grid_labels(&whole, true, r->trial);
    bool made = qs_icm(model, NULL, NULL, 0, r->trial, &ended) == QS_OK;
    (void)qs_take_kept_everywhere(model, r->trial);
    return made;
}

/* Makes labellings of a large grid better, window by window. */
static void solve_windows(reducer *r, const qs_trws_state *state, qs_solution *so_far)
{
    const qs_model *model = &r->sets.model;
    r->next_windows = so_far->iterations + so_far->iterations / 2;
    if (model->width <= SIDE || model->height <= SIDE || r->sets.left_count < model->sites / MANY) {
        return;
    }
    if (!choose_start(r, state, so_far)) {
        return;
    }
    go_round(r);
    so_far->energy -= qs_merge(&r->merger, NULL, 0, r->sets.labelling, r->trial);
    r->windowed = so_far->energy;
}

/* No certificate can state what searches of windows prove. A witness that is asked for all that is
 * left refuses that, and so knows that there may be more to prove. Of less it has been asked by
 * parts. */
static void leave_spots_out(const reducer *r, const qs_witness *witness)
{
    if (r->sets.left_count > QS_PART_NODES) {
        (void)witness->part(witness->context, r->sets.left, r->sets.left_count, true);
    }
}

/* Searches windows around the spots where the gap sits. With a gap that lets no label leave, other
 * ways do more in the same time. */
static void search_spots(reducer *r, qs_trws_state *state, qs_solution *so_far)
{
    uint64_t iterations = so_far->iterations - r->spots_at;
    r->next_spots = so_far->iterations + so_far->iterations / 4;
    r->spots_at = so_far->iterations;
    if (!has_spots(&r->sets.model) || r->sets.model.height <= QS_SPOT_SIDE ||
        is_gap_too_wide(state, so_far)) {
        return;
    }
    if (witness_of(r)) {
        leave_spots_out(r, witness_of(r));
        return;
    }
    r->spots_work += SPOTS_TIMES * iterations * iteration_work(state);
    qs_allowance work = {r->spots_work, &r->look};
    qs_spots_call call = {&r->sets,      state,     r->spots_side, r->marginals,
                          r->parts_size, r->shares, &work};
    int64_t gap;
    bool done = qs_spots_take_out(&r->spots, &call, &gap);
    r->spots_side = work.left > r->spots_work / 2
                        ? qs_min_u32(r->spots_side + SPOT_STEP, QS_SPOT_SIDE)
                        : qs_max_u32(r->spots_side - SPOT_STEP, QS_SPOT_SIDE_LEAST);
    r->spots_work = work.left;
    if (done) {
        int64_t energy = qs_model_energy(&r->sets.model, r->sets.labelling);
        so_far->lower_bound = qs_max_i64(so_far->lower_bound, energy - gap);
        qs_eliminate_follow(&r->sets);
        list_visits(r, state);
        count(r);
    }
    so_far->energy = qs_model_energy(&r->sets.model, r->sets.labelling);
}

/* Where there are no windows the whole is searched by kicks, which takes as much work as the
 * messages up to now at most, or KICKS_WORK for each iteration. Tables of their own for the edges
 * rule windows out. */
static void search_by_kicks(reducer *r, const qs_trws_state *state, qs_solution *so_far)
{
    const qs_model *model = &r->sets.model;
    r->next_kicks = 2 * so_far->iterations;
    if (model->width > SIDE && model->height > SIDE && !model->tables) {
        return;
    }
    uint64_t numbers = iteration_work(state),
             rounds = so_far->iterations * qs_max_u64(KICKS_WORK, numbers / KICKS_SLOWER) / numbers;
    so_far->energy -= qs_kicks_improve(&r->kicks, model, r->sets.left, r->sets.left_count, rounds,
                                       r->sets.labelling, r->marginals, r->parts_size, &r->look);
}

/* Takes over the caller's labelling where it is the best one. Labels of it that have left are
 * replaced: that is no rise. */
static void offer_start(reducer *r, qs_solution *so_far)
{
    const qs_model *model = &r->sets.model;
    const uint16_t *start = r->options ? r->options->start : NULL;
    if (!start) {
        return;
    }
    memcpy(r->trial, start, sizeof *start * model->sites);
    (void)qs_take_kept_everywhere(model, r->trial);
    int64_t energy = qs_model_energy(model, r->trial);
    if (energy < so_far->energy) {
        so_far->energy = energy;
        memcpy(r->sets.labelling, r->trial, sizeof *start * model->sites);
    }
}

static size_t messages_size(const qs_trws_state *state)
{
    return sizeof *state->messages * (size_t)qs_trws_messages(state->model);
}

static void begin_anew(reducer *r, qs_trws_state *state)
{
    memcpy(r->marginals, state->messages, messages_size(state));
    memset(state->messages, 0, messages_size(state));
    r->again.trying = true;
}

static void take_back(reducer *r, qs_trws_state *state)
{
    memcpy(state->messages, r->marginals, messages_size(state));
    r->again.trying = false;
    r->again.failed = r->sets.left_count;
}

/* After each iteration. */
static void consider_restart(reducer *r, qs_trws_state *state, qs_solution *so_far)
{
    restart *a = &r->again;
    uint64_t since = so_far->iterations - a->since;
    bool better = so_far->lower_bound > a->bound;
    if (a->trying && !better) {
        if (since >= qs_max_u64(TRY, a->since / 2)) {
            take_back(r, state);
            a->since = so_far->iterations;
        }
        return;
    }
    if (a->trying || (since >= STALL && !has_stalled(r, so_far))) {
        *a = (restart){so_far->lower_bound, so_far->iterations, false, a->failed};
        return;
    }
    if (has_stalled(r, so_far) && r->sets.left_count < a->failed - a->failed / FEWER) {
        (void)tighten(r, state, so_far);
        begin_anew(r, state);
        a->bound = so_far->lower_bound;
        a->since = so_far->iterations;
    }
}

static void note_gain(reducer *r, const qs_solution *so_far)
{
    last_gain *g = &r->gain;
    int64_t gap = so_far->energy - so_far->lower_bound;
    uint32_t left = r->begun ? r->sets.left_count : g->left;
    if (gap < g->gap - g->gap / NO_GAIN || left < g->left) {
        *g = (last_gain){gap, left, so_far->iterations, false};
    }
    uint64_t idle = so_far->iterations - g->iterations;
    g->is_long_ago = r->target == 0 && idle >= qs_max_u64(IDLE, g->iterations);
}

static void begin(reducer *r)
{
    r->look = (qs_look){.going = watch_on_the_way, .context = r};
    r->sets.look = &r->look;
    qs_eliminate_begin(&r->sets);
    r->begun = true;
    tell_end(r);
    count(r);
}

/* No more labels leave. The witness may still find the least energies of parts by search, which
 * says nothing of their labels; a split of the rest has to follow. */
static void prove_parts(reducer *r, const qs_trws_state *state)
{
    const qs_witness *witness = witness_of(r);
    if (witness && !r->aim.answer &&
        qs_parts_prove(&r->sets, r->marginals, r->parts_size, witness)) {
        tell_split(r, state);
        tell_end(r);
    }
}

static bool between(void *context, qs_trws_state *state, qs_solution *so_far, bool stopped)
{
    reducer *r = context;
    if (so_far->iterations <= 1) {
        offer_start(r, so_far);
    }
    note_gain(r, so_far);
    bool ends = stopped || qs_is_proven(so_far) || so_far->iterations >= r->iterations ||
                r->gain.is_long_ago;
    if (!r->begun) { /* messages and a first round of moves do more in the same time */
        if (ends || so_far->iterations < FIRST) {
            return true;
        }
        begin(r);
        so_far->energy = qs_model_energy(&r->sets.model, r->sets.labelling);
    }
    if (r->again.trying && ends && so_far->lower_bound <= r->again.bound) {
        take_back(r, state); /* their marginals are the better ones */
    }
    r->again.trying = r->again.trying && !ends;
    if (!ends) {
        consider_restart(r, state, so_far);
    }
    /* The memory of windows is that of the old messages, too. */
    if (r->target == 0 && !ends && !r->again.trying && so_far->iterations >= r->next_windows) {
        solve_windows(r, state, so_far);
    }
    if (r->target == 0 && !ends && !r->again.trying && so_far->iterations >= r->next_spots) {
        search_spots(r, state, so_far);
    }
    if (r->target == 0 && !ends && !r->again.trying && so_far->iterations >= r->next_kicks) {
        search_by_kicks(r, state, so_far);
    }
    if (!at_target(r) && !r->again.trying && is_due(r, state, so_far, stopped)) {
        int64_t room = tighten(r, state, so_far);
        if (so_far->energy == so_far->lower_bound && !stopped && !r->aim.answer) {
            finish(r, state, so_far, room);
        }
    }
    if (ends && !stopped && r->target == 0 && so_far->energy > so_far->lower_bound) {
        prove_parts(r, state);
    }
    if (at_target(r)) { /* the bound that is stated has a proof, too */
        tell_split(r, state);
        tell_end(r);
    }
    return !at_target(r) && !r->gain.is_long_ago;
}

/* Hands out the workspace, or counts it. Returns its size. */
static size_t take_parts(reducer *r, const qs_model *model, void *workspace)
{
    qs_arena arena = {.base = workspace};
    r->others_size = qs_messages_and_moves_workspace(model);
    qs_eliminate_take(&r->sets, model, &arena);
    r->trial = qs_arena_take(&arena, model->sites, sizeof *r->trial);
    qs_merger_take(&r->merger, &r->sets.model, &arena);
    r->shares = qs_arena_take(&arena, model->sites, sizeof *r->shares);
    r->parts_size = sizeof *r->marginals * (size_t)qs_trws_marginal_numbers(model);
    r->parts_size = r->parts_size < qs_parts_memory(model) ? qs_parts_memory(model) : r->parts_size;
    r->marginals = qs_arena_take(&arena, r->parts_size, 1);
    if (has_spots(model)) {
        qs_spots_take(&r->spots, model, &arena);
    }
    r->others = qs_arena_take(&arena, r->others_size, 1);
    return qs_arena_size(&arena);
}

size_t qs_reduce_workspace(const qs_model *model)
{
    if (!qs_messages_fit(model, true)) {
        return QS_IN_64_BITS(SIZE_MAX, qs_reduce_workspace, model);
    }
    reducer r;
    return take_parts(&r, model, NULL);
}

static qs_status run(reducer *r, uint16_t *labelling, qs_reduction *reduction, bool *converged)
{
    qs_solve_options watched = {.iterations = r->iterations, .watch = tell, .context = r};
    qs_guest guest = {between, r};
    qs_solution solution;
    qs_status status = qs_messages_and_moves(&r->sets.model, &watched, &guest, r->others,
                                             r->others_size, labelling, &solution);
    if (status == QS_OK) {
        r->so_far.upper_bound = solution.energy;
        r->so_far.lower_bound = solution.lower_bound;
        r->so_far.iterations = solution.iterations;
        *reduction = r->so_far;
        *converged = solution.converged || r->gain.is_long_ago;
    }
    return status;
}

qs_status qs_reduce_as(const qs_model *model, const qs_reduce_options *options,
                       const qs_reduce_aim *aim, void *workspace, size_t workspace_size,
                       uint8_t *kept, uint16_t *labelling, qs_reduction *reduction, bool *converged)
{
    if (!model || !workspace || !kept || !labelling || !reduction) {
        return QS_E_ARGUMENT;
    }
    if (options && options->start && !qs_labels_in_range(model, options->start)) {
        return QS_E_ARGUMENT;
    }
    if (!qs_messages_fit(model, true)) {
        return QS_IN_64_BITS(QS_E_OVERFLOW, qs_reduce_as, model, options, aim, workspace,
                             workspace_size, kept, labelling, reduction, converged);
    }
    reducer r = {.options = options,
                 .aim = *aim,
                 .next = FIRST,
                 .trials = TRIALS,
                 .next_windows = FIRST_WINDOWS,
                 .next_spots = FIRST_WINDOWS,
                 .spots_side = FIRST_SPOT,
                 .next_kicks = 2 * FIRST,
                 .windowed = INT64_MAX,
                 .looked = INT64_MAX};
    r.again.failed = model->sites;
    r.gain = (last_gain){.gap = INT64_MAX, .left = model->sites};
    size_t size = take_parts(&r, model, workspace);
    if (workspace_size < size || size == SIZE_MAX) {
        return QS_E_WORKSPACE;
    }
    r.iterations = options && options->iterations > 0 ? options->iterations : QS_REDUCE_ITERATIONS;
    r.target = options ? options->target : 0;
    qs_eliminate_lay(&r.sets, model, options && options->walls, kept, labelling);
    r.sets.answer = aim->answer;
    if (!aim->answer || witness_of(&r)) {
        qs_model_winner(model, labelling);
        r.so_far.upper_bound = qs_model_energy(model, labelling);
        r.so_far.lower_bound = model->constant; /* no cost is below 0 */
        begin(&r);
    }
    qs_status status = run(&r, labelling, reduction, converged);
    if (status == QS_OK && reduction->iterations == 0) {
        qs_flow_split_none(&r.sets.model, witness_of(&r), labelling);
    }
    return status;
}

qs_status qs_reduce(const qs_model *model, const qs_reduce_options *options, void *workspace,
                    size_t workspace_size, uint8_t *kept, uint16_t *labelling,
                    qs_reduction *reduction)
{
    const qs_reduce_aim all = {0};
    bool converged;
    return qs_reduce_as(model, options, &all, workspace, workspace_size, kept, labelling, reduction,
                        &converged);
}
