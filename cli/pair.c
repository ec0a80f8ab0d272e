#include "pair.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "matching_read.h"
#include "pictures/picture_read.h"
#include "smoothness.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/numbers.h"
#include "text/plain.h"

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

static const char *or_else(const char *given, const char *otherwise)
{
    return given != NULL ? given : otherwise;
}

static const preset_range *range_of(const preset *from, const qs_matching *stereo)
{
    int32_t pixels = (stereo->disparity_max - stereo->disparity_min) / (int32_t)stereo->parts;
    return &from->ranges[pixels >= PRESET_WIDE];
}

/* The argument of each option: what is given, else what the preset says. */
static pair_settings settle(const char *const *values, const preset *from,
                            const preset_range *range, uint32_t parts)
{
    const preset_smoothness *strength = &range->strength[parts - 1];
    const char *smoothness = or_else(values[PAIR_SMOOTHNESS], from->smoothness);
    bool as_preset = strcmp(smoothness, from->smoothness) == 0;
    bool potts = strcmp(smoothness, "potts") == 0;
    return (pair_settings){
        .cost = or_else(values[PAIR_COST], from->cost),
        .contrast = or_else(values[PAIR_CONTRAST], from->contrast),
        .border = or_else(values[PAIR_BORDER], from->border),
        .smoothness = smoothness,
        .lambda = or_else(values[PAIR_LAMBDA], potts ? range->potts_lambda : strength->lambda),
        .truncation = or_else(values[PAIR_TRUNCATION], as_preset ? strength->truncation : NULL),
    };
}

/* Reads what depends on the preset and the range of disparities. */
static int read_settings(const char *const *values, pair *asked)
{
    qs_matching *stereo = &asked->stereo;
    pair_settings *set = &asked->settings;
    *set = settle(values, asked->from, asked->range, stereo->parts);
    TRY(lambda_read(set->lambda, DECIMAL_DENOMINATOR_MAX, &stereo->scale, &stereo->weight));
    TRY(cost_read(set->cost, stereo));
    TRY(contrast_read(set->contrast, stereo));
    TRY(border_read(set->border, stereo));
    return smoothness_read(set->smoothness, set->truncation, &asked->pairwise);
}

/* Reads MIN:MAX[:STEP]. The step of the preset depends on MIN and MAX. */
static int read_range(const char *text, pair *asked)
{
    TRY(disparity_range_read(text, "1", &asked->stereo));
    asked->range = range_of(asked->from, &asked->stereo);
    return disparity_range_read(text, asked->range->step, &asked->stereo);
}

int pair_set_labels(const char *const *values, uint32_t pixels, pair *asked)
{
    char text[sizeof "0:4294967295"];
    (void)snprintf(text, sizeof text, "0:%" PRIu32, pixels - 1);
    TRY(read_range(text, asked));
    return read_settings(values, asked);
}

int pair_read(const char *const *operands, const char *const *values, void *state)
{
    pair *asked = state;
    uint32_t bits = 0;
    memset(asked, 0, sizeof *asked);
    asked->left = operands[0];
    asked->right = operands[1];
    TRY(preset_read(values[PAIR_PRESET], &asked->from));
    TRY(read_range(values[PAIR_DISPARITY], asked));
    TRY(read_settings(values, asked));
    TRY(read_roi(values[PAIR_ROI], asked));
    if (values[PAIR_BITS] != NULL) {
        TRY(number_read("--bits", values[PAIR_BITS], 9, 16, &bits));
    }
    asked->bits = bits;
    return DONE;
}

/* Checks that a pixel of the columns from `start` to `end` - 1 has all its matches in the right
 * picture. */
static int check_columns(const pair *asked, int64_t start, int64_t end)
{
    int32_t parts = (int32_t)asked->stereo.parts;
    int64_t most = asked->stereo.disparity_max / parts, least = asked->stereo.disparity_min / parts;
    int64_t width = (int64_t)asked->stereo.right.width;
    const char *window = asked->whole ? "the picture" : "--roi";
    if (asked->stereo.border == QS_BORDER_KEEP) {
        return DONE;
    }
    if (end <= most) {
        return fail(BAD_INPUT, input_name(asked->left),
                    "%s has its last column at %" PRId64 ", but disparity %" PRId64
                    " needs one at %" PRId64 " or further right: no pixel would have all its "
                    "matches inside the right picture; lower --disparity%s",
                    window, end - 1, most, most, asked->whole ? "" : " or move --roi to the right");
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
    const qs_matching *stereo = &asked->stereo;
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

/* The costs of the paper, for which there is a faster way. */
static bool is_plain(const qs_matching *of)
{
    const qs_match_term *term = &of->terms[0];
    return of->term_count == 1 && term->cost == QS_MATCH_AD && term->weight == 1 &&
           term->truncation == 0 && of->parts == 1 && of->border == QS_BORDER_LEAVE_OUT &&
           of->contrast_below == 0;
}

static qs_stereo plain_of(const qs_matching *of)
{
    return (qs_stereo){.left = of->left,
                       .right = of->right,
                       .cost = QS_COST_AD,
                       .disparity_min = of->disparity_min,
                       .disparity_max = of->disparity_max,
                       .x = of->x,
                       .y = of->y,
                       .width = of->width,
                       .height = of->height,
                       .scale = of->scale,
                       .weight = of->weight};
}

int pair_problem(const qs_matching *matching, const char *name, budget *limit, qs_problem *problem,
                 qs_status *made)
{
    const qs_stereo stereo = plain_of(matching);
    bool simple = is_plain(matching);
    size_t size = simple ? qs_stereo_workspace(&stereo) : qs_matching_workspace(matching);
    void *workspace = budget_take(limit, name, size > 0 ? size : 1);
    if (workspace == NULL) {
        return NO_RESOURCE;
    }
    *made = simple ? qs_stereo_problem(&stereo, workspace, size, problem)
                   : qs_matching_problem(matching, workspace, size, problem);
    return DONE;
}

int pair_make(pair *asked, budget *limit, made_problem *opened)
{
    qs_status status;
    opened->name = input_name(asked->left);
    opened->mend = "--lambda or --truncation";
    TRY(check_geometry(asked));
    TRY(pair_problem(&asked->stereo, opened->name, limit, &opened->problem, &status));
    if (status != QS_OK) {
        return made_fail(opened, "choose a smaller --roi or --disparity", status);
    }
    opened->problem.pairwise = asked->pairwise;
    return DONE;
}

static int pair_open(void *state, budget *limit, made_problem *opened)
{
    pair *asked = state;
    TRY(picture_read_grey(asked->left, asked->bits, limit, &asked->stereo.left));
    TRY(picture_read_grey(asked->right, asked->bits, limit, &asked->stereo.right));
    return pair_make(asked, limit, opened);
}

static void plan(const void *state, qs_problem *planned)
{
    const pair *asked = state;
    planned->labels = (uint32_t)(asked->stereo.disparity_max - asked->stereo.disparity_min) + 1;
    planned->scale = asked->stereo.scale;
    planned->pairwise = asked->pairwise;
}

const maker pair_maker = {sizeof(pair), pair_read, pair_open, plan};

void pair_json(const pair *asked)
{
    const pair_settings *set = &asked->settings;
    json_name("preset", asked->from->name);
    json_name("cost", set->cost);
    json_name("contrast", set->contrast);
    json_name("border", set->border);
    json_name("smoothness", set->smoothness);
    json_name("truncation", set->truncation);
    json_name("lambda", set->lambda);
    json_real("disparity_step", 1.0 / asked->stereo.parts);
}

static void print_columns(uint32_t count, const char *side, const char *right)
{
    if (count > 0) {
        printf("%" PRIu32 " column%s on the %s %s left out: a match would fall outside %s\n", count,
               plural(count), side, count == 1 ? "is" : "are", plain(right));
    }
}

void pair_print_outside(const pair *asked, const qs_problem *made)
{
    const qs_matching *stereo = &asked->stereo;
    uint32_t start = asked->whole ? 0 : stereo->x;
    uint32_t end = asked->whole ? (uint32_t)stereo->left.width : start + stereo->width;
    print_columns(made->frame.x - start, "left", asked->right);
    print_columns(end - made->frame.x - made->grid.width, "right", asked->right);
}
