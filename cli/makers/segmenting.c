#include "makers/segmenting.h"

#include <inttypes.h>
#include <string.h>

#include "pictures/planes.h"
#include "smoothness.h"
#include "text/fail.h"
#include "text/numbers.h"

/* Costs are rounded to a thousandth of a nat, or finer if lambda has such a denominator. */
enum { UNITS = 1000 };

int segmenting_read(const char *const *operands, const char *const *values, void *state)
{
    segmenting *asked = state;
    qs_segment *segment = &asked->segment;
    uint32_t denominator;
    memset(asked, 0, sizeof *asked);
    asked->photo = operands[0];
    asked->strokes = operands[1];
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
                    "has a stroke of class %" PRIu32 ", but --classes is %" PRIu32, most,
                    segment->classes);
    }
    return DONE;
}

static int read_pictures(segmenting *asked, budget *limit)
{
    qs_segment *segment = &asked->segment;
    colours photo;
    qs_image strokes;
    TRY(colours_read(asked->photo, limit, &photo));
    TRY(numbers_picture_read(asked->strokes, limit, &strokes));
    TRY(same_size_check(asked->strokes, strokes.width, strokes.height, asked->photo, photo.width,
                        photo.height));
    segment->photo = photo.pixels;
    segment->width = photo.width;
    segment->height = photo.height;
    segment->stride = (size_t)photo.width * photo.channels;
    segment->channels = photo.channels;
    segment->strokes = strokes.pixels;
    return count_classes(asked);
}

int segmenting_open(void *state, budget *limit, made_problem *opened)
{
    segmenting *asked = state;
    opened->name = input_name(asked->photo);
    opened->mend = "--lambda";
    TRY(read_pictures(asked, limit));
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
