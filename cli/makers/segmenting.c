#include "makers/segmenting.h"

#include <inttypes.h>
#include <string.h>

#include "arrays/units.h"
#include "pictures/planes.h"
#include "smoothness.h"
#include "text/fail.h"
#include "text/numbers.h"

/* Costs are rounded to a thousandth of a nat, or finer if lambda has such a denominator. */
enum { UNITS = 1000 };

static int segmenting_read(const char *const *operands, const char *const *values, void *state)
{
    segmenting *asked = state;
    qs_segment *segment = &asked->segment;
    uint32_t denominator;
    memset(asked, 0, sizeof *asked);
    asked->photo = operands[0];
    asked->strokes = operands[1];
    asked->costs = values[SEGMENTING_COSTS];
    if (asked->strokes == NULL && asked->costs == NULL) {
        return fail_usage("the operand STROKES is missing: give it, or --costs");
    }
    TRY(lambda_read(values[SEGMENTING_LAMBDA], UNITS, &denominator, &segment->weight));
    segment->scale = UNITS % denominator == 0 ? UNITS : UNITS * denominator;
    int64_t weight = (int64_t)segment->weight * (segment->scale / denominator);
    if (weight > INT32_MAX) {
        return fail_usage("--lambda %s is too large: it can be up to 2000",
                          values[SEGMENTING_LAMBDA]);
    }
    segment->weight = (int32_t)weight;
    return values[SEGMENTING_CLASSES] == NULL ? DONE
                                              : number_read("--classes", values[SEGMENTING_CLASSES],
                                                            2, QS_CLASSES_MAX, &segment->classes);
}

/* The number of classes is that of the strokes if it was not given. */
static int count_classes(segmenting *asked)
{
    qs_segment *segment = &asked->segment;
    uint32_t most = 0;
    for (size_t i = 0; i < (size_t)segment->width * segment->height; i++) {
        most = segment->strokes[i] > most ? segment->strokes[i] : most;
    }
    if (most == 0) {
        return fail(BAD_INPUT, input_name(asked->strokes),
                    "has no stroke: each pixel that is not 0 marks one of the class of its value");
    }
    if (segment->classes == 0) {
        segment->classes = most < 2 ? 2 : most;
    }
    if (most > segment->classes) {
        return fail(BAD_INPUT, input_name(asked->strokes),
                    "has a stroke of class %" PRIu32 ", but there are %" PRIu32 " classes", most,
                    segment->classes);
    }
    return DONE;
}

static int read_strokes(segmenting *asked, budget *limit)
{
    qs_segment *segment = &asked->segment;
    qs_image strokes;
    TRY(numbers_picture_read(asked->strokes, limit, &strokes));
    TRY(same_size_check(asked->strokes, strokes.width, strokes.height, asked->photo, segment->width,
                        segment->height));
    segment->strokes = strokes.pixels;
    return count_classes(asked);
}

/* The last dimension says how many classes there are. */
static int read_costs(segmenting *asked, budget *limit)
{
    qs_segment *segment = &asked->segment;
    const units as = {{segment->scale, 1}, "a cost", "divide the costs and --lambda", true, false};
    char shape[NPY_TEXT];
    npy_array array;
    TRY(npy_open(asked->costs, limit, &array));
    npy_shape_write(&array, shape);
    if (array.dimensions != 3 || array.shape[0] != segment->height ||
        array.shape[1] != segment->width || array.shape[2] < 2 || array.shape[2] > QS_CLASSES_MAX ||
        (segment->classes != 0 && segment->classes != array.shape[2])) {
        return fail(BAD_INPUT, array.name,
                    "has the shape %s, but %" PRIu32 " x %" PRIu32
                    " x classes is needed, from 2 to %u classes, as many as --classes says",
                    shape, segment->height, segment->width, QS_CLASSES_MAX);
    }
    segment->classes = (uint32_t)array.shape[2];
    return units_read(&array, &as, limit, &segment->costs);
}

static int read_inputs(segmenting *asked, budget *limit)
{
    qs_segment *segment = &asked->segment;
    colours photo;
    TRY(colours_read(asked->photo, limit, &photo));
    segment->photo = photo.pixels;
    segment->width = photo.width;
    segment->height = photo.height;
    segment->stride = (size_t)photo.width * photo.channels;
    segment->channels = photo.channels;
    if (asked->costs != NULL) {
        TRY(read_costs(asked, limit));
    }
    return asked->strokes != NULL ? read_strokes(asked, limit) : DONE;
}

static int segmenting_open(void *state, budget *limit, made_problem *opened)
{
    segmenting *asked = state;
    opened->name = input_name(asked->photo);
    opened->mend = "--lambda";
    TRY(read_inputs(asked, limit));
    size_t size = qs_segment_workspace(&asked->segment);
    asked->workspace = budget_take(limit, opened->name, size);
    if (asked->workspace == NULL) {
        return NO_RESOURCE;
    }
    qs_status status =
        qs_segment_problem(&asked->segment, asked->workspace, size, &opened->problem);
    return status == QS_OK ? DONE : made_fail(opened, "take a part of the picture", status);
}

const maker segmenting_maker = {sizeof(segmenting), segmenting_read, segmenting_open, NULL};
