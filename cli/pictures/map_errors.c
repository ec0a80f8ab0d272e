#include "pictures/map_errors.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#include "text/json.h"
#include "text/fail.h"
#include "text/numbers.h"

/* Equations (6) and (7) of the paper, from the exact sums of the library. */
static void divide(const qs_score *score, uint32_t scale, uint32_t truth_scale,
                   double errors[ERRORS])
{
    double pixels = (double)score->pixels;
    double squares = ldexp((double)score->squares_high, 64) + (double)score->squares_low;
    errors[ERROR_RMS] = sqrt(squares / pixels) / ((double)scale * truth_scale);
    errors[ERROR_BAD_HALF] = 100.0 * (double)score->bad_half / pixels;
    errors[ERROR_BAD_ONE] = 100.0 * (double)score->bad_one / pixels;
    errors[ERROR_BAD_TWO] = 100.0 * (double)score->bad_two / pixels;
    errors[ERROR_D1] = 100.0 * (double)score->d1 / pixels;
    double sum = ldexp((double)score->sum_high, 64) + (double)score->sum_low;
    errors[ERROR_AVERAGE] = sum / pixels / ((double)scale * truth_scale);
}

int map_errors_find(const char *name, const qs_map *map, const char *truth_name,
                    const qs_map *truth, map_errors *found)
{
    qs_score score;
    qs_status compared = qs_score_map(map, truth, &score);
    if (compared == QS_E_GEOMETRY) {
        return fail(BAD_INPUT, truth_name, "is %zu x %zu pixels, but %s is %zu x %zu", truth->width,
                    truth->height, name, map->width, map->height);
    }
    if (compared != QS_OK) {
        return fail_status(name, compared);
    }
    *found = (map_errors){.pixels = score.pixels};
    if (score.truths > 0) {
        found->density = 100.0 * (double)score.pixels / (double)score.truths;
    }
    if (score.pixels > 0) {
        divide(&score, map->scale, truth->scale, found->of);
    }
    return DONE;
}

static void json_error(const map_errors *shown, const char *key, double error)
{
    if (shown->pixels > 0) {
        json_real(key, error);
    } else {
        json_null(key);
    }
}

void map_errors_json(const map_errors *shown)
{
    json_count("pixels", shown->pixels);
    json_error(shown, "rms", shown->of[ERROR_RMS]);
    json_error(shown, "bad_0_5", shown->of[ERROR_BAD_HALF]);
    json_error(shown, "bad_1_0", shown->of[ERROR_BAD_ONE]);
}

void map_errors_json_more(const map_errors *shown)
{
    json_error(shown, "bad_2_0", shown->of[ERROR_BAD_TWO]);
    json_error(shown, "average", shown->of[ERROR_AVERAGE]);
    json_error(shown, "d1", shown->of[ERROR_D1]);
    json_error(shown, "density", shown->density);
}

void map_errors_print(const map_errors *shown)
{
    printf("pixels   %" PRIu64 "\n", shown->pixels);
    if (shown->pixels > 0) {
        printf("rms      %.4f pixels\nbad-0.5  %.2f %%\nbad-1.0  %.2f %%\n", shown->of[ERROR_RMS],
               shown->of[ERROR_BAD_HALF], shown->of[ERROR_BAD_ONE]);
    }
}

void map_errors_print_more(const map_errors *shown)
{
    if (shown->pixels > 0) {
        printf("bad-2.0  %.2f %%\naverage  %.4f pixels\nD1       %.2f %%\n",
               shown->of[ERROR_BAD_TWO], shown->of[ERROR_AVERAGE], shown->of[ERROR_D1]);
    }
    printf("density  %.2f %% of the pixels with a true value\n", shown->density);
}

void map_errors_warn(const char *name, const map_errors *found)
{
    enum { NEARLY_ALL = 90 };
    if (found->pixels > 0 && found->of[ERROR_BAD_ONE] > NEARLY_ALL) {
        warn(name,
             "%.4g %% of the pixels are wrong by more than 1: are the scales right (--scale, "
             "--truth-scale)?",
             found->of[ERROR_BAD_ONE]);
    }
}

int truth_form_read(const char *scale, const char *no_value, map_form *form)
{
    return map_form_read("--truth-scale", scale, "--truth-no-value", no_value, form);
}

int truth_open(const char *path, const map_form *form, uint32_t width, uint32_t height,
               budget *limit, true_map *opened)
{
    *opened = (true_map){.name = input_name(path)};
    TRY(map_read(path, form, limit, &opened->map));
    if (opened->map.width != width || opened->map.height != height) {
        return fail(BAD_INPUT, opened->name,
                    "is %zu x %zu pixels, but the left picture is %" PRIu32 " x %" PRIu32,
                    opened->map.width, opened->map.height, width, height);
    }
    return DONE;
}

int truth_compare(const true_map *with, const pixel_map *map, map_errors *found)
{
    const qs_map compared = {map->disparities, map->width, map->height, map->unit};
    return map_errors_find("the map", &compared, with->name, &with->map, found);
}
