#include "makers/displacing.h"
#include "one_go.h"
#include "pictures/planes.h"
#include "pictures/picture_write.h"
#include "scores/flow_score.h"
#include "text/fail.h"

enum { COLOR = ONE_GO_MAKER + DISPLACING_OPTIONS };

static const option options[] = {
    [ONE_GO_OUTPUT] = FLOW_OUTPUT_OPTION("FLOW"),
    ONE_GO_OPTION_ROWS("score against this flow, .flo, .npy or KITTI's .png: aepe, aae"),
    [ONE_GO_MAKER] = FLOW_OPTION_ROWS,
    [COLOR] = {"color", 0, false, "PICTURE", NULL,
               "also write the flow in colours, as .png or .ppm: hue = direction, saturation = "
               "length"},
};

static void print_result(const job *at, const one_go *run, const flow_field *field,
                         const flow_field *truth)
{
    flow_score score;
    if (!one_go_print(at, run)) {
        return;
    }
    if (run->truth != NULL) {
        flow_score_find(field, truth, &score);
        (at->json ? flow_score_json : flow_score_print)(&score);
    }
    one_go_end(at);
}

static int run_flow(job *at)
{
    one_go run;
    displacing asked;
    flow_field truth = {0}, field;
    output *out, *coloured = NULL;
    bool png;
    TRY(one_go_read(at, &run));
    TRY(flow_format_read(at->values[ONE_GO_OUTPUT], &png));
    TRY(flow_colour_check(at->values[COLOR]));
    TRY(one_go_open(at, &displacing_maker, &asked, &run));
    if (run.truth != NULL) {
        TRY(displacing_truth_read(&asked, run.truth, &at->limit, &truth));
    }
    TRY(job_open_output(at, at->values[ONE_GO_OUTPUT], &out));
    if (at->values[COLOR] != NULL) {
        TRY(job_open_beside(at, "color", at->values[COLOR], &coloured));
    }
    TRY(one_go_solve(at, &run));
    TRY(meaning_field(run.made.name, &run.laid.labels, run.found.labelling, &at->limit, &field));
    TRY(flow_write(&field, png, out));
    if (coloured != NULL) {
        TRY(flow_colour_write(&field, at->values[COLOR], coloured));
    }
    TRY(job_commit(at));
    print_result(at, &run, &field, &truth);
    return DONE;
}

const command cmd_flow = {
    .line =
        {
            .name = "flow",
            .operands = {"FIRST", "SECOND"},
            .about =
                "Finds where each place of a picture went in a second one: FLOW holds (dx, dy) of "
                "each pixel, with FIRST(x) = SECOND(x + d). The sites are pixels, --step apart; a "
                "displacement costs the mean difference of the squares around both places; "
                "neighbours cost lambda times what they differ, |dx| + |dy|, up to the truncation "
                "(Glocker et al. 2008). qstereo solve --help describes the solvers.\n\n"
                "aepe and aae are the mean endpoint error in pixels and the mean angular error in "
                "degrees (Baker et al. 2011).\n",
            OPTIONS(options),
            .examples = "  qstereo flow first.png second.png -o flow.flo --color flow.png\n"
                        "  qstereo flow first.png second.png -o flow.flo --radius 6,2 --step 8 \\\n"
                        "      --truth true.flo --json\n",
        },
    .summary = "find where each place of a picture went in a second one",
    .run = run_flow,
};
