#include "scores/flow_score.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "text/json.h"

/* The angle between (a, 1) and (b, 1) in degrees; by atan2, which is exact for small ones. */
static double angle(const float *a, const float *b)
{
    const double pi = 3.14159265358979323846;
    double ax = (double)a[0], ay = (double)a[1], bx = (double)b[0], by = (double)b[1];
    double cross_x = ay - by, cross_y = bx - ax, cross_z = ax * by - ay * bx;
    double cross = sqrt(cross_x * cross_x + cross_y * cross_y + cross_z * cross_z);
    return atan2(cross, ax * bx + ay * by + 1) * 180 / pi;
}

void flow_score_find(const flow_field *field, const flow_field *truth, flow_score *found)
{
    double ends = 0, angles = 0;
    memset(found, 0, sizeof *found);
    for (size_t i = 0; i < (size_t)field->width * field->height; i++) {
        const float *a = field->vectors + 2 * i, *b = truth->vectors + 2 * i;
        if (isnan(a[0]) || isnan(b[0])) {
            continue;
        }
        ends += hypot((double)a[0] - (double)b[0], (double)a[1] - (double)b[1]);
        angles += angle(a, b);
        found->pixels++;
    }
    if (found->pixels > 0) {
        found->aepe = ends / (double)found->pixels;
        found->aae = angles / (double)found->pixels;
    }
}

void flow_score_json(const flow_score *shown)
{
    json_count("pixels", shown->pixels);
    if (shown->pixels > 0) {
        json_real("aepe", shown->aepe);
        json_real("aae", shown->aae);
    } else {
        json_null("aepe");
        json_null("aae");
    }
}

void flow_score_print(const flow_score *shown)
{
    printf("endpoint error %.4f pixels, angular error %.3f degrees, over %" PRIu64 " pixels\n",
           shown->aepe, shown->aae, shown->pixels);
}
