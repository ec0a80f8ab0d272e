#include <stdio.h>
#include <string.h>

#include "command.h"
#include "hints.h"
#include "pair.h"
#include "pictures/disparity_map.h"
#include "pictures/map_errors.h"
#include "text/fail.h"
#include "text/json.h"

enum {
    OUTPUT,
    PAIR,
    SOLVER = PAIR + PAIR_OPTIONS,
    SEARCH,
    STOPPING = SEARCH + SEARCH_OPTIONS,
    SCALE = STOPPING + STOPPING_OPTIONS,
    COLOR,
    TRUTH,
    TRUTH_SCALE,
    TRUTH_NO_VALUE,
    JSON,
    MEMORY_LIMIT
};

static const option options[] = {
    [OUTPUT] = MAP_OUTPUT_OPTION,
    [PAIR] = PAIR_OPTION_ROWS,
    [SOLVER] = SOLVER_OPTION,
    [SEARCH] = SEARCH_OPTION_ROWS,
    [STOPPING] = STOPPING_OPTION_ROWS,
    [SCALE] = SCALE_OPTION,
    [COLOR] = COLOR_OPTION,
    [TRUTH] = TRUTH_OPTION,
    [TRUTH_SCALE] = TRUTH_SCALE_OPTION,
    [TRUTH_NO_VALUE] = TRUTH_NO_VALUE_OPTION,
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

typedef struct request {
    pair pair;
    map_request map;
    const solver *by;
    search how;
    bool scored; /* there is a truth */
    map_form truth_form;
    true_map truth;
} request;

static int read_request(job *at, request *asked)
{
    const char *const *values = at->values;
    memset(asked, 0, sizeof *asked);
    asked->scored = values[TRUTH] != NULL;
    TRY(pair_read(at->given->operands, &values[PAIR], &asked->pair));
    TRY(solver_read(values[SOLVER], &asked->by));
    TRY(search_read(&values[SEARCH], &asked->how));
    TRY(stopping_read(&values[STOPPING], &asked->how));
    TRY(truth_form_read(values[TRUTH_SCALE], values[TRUTH_NO_VALUE], &asked->truth_form));
    return map_request_read(values[OUTPUT], values[SCALE], values[COLOR] != NULL, &at->limit,
                            &asked->map);
}

static void print_result(const job *at, const request *asked, const solved *found,
                         const map_errors *errors)
{
    uint32_t scale = asked->pair.stereo.scale;
    if (at->json) {
        json_begin();
        solved_json(found, scale);
        json_count("sample", 0);
        json_count("repaired", 0);
        map_request_json(&asked->map);
        if (asked->scored) {
            map_errors_json(errors);
            map_errors_json_more(errors);
        }
        json_end();
        return;
    }
    map_request_print(&asked->map);
    solved_print(found, scale);
    if (asked->scored) {
        map_errors_print(errors);
    }
}

/* Makes the map of what was found, scores it and writes it. */
static int write_found(job *at, request *asked, const laid_out *laid, const solved *found)
{
    pixel_map map;
    map_errors errors;
    TRY(map_of_labelling(laid->name, &laid->labels, found->labelling, &at->limit, &map));
    if (asked->scored) {
        TRY(truth_compare(&asked->truth, &map, &errors));
    }
    TRY(map_request_write(&asked->map, &map));
    TRY(job_commit(at));
    if (!output_is_standard(asked->map.output)) {
        print_result(at, asked, found, &errors);
    }
    hint_range(&asked->pair, &map);
    if (asked->scored) {
        map_errors_warn(asked->map.output, &errors);
    }
    return DONE;
}

/* What making and writing the map takes, after the solver's work is freed. */
static uint64_t map_need(const request *asked, const qs_frame *frame)
{
    const qs_labels labels = {.frame = *frame};
    return map_bytes(&asked->map, &labels);
}

static int match(job *at, request *asked)
{
    const qs_image *left = &asked->pair.stereo.left;
    made_problem opened;
    laid_out laid;
    solved found;
    TRY(pair_open(&asked->pair, &at->limit, &opened));
    if (asked->scored) {
        TRY(truth_open(at->values[TRUTH], &asked->truth_form, (uint32_t)left->width,
                       (uint32_t)left->height, &at->limit, &asked->truth));
        hint_truth(&asked->pair, &asked->truth);
    }
    TRY(made_need(&opened, asked->by, map_need(asked, &opened.problem.frame), &at->limit));
    hint_swapped(&asked->pair);
    TRY(lay_out_problem(opened.name, &opened.problem, opened.mend, &at->limit, &laid));
    TRY(map_check(laid.name, &laid.labels, asked->map.format));
    TRY(laid_out_need(&laid, asked->by, map_need(asked, &opened.problem.frame), &at->limit));
    TRY(map_request_open(&asked->map, at));
    TRY(solve_problem(&laid, asked->by, &asked->how, &at->limit, &found));
    TRY(solved_check(&laid, &found));
    return write_found(at, asked, &laid, &found);
}

static int run_match(job *at)
{
    request asked;
    TRY(read_request(at, &asked));
    return match(at, &asked);
}

const command cmd_match = {
    .line =
        {
            .name = "match",
            .operands = {"LEFT", "RIGHT"},
            .about =
                "Turns a rectified stereo pair into a disparity map on this machine: sets up the "
                "labelling problem, solves it and makes the map in one go, without files between. "
                "qstereo solve --help describes the solvers.\n",
            OPTIONS(options),
            .examples = "  qstereo match left.png right.png -o disparity.png\n"
                        "  qstereo match left.png right.png -o disparity.png --disparity 0:19 \\\n"
                        "      --lambda 20 --time-limit 2 --color\n"
                        "  qstereo match left.png right.png -o disparity.png --truth truth.png \\\n"
                        "      --truth-scale 8 --json\n",
        },
    .summary = "turn a stereo pair into a disparity map in one go",
    .run = run_match,
};
