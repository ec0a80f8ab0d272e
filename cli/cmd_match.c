#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "json.h"
#include "map_errors.h"
#include "map_output.h"
#include "messages.h"
#include "options.h"
#include "pair_options.h"
#include "solving.h"

enum {
    OUTPUT,
    PAIR,
    SOLVER = PAIR + PAIR_OPTIONS,
    SEARCH,
    SCALE = SEARCH + SEARCH_OPTIONS,
    COLOR,
    TRUTH,
    TRUTH_SCALE,
    JSON,
    MEMORY_LIMIT
};

static const option options[] = {
    [OUTPUT] = MAP_OUTPUT_OPTION, [PAIR] = PAIR_OPTION_ROWS,
    [SOLVER] = SOLVER_OPTION,     [SEARCH] = SEARCH_OPTION_ROWS,
    [SCALE] = SCALE_OPTION,       [COLOR] = COLOR_OPTION,
    [TRUTH] = TRUTH_OPTION,       [TRUTH_SCALE] = TRUTH_SCALE_OPTION,
    [JSON] = JSON_OPTION,         [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

static const command_line line = {
    .name = "match",
    .operands = {"LEFT", "RIGHT"},
    .about = "Turns a rectified stereo pair into a disparity map on this machine: encode, solve "
             "and decode in one go,\n"
             "without files between. qstereo solve --help says what the solvers are.\n",
    .options = options,
    .option_count = sizeof options / sizeof options[0],
    .examples = "  qstereo match left.png right.png -o disparity.png\n"
                "  qstereo match left.png right.png -o disparity.png --disparity 0:19 --lambda 20 "
                "--time-limit 2 --color\n"
                "  qstereo match left.png right.png -o disparity.png --truth truth.png "
                "--truth-scale 8 --json\n",
};

typedef struct request {
    pair pair;
    map_request map;
    const solver *by;
    search how;
    const char *truth; /* NULL = none */
    uint32_t truth_scale;
    bool json;
} request;

static int read_request(const arguments *given, request *asked)
{
    const char *const *values = given->values;
    asked->truth = values[TRUTH];
    asked->json = values[JSON] != NULL;
    int status = pair_read(given->operands[0], given->operands[1], &values[PAIR],
                           "--lambda or --truncation", &asked->pair);
    if (status == DONE) {
        status = solver_read(values[SOLVER], &asked->by);
    }
    if (status == DONE) {
        status = search_read(&values[SEARCH], &asked->how);
    }
    if (status == DONE) {
        status = truth_scale_read(values[TRUTH_SCALE], &asked->truth_scale);
    }
    if (status == DONE) {
        status = map_request_read(values[OUTPUT], values[SCALE], values[COLOR] != NULL, asked->json,
                                  &asked->map);
    }
    return status;
}

static void print_result(const request *asked, uint32_t scale, const solved *found,
                         const map_errors *errors)
{
    if (asked->json) {
        json_begin();
        solved_json(found, scale);
        json_count("sample", 0);
        json_count("repaired", 0);
        map_request_json(&asked->map);
        if (errors != NULL) {
            map_errors_json(errors);
        }
        json_end();
        return;
    }
    map_request_print(&asked->map);
    solved_print(found, scale);
    if (errors != NULL) {
        map_errors_print(errors);
    }
}

static int write_found(const request *asked, const laid_out *problem, budget *limit,
                       const true_map *truth, const solved *found, map_outputs *outs)
{
    uint32_t *disparities = NULL;
    pixel_map map;
    map_errors errors;
    int status = map_of_labelling(problem->problem, found->labelling, limit, &disparities, &map);
    if (status == DONE && truth != NULL) {
        status = truth_compare(truth, &map, &errors);
    }
    if (status == DONE) {
        status = map_outputs_write(&asked->map, &map, outs);
    }
    if (status == DONE && !output_is_standard(asked->map.output)) {
        print_result(asked, problem->problem->scale, found, truth != NULL ? &errors : NULL);
    }
    free(disparities);
    return status;
}

static int solve_and_write(const request *asked, const laid_out *problem, budget *limit,
                           const true_map *truth, map_outputs *outs)
{
    solved found;
    int status = solve_problem(problem, asked->by, &asked->how, *limit, &found);
    if (status != DONE) {
        return status;
    }
    status = solved_check(problem, &found);
    if (status == DONE) {
        status = write_found(asked, problem, limit, truth, &found, outs);
    }
    solved_free(&found);
    return status;
}

/* Opens the outputs before the work, so that a long search is not in vain. */
static int match_encoded(const request *asked, problem_file *problem, budget *limit,
                         const true_map *truth)
{
    laid_out laid;
    map_outputs outs;
    int status = laid_out_open(problem, limit, &laid);
    if (status == DONE) {
        status = map_outputs_open(&asked->map, &outs);
    }
    if (status == DONE) {
        status = solve_and_write(asked, &laid, limit, truth, &outs);
        if (status == DONE) {
            status = map_outputs_commit(&outs);
        } else {
            map_outputs_abandon(&outs);
        }
    }
    laid_out_close(&laid);
    return status;
}

static int match_pair(request *asked, budget *limit)
{
    static const qs_encode_options defaults;
    qs_problem problem;
    problem_file encoded;
    true_map truth = {.values = NULL};
    memset(&encoded, 0, sizeof encoded);
    int status = pair_open(&asked->pair, &problem);
    if (status == DONE && asked->truth != NULL) {
        status =
            truth_open(asked->truth, asked->truth_scale, (uint32_t)asked->pair.stereo.left.width,
                       (uint32_t)asked->pair.stereo.left.height, &truth);
    }
    if (status == DONE) {
        status = pair_hold(&asked->pair, &problem, &defaults, limit, &encoded);
    }
    /* The pictures are not needed from here on. */
    pair_close(&asked->pair);
    if (status == DONE) {
        status = match_encoded(asked, &encoded, limit, asked->truth != NULL ? &truth : NULL);
    }
    problem_close(&encoded);
    truth_close(&truth);
    return status;
}

int cmd_match(int argc, char **argv)
{
    arguments given;
    request asked;
    budget limit;
    int status;
    if (!options_read(&line, argc, argv, &given, &status)) {
        return status;
    }
    memset(&asked, 0, sizeof asked);
    status = budget_read(given.values[MEMORY_LIMIT], &limit);
    if (status == DONE) {
        status = read_request(&given, &asked);
    }
    if (status == DONE) {
        status = match_pair(&asked, &limit);
    }
    map_request_free(&asked.map);
    return status;
}
