#include "makers/detecting.h"

#include <string.h>

#include "text/fail.h"

static int detecting_read(const char *const *operands, const char *const *values, void *state)
{
    detecting *asked = state;
    (void)values;
    memset(asked, 0, sizeof *asked);
    asked->path = operands[0];
    return DONE;
}

static int detecting_open(void *state, budget *limit, made_problem *opened)
{
    detecting *asked = state;
    opened->name = input_name(asked->path);
    opened->mend = "score";
    TRY(boxes_read(asked->path, true, limit, &asked->file));
    if (asked->file.count == 0) {
        return fail(BAD_INPUT, opened->name, "has no box below its line of names");
    }
    size_t size = qs_overlap_workspace(asked->file.boxes, asked->file.count);
    void *workspace = budget_take(limit, opened->name, size);
    if (workspace == NULL) {
        return NO_RESOURCE;
    }
    qs_status status =
        qs_overlap_problem(asked->file.boxes, asked->file.count, workspace, size, &opened->problem);
    return status == QS_OK ? DONE : made_fail(opened, "give fewer boxes", status);
}

const maker detecting_maker = {sizeof(detecting), detecting_read, detecting_open, NULL};
