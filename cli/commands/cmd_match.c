#include <stdio.h>
#include <string.h>

#include "after.h"
#include "camera/frames.h"
#include "command.h"
#include "halves.h"
#include "hints.h"
#include "pair.h"
#include "pictures/disparity_map.h"
#include "pictures/map_errors.h"
#include "progress_line.h"
#include "solver_work.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/numbers.h"
#include "threads.h"

enum {
    OUTPUT,
    PAIR,
    SOLVER = PAIR + PAIR_OPTIONS,
    SEARCH,
    STOPPING = SEARCH + SEARCH_OPTIONS,
    AFTER = STOPPING + STOPPING_OPTIONS,
    SCALE = AFTER + AFTER_OPTIONS,
    COLOR,
    PALETTE,
    SCALE_BAR,
    TRUTH,
    TRUTH_SCALE,
    TRUTH_NO_VALUE,
    SIDE_BY_SIDE,
    CALIBRATION,
    THREADS,
    TRACE,
    JSON,
    MEMORY_LIMIT
};

enum { THREADS_MOST = 32, LEFT = 0, RIGHT = 1 };

static const option options[] = {
    [OUTPUT] = MAP_OUTPUT_OPTION,
    [PAIR] = PAIR_OPTION_ROWS,
    [SOLVER] = PAIR_SOLVER_OPTION,
    [SEARCH] = SEARCH_OPTION_ROWS,
    [STOPPING] = STOPPING_OPTION_ROWS,
    [AFTER] = AFTER_OPTION_ROWS,
    [SCALE] = SCALE_OPTION,
    [COLOR] = COLOR_OPTION,
    [PALETTE] = PALETTE_OPTION,
    [SCALE_BAR] = SCALE_BAR_OPTION,
    [TRUTH] = TRUTH_OPTION,
    [TRUTH_SCALE] = TRUTH_SCALE_OPTION,
    [TRUTH_NO_VALUE] = TRUTH_NO_VALUE_OPTION,
    [SIDE_BY_SIDE] = {"sbs", 0, false, NULL, NULL,
                      "both pictures of each pair are side by side in LEFT, and there is no RIGHT"},
    [CALIBRATION] = CALIBRATION_OPTION(
        false, "rectify the pictures first, as qstereo rectify does; the ndisp of a calib.txt is "
               "the range of disparities if --disparity is not given"),
    [THREADS] = {"threads", 0, false, "N", "1",
                 "1 to 32: the left and the right picture's problem (with --after check) and their "
                 "parts (of trws16) are solved at the same time. The maps are the same"},
    [TRACE] = TRACE_OPTION,
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

typedef struct request {
    pair pair;
    frames frames;
    calibration cameras; /* with --calibration */
    uint32_t number; /* of the frame in work */
    bool is_first; /* the frame in work is the first one: hints are given for it */
    map_request map;
    after after;
    uint32_t threads, workers[2]; /* in all, and for the problem of each picture */
    team *teams[2]; /* the workers but one; NULL = that one works alone */
    const solver *by;
    search how;
    trace course;
    bool scored; /* there is a truth */
    map_form truth_form;
    true_map truth;
} request;

/* The inputs: LEFT and RIGHT, or pairs side by side in LEFT. */
static int read_inputs(const job *at, request *asked)
{
    const char *left = at->given->operands[0], *right = at->given->operands[1];
    bool side_by_side = at->values[SIDE_BY_SIDE] != NULL;
    if (side_by_side && right != NULL) {
        return fail_usage("--sbs goes with one input, which has both pictures: leave out %s",
                          right);
    }
    if (!side_by_side && right == NULL) {
        return fail_usage("the operand RIGHT is missing (with --sbs LEFT has both pictures)");
    }
    return frames_open(left, right, asked->map.output, &asked->frames);
}

/* Iterations are those of the preset unless they are given. A solver that is given has its own
 * limit. */
static int read_search(const char *const *values, request *asked)
{
    const char *limit = asked->pair.range->iterations;
    TRY(search_read(&values[SEARCH], &asked->how));
    bool own = values[SOLVER] == NULL && values[SEARCH + SEARCH_ITERATIONS] == NULL;
    return own && limit != NULL
               ? number64_read("--iterations", limit, 1, UINT32_MAX, &asked->how.iterations)
               : DONE;
}

/* Reads how a pair is solved and what follows. A preset says it for the pair's range. */
static int read_work(const char *const *values, request *asked)
{
    TRY(read_search(values, asked));
    TRY(after_read(&values[AFTER], &asked->pair, &asked->after));
    TRY(stopping_read(&values[STOPPING], &asked->how));
    asked->how.follow_up = asked->after.check && asked->threads == 1;
    return DONE;
}

/* Whether the range is that of the cameras, if they know one. */
static bool range_comes_later(const job *at)
{
    size_t next = 0;
    return at->values[CALIBRATION] != NULL &&
           options_next(at->given, PAIR + PAIR_DISPARITY, &next) == NULL;
}

static int read_calibration(job *at, request *asked)
{
    if (at->values[CALIBRATION] == NULL) {
        return DONE;
    }
    TRY(calibration_read(at, CALIBRATION, &at->limit, &asked->cameras));
    asked->frames.by = &asked->cameras;
    asked->frames.whole = &at->limit;
    if (!range_comes_later(at)) {
        return DONE;
    }
    if (asked->cameras.labels > 0) {
        TRY(pair_set_labels(&at->values[PAIR], asked->cameras.labels, &asked->pair));
    }
    return read_work(at->values, asked);
}

static int read_map(job *at, const char *path, request *asked)
{
    const char *const *values = at->values;
    const map_options given = {path, values[SCALE], values[COLOR], values[PALETTE],
                               values[SCALE_BAR]};
    return map_request_read(&given, &at->limit, &asked->map);
}

/* Whether no sum of costs and messages can be too large for trws16: costs are bytes, and a site has
 * four messages. */
static bool fits_trws16(const pair *asked)
{
    enum { MESSAGES = 4, MOST = (1 << 14) - 1 - UINT8_MAX };
    const qs_matching *stereo = &asked->stereo;
    const qs_pairwise *v = &asked->pairwise;
    uint64_t labels = (uint64_t)((int64_t)stereo->disparity_max - stereo->disparity_min + 1),
             reach = v->truncation > 0 && v->truncation < labels ? v->truncation : labels,
             heaviest = (uint64_t)stereo->weight *
                        (stereo->contrast_below > 0 ? stereo->contrast_times : 1);
    return v->smoothness != QS_TRUNCATED_QUADRATIC &&
           (uint64_t)stereo->scale * qs_matching_most(stereo) <= UINT8_MAX &&
           heaviest <= MOST / MESSAGES / (v->smoothness == QS_POTTS ? 1 : reach);
}

/* The solver of the preset, or, where the numbers of trws16 are too small, the same algorithm with
 * larger ones. */
static const char *preset_solver(const pair *asked)
{
    bool small = strcmp(asked->from->solver, "trws16") == 0;
    return small && !fits_trws16(asked) ? "trws" : asked->from->solver;
}

/* The solver is that of the preset unless it is given. */
static int choose_solver(const char *const *values, request *asked)
{
    const char *given = values[SOLVER];
    return pair_solver_read(given != NULL ? given : preset_solver(&asked->pair), &asked->by);
}

static int read_request(job *at, request *asked)
{
    const char *const *values = at->values;
    asked->scored = values[TRUTH] != NULL;
    TRY(pair_read(at->given->operands, &values[PAIR], &asked->pair));
    TRY(number_read("--threads", values[THREADS], 1, THREADS_MOST, &asked->threads));
    if (!range_comes_later(at)) {
        TRY(read_work(values, asked));
    }
    TRY(truth_form_read(values[TRUTH_SCALE], values[TRUTH_NO_VALUE], &asked->truth_form));
    TRY(read_map(at, values[OUTPUT], asked));
    TRY(read_inputs(at, asked));
    asked->frames.bits = asked->pair.bits;
    if (asked->scored && asked->frames.is_sequence) {
        return fail_usage("--truth goes with one pair, not with a sequence");
    }
    if (values[TRACE] != NULL && asked->frames.is_sequence) {
        return fail_usage("--trace goes with one pair, not with a sequence");
    }
    TRY(read_calibration(at, asked));
    if ((asked->after.confidence != NULL || asked->after.mask != NULL) &&
        asked->frames.is_sequence) {
        return fail_usage("%s goes with one pair, not with a sequence",
                          asked->after.mask != NULL ? "--mask" : "--confidence");
    }
    return choose_solver(values, asked);
}

static void print_result(const job *at, const request *asked, const solved *found,
                         const map_errors *errors)
{
    uint32_t scale = asked->pair.stereo.scale;
    if (at->json) {
        json_begin();
        if (asked->frames.is_sequence) {
            json_count("frame", asked->number);
        }
        solved_json(found, scale);
        json_count("sample", 0);
        json_count("repaired", 0);
        map_request_json(&asked->map);
        pair_json(&asked->pair);
        json_name("after", asked->after.steps);
        if (asked->scored) {
            map_errors_json(errors);
            map_errors_json_more(errors);
        }
        json_end();
        return;
    }
    job_print_outputs(at, asked->map.output);
    solved_print(found, scale);
    if (asked->scored) {
        map_errors_print(errors);
    }
}

/* Makes the map of what was found, scores it and writes it. */
static int write_found(job *at, request *asked, const side *left, side *right)
{
    pixel_map map;
    map_errors errors;
    TRY(after_labels(&asked->after, &asked->pair, left, asked->by, &asked->how, &at->limit, right,
                     &map));
    if (asked->scored) {
        TRY(truth_compare(&asked->truth, &map, &errors));
    }
    TRY(map_request_write(&asked->map, &map));
    TRY(job_commit(at));
    if (!output_is_standard(asked->map.output)) {
        print_result(at, asked, &left->found, &errors);
    }
    if (asked->is_first) {
        hint_range(&asked->pair, &map);
    }
    if (asked->scored) {
        map_errors_warn(asked->map.output, &errors);
    }
    return DONE;
}

/* What making and writing the map takes, after the solver's work is freed. */
static uint64_t map_need(const request *asked, const qs_problem *problem)
{
    const qs_labels labels = {.frame = problem->frame};
    return map_bytes(&asked->map, &labels);
}

/* Whether the solver takes the problem itself, and nothing after it needs a model. */
static bool is_straight(const request *asked)
{
    return asked->by->run_straight != NULL && !asked->after.refine &&
           asked->after.confidence == NULL;
}

/* Whether both pictures' problems are solved at the same time. */
static bool is_in_two(const request *asked)
{
    return asked->after.check && asked->threads > 1;
}

/* Shares the threads out between the problems that are solved at the same time. */
static int begin_teams(request *asked)
{
    uint32_t right = is_in_two(asked) ? asked->threads / 2 : 0;
    asked->workers[LEFT] = asked->threads - right;
    asked->workers[RIGHT] = right;
    for (int i = LEFT; i <= RIGHT; i++) {
        if (asked->workers[i] > 1 && asked->by->run_straight != NULL) {
            TRY(team_begin(asked->workers[i] - 1, &asked->teams[i]));
        }
    }
    if (asked->teams[LEFT] != NULL) {
        asked->pair.stereo.copies =
            asked->workers[LEFT] < QS_MATCH_COPIES ? asked->workers[LEFT] : QS_MATCH_COPIES;
    }
    return DONE;
}

/* What comes after the solver: the map, or before it, with --after check, the right picture's model
 * beside this one and its solver's work. In two threads both works are there at once, until the map
 * is written. */
static uint64_t later_need(const request *asked, const qs_problem *problem, uint64_t work)
{
    uint64_t map = map_need(asked, problem);
    uint64_t model = is_straight(asked) ? 0 : qs_model_of_problem_workspace(problem);
    uint64_t finer = asked->after.halves ? halves_bytes(problem) : 0;
    uint64_t right = asked->after.check ? bytes_sum(model, bytes_sum(work, finer)) : 0;
    return bytes_sum(bytes_sum(map, right), is_in_two(asked) ? work : 0);
}

/* The same before the problem is laid out: a solver's work is about as large as a model. */
static uint64_t foreseen_need(const request *asked, const qs_problem *problem)
{
    return later_need(asked, problem,
                      is_straight(asked)
                          ? asked->by->straight_workspace(problem, asked->how.iterations)
                          : qs_model_of_problem_workspace(problem));
}

static int open_truth(job *at, request *asked)
{
    const qs_image *left = &asked->pair.stereo.left;
    if (!asked->scored) {
        return DONE;
    }
    TRY(truth_open(at->values[TRUTH], &asked->truth_form, (uint32_t)left->width,
                   (uint32_t)left->height, &at->limit, &asked->truth));
    hint_truth(&asked->pair, &asked->truth);
    return DONE;
}

/* Solves both problems at once. What is found for the right picture stays in the memory of the left
 * one's work, which is ended later. */
static int solve_two(request *asked, solver_work *left, side *right)
{
    solver_work beside;
    const search *how = &asked->how;
    search untraced = *how; /* the right picture's solver has no part in the course */
    untraced.traced = NULL;
    budget *memory = &left->memory;
    right->halved = asked->after.halves;
    TRY(right_side_make(&asked->pair, asked->by, how->iterations, is_straight(asked), memory,
                        right));
    int status = work_begin(&right->laid, asked->by, &untraced, side_halves(right), memory,
                            &right->found, &beside);
    beside.hidden = true;
    beside.team = asked->teams[RIGHT];
    beside.workers = asked->workers[RIGHT];
    if (status == DONE) {
        status = threads_both(work_do, left, &beside);
    }
    if (status == DONE) {
        status = work_check(left);
    }
    if (status == DONE) {
        status = work_check(&beside);
    }
    work_end(&beside);
    return status;
}

/* Solves the problem, or both, and makes the map of what was found. */
static int solve(job *at, request *asked, side *left, bool *interrupted)
{
    solver_work work;
    side right;
    memset(&right, 0, sizeof right);
    int status = work_begin(&left->laid, asked->by, &asked->how, side_halves(left), &at->limit,
                            &left->found, &work);
    work.team = asked->teams[LEFT];
    work.workers = asked->workers[LEFT];
    if (status == DONE && is_in_two(asked)) {
        status = solve_two(asked, &work, &right);
    } else if (status == DONE) {
        work_do(&work);
        status = work_check(&work);
        work_end(&work);
    }
    asked->how.traced = NULL; /* the right picture's solver has no part in it */
    status = status == DONE ? solved_check(&left->laid, asked->by, &left->found) : status;
    if (status == DONE) {
        status = write_found(at, asked, left, &right);
        *interrupted = left->found.interrupted || right.found.interrupted;
    }
    work_end(&work);
    return status;
}

/* Makes the problem of the left picture, and makes sure that there is memory for all that
 * follows. */
static int make_left(job *at, request *asked, side *left)
{
    made_problem *made = &left->made;
    const qs_problem *problem = &made->problem;
    left->halved = asked->after.halves;
    TRY(pair_make(&asked->pair, &at->limit, made));
    TRY(open_truth(at, asked));
    TRY(made_need(made, asked->by, foreseen_need(asked, problem), &at->limit));
    if (asked->is_first) {
        hint_swapped(&asked->pair);
    }
    TRY(made_lay_out(made, is_straight(asked), &at->limit, &left->laid));
    TRY(map_check(left->laid.name, &left->laid.labels, asked->map.format));
    if (left->halved) {
        TRY(halves_begin(made->name, &asked->pair.stereo, &asked->pair.pairwise, &at->limit,
                         &left->finer));
    }
    uint64_t work = solve_bytes(&left->laid, asked->by, asked->how.iterations);
    return laid_out_need(&left->laid, asked->by, asked->how.iterations,
                         later_need(asked, problem, work), &at->limit);
}

/* Matches the pair whose pictures are there. */
static int match(job *at, request *asked, bool *interrupted)
{
    side left;
    memset(&left, 0, sizeof left);
    TRY(make_left(at, asked, &left));
    TRY(map_request_open(&asked->map, at));
    TRY(after_open(&asked->after, at));
    TRY(trace_open(at, at->values[TRACE], left.laid.scale, &asked->course));
    asked->how.traced = &asked->course;
    return solve(at, asked, &left, interrupted);
}

/* Names the map of a frame. */
static int name_map(job *at, request *asked)
{
    numbered names;
    const char *path = at->values[OUTPUT];
    if (!asked->frames.is_sequence || !numbered_read(path, &names)) {
        return DONE;
    }
    path = numbered_name(&names, asked->number, &at->limit);
    return path == NULL ? NO_RESOURCE : read_map(at, path, asked);
}

/* The next frame, whose map stays even if a later one fails. */
static int match_next(job *at, request *asked, bool *ended)
{
    frame_pair next;
    qs_matching *stereo = &asked->pair.stereo;
    TRY(frames_next(&asked->frames, &at->limit, &next, ended));
    if (*ended) {
        return DONE;
    }
    asked->number = next.number;
    asked->pair.left = next.names[0];
    asked->pair.right = next.names[1];
    stereo->left = next.grey[0];
    stereo->right = next.grey[1];
    TRY(name_map(at, asked));
    return match(at, asked, ended);
}

/* Makes the folder of the maps of a sequence. */
static int make_folder(job *at)
{
    const char *path = at->values[OUTPUT], *slash = strrchr(path, '/');
    if (slash == NULL || slash == path || output_is_straight(path)) {
        return DONE;
    }
    size_t length = (size_t)(slash - path);
    char *folder = budget_take(&at->limit, path, length + 1);
    if (folder == NULL) {
        return NO_RESOURCE;
    }
    memcpy(folder, path, length);
    folder[length] = '\0';
    return output_make_folder(folder);
}

/* Where a later frame may begin from what an earlier one has found, that is to be kept here. */
static int match_all(job *at, request *asked)
{
    bool ended = false;
    int status = make_folder(at);
    for (asked->is_first = true; status == DONE && !ended; asked->is_first = false) {
        job part = job_begin_part(at);
        progress_start_part(); /* the time limit is that of each frame */
        status = job_end_part(&part, match_next(&part, asked, &ended));
    }
    return status;
}

static int match_one(job *at, request *asked)
{
    bool ended;
    asked->is_first = true;
    return match_next(at, asked, &ended);
}

static int run_match(job *at)
{
    request asked;
    memset(&asked, 0, sizeof asked);
    budget_keep_blocks(); /* a right picture takes what the left one took, and so does a frame */
    int status = read_request(at, &asked);
    if (status == DONE) {
        status = begin_teams(&asked);
    }
    if (status == DONE) {
        status = asked.frames.is_sequence ? match_all(at, &asked) : match_one(at, &asked);
    }
    team_end(asked.teams[LEFT]);
    team_end(asked.teams[RIGHT]);
    frames_close(&asked.frames);
    return status;
}

const command cmd_match = {
    .line =
        {
            .name = "match",
            .operands = {"LEFT", "RIGHT"},
            .optional = 1,
            .about =
                "Turns a stereo pair into a disparity map on this machine: sets up the labelling "
                "problem, solves it and makes the map in one go, without files between. The pair "
                "is rectified, or --calibration says how to. qstereo solve --help describes the "
                "solvers.\n\nA sequence makes a map of each pair: LEFT, RIGHT and the MAP have "
                "the number of the frame in their names, such as left_%04d.png, from the first "
                "number that is there to the first one that is missing. Without a number an input "
                "is a stream of binary PGM, PPM or YUV4MPEG2 frames, and - is standard input. "
                "Maps stay where a later frame fails. --time-limit is that of each frame, and "
                "--json prints an object for each.\n\nA proof of the energy (--certificate) is "
                "about a "
                "file, so it takes qstereo encode, solve --certificate and decode.\n",
            OPTIONS(options),
            .examples = "  qstereo match left.png right.png -o disparity.png\n"
                        "  qstereo match left.png right.png -o disparity.png --disparity 0:19 \\\n"
                        "      --lambda 20 --time-limit 2 --color\n"
                        "  qstereo match left.png right.png -o disparity.png --truth truth.png \\\n"
                        "      --truth-scale 8 --json\n"
                        "  qstereo match left_%04d.png right_%04d.png -o out/d_%04d.pfm \\\n"
                        "      --calibration stereo.yml --disparity 0:63\n"
                        "  ffmpeg -i sbs.mkv -f yuv4mpegpipe - | \\\n"
                        "      qstereo match --sbs - -o out/d_%04d.pfm\n",
        },
    .summary = "turn a stereo pair into a disparity map in one go",
    .run = run_match,
};
