#include "certifying.h"

#include <string.h>

#include "text/fail.h"
#include "text/numbers.h"

static int fail_record(const certifying *made, const char *by, qs_status status)
{
    const char *name = made->problem->name;
    switch (status) {
    case QS_E_ENCODING:
        return fail(BAD_INPUT, name,
                    "%s writes no certificate of this problem, which it solves without messages: "
                    "use --solver trws, or leave --certificate out",
                    by);
    case QS_E_OVERFLOW:
        return fail(BAD_INPUT, name,
                    "its costs are too large for a certificate: leave --certificate out");
    default: return fail_status(name, status);
    }
}

uint64_t certifying_bytes(const laid_out *problem, uint64_t work)
{
    const qs_index *index = &problem->file->index;
    uint64_t check = qs_certificate_workspace(index);
    return bytes_sum(qs_recorder_workspace(index, &problem->model), check > work ? check : work);
}

int certifying_begin(const laid_out *problem, budget *limit, output *out, certifying *made)
{
    const qs_index *index = &problem->file->index;
    size_t size = qs_recorder_workspace(index, &problem->model);
    memset(made, 0, sizeof *made);
    made->problem = problem;
    made->limit = limit;
    made->out = out;
    made->stages = growing_begin(limit->left, 0);
    made->sink = (qs_sink){growing_append, &made->stages};
    void *workspace = budget_take(limit, problem->name, size);
    if (workspace == NULL) {
        return NO_RESOURCE;
    }
    qs_status status =
        qs_recorder_begin(&made->recorder, index, &problem->model, workspace, size, &made->sink);
    if (status == QS_E_ENCODING) {
        return fail(BAD_INPUT, problem->name,
                    "couples the same two sites more than once, which a certificate cannot hold: "
                    "leave --certificate out");
    }
    if (status == QS_E_LIMIT) {
        return fail(BAD_INPUT, problem->name,
                    "has a site with more than 65536 neighbours, which a certificate cannot hold: "
                    "leave --certificate out");
    }
    made->witness = qs_recorder_witness(&made->recorder);
    return status == QS_OK ? DONE : fail_status(problem->name, status);
}

static qs_status write_file(const certifying *made, const uint16_t *labelling, int64_t bound,
                            int64_t energy, qs_sink sink)
{
    const file_bytes *stages = &made->stages.file;
    return qs_certificate_write(&made->recorder, labelling, bound, energy, stages->bytes,
                                stages->size, &sink, NULL);
}

/* Checks the certificate that states no bound yet. Whatever the solver says, the bound that counts
 * is the one that the checker finds. */
static int find_bound(const certifying *made, const file_bytes *file, budget *work,
                      int64_t *lower_bound)
{
    const char *name = made->problem->name;
    const qs_index *index = &made->problem->file->index;
    qs_certificate view;
    qs_verdict verdict;
    qs_fault fault = {0, NULL};
    size_t size = qs_certificate_workspace(index);
    void *workspace = budget_take(work, name, size);
    if (workspace == NULL) {
        return NO_RESOURCE;
    }
    qs_status status = qs_certificate_open(file->bytes, file->size, &view, NULL);
    if (status == QS_OK) {
        status = qs_certificate_check(index, &view, workspace, size, &verdict, NULL, &fault);
    }
    if (status == QS_E_OVERFLOW) {
        return fail_record(made, "", status);
    }
    if (status != QS_OK || !verdict.valid) {
        return fail(NO_RESOURCE, name,
                    "internal error: the certificate does not hold (%s); please report this",
                    status != QS_OK ? fault.what : verdict.why);
    }
    *lower_bound = verdict.lower_bound;
    return DONE;
}

static int check_trial(certifying *made, const uint16_t *labelling, int64_t energy, budget *work,
                       int64_t *lower_bound)
{
    growing_file trial = growing_begin(work->left, 0);
    file_bytes file;
    trial.counts = true;
    (void)write_file(made, labelling, QS_NO_BOUND, energy, (qs_sink){growing_append, &trial});
    TRY(growing_end(&trial, made->out->name, work));
    file = trial.file;
    return find_bound(made, &file, work, lower_bound);
}

/* Says where the answer states less than it would without a certificate, or may do so: none holds a
 * long search of packing, nor what messages before the last ones prove, nor a search of a part that
 * is too wide. */
static void warn_of_less(const certifying *made, int64_t found, int64_t certified, int64_t energy)
{
    const laid_out *problem = made->problem;
    char known[DECIMAL_SIZE], proven[DECIMAL_SIZE] = "none";
    if (found > certified) {
        decimal_write(found, problem->scale, known);
        if (certified != QS_NO_BOUND) {
            decimal_write(certified, problem->scale, proven);
        }
        warn(problem->name,
             "the solver found the lower bound %s, but the certificate cannot hold it and proves "
             "%s: the answer states that too. Without --certificate it states %s",
             known, proven, known);
    } else if (made->recorder.has_refused && certified < energy) {
        warn(problem->name,
             "a part of the problem is too wide for a certificate: without --certificate the lower "
             "bound may be higher");
    }
}

int certifying_end(certifying *made, const char *by, const uint16_t *labelling, int64_t energy,
                   int64_t *lower_bound)
{
    qs_status status = qs_recorder_end(&made->recorder);
    if (status != QS_OK && status != QS_E_IO) { /* growing_end says what was refused */
        certifying_abandon(made);
        return fail_record(made, by, status);
    }
    TRY(growing_end(&made->stages, made->out->name, made->limit));
    budget work = budget_inside(made->limit);
    int64_t found = *lower_bound;
    int checked = check_trial(made, labelling, energy, &work, lower_bound);
    budget_free(&work);
    if (checked != DONE) {
        return checked;
    }
    status = write_file(made, labelling, *lower_bound, energy, (qs_sink){output_sink, made->out});
    warn_of_less(made, found, *lower_bound, energy);
    /* The end of the command reports refused bytes. */
    return status == QS_OK || status == QS_E_IO ? DONE : fail_status(made->out->name, status);
}

void certifying_abandon(certifying *made)
{
    file_free(&made->stages.file);
}
