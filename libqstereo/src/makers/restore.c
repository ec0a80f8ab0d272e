#include "../../include/qstereo/restore.h"

#include <stdbool.h>
#include <string.h>

enum { GREYS = 256 };

typedef struct restorer {
    qs_restore restore;
    uint32_t labels;
    /* Of each grey of a pixel: the cost of every label less the least, and the least. */
    uint32_t costs[GREYS][GREYS];
    int32_t least[GREYS];
} restorer;

size_t qs_restore_workspace(void)
{
    return sizeof(restorer);
}

static uint32_t cost_of(const qs_restore *restore, uint32_t grey, uint32_t value)
{
    uint32_t apart = grey > value ? grey - value : value - grey;
    return restore->scale * (restore->cost == QS_RESTORE_SQUARED ? apart * apart : apart);
}

static void fill_table(restorer *r)
{
    for (uint32_t grey = 0; grey < GREYS; grey++) {
        uint32_t least = UINT32_MAX;
        for (uint32_t d = 0; d < r->labels; d++) {
            r->costs[grey][d] = cost_of(&r->restore, grey, d * r->restore.step);
            least = r->costs[grey][d] < least ? r->costs[grey][d] : least;
        }
        for (uint32_t d = 0; d < r->labels; d++) {
            r->costs[grey][d] -= least;
        }
        r->least[grey] = (int32_t)least;
    }
}

static void restore_row(void *context, uint32_t row, void *costs, int32_t *least)
{
    const restorer *r = context;
    const qs_image *noisy = &r->restore.noisy;
    const uint8_t *pixels = noisy->pixels + row * noisy->stride;
    const uint8_t *hole = r->restore.hole ? r->restore.hole + row * noisy->width : NULL;
    size_t bytes = r->labels * sizeof(uint32_t);
    for (size_t x = 0; x < noisy->width; x++) {
        uint8_t *to = (uint8_t *)costs + x * bytes;
        if (hole && hole[x] != 0) {
            memset(to, 0, bytes);
            least[x] = 0;
        } else {
            memcpy(to, r->costs[pixels[x]], bytes);
            least[x] = r->least[pixels[x]];
        }
    }
}

static bool is_restore(const qs_restore *restore)
{
    return restore && qs_image_is_valid(&restore->noisy) && restore->cost <= QS_RESTORE_SQUARED &&
           restore->step >= 1 && restore->step < GREYS && restore->scale >= 1 &&
           restore->scale <= INT32_MAX / (GREYS * GREYS);
}

qs_status qs_restore_problem(const qs_restore *restore, void *workspace, size_t workspace_size,
                             qs_problem *problem)
{
    if (!is_restore(restore) || !workspace || !problem) {
        return QS_E_ARGUMENT;
    }
    if (workspace_size < qs_restore_workspace()) {
        return QS_E_WORKSPACE;
    }
    restorer *r = workspace;
    r->restore = *restore;
    r->labels = (GREYS - 1) / restore->step + 1;
    fill_table(r);
    uint32_t width = (uint32_t)restore->noisy.width, height = (uint32_t)restore->noisy.height;
    qs_problem made = {
        .labels = r->labels,
        .scale = restore->scale,
        .weight = restore->weight,
        .pairwise = restore->pairwise,
        .grid = {.width = width, .height = height},
        .source = {restore_row, r, sizeof(uint32_t)},
        .frame = {.picture_width = width, .picture_height = height},
        .meaning = {.kind = QS_MEANS_GREY, .step = restore->step},
    };
    qs_status status = qs_problem_check(&made);
    if (status == QS_OK) {
        *problem = made;
    }
    return status;
}
