#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "fields/warp.h"
#include "makers/displacing.h"
#include "one_go.h"
#include "pictures/picture_write.h"
#include "pictures/planes.h"
#include "scores/flow_score.h"
#include "text/fail.h"
#include "text/json.h"

enum { WARPED = ONE_GO_MAKER + DISPLACING_OPTIONS };

static const option options[] = {
    [ONE_GO_OUTPUT] = FLOW_OUTPUT_OPTION("FIELD"),
    ONE_GO_OPTION_ROWS(
        "score against this field, .flo, .npy or KITTI's .png: tre, before and after"),
    [ONE_GO_MAKER] = REGISTER_OPTION_ROWS,
    [WARPED] = {"warped", 0, false, "PICTURE", NULL,
                "also write MOVING drawn over FIXED, as .png or .pgm"},
};

/* What registration has reached. */
typedef struct reached {
    double mse_before,
        mse; /* of MOVING and of the warped picture from FIXED, squared grey levels */
    flow_score before, after; /* of no displacement and of the field, beside the truth */
} reached;

static double mse_of(const qs_image *a, const uint8_t *b, size_t b_stride)
{
    double sum = 0;
    for (size_t y = 0; y < a->height; y++) {
        for (size_t x = 0; x < a->width; x++) {
            double off = a->pixels[y * a->stride + x] - (double)b[y * b_stride + x];
            sum += off * off;
        }
    }
    return sum / ((double)a->width * (double)a->height);
}

/* The error before is that of a field of zeros. */
static int score(job *at, const flow_field *field, const flow_field *truth, reached *found)
{
    flow_field none;
    TRY(flow_take(NULL, field->width, field->height, &at->limit, &none));
    memset(none.vectors, 0, 2 * sizeof(float) * field->width * field->height);
    flow_score_find(&none, truth, &found->before);
    flow_score_find(field, truth, &found->after);
    return DONE;
}

static void print_keys(const reached *found, bool scored)
{
    json_real("mse_before", found->mse_before);
    json_real("mse", found->mse);
    if (scored) {
        json_real("tre_before", found->before.aepe);
        json_real("tre", found->after.aepe);
        json_count("pixels", found->after.pixels);
    }
}

static void print_lines(const reached *found, bool scored)
{
    printf("mse %.2f, before %.2f", found->mse, found->mse_before);
    if (scored) {
        printf("; tre %.4f pixels, before %.4f, over %" PRIu64 " pixels", found->after.aepe,
               found->before.aepe, found->after.pixels);
    }
    putchar('\n');
}

static int write_warped(const qs_image *fixed, const uint8_t *pixels, bool png, output *to)
{
    picture made = {fixed->width, fixed->height, 1, 255, NULL};
    if (!picture_allocate(&made)) {
        return fail_memory(to->name);
    }
    for (size_t i = 0; i < fixed->width * fixed->height; i++) {
        made.samples[i] = pixels[i];
    }
    int status = picture_write(&made, png, to);
    picture_free(&made);
    return status;
}

/* The outputs of the command. */
typedef struct outputs {
    output *field, *warped; /* NULL = it was not asked for */
    bool field_png, warped_png;
} outputs;

static int open_outputs(job *at, outputs *outs)
{
    TRY(job_open_output(at, at->values[ONE_GO_OUTPUT], &outs->field));
    return at->values[WARPED] != NULL
               ? job_open_beside(at, "warped", at->values[WARPED], &outs->warped)
               : DONE;
}

static int write_found(job *at, const one_go *run, const displacing *asked, const flow_field *truth,
                       const outputs *outs)
{
    const qs_image *fixed = &asked->displace.first, *moving = &asked->displace.second;
    flow_field field;
    reached found = {0};
    TRY(meaning_field(run->made.name, &run->laid.labels, run->found.labelling, &at->limit, &field));
    uint8_t *warped = budget_take(&at->limit, run->made.name, fixed->width * fixed->height);
    if (warped == NULL) {
        return NO_RESOURCE;
    }
    warp(moving, &field, warped);
    found.mse_before = mse_of(fixed, moving->pixels, moving->stride);
    found.mse = mse_of(fixed, warped, fixed->width);
    if (run->truth != NULL) {
        TRY(score(at, &field, truth, &found));
    }
    TRY(flow_write(&field, outs->field_png, outs->field));
    if (outs->warped != NULL) {
        TRY(write_warped(fixed, warped, outs->warped_png, outs->warped));
    }
    TRY(job_commit(at));
    if (one_go_print(at, run)) {
        (at->json ? print_keys : print_lines)(&found, run->truth != NULL);
        one_go_end(at);
    }
    return DONE;
}

static int run_register(job *at)
{
    one_go run;
    displacing asked;
    flow_field truth = {0};
    outputs outs = {0};
    TRY(one_go_read(at, &run));
    TRY(flow_format_read(at->values[ONE_GO_OUTPUT], &outs.field_png));
    if (at->values[WARPED] != NULL) {
        TRY(picture_format_read(at->values[WARPED], &outs.warped_png));
    }
    TRY(one_go_open(at, &displacing_maker, &asked, &run));
    if (run.truth != NULL) {
        TRY(displacing_truth_read(&asked, run.truth, &at->limit, &truth));
    }
    TRY(open_outputs(at, &outs));
    TRY(one_go_solve(at, &run));
    return write_found(at, &run, &asked, &truth, &outs);
}

const command cmd_register = {
    .line =
        {
            .name = "register",
            .operands = {"FIXED", "MOVING"},
            .about =
                "Finds how a picture has to be bent to lie over another one: FIELD holds (dx, dy) "
                "of each pixel, with FIXED(x) = MOVING(x + d). It is the problem of qstereo flow "
                "with larger squares and steps, and without a truncation. qstereo solve --help "
                "describes the solvers.\n\n"
                "mse is the mean squared difference of the greys over all pixels; tre the mean "
                "distance of the displacements from the true ones, over the pixels that TRUTH "
                "knows.\n",
            OPTIONS(options),
            .examples = "  qstereo register fixed.png moving.png -o field.flo --warped over.png\n"
                        "  qstereo register fixed.png moving.png -o field.flo --radius 5 \\\n"
                        "      --fraction 4 --truth true.flo --json\n",
        },
    .summary = "bend a picture so that it lies over another one",
    .run = run_register,
};
