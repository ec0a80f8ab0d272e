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
    *found = (map_errors){score.pixels, {0, 0, 0}};
    if (score.pixels > 0) {
        divide(&score, map->scale, truth->scale, found->of);
    }
    return DONE;
}

void map_errors_json(const map_errors *shown)
{
    static const char *const keys[ERRORS] = {"rms", "bad_0_5", "bad_1_0"};
    json_count("pixels", shown->pixels);
    for (size_t i = 0; i < ERRORS; i++) {
        if (shown->pixels > 0) {
            json_real(keys[i], shown->of[i]);
        } else {
            json_null(keys[i]);
        }
    }
}

void map_errors_print(const map_errors *shown)
{
    printf("pixels   %" PRIu64 "\n", shown->pixels);
    if (shown->pixels > 0) {
        printf("rms      %.4f pixels\nbad-0.5  %.2f %%\nbad-1.0  %.2f %%\n", shown->of[ERROR_RMS],
               shown->of[ERROR_BAD_HALF], shown->of[ERROR_BAD_ONE]);
    }
}

int truth_scale_read(const char *text, uint32_t *scale)
{
    return number_read("--truth-scale", text, 1, 65536, scale);
}

int truth_open(const char *path, uint32_t scale, uint32_t width, uint32_t height, budget *limit,
               true_map *opened)
{
    *opened = (true_map){.name = input_name(path)};
    TRY(map_read(path, scale, limit, &opened->map));
    if (opened->map.width != width || opened->map.height != height) {
        return fail(BAD_INPUT, opened->name,
                    "is %zu x %zu pixels, but the left picture is %" PRIu32 " x %" PRIu32,
                    opened->map.width, opened->map.height, width, height);
    }
    return DONE;
}

int truth_compare(const true_map *with, const pixel_map *map, map_errors *found)
{
    const qs_map compared = {map->disparities, map->width, map->height, 1};
    return map_errors_find("the map", &compared, with->name, &with->map, found);
}
