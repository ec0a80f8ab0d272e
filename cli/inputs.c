#include "inputs.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "json_check.h"
#include "messages.h"

static bool begins_with(const file_bytes *file, const char *magic)
{
    size_t length = strlen(magic);
    return memcmp(file->bytes, magic, file->size < length ? file->size : length) == 0;
}

bool samples_are(const file_bytes *file)
{
    return begins_with(file, "\x89QSF");
}

bool problem_is(const file_bytes *file)
{
    return begins_with(file, "\x89QCF");
}

/* Says what is wrong with a file and where. `kind` is what it should be, `other` what it is
 * instead, if known. */
static int fail_fault(const char *name, qs_status status, const qs_fault *fault, const char *kind,
                      const char *other)
{
    if (status == QS_E_FORMAT) {
        return fail(BAD_INPUT, name, "is not a %s file%s%s", kind, other != NULL ? " but " : "",
                    other != NULL ? other : "");
    }
    return fail(BAD_INPUT, name, "%s %s at byte %" PRIu64 ": %s", kind, qs_status_text(status),
                fault->offset, fault->what != NULL ? fault->what : "cannot be read");
}

int problem_take(const char *path, file_bytes file, const budget *limit, problem_file *opened)
{
    qs_fault fault = {0, NULL};
    memset(opened, 0, sizeof *opened);
    opened->name = input_name(path);
    opened->file = file;
    qs_status status = qs_qubo_open(file.bytes, file.size, limit->left, &opened->qubo, &fault);
    if (status == QS_OK) {
        opened->scale = opened->qubo.has_labels ? opened->qubo.labels.scale : 1;
        return DONE;
    }
    int failed = status == QS_E_LIMIT
                     ? budget_fail(limit, opened->name)
                     : fail_fault(opened->name, status, &fault, ".qcf",
                                  samples_are(&file) ? "a .qsf: samples of a problem" : NULL);
    file_free(&opened->file);
    return failed;
}

int samples_take(const char *path, file_bytes file, samples_file *opened)
{
    qs_fault fault = {0, NULL};
    memset(opened, 0, sizeof *opened);
    opened->name = input_name(path);
    opened->file = file;
    qs_status status = qs_samples_open(file.bytes, file.size, &opened->view, &fault);
    if (status == QS_OK && json_is_object(opened->view.info, opened->view.info_size)) {
        return DONE;
    }
    int failed = status == QS_OK
                     ? fail(BAD_INPUT, opened->name, ".qsf damaged: its INFO is not a JSON object")
                     : fail_fault(opened->name, status, &fault, ".qsf",
                                  problem_is(&file) ? "a .qcf: a problem" : NULL);
    file_free(&opened->file);
    return failed;
}

/* The digest says which problem the samples are of. */
static int check_match(const answer *both)
{
    uint8_t digest[QS_DIGEST_SIZE];
    const qs_samples_view *samples = &both->samples.view;
    qs_digest(both->problem.file.bytes, both->problem.file.size, digest);
    if (memcmp(digest, samples->problem, QS_DIGEST_SIZE) != 0) {
        return fail(BAD_INPUT, both->samples.name,
                    "samples of another problem than %s (its digest differs): solve this one",
                    both->problem.name);
    }
    if (samples->variables != both->problem.qubo.variables) {
        return fail(BAD_INPUT, both->samples.name,
                    "samples of %" PRIu32 " variables, but %s has %" PRIu32, samples->variables,
                    both->problem.name, both->problem.qubo.variables);
    }
    return DONE;
}

int problem_open(const char *path, budget *limit, problem_file *opened)
{
    file_bytes file;
    memset(opened, 0, sizeof *opened);
    int status = file_read(path, limit, &file);
    return status == DONE ? problem_take(path, file, limit, opened) : status;
}

int problem_index(problem_file *problem, budget *limit)
{
    size_t size = qs_index_workspace(&problem->qubo);
    int status = budget_allocate(limit, problem->name, size, &problem->workspace);
    if (status != DONE) {
        return status;
    }
    qs_status built = qs_index_build(&problem->qubo, problem->workspace, size, &problem->index);
    if (built == QS_E_CORRUPT) {
        return fail(BAD_INPUT, problem->name, ".qcf damaged: its couplings do not fit its groups");
    }
    return built == QS_OK ? DONE : fail_status(problem->name, built);
}

void problem_close(problem_file *closed)
{
    free(closed->workspace);
    closed->workspace = NULL;
    file_free(&closed->file);
}

uint64_t labels_left(const qs_labels *labels)
{
    uint64_t left = labels->sites - labels->undecided;
    size_t bytes = (size_t)labels->undecided * (((size_t)labels->labels + 7) / 8);
    if (labels->fixed_bytes == 0) {
        return left + (uint64_t)labels->undecided * labels->labels;
    }
    for (size_t i = 0; i < bytes; i++) {
        for (unsigned bits = labels->sets[i]; bits != 0; bits &= bits - 1) {
            left++;
        }
    }
    return left;
}

int answer_open_samples(answer *both, const char *samples_path, budget *limit)
{
    file_bytes file;
    int status = file_read(samples_path, limit, &file);
    if (status == DONE) {
        status = samples_take(samples_path, file, &both->samples);
    }
    if (status == DONE) {
        status = check_match(both);
        if (status != DONE) {
            answer_close_samples(both);
        }
    }
    return status;
}

void answer_close_samples(answer *both)
{
    file_free(&both->samples.file);
}

int answer_open(const char *problem_path, const char *samples_path, budget *limit, answer *opened)
{
    memset(opened, 0, sizeof *opened);
    int status = problem_open(problem_path, limit, &opened->problem);
    if (status == DONE) {
        status = answer_open_samples(opened, samples_path, limit);
    }
    if (status == DONE) {
        status = problem_index(&opened->problem, limit);
    }
    if (status != DONE) {
        answer_close(opened);
    }
    return status;
}

void answer_close(answer *closed)
{
    problem_close(&closed->problem);
    answer_close_samples(closed);
}
