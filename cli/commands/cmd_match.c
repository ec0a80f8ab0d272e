#include <stdio.h>
#include <string.h>

#include "command.h"
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

typedef struct request {
    pair pair;
    map_request map;
    const solver *by;
    search how;
    bool scored; /* there is a truth */
    uint32_t truth_scale;
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
    TRY(truth_scale_read(values[TRUTH_SCALE], &asked->truth_scale));
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
    if (!output_is_standard(asked->map.output)) {
        print_result(at, asked, found, &errors);
    }
    return DONE;
}

static int match(job *at, request *asked)
{
    const qs_image *left = &asked->pair.stereo.left;
    made_problem opened;
    laid_out laid;
    solved found;
    TRY(pair_open(&asked->pair, &at->limit, &opened));
    if (asked->scored) {
        TRY(truth_open(at->values[TRUTH], asked->truth_scale, (uint32_t)left->width,
                       (uint32_t)left->height, &asked->truth));
    }
    TRY(map_request_open(&asked->map, at));
    TRY(made_solve(&opened, asked->by, &asked->how, &at->limit, &laid, &found));
    return write_found(at, asked, &laid, &found);
}

static int run_match(job *at)
{
    request asked;
    TRY(read_request(at, &asked));
    int status = match(at, &asked);
    truth_close(&asked.truth);
    return status;
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
