#include "recoding.h"

#include <stdlib.h>
#include <string.h>

#include "messages.h"

static qs_status recode(const laid_out *problem, const qs_recode_options *options, uint64_t left,
                        growing_file *grown)
{
    size_t size = qs_recode_workspace(&problem->model, options);
    void *workspace = size <= left ? malloc(size > 0 ? size : 1) : NULL;
    *grown = growing_begin(left - (workspace != NULL ? size : 0));
    const qs_sink sink = {growing_append, grown};
    if (workspace == NULL) {
        grown->over = size > left;
        grown->refused = size <= left;
        return QS_E_IO;
    }
    qs_status status = qs_recode(&problem->model, &problem->problem->qubo.labels, options, &sink,
                                 workspace, size, NULL);
    free(workspace);
    return status;
}

qs_status recode_quietly(const laid_out *problem, const qs_recode_options *options, budget *limit,
                         file_bytes *made)
{
    growing_file grown;
    qs_status status = recode(problem, options, limit->left, &grown);
    if (status != QS_OK) {
        file_free(&grown.file);
        return status == QS_E_IO ? QS_E_LIMIT : status;
    }
    limit->left -= grown.file.size;
    *made = grown.file;
    return QS_OK;
}

static int fail_recode(const char *name, const char *mend, qs_status status)
{
    if (status == QS_E_LIMIT) {
        return fail(BAD_INPUT, name,
                    "has over %u variables in this encoding: choose another, or a smaller window",
                    QS_VARIABLES_MAX);
    }
    if (status == QS_E_OVERFLOW) {
        return fail(BAD_INPUT, name,
                    "the coefficients overflow (their sum is above 2^53): choose a smaller %s",
                    mend);
    }
    return fail_status(name, status);
}

int recode_problem(const laid_out *problem, const qs_recode_options *options, const char *mend,
                   budget *limit, problem_file *made)
{
    const char *name = problem->problem->name;
    growing_file grown;
    memset(made, 0, sizeof *made);
    qs_status written = recode(problem, options, limit->left, &grown);
    if (written != QS_OK && written != QS_E_IO) {
        file_free(&grown.file);
        return fail_recode(name, mend, written);
    }
    int status = growing_end(&grown, name, limit);
    return status == DONE ? problem_take(name, grown.file, limit, made) : status;
}
