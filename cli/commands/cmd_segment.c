#include <inttypes.h>
#include <stdio.h>

#include "makers/segmenting.h"
#include "one_go.h"
#include "pictures/picture_write.h"
#include "pictures/planes.h"
#include "scores/label_score.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/numbers.h"

enum { ROUNDS = ONE_GO_MAKER + SEGMENTING_OPTIONS };

static const option options[] = {
    [ONE_GO_OUTPUT] = PICTURE_OUTPUT_OPTION("MASK"),
    ONE_GO_OPTION_ROWS("score against this mask: iou, error rate"),
    [ONE_GO_MAKER] = SEGMENTING_OPTION_ROWS,
    [ROUNDS] = {"rounds", 0, false, "N", "1",
                "solve N times, each time with the colours of the classes found before"},
};

static int read_truth(job *at, const one_go *run, const segmenting *asked, label_map *truth)
{
    const qs_segment *segment = &asked->segment;
    label_map photo = {.name = run->made.name};
    (void)snprintf(photo.shape, sizeof photo.shape, "%" PRIu32 " x %" PRIu32, segment->height,
                   segment->width);
    TRY(label_map_read(run->truth, &at->limit, truth));
    return label_map_check(truth, &photo);
}

/* A solution takes memory of its own, which the next round does not need. */
static int solve_round(job *at, one_go *run, uint16_t *labelling)
{
    budget inside = budget_inside(&at->limit);
    one_go round = *run;
    int status = made_solve(&round.made, round.by, &round.how, &inside, &round.laid, &round.found);
    for (size_t i = 0; status == DONE && i < round.laid.labels.sites; i++) {
        labelling[i] = round.found.labelling[i];
    }
    budget_free(&inside);
    return status;
}

/* All rounds but the last one change the costs. */
static int solve_rounds(job *at, const segmenting *asked, uint32_t rounds, one_go *run)
{
    size_t sites = (size_t)asked->segment.width * asked->segment.height;
    uint16_t *labelling = budget_take(&at->limit, run->made.name, sites * sizeof *labelling);
    if (labelling == NULL) {
        return NO_RESOURCE;
    }
    for (uint32_t round = 1; round < rounds; round++) {
        TRY(solve_round(at, run, labelling));
        qs_status refitted = qs_segment_refit(asked->workspace, labelling);
        if (refitted != QS_OK) {
            return fail_status(run->made.name, refitted);
        }
    }
    return one_go_solve(at, run);
}

static int write_mask(job *at, const one_go *run, const label_map *truth, bool png, output *out)
{
    picture made;
    label_map mask;
    label_score score;
    const qs_labels *labels = &run->laid.labels;
    TRY(meaning_picture(run->made.name, labels, run->found.labelling, &at->limit, &made));
    TRY(picture_write(&made, png, out));
    if (run->truth != NULL) {
        TRY(label_map_of(&made, run->made.name, &at->limit, &mask));
        TRY(label_score_find(&mask, truth, &at->limit, &score));
    }
    TRY(job_commit(at));
    if (!one_go_print(at, run)) {
        return DONE;
    }
    if (run->truth != NULL) {
        (at->json ? label_score_json : label_score_print)(&score);
    }
    one_go_end(at);
    return DONE;
}

static int run_segment(job *at)
{
    one_go run;
    segmenting asked;
    label_map truth = {0};
    output *out;
    uint32_t rounds;
    bool png;
    TRY(one_go_read(at, &run));
    TRY(picture_format_read(at->values[ONE_GO_OUTPUT], &png));
    TRY(number_read("--rounds", at->values[ROUNDS], 1, 1000, &rounds));
    TRY(one_go_open(at, &segmenting_maker, &asked, &run));
    if (run.truth != NULL) {
        TRY(read_truth(at, &run, &asked, &truth));
    }
    TRY(job_open_output(at, at->values[ONE_GO_OUTPUT], &out));
    TRY(solve_rounds(at, &asked, rounds, &run));
    return write_mask(at, &run, &truth, png, out);
}

const command cmd_segment = {
    .line =
        {
            .name = "segment",
            .operands = {"PHOTO", "STROKES"},
            .optional = 1,
            .about =
                "Divides a picture into classes, of which STROKES marks some pixels: a grey "
                "picture of the same size, 0 = no stroke, v = class v. MASK holds the class of "
                "each pixel as its grey: 1, 2, ..., which look black in a viewer. A class costs "
                "-ln of how frequent the pixel's colour is in the class; "
                "neighbours of two classes cost lambda, less where the colours differ; strokes are "
                "kept (Boykov and Jolly 2001). With a box around an object marked outside as class "
                "1, class 2 needs no strokes: add --rounds 3. --costs gives other costs, from a "
                "model of your own. qstereo solve --help describes the solvers.\n\n"
                "iou is the mean over the classes that are in MASK or TRUTH.\n",
            OPTIONS(options),
            .examples = "  qstereo segment photo.png strokes.png -o mask.png\n"
                        "  qstereo segment photo.png outside.png -o mask.png --rounds 3 \\\n"
                        "      --truth truth.png --json\n",
        },
    .summary = "divide a picture into classes that strokes mark",
    .run = run_segment,
};
