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
    int32_t range[2];
    if (!range_read(text, range)) {
        return fail_usage("--disparity %s is not MIN:MAX, two whole numbers from -%ld to %ld", text,
                          (long)INT32_MAX, (long)INT32_MAX);
    }
    if (range[0] > range[1]) {
        return fail_usage("--disparity %s is empty: MIN is above MAX", text);
    }
    int64_t labels = (int64_t)range[1] - range[0] + 1;
    if (labels > QS_LABELS_MAX) {
        return fail_usage("--disparity %s has %" PRId64 " labels: %u is the most", text, labels,
                          QS_LABELS_MAX);
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

/* Checks that a pixel of the columns from `start` to `end` - 1 has all its matches in the right
 * picture. */
static int check_columns(const pair *asked, int64_t start, int64_t end)
{
    int64_t most = asked->stereo.disparity_max, least = asked->stereo.disparity_min;
    int64_t width = (int64_t)asked->stereo.right.width;
    const char *window = asked->whole ? "the picture" : "--roi";
    if (end <= most) {
        return fail(BAD_INPUT, input_name(asked->left),
                    "%s ends at column %" PRId64 ", which is too narrow for disparity %" PRId64
                    ": no pixel would have all its matches inside the right picture; lower "
                    "--disparity%s",
                    window, end - 1, most, asked->whole ? "" : " or move --roi to the right");
    }
    if ((most > start ? most : start) >= width + least) {
        return fail(BAD_INPUT, input_name(asked->left),
                    "%s begins at column %" PRId64 ", and disparities %" PRId64 " to %" PRId64
                    " are too many for %" PRId64 " columns: no pixel would have all its matches "
                    "inside the right picture; raise the MIN of --disparity%s",
                    window, start, least, most, width,
                    asked->whole ? "" : " or move --roi to the left");
    }
    return DONE;
}

/* Checks the geometry as the library does, so that a message can name what the user can mend. */
static int check_geometry(const pair *asked)
{
    const qs_stereo *stereo = &asked->stereo;
    const qs_image *left = &stereo->left, *right = &stereo->right;
    size_t start = asked->whole ? 0 : stereo->x;
    size_t end = asked->whole ? left->width : start + stereo->width;
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
    return check_columns(asked, (int64_t)start, (int64_t)end);
}

int pair_open(void *state, budget *limit, made_problem *opened)
{
    pair *asked = state;
    opened->name = input_name(asked->left);
    opened->mend = "--lambda or --truncation";
    TRY(picture_read_grey(asked->left, asked->bits, limit, &asked->stereo.left));
    TRY(picture_read_grey(asked->right, asked->bits, limit, &asked->stereo.right));
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

static void plan(const void *state, qs_problem *planned)
{
    const pair *asked = state;
    planned->labels = (uint32_t)(asked->stereo.disparity_max - asked->stereo.disparity_min) + 1;
    planned->scale = asked->stereo.scale;
    planned->pairwise = asked->pairwise;
}

const maker pair_maker = {sizeof(pair), pair_read, pair_open, plan};

static void print_columns(uint32_t count, const char *side, const char *right)
{
    if (count > 0) {
        printf("%" PRIu32 " column%s on the %s %s left out: a match would fall outside %s\n", count,
               plural(count), side, count == 1 ? "is" : "are", plain(right));
    }
}

void pair_print_outside(const pair *asked, const qs_problem *made)
{
    const qs_stereo *stereo = &asked->stereo;
    uint32_t start = asked->whole ? 0 : stereo->x;
    uint32_t end = asked->whole ? (uint32_t)stereo->left.width : start + stereo->width;
    print_columns(made->frame.x - start, "left", asked->right);
    print_columns(end - made->frame.x - made->grid.width, "right", asked->right);
}
