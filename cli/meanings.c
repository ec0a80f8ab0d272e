#include "meanings.h"

#include <string.h>

#include "text/fail.h"

static const char *const names[QS_MEANING_KINDS] = {"disparity", "number",       "grey",
                                                    "class",     "displacement", "keep"};

const char *meaning_name(qs_meaning_kind kind)
{
    return names[kind];
}

/* What label 0 stands for, and from one label to the next. */
static uint64_t value_of(const qs_labels *labels, uint32_t label)
{
    const qs_meaning *meaning = &labels->meaning;
    uint64_t step = meaning->kind == QS_MEANS_GREY ? meaning->step : 1;
    return (uint32_t)labels->frame.first + label * step; /* only disparities are below 0 */
}

static int check_grid(const char *name, const qs_labels *labels)
{
    return labels->width > 0 ? DONE
                             : fail(BAD_INPUT, name,
                                    "is not a problem on a grid of pixels, so no picture can be "
                                    "made from it");
}

/* The label of each pixel of the picture less frame.first, QS_NO_DISPARITY where there is none. */
static int place(const char *name, const qs_labels *labels, const uint16_t *labelling,
                 budget *limit, int32_t **placed)
{
    uint64_t pixels = (uint64_t)labels->frame.picture_width * labels->frame.picture_height;
    *placed = budget_take(limit, name, bytes_product(pixels, sizeof **placed));
    if (*placed == NULL) {
        return NO_RESOURCE;
    }
    qs_status status = qs_map_of_labelling(labels, labelling, *placed);
    return status == QS_OK ? DONE : fail_status(name, status);
}

static void fill(const qs_labels *labels, const int32_t *placed, picture *made)
{
    for (size_t i = 0; i < made->width * made->height; i++) {
        uint32_t label = (uint32_t)(placed[i] - labels->frame.first);
        made->samples[i] = placed[i] == QS_NO_DISPARITY ? 0 : (uint16_t)value_of(labels, label);
    }
}

int meaning_picture(const char *name, const qs_labels *labels, const uint16_t *labelling,
                    budget *limit, picture *made)
{
    int32_t *placed = NULL;
    uint64_t most = value_of(labels, labels->labels - 1);
    TRY(check_grid(name, labels));
    if (most > UINT16_MAX) {
        return fail(BAD_INPUT, name, "has values up to %llu: a picture holds at most 65535",
                    (unsigned long long)most);
    }
    TRY(place(name, labels, labelling, limit, &placed));
    *made = (picture){labels->frame.picture_width, labels->frame.picture_height, 1,
                      most > UINT8_MAX ? UINT16_MAX : UINT8_MAX, NULL};
    made->samples = budget_take(limit, name, made->width * made->height * sizeof *made->samples);
    if (made->samples == NULL) {
        return NO_RESOURCE;
    }
    fill(labels, placed, made);
    return DONE;
}

int meaning_image(const char *name, const qs_labels *labels, const uint16_t *labelling,
                  budget *limit, qs_image *made)
{
    picture from;
    TRY(meaning_picture(name, labels, labelling, limit, &from));
    uint8_t *pixels = budget_take(limit, name, from.width * from.height);
    if (pixels == NULL) {
        return NO_RESOURCE;
    }
    for (size_t i = 0; i < from.width * from.height; i++) {
        pixels[i] = (uint8_t)from.samples[i];
    }
    *made = (qs_image){pixels, from.width, from.height, from.width};
    return DONE;
}

static int fail_field(const char *name, qs_status status)
{
    return status == QS_E_ARGUMENT
               ? fail(BAD_INPUT, name,
                      "says that its labels are displacements of a grid of another size: it is "
                      "damaged")
               : fail_status(name, status);
}

int meaning_field(const char *name, const qs_labels *labels, const uint16_t *labelling,
                  budget *limit, flow_field *made)
{
    const qs_meaning *meaning = &labels->meaning;
    uint32_t width = labels->frame.picture_width, height = labels->frame.picture_height;
    TRY(check_grid(name, labels));
    TRY(flow_take(name, width, height, limit, made));
    size_t numbers = 2 * (size_t)width * height;
    int32_t *parts = budget_take(limit, name, numbers * sizeof *parts);
    if (parts == NULL) {
        return NO_RESOURCE;
    }
    qs_status status =
        qs_displace_field(meaning, labels->width, labels->height, labelling, width, height, parts);
    if (status != QS_OK) {
        return fail_field(name, status);
    }
    double units = (double)meaning->unit * meaning->step * meaning->step;
    for (size_t i = 0; i < numbers; i++) {
        made->vectors[i] = (float)(parts[i] / units);
    }
    return DONE;
}
