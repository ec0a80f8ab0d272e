#include "scores/label_score.h"

#include <stdio.h>
#include <string.h>

#include "text/json.h"

void label_score_find(const qs_image *map, const qs_image *truth, label_score *found)
{
    memset(found, 0, sizeof *found);
    found->pixels = (uint64_t)map->width * map->height;
    for (size_t y = 0; y < map->height; y++) {
        const uint8_t *a = map->pixels + y * map->stride, *b = truth->pixels + y * truth->stride;
        for (size_t x = 0; x < map->width; x++) {
            found->either[a[x]]++;
            if (a[x] == b[x]) {
                found->both[a[x]]++;
            } else {
                found->either[b[x]]++;
                found->wrong++;
            }
        }
    }
}

static double iou_of(const label_score *of, int value)
{
    return (double)of->both[value] / (double)of->either[value];
}

double label_score_iou(const label_score *of)
{
    double sum = 0;
    int classes = 0;
    for (int value = 0; value < LABEL_VALUES; value++) {
        if (of->either[value] > 0) {
            sum += iou_of(of, value);
            classes++;
        }
    }
    return sum / classes;
}

static double error_rate(const label_score *of)
{
    return (double)of->wrong / (double)of->pixels;
}

void label_score_json(const label_score *shown)
{
    json_count("pixels", shown->pixels);
    json_real("iou", label_score_iou(shown));
    json_real("error_rate", error_rate(shown));
    json_list("classes");
    for (int value = 0; value < LABEL_VALUES; value++) {
        if (shown->either[value] > 0) {
            json_item();
            json_count("class", (uint64_t)value);
            json_real("iou", iou_of(shown, value));
            json_item_end();
        }
    }
    json_list_end();
}

void label_score_print(const label_score *shown)
{
    printf("iou %.4f", label_score_iou(shown));
    const char *before = " (";
    for (int value = 0; value < LABEL_VALUES; value++) {
        if (shown->either[value] > 0) {
            printf("%sclass %d: %.4f", before, value, iou_of(shown, value));
            before = ", ";
        }
    }
    printf("), error rate %.4f\n", error_rate(shown));
}
