#include <inttypes.h>
#include <stdio.h>

#include "makers/detecting.h"
#include "makers/kept_list.h"
#include "one_go.h"
#include "pictures/picture_write.h"
#include "scores/box_score.h"
#include "text/fail.h"
#include "text/json.h"

static const option options[] = {
    [ONE_GO_OUTPUT] = {"output", 'o', true, "KEPT.csv", NULL,
                       "boxes to keep, lines of BOXES.csv; - is standard output"},
    ONE_GO_OPTION_ROWS("score against these boxes: precision, recall, ap"),
};

static int print_result(job *at, const one_go *run, const box_file *all, const box_file *truth)
{
    box_file kept;
    box_score score;
    TRY(kept_boxes_take(all, run->found.labelling, &at->limit, &kept));
    if (run->truth != NULL) {
        TRY(box_score_find(&kept, truth, &at->limit, &score));
    }
    TRY(job_commit(at));
    if (!one_go_print(at, run)) {
        return DONE;
    }
    if (at->json) {
        json_count("kept", kept.count);
    } else {
        printf("%" PRIu32 " of %" PRIu32 " boxes are kept\n", kept.count, all->count);
    }
    if (run->truth != NULL) {
        (at->json ? box_score_json : box_score_print)(&score);
    }
    one_go_end(at);
    return DONE;
}

static int run_detect(job *at)
{
    one_go run;
    detecting asked;
    box_file truth;
    output *out;
    const char *path = at->values[ONE_GO_OUTPUT];
    if (!path_ends(path, ".csv") && !output_is_straight(path)) {
        return fail_usage("-o %s: the name of a list of boxes ends in .csv", path);
    }
    TRY(one_go_read(at, &run));
    TRY(one_go_open(at, &detecting_maker, &asked, &run));
    if (run.truth != NULL) {
        TRY(boxes_read(run.truth, false, &at->limit, &truth));
    }
    TRY(job_open_output(at, path, &out));
    TRY(one_go_solve(at, &run));
    boxes_write(&asked.file, run.found.labelling, out);
    return print_result(at, &run, &asked.file, &truth);
}

const command cmd_detect = {
    .line =
        {
            .name = "detect",
            .operands = {"BOXES.csv"},
            .about =
                "Chooses among overlapping boxes of a detector: keeping a box costs -score, "
                "keeping two that overlap costs 4 IoU, where their IoU is above 0.1; both are "
                "rounded to hundredths. BOXES.csv begins with a line of names and has the columns "
                "picture, x, y, width, height and score; others are kept. qstereo solve --help "
                "describes the solvers.\n\n"
                "A box is right if its IoU with a true one is at least 0.5 and no box of a higher "
                "score has taken that one; ap is the area under the curve of precision over recall "
                "(Everingham et al. 2010).\n",
            OPTIONS(options),
            .examples = "  qstereo detect boxes.csv -o kept.csv\n"
                        "  qstereo detect boxes.csv -o kept.csv --truth truth.csv --json\n",
        },
    .summary = "choose among overlapping boxes of a detector",
    .run = run_detect,
};
