#include "makers/displacing.h"

#include <string.h>

#include "pictures/planes.h"
#include "smoothness.h"
#include "text/fail.h"
#include "text/numbers.h"

enum { UNIT_MAX = 16, SCALE_MAX = 1000 };

static int read_radius(const char *text, qs_displace *displace)
{
    uint32_t radius[2];
    if (numbers_read(text, ',', radius, 1)) {
        radius[1] = radius[0];
    } else if (!numbers_read(text, ',', radius, 2)) {
        return fail_usage("--radius %s is not R or RX,RY, whole numbers of pixels", text);
    }
    uint64_t columns = 2 * (uint64_t)radius[0] * displace->unit + 1,
             rows = 2 * (uint64_t)radius[1] * displace->unit + 1;
    if (columns > QS_LABELS_MAX || rows > QS_LABELS_MAX || columns * rows > QS_LABELS_MAX) {
        return fail_usage("--radius %s at --fraction %lu gives more than %u displacements: lower "
                          "one of them",
                          text, (unsigned long)displace->unit, QS_LABELS_MAX);
    }
    displace->radius_x = radius[0] * displace->unit;
    displace->radius_y = radius[1] * displace->unit;
    return DONE;
}

static int read_window(const char *text, uint32_t *window)
{
    TRY(number_read("--window", text, 1, 255, window));
    return *window % 2 == 1
               ? DONE
               : fail_usage("--window %s is even: it must be odd, so that a pixel is its middle",
                            text);
}

static int read_truncation(const char *text, qs_displace *displace)
{
    fraction pixels;
    decimal_status status = decimal_read(text, INT32_MAX / UNIT_MAX, displace->unit, &pixels);
    if (status == DECIMAL_OK && displace->unit % pixels.denominator != 0) {
        status = DECIMAL_TOO_FINE;
    }
    if (status != DECIMAL_OK) {
        return decimal_fail("--truncation", text, status, "a multiple of 1/N pixel (--fraction N)");
    }
    displace->truncation = (uint32_t)pixels.numerator * (displace->unit / pixels.denominator);
    return DONE;
}

static int displacing_read(const char *const *operands, const char *const *values, void *state)
{
    displacing *asked = state;
    qs_displace *displace = &asked->displace;
    memset(asked, 0, sizeof *asked);
    asked->first = operands[0];
    asked->second = operands[1];
    TRY(lambda_read(values[DISPLACING_LAMBDA], SCALE_MAX, &displace->scale, &displace->weight));
    TRY(number_read("--step", values[DISPLACING_STEP], 1, 65535, &displace->step));
    TRY(read_window(values[DISPLACING_WINDOW], &displace->window));
    TRY(number_read("--fraction", values[DISPLACING_UNIT], 1, UNIT_MAX, &displace->unit));
    TRY(read_radius(values[DISPLACING_RADIUS], displace));
    return read_truncation(values[DISPLACING_TRUNCATION], displace);
}

static int displacing_open(void *state, budget *limit, made_problem *opened)
{
    displacing *asked = state;
    qs_displace *displace = &asked->displace;
    opened->name = input_name(asked->first);
    opened->mend = "--lambda, --window or --fraction";
    TRY(grey_read(asked->first, limit, &displace->first));
    TRY(grey_read(asked->second, limit, &displace->second));
    TRY(same_size_check(asked->second, displace->second.width, displace->second.height,
                        asked->first, displace->first.width, displace->first.height));
    size_t size = qs_displace_workspace(displace);
    void *workspace = budget_take(limit, opened->name, size);
    if (workspace == NULL) {
        return NO_RESOURCE;
    }
    qs_status status = qs_displace_problem(displace, workspace, size, &opened->problem);
    return status == QS_OK ? DONE
                           : made_fail(opened,
                                       "choose a larger --step, or a smaller --radius or "
                                       "--fraction",
                                       status);
}

const maker displacing_maker = {sizeof(displacing), displacing_read, displacing_open, NULL};

int displacing_truth_read(const displacing *asked, const char *path, budget *limit,
                          flow_field *truth)
{
    const qs_image *first = &asked->displace.first;
    TRY(flow_read(path, limit, truth));
    return same_size_check(path, truth->width, truth->height, asked->first, first->width,
                           first->height);
}
