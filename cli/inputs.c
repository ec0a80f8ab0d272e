#include "inputs.h"

#include <inttypes.h>
#include <string.h>

#include "text/fail.h"
#include "text/json.h"
#include "text/numbers.h"

static bool begins_with(const file_bytes *file, const char *magic)
{
    size_t length = strlen(magic);
    return file->size > 0 &&
           memcmp(file->bytes, magic, file->size < length ? file->size : length) == 0;
}

bool samples_are(const file_bytes *file)
{
    return begins_with(file, "\x89QSF\r\n\x1a\n");
}

bool problem_is(const file_bytes *file)
{
    return begins_with(file, "\x89QCF\r\n\x1a\n");
}

int fail_kind(const char *name, const file_bytes *file, const char *wanted)
{
    const char *is = problem_is(file)                         ? "a .qcf: a problem"
                     : samples_are(file)                      ? "a .qsf: samples of a problem"
                     : begins_with(file, "\x89QPF\r\n\x1a\n") ? "a .qpf: a certificate"
                                                              : NULL;
    if (file->size == 0) {
        return fail(BAD_INPUT, name, "is empty: a %s file is needed here", wanted);
    }
    return fail(BAD_INPUT, name, "is not a %s file%s%s", wanted, is != NULL ? " but " : "",
                is != NULL ? is : "");
}

/* Prints what is wrong with a file, and where. `kind` is what it should be. */
static int fail_fault(const char *path, const file_bytes *file, qs_status status,
                      const qs_fault *fault, const char *kind)
{
    const char *name = input_name(path);
    if (status == QS_E_FORMAT || file->size == 0) {
        return fail_kind(name, file, kind);
    }
    return fail(BAD_INPUT, name, "%s %s at byte %" PRIu64 ": %s%s", kind, qs_status_text(status),
                fault->offset, fault->what != NULL ? fault->what : "cannot be read",
                status == QS_E_TRUNCATED ? "; copy it again" : "");
}

int problem_check(const char *path, file_bytes file, const budget *limit, problem_file *opened)
{
    qs_fault fault = {0, NULL};
    memset(opened, 0, sizeof *opened);
    opened->name = input_name(path);
    opened->file = file;
    qs_status status = qs_qubo_open(file.bytes, file.size, limit->left, &opened->qubo, &fault);
    if (status == QS_E_LIMIT) {
        TRY(budget_need(limit, opened->name, qs_index_workspace(&opened->qubo)));
        return fail_memory(opened->name); /* more than this machine can address */
    }
    if (status != QS_OK) {
        return fail_fault(path, &file, status, &fault, ".qcf");
    }
    opened->scale = opened->qubo.has_labels ? opened->qubo.labels.scale : 1;
    return DONE;
}

int samples_check(const char *path, file_bytes file, samples_file *opened)
{
    qs_fault fault = {0, NULL};
    memset(opened, 0, sizeof *opened);
    opened->name = input_name(path);
    opened->file = file;
    qs_status status = qs_samples_open(file.bytes, file.size, &opened->view, &fault);
    if (status != QS_OK) {
        return fail_fault(path, &file, status, &fault, ".qsf");
    }
    if (!json_is_object(opened->view.info, opened->view.info_size)) {
        return fail(BAD_INPUT, opened->name, ".qsf damaged: its INFO is not a JSON object");
    }
    return DONE;
}

int certificate_fail(const char *path, file_bytes file, qs_status status, const qs_fault *fault)
{
    return fail_fault(path, &file, status, fault, ".qpf");
}

int certificate_check(const char *path, file_bytes file, qs_certificate *opened)
{
    qs_fault fault = {0, NULL};
    qs_status status = qs_certificate_open(file.bytes, file.size, opened, &fault);
    return status == QS_OK ? DONE : certificate_fail(path, file, status, &fault);
}

/* The digest says which problem the samples are of. */
static int check_match(const answer *both)
{
    uint8_t digest[QS_DIGEST_SIZE];
    const qs_samples_view *samples = &both->samples.view;
    qs_digest(both->problem.file.bytes, both->problem.file.size, digest);
    if (memcmp(digest, samples->problem, QS_DIGEST_SIZE) != 0) {
        return fail(BAD_INPUT, both->samples.name,
                    "holds samples of another problem than %s (the digests differ): give the "
                    "samples of this problem",
                    both->problem.name);
    }
    if (samples->variables != both->problem.qubo.variables) {
        return fail(BAD_INPUT, both->samples.name,
                    "holds samples of %" PRIu32 " variables, but %s has %" PRIu32,
                    samples->variables, both->problem.name, both->problem.qubo.variables);
    }
    return DONE;
}

int problem_open(const char *path, budget *limit, problem_file *opened)
{
    file_bytes file;
    TRY(file_read(path, limit, &file));
    return problem_check(path, file, limit, opened);
}

/* Refuses a lower bound above H of the labelling that the file carries beside it. */
static int check_known(const problem_file *problem, budget *limit)
{
    const qs_known *known = &problem->qubo.known;
    char stated[DECIMAL_SIZE], found[DECIMAL_SIZE];
    if (known->bytes == 0 || known->lower_bound == QS_NO_BOUND) {
        return DONE;
    }
    budget work = budget_inside(limit);
    uint8_t *bits = budget_take(&work, problem->name, ((size_t)problem->qubo.variables + 7) / 8);
    if (bits == NULL) {
        return NO_RESOURCE;
    }
    qs_qubo_known_state(&problem->qubo, bits);
    int64_t energy = qs_qubo_energy(&problem->index, bits);
    budget_free(&work);
    if (known->lower_bound <= energy) {
        return DONE;
    }
    decimal_write(known->lower_bound, problem->scale, stated);
    decimal_write(energy, problem->scale, found);
    return fail(BAD_INPUT, problem->name,
                "states the lower bound %s, but the labelling that it carries has the energy %s: "
                "one of them is wrong, so reduce the problem again",
                stated, found);
}

int problem_index(problem_file *problem, budget *limit)
{
    size_t size = qs_index_workspace(&problem->qubo);
    void *workspace = budget_take(limit, problem->name, size);
    if (workspace == NULL) {
        return NO_RESOURCE;
    }
    qs_status built = qs_index_build(&problem->qubo, workspace, size, &problem->index);
    if (built == QS_E_CORRUPT) {
        return fail(BAD_INPUT, problem->name, ".qcf damaged: its couplings do not fit its groups");
    }
    return built == QS_OK ? check_known(problem, limit) : fail_status(problem->name, built);
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

int answer_take_samples(answer *both, const char *samples_path, file_bytes file)
{
    TRY(samples_check(samples_path, file, &both->samples));
    return check_match(both);
}

int answer_open_samples(answer *both, const char *samples_path, budget *limit)
{
    file_bytes file;
    TRY(file_read(samples_path, limit, &file));
    return answer_take_samples(both, samples_path, file);
}
