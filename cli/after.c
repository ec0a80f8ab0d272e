#include "after.h"

#include <string.h>

#include "pictures/picture_write.h"
#include "solver_work.h"
#include "text/fail.h"

static const char *const step_names[] = {"halves", "refine", "check", "fill", "median"};
enum { STEPS = sizeof step_names / sizeof step_names[0] };

/* Reads names with commas between, each at most once and in the order of the steps. */
static bool read_steps(const char *text, bool wanted[STEPS])
{
    memset(wanted, 0, STEPS * sizeof *wanted);
    if (strcmp(text, "none") == 0) {
        return true;
    }
    for (int i = 0; i < STEPS; i++) {
        size_t length = strlen(step_names[i]);
        bool next = strncmp(text, step_names[i], length) == 0;
        if (next && text[length] == '\0') {
            wanted[i] = true;
            return true;
        }
        if (next && text[length] == ',') {
            wanted[i] = true;
            text += length + 1;
        }
    }
    return false;
}

/* Those of the preset, without halves where the labels are half pixels already. */
static const char *preset_steps(const pair *asked)
{
    static const char first[] = "halves,";
    const char *steps = asked->range->after;
    bool have_halves = strncmp(steps, first, strlen(first)) == 0;
    return asked->stereo.parts > 1 && have_halves ? steps + strlen(first) : steps;
}

/* Whether half pixels can be made of the labels. */
static int check_halves(const pair *asked, const after *read)
{
    if (!read->halves) {
        return DONE;
    }
    if (asked->stereo.parts > 1) {
        return fail_usage("--after halves goes with whole pixels: give --disparity MIN:MAX:1, or "
                          "--after without halves");
    }
    if (asked->pairwise.smoothness == QS_TRUNCATED_QUADRATIC) {
        return fail_usage("--after halves goes with --smoothness potts or linear: give --after "
                          "without halves");
    }
    return read->refine ? fail_usage("--after has halves and refine: choose one") : DONE;
}

int after_read(const char *const *values, const pair *asked, after *read)
{
    bool wanted[STEPS];
    memset(read, 0, sizeof *read);
    read->steps = values[AFTER_STEPS] != NULL ? values[AFTER_STEPS] : preset_steps(asked);
    if (!read_steps(read->steps, wanted)) {
        return fail_usage("--after %s is not none, nor some of halves,refine,check,fill,median in "
                          "this order",
                          read->steps);
    }
    read->halves = wanted[0];
    read->refine = wanted[1];
    read->check = wanted[2];
    read->fill = wanted[3];
    read->median = wanted[4];
    TRY(check_halves(asked, read));
    read->confidence = values[AFTER_CONFIDENCE];
    read->mask = values[AFTER_MASK];
    if (read->check && asked->stereo.border != QS_BORDER_KEEP) {
        return fail_usage("--after check goes with --border keep: it needs a value at every pixel "
                          "of the right picture");
    }
    if (read->confidence != NULL) {
        TRY(picture_format_read(read->confidence, &read->confidence_png));
    }
    return read->mask != NULL ? picture_format_read(read->mask, &read->mask_png) : DONE;
}

int after_open(after *asked, job *at)
{
    if (asked->confidence != NULL) {
        TRY(job_open_beside(at, "confidence", asked->confidence, &asked->files[0]));
    }
    return asked->mask != NULL ? job_open_beside(at, "mask", asked->mask, &asked->files[1]) : DONE;
}

static int refine(const laid_out *laid, const solved *found, pixel_map *map)
{
    int32_t finer = QS_REFINED_UNIT / (int32_t)map->unit;
    if (map->most > INT32_MAX / finer - 1 || map->least < -(INT32_MAX / finer)) {
        return fail(BAD_INPUT, laid->name, "its disparities are too large to be refined");
    }
    qs_status status =
        qs_map_refine(&laid->model, &laid->labels, found->labelling, map->disparities);
    map->unit = QS_REFINED_UNIT;
    map->least *= finer;
    map->most *= finer;
    return status == QS_OK ? DONE : fail_status(laid->name, status);
}

/* The map of a side, in sixteenths of a pixel if it is to be refined. */
static int make_map(const after *asked, const side *of, budget *limit, pixel_map *map)
{
    const laid_out *laid = &of->laid;
    if (of->halved) {
        return map_of_labelling(laid->name, &of->finer.labels, of->finer.labelling, limit, map);
    }
    TRY(map_of_labelling(laid->name, &laid->labels, of->found.labelling, limit, map));
    return asked->refine ? refine(laid, &of->found, map) : DONE;
}

/* Solves the right picture's problem, unless that is done. */
static int solve_right(const after *asked, const pair *of, const solver *by, const search *how,
                       budget *limit, side *right)
{
    search last = *how;
    last.follow_up = false;
    if (right->found.labelling == NULL) {
        right->halved = asked->halves;
        TRY(right_side_make(of, by, how->iterations, !asked->refine, limit, right));
        TRY(work_whole(&right->laid, by, &last, side_halves(right), limit, &right->found));
    }
    return solved_check(&right->laid, by, &right->found);
}

static void mirror_rows(pixel_map *map)
{
    for (size_t y = 0; y < map->height; y++) {
        int32_t *row = map->disparities + y * map->width;
        for (size_t x = 0; x < map->width / 2; x++) {
            int32_t value = row[x];
            row[x] = row[map->width - 1 - x];
            row[map->width - 1 - x] = value;
        }
    }
}

/* Takes out what the map of the right picture does not confirm within half a pixel, or, of whole
 * pixels, within one. */
static int compare(const after *asked, const pair *of, const side *confirming, budget *limit,
                   pixel_map *map)
{
    pixel_map right;
    TRY(make_map(asked, confirming, limit, &right));
    uint32_t tolerance = map->unit > 1 ? map->unit / 2 : 1;
    mirror_rows(&right);
    qs_status checked = qs_map_check(map->disparities, right.disparities, map->width, map->height,
                                     map->unit, tolerance);
    return checked == QS_OK ? DONE : fail_status(input_name(of->left), checked);
}

static int check(const after *asked, const pair *of, const solver *by, const search *how,
                 budget *limit, side *right, pixel_map *map)
{
    budget aside = budget_inside(limit);
    int status = solve_right(asked, of, by, how, &aside, right);
    if (status == DONE) {
        status = compare(asked, of, right, &aside, map);
    }
    budget_free(&aside);
    return status;
}

static int write_mask(const after *asked, const pixel_map *map)
{
    picture made = {map->width, map->height, 1, 255, NULL};
    if (!picture_allocate(&made)) {
        return fail_memory(asked->mask);
    }
    for (size_t i = 0; i < made.width * made.height; i++) {
        made.samples[i] = map->disparities[i] == QS_NO_DISPARITY ? 0 : 255;
    }
    int status = picture_write(&made, asked->mask_png, asked->files[1]);
    picture_free(&made);
    return status;
}

/* The margins as greys, in units of the costs; at least 1 where there is a value that agrees.
 *
 * greys  out: one for each pixel of the map */
static void read_margins(const laid_out *laid, const uint32_t *margins, const pixel_map *map,
                         uint16_t *greys)
{
    const qs_frame *frame = &laid->labels.frame;
    for (size_t i = 0; i < (size_t)map->width * map->height; i++) {
        size_t x = i % map->width - frame->x, y = i / map->width - frame->y;
        bool inside = x < laid->model.width && y < laid->model.height;
        greys[i] = 0;
        if (inside && map->disparities[i] != QS_NO_DISPARITY) {
            uint32_t margin = margins[y * laid->model.width + x] / laid->scale;
            greys[i] = (uint16_t)(margin < 1 ? 1 : margin > 255 ? 255 : margin);
        }
    }
}

static int write_confidence(const after *asked, const laid_out *laid, const solved *found,
                            const pixel_map *map, budget *limit)
{
    const qs_model *model = &laid->model;
    uint32_t unit = laid->labels.meaning.unit > 0 ? laid->labels.meaning.unit : 1;
    size_t size = qs_margins_workspace(model);
    void *workspace = budget_take(limit, laid->name, size);
    uint32_t *margins = budget_take(limit, laid->name, sizeof *margins * model->sites);
    uint16_t *greys = budget_take(limit, laid->name, sizeof *greys * map->width * map->height);
    picture made = {map->width, map->height, 1, 255, NULL};
    if (workspace == NULL || margins == NULL || greys == NULL) {
        return NO_RESOURCE;
    }
    qs_status status = qs_margins(model, found->labelling, unit, workspace, size, margins);
    if (status != QS_OK) {
        return status == QS_E_OVERFLOW ? fail(BAD_INPUT, laid->name,
                                              "its costs are too large for --confidence: choose a "
                                              "smaller --lambda")
                                       : fail_status(laid->name, status);
    }
    if (!picture_allocate(&made)) {
        return fail_memory(asked->confidence);
    }
    read_margins(laid, margins, map, greys);
    status = qs_map_mean(greys, map->width, map->height, made.samples);
    int written = status == QS_OK ? picture_write(&made, asked->confidence_png, asked->files[0])
                                  : fail_status(laid->name, status);
    picture_free(&made);
    return written;
}

static int take_median(const char *name, pixel_map *map, budget *limit)
{
    size_t size = (size_t)map->width * map->height * sizeof *map->disparities;
    int32_t *out = budget_take(limit, name, size);
    if (out == NULL) {
        return NO_RESOURCE;
    }
    qs_status status = qs_map_median(map->disparities, map->width, map->height, out);
    map->disparities = out;
    return status == QS_OK ? DONE : fail_status(name, status);
}

/* Fills the holes of the window that is matched; what lies outside of it has no value. */
static int fill_window(const char *name, const pair *of, pixel_map *map)
{
    const qs_matching *window = &of->stereo;
    if (window->width == 0) {
        qs_status status = qs_map_fill(map->disparities, map->width, map->height);
        return status == QS_OK ? DONE : fail_status(name, status);
    }
    for (uint32_t y = window->y; y < window->y + window->height; y++) {
        int32_t *row = map->disparities + (size_t)y * map->width + window->x;
        qs_status status = qs_map_fill(row, window->width, 1);
        if (status != QS_OK) {
            return fail_status(name, status);
        }
    }
    return DONE;
}

int after_labels(const after *asked, const pair *of, const side *left, const solver *by,
                 const search *how, budget *limit, side *right, pixel_map *map)
{
    const laid_out *laid = &left->laid;
    TRY(make_map(asked, left, limit, map));
    if (asked->check) {
        TRY(check(asked, of, by, how, limit, right, map));
    }
    if (asked->mask != NULL) {
        TRY(write_mask(asked, map));
    }
    if (asked->confidence != NULL) {
        TRY(write_confidence(asked, laid, &left->found, map, limit));
    }
    if (asked->fill) {
        TRY(fill_window(laid->name, of, map));
    }
    return asked->median ? take_median(laid->name, map, limit) : DONE;
}
