#include "pair.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "pictures/picture_read.h"
#include "smoothness.h"
#include "text/fail.h"
#include "text/names.h"
#include "text/numbers.h"
#include "text/plain.h"

static int read_disparity(const char *text, qs_stereo *stereo)
{
    uint32_t range[2];
    if (!numbers_read(text, ':', range, 2) || range[1] > INT32_MAX) {
        return fail_usage("--disparity %s is not MIN:MAX, two whole numbers from 0 to %ld", text,
                          (long)INT32_MAX);
    }
    if (range[0] > range[1]) {
        return fail_usage("--disparity %s is empty: MIN is above MAX", text);
    }
    if (range[1] - range[0] >= QS_LABELS_MAX) {
        return fail_usage("--disparity %s has %lu labels: %u is the most", text,
                          (unsigned long)(range[1] - range[0]) + 1, QS_LABELS_MAX);
    }
    stereo->disparity_min = range[0];
    stereo->disparity_max = range[1];
    return DONE;
}

static int read_roi(const char *text, pair *asked)
{
    uint32_t roi[4];
    asked->whole = text == NULL;
    if (text == NULL) {
        return DONE;
    }
    if (!numbers_read(text, ',', roi, 4) || roi[2] == 0 || roi[3] == 0) {
        return fail_usage("--roi %s is not X,Y,W,H, four whole numbers with W and H from 1", text);
    }
    asked->stereo.x = roi[0];
    asked->stereo.y = roi[1];
    asked->stereo.width = roi[2];
    asked->stereo.height = roi[3];
    return DONE;
}

int pair_read(const char *const *operands, const char *const *values, void *state)
{
    pair *asked = state;
    int cost = QS_COST_AD;
    uint32_t bits = 0;
    memset(asked, 0, sizeof *asked);
    asked->left = operands[0];
    asked->right = operands[1];
    TRY(read_disparity(values[PAIR_DISPARITY], &asked->stereo));
    TRY(lambda_read(values[PAIR_LAMBDA], DECIMAL_DENOMINATOR_MAX, &asked->stereo.scale,
                    &asked->stereo.weight));
    TRY(read_roi(values[PAIR_ROI], asked));
    TRY(name_read(&cost_names, values[PAIR_COST], "", &cost));
    TRY(smoothness_read(values[PAIR_SMOOTHNESS], values[PAIR_TRUNCATION], &asked->pairwise));
    if (values[PAIR_BITS] != NULL) {
        TRY(number_read("--bits", values[PAIR_BITS], 9, 16, &bits));
    }
    asked->bits = bits;
    asked->stereo.cost = (qs_cost)cost;
    return DONE;
}

/* Checks the geometry as the library does, so that a message can name what the user can mend. */
static int check_geometry(const pair *asked)
{
    const qs_stereo *stereo = &asked->stereo;
    const qs_image *left = &stereo->left, *right = &stereo->right;
    size_t end = asked->whole ? left->width : (size_t)stereo->x + stereo->width;
    if (left->width != right->width || left->height != right->height) {
        return fail(BAD_INPUT, input_name(asked->right),
                    "is %zu x %zu pixels, but %s is %zu x %zu: both pictures need the same size",
                    right->width, right->height, input_name(asked->left), left->width,
                    left->height);
    }
    if (end > left->width || (!asked->whole && (size_t)stereo->y + stereo->height > left->height)) {
        return fail(BAD_INPUT, input_name(asked->left),
                    "is %zu x %zu pixels: --roi %lu,%lu,%lu,%lu does not fit inside", left->width,
                    left->height, (unsigned long)stereo->x, (unsigned long)stereo->y,
                    (unsigned long)stereo->width, (unsigned long)stereo->height);
    }
    if (end <= stereo->disparity_max) {
        return fail(BAD_INPUT, input_name(asked->left),
                    "%s ends at column %zu, which is too narrow for disparity %lu: no pixel would "
                    "have all its matches inside the right picture; lower --disparity%s",
                    asked->whole ? "the picture" : "--roi", end - 1,
                    (unsigned long)stereo->disparity_max,
                    asked->whole ? "" : " or move --roi to the right");
    }
    return DONE;
}

int pair_make(pair *asked, budget *limit, made_problem *opened)
{
    opened->name = input_name(asked->left);
    opened->mend = "--lambda or --truncation";
    TRY(check_geometry(asked));
    size_t size = qs_stereo_workspace(&asked->stereo);
    void *workspace = budget_take(limit, opened->name, size);
    if (workspace == NULL) {
        return NO_RESOURCE;
    }
    qs_status status = qs_stereo_problem(&asked->stereo, workspace, size, &opened->problem);
    if (status != QS_OK) {
        return made_fail(opened, "choose a smaller --roi or --disparity", status);
    }
    opened->problem.pairwise = asked->pairwise;
    return DONE;
}

int pair_open(void *state, budget *limit, made_problem *opened)
{
    pair *asked = state;
    TRY(picture_read_grey(asked->left, asked->bits, limit, &asked->stereo.left));
    TRY(picture_read_grey(asked->right, asked->bits, limit, &asked->stereo.right));
    return pair_make(asked, limit, opened);
}

static void plan(const void *state, qs_problem *planned)
{
    const pair *asked = state;
    planned->labels = asked->stereo.disparity_max - asked->stereo.disparity_min + 1;
    planned->scale = asked->stereo.scale;
    planned->pairwise = asked->pairwise;
}

const maker pair_maker = {sizeof(pair), pair_read, pair_open, plan};

void pair_print_outside(const pair *asked, uint32_t first)
{
    uint32_t left = asked->whole ? 0 : asked->stereo.x;
    if (first > left) {
        printf("%" PRIu32 " column%s on the left %s left out: a match would fall outside %s\n",
               first - left, plural(first - left), first - left == 1 ? "is" : "are",
               plain(asked->right));
    }
}
