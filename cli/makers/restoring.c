#include "makers/restoring.h"

#include <string.h>

#include "pictures/planes.h"
#include "smoothness.h"
#include "text/fail.h"
#include "text/names.h"
#include "text/numbers.h"

/* The largest scale at which a squared difference of greys fits the library's costs. */
enum { SCALE_MAX = 32767 };

static const named costs[] = {{"absolute", QS_RESTORE_ABSOLUTE}, {"squared", QS_RESTORE_SQUARED}};
static const name_table restore_cost_names = {"cost", costs, 2, 2};

static int restoring_read(const char *const *operands, const char *const *values, void *state)
{
    restoring *asked = state;
    qs_restore *restore = &asked->restore;
    int cost;
    memset(asked, 0, sizeof *asked);
    asked->noisy = operands[0];
    asked->mask = values[RESTORING_HOLE];
    TRY(lambda_read(values[RESTORING_LAMBDA], SCALE_MAX, &restore->scale, &restore->weight));
    TRY(name_read(&restore_cost_names, values[RESTORING_COST], "", &cost));
    restore->cost = (qs_restore_cost)cost;
    TRY(smoothness_read(values[RESTORING_SMOOTHNESS], values[RESTORING_TRUNCATION],
                        &restore->pairwise));
    return number_read("--step", values[RESTORING_STEP], 1, 255, &restore->step);
}

static int read_hole(restoring *asked, budget *limit)
{
    const qs_image *noisy = &asked->restore.noisy;
    qs_image hole;
    TRY(grey_read(asked->mask, limit, &hole));
    TRY(same_size_check(asked->mask, hole.width, hole.height, asked->noisy, noisy->width,
                        noisy->height));
    asked->restore.hole = hole.pixels;
    return DONE;
}

static int restoring_open(void *state, budget *limit, made_problem *opened)
{
    restoring *asked = state;
    opened->name = input_name(asked->noisy);
    opened->mend = "--lambda or --truncation";
    TRY(plain_grey_read(asked->noisy, limit, &asked->restore.noisy));
    if (asked->mask != NULL) {
        TRY(read_hole(asked, limit));
    }
    size_t size = qs_restore_workspace();
    void *workspace = budget_take(limit, opened->name, size);
    if (workspace == NULL) {
        return NO_RESOURCE;
    }
    qs_status status = qs_restore_problem(&asked->restore, workspace, size, &opened->problem);
    return status == QS_OK
               ? DONE
               : made_fail(opened, "take a part of the picture, or a larger --step", status);
}

static void plan(const void *state, qs_problem *planned)
{
    const restoring *asked = state;
    planned->labels = 255 / asked->restore.step + 1;
    planned->scale = asked->restore.scale;
    planned->pairwise = asked->restore.pairwise;
}

const maker restoring_maker = {sizeof(restoring), restoring_read, restoring_open, plan};
