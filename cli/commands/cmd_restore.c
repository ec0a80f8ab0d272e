#include "makers/restoring.h"
#include "one_go.h"
#include "pictures/picture_write.h"
#include "pictures/planes.h"
#include "scores/picture_score.h"
#include "text/fail.h"

static const option options[] = {
    [ONE_GO_OUTPUT] = PICTURE_OUTPUT_OPTION("CLEAN"),
    ONE_GO_OPTION_ROWS("score against this clean picture: psnr, ssim, psnr in the hole"),
    [ONE_GO_MAKER] = RESTORING_OPTION_ROWS,
};

static int read_truth(job *at, const one_go *run, const restoring *asked, qs_image *truth)
{
    const qs_image *noisy = &asked->restore.noisy;
    TRY(plain_grey_read(run->truth, &at->limit, truth));
    return same_size_check(run->truth, truth->width, truth->height, asked->noisy, noisy->width,
                           noisy->height);
}

static void print_result(const job *at, const one_go *run, const restoring *asked,
                         const qs_image *clean, const qs_image *truth)
{
    picture_score score;
    if (!one_go_print(at, run)) {
        return;
    }
    if (run->truth != NULL) {
        picture_score_find(clean, truth, asked->restore.hole, &score);
        (at->json ? picture_score_json : picture_score_print)(&score);
    }
    one_go_end(at);
}

static int run_restore(job *at)
{
    one_go run;
    restoring asked;
    qs_image truth = {0}, clean;
    picture made;
    output *out;
    bool png;
    TRY(one_go_read(at, &run));
    TRY(picture_format_read(at->values[ONE_GO_OUTPUT], &png));
    TRY(one_go_open(at, &restoring_maker, &asked, &run));
    if (run.truth != NULL) {
        TRY(read_truth(at, &run, &asked, &truth));
    }
    TRY(job_open_output(at, at->values[ONE_GO_OUTPUT], &out));
    TRY(one_go_solve(at, &run));
    const qs_labels *labels = &run.laid.labels;
    TRY(meaning_picture(run.made.name, labels, run.found.labelling, &at->limit, &made));
    TRY(meaning_image(run.made.name, labels, run.found.labelling, &at->limit, &clean));
    TRY(picture_write(&made, png, out));
    TRY(job_commit(at));
    print_result(at, &run, &asked, &clean, &truth);
    return DONE;
}

const command cmd_restore = {
    .line =
        {
            .name = "restore",
            .operands = {"NOISY"},
            .about =
                "Restores a noisy grey picture, and fills its holes: each pixel is a site, each "
                "grey a label. A grey costs what it differs from the pixel's, nothing in a hole; "
                "neighbours cost lambda times what their labels differ. NOISY is grey, of 8 bits "
                "or less; a picture in colours is restored channel by channel. qstereo solve "
                "--help describes the solvers.\n\n"
                "psnr and ssim are those of the grey pictures (Wang et al. 2004).\n",
            OPTIONS(options),
            .examples =
                "  qstereo restore noisy.png -o clean.png --lambda 2\n"
                "  qstereo restore old.png -o clean.png --cost absolute --smoothness "
                "linear \\\n"
                "      --truncation 40 --lambda 0.5 --hole scratches.png --truth true.png\n",
        },
    .summary = "remove noise from a picture and fill its holes",
    .run = run_restore,
};
