/* Labellings placed into pictures. */
#include "tiny.h"

#include <string.h>

enum { ROUNDS = 500, WIDTH = 20, HEIGHT = 18 };

static void every_site_stands_at_its_pixel(void **unused)
{
    (void)unused;
    uint64_t state = 81;
    static uint64_t memory[1 << 12];
    for (int round = 0; round < ROUNDS; round++) {
        tiny t;
        tiny_make(&t, &state, 24, true);
        const qs_grid *grid = &t.problem.grid;
        if (grid->width == 0) {
            continue;
        }
        qs_frame frame = {WIDTH, HEIGHT, tiny_random(&state, WIDTH - grid->width + 1),
                          tiny_random(&state, HEIGHT - grid->height + 1),
                          (int32_t)tiny_random(&state, 100) - 50};
        if (round % 3 > 0) {
            t.problem.frame = frame;
        } else { /* the grid is the picture */
            frame = (qs_frame){grid->width, grid->height, 0, 0, 0};
        }
        qs_model model;
        qs_labels labels;
        assert_int_equal(qs_model_of_problem(&t.problem, memory, sizeof memory, &model, &labels),
                         QS_OK);
        uint16_t labelling[TINY_SITES];
        int32_t map[WIDTH * HEIGHT];
        for (uint32_t p = 0; p < labels.sites; p++) {
            labelling[p] = (uint16_t)tiny_random(&state, labels.labels);
        }
        assert_int_equal(qs_map_of_labelling(&labels, labelling, map), QS_OK);
        uint32_t site = 0;
        for (uint32_t y = 0; y < frame.picture_height; y++) {
            for (uint32_t x = 0; x < frame.picture_width; x++) {
                int32_t held = map[y * frame.picture_width + x];
                bool inside = x >= frame.x && x < frame.x + grid->width && y >= frame.y &&
                              y < frame.y + grid->height;
                if (inside &&
                    (!grid->mask || grid->mask[(y - frame.y) * grid->width + x - frame.x] != 0)) {
                    assert_int_equal(held, frame.first + labelling[site]);
                    site++;
                } else {
                    assert_int_equal(held, QS_NO_DISPARITY);
                }
            }
        }
        assert_int_equal(site, labels.sites);
    }
}

static void refusals(void **unused)
{
    (void)unused;
    uint16_t labelling[4] = {0, 1, 2, 0};
    int32_t map[12], untouched[12];
    qs_labels labels = {.labels = 3, .width = 2, .height = 2, .frame = {4, 3, 2, 1, 5}, .sites = 4};
    assert_int_equal(qs_map_of_labelling(&labels, labelling, map), QS_OK);
    assert_int_equal(map[6], 5);
    assert_int_equal(map[11], 5);
    memset(map, 0x11, sizeof map);
    memcpy(untouched, map, sizeof map);
    labelling[3] = 3;
    assert_int_equal(qs_map_of_labelling(&labels, labelling, map), QS_E_ARGUMENT);
    labelling[3] = 0;
    labels.frame.x = 3;
    assert_int_equal(qs_map_of_labelling(&labels, labelling, map), QS_E_GEOMETRY);
    labels.frame.x = 2;
    labels.frame.y = 2;
    assert_int_equal(qs_map_of_labelling(&labels, labelling, map), QS_E_GEOMETRY);
    labels.frame.y = 1;
    labels.frame.first = INT32_MAX - 1;
    assert_int_equal(qs_map_of_labelling(&labels, labelling, map), QS_E_OVERFLOW);
    labels.width = labels.height = 0;
    assert_int_equal(qs_map_of_labelling(&labels, labelling, map), QS_E_GEOMETRY);
    assert_int_equal(qs_map_of_labelling(NULL, labelling, map), QS_E_ARGUMENT);
    assert_int_equal(qs_map_of_labelling(&labels, NULL, map), QS_E_ARGUMENT);
    assert_int_equal(qs_map_of_labelling(&labels, labelling, NULL), QS_E_ARGUMENT);
    assert_memory_equal(map, untouched, sizeof map);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_site_stands_at_its_pixel),
        cmocka_unit_test(refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
