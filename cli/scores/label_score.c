#include "scores/label_score.h"

#include <stdio.h>
#include <string.h>

#include "pictures/planes.h"
#include "pictures/picture_write.h"
#include "text/fail.h"
#include "text/json.h"

static int take_values(label_map *map, budget *limit)
{
    map->values = budget_take(limit, map->name, bytes_product(map->count, sizeof *map->values));
    return map->values != NULL ? DONE : NO_RESOURCE;
}

static int fail_value(const npy_array *array, uint64_t at)
{
    char index[NPY_TEXT], value[NPY_TEXT];
    npy_index_write(array, at, index);
    npy_value_write(array, at, value);
    return fail(BAD_INPUT, array->name,
                "%s is %s: labels are whole numbers from 0 to 65535, or -1 for none", index, value);
}

static int read_array(const char *path, budget *limit, label_map *read)
{
    npy_array array;
    TRY(npy_open(path, limit, &array));
    read->count = array.count;
    npy_shape_write(&array, read->shape);
    TRY(take_values(read, limit));
    for (uint64_t i = 0; i < array.count; i++) {
        int32_t value;
        uint64_t bad;
        npy_scaling plain = {1, 1};
        if (array.kind == NPY_FLOAT ||
            npy_convert(&array, i, 1, plain, false, &value, &bad) != NPY_FITS || value < -1 ||
            value > UINT16_MAX) {
            return fail_value(&array, i);
        }
        read->values[i] = value;
    }
    return DONE;
}

int label_map_of(const picture *from, const char *name, budget *limit, label_map *made)
{
    *made = (label_map){.name = name};
    if (from->channels != 1) {
        return fail(BAD_INPUT, made->name,
                    "is a picture in colours: give a grey one, with one number per pixel");
    }
    made->count = (uint64_t)from->width * from->height;
    (void)snprintf(made->shape, sizeof made->shape, "%zu x %zu", from->height, from->width);
    TRY(take_values(made, limit));
    for (uint64_t i = 0; i < made->count; i++) {
        made->values[i] = from->samples[i];
    }
    return DONE;
}

int label_map_read(const char *path, budget *limit, label_map *read)
{
    picture from;
    *read = (label_map){.name = input_name(path)};
    if (path_ends(path, ".npy")) {
        return read_array(path, limit, read);
    }
    TRY(picture_open(path, limit, &from));
    int status = label_map_of(&from, input_name(path), limit, read);
    picture_free(&from);
    return status;
}

int label_map_check(const label_map *map, const label_map *truth)
{
    return strcmp(map->shape, truth->shape) == 0
               ? DONE
               : fail(BAD_INPUT, map->name,
                      "has %s values (rows x columns), but %s has %s: both need the same size",
                      map->shape, truth->name, truth->shape);
}

int label_score_find(const label_map *map, const label_map *truth, budget *limit,
                     label_score *found)
{
    const size_t size = LABEL_VALUES * sizeof *found->both;
    *found = (label_score){0, 0, budget_take(limit, map->name, size),
                           budget_take(limit, map->name, size)};
    if (found->both == NULL || found->either == NULL) {
        return NO_RESOURCE;
    }
    memset(found->both, 0, size);
    memset(found->either, 0, size);
    for (uint64_t i = 0; i < map->count; i++) {
        int32_t a = map->values[i], b = truth->values[i];
        if (a < 0 || b < 0) {
            continue;
        }
        found->pixels++;
        found->either[a]++;
        if (a == b) {
            found->both[a]++;
        } else {
            found->either[b]++;
            found->wrong++;
        }
    }
    return DONE;
}

static double iou_of(const label_score *of, int value)
{
    return (double)of->both[value] / (double)of->either[value];
}

static double mean_iou(const label_score *of)
{
    double sum = 0;
    int classes = 0;
    for (int value = 0; value < LABEL_VALUES; value++) {
        if (of->either[value] > 0) {
            sum += iou_of(of, value);
            classes++;
        }
    }
    return classes > 0 ? sum / classes : 0;
}

static double error_rate(const label_score *of)
{
    return of->pixels > 0 ? (double)of->wrong / (double)of->pixels : 0;
}

void label_score_json(const label_score *shown)
{
    json_count("pixels", shown->pixels);
    json_real("iou", mean_iou(shown));
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
    printf("iou %.4f", mean_iou(shown));
    const char *before = " (";
    for (int value = 0; value < LABEL_VALUES; value++) {
        if (shown->either[value] > 0) {
            printf("%sclass %d: %.4f", before, value, iou_of(shown, value));
            before = ", ";
        }
    }
    printf("), error rate %.4f\n", error_rate(shown));
}
