/* A .qpf, checked against the golden problems: whatever it says, it proves no bound above an
 * optimum. QSTEREO_GOLDEN is their folder (default tests/golden). */
#include <qstereo.h>
#include <string.h>

#include "fuzz.h"

enum { FILE_SIZE = 4096, PROBLEMS = 6 };

typedef struct problem {
    uint8_t file[FILE_SIZE];
    qs_qubo qubo;
    qs_index index;
    int64_t optimum;
    size_t work; /* bytes of the workspace: it is large, so it is taken once */
    void *workspace;
    uint8_t *left;
} problem;

static problem problems[PROBLEMS];

/* Golden problems are small: best proves each. */
static int64_t find_optimum(const qs_index *index)
{
    qs_model model;
    qs_solution solution;
    size_t size = qs_model_workspace(index->qubo);
    void *memory = malloc(size + 1);
    PROMISE(qs_model_build(index, memory, size, &model) == QS_OK);
    size_t work = qs_best_workspace(&model);
    void *workspace = malloc(work + 1);
    uint16_t *labelling = calloc(model.sites + (size_t)1, sizeof *labelling);
    PROMISE(qs_best(&model, NULL, workspace, work, labelling, &solution) == QS_OK);
    PROMISE(solution.energy == solution.lower_bound);
    free(labelling);
    free(workspace);
    free(memory);
    return solution.energy;
}

static void load(const char *name, problem *to)
{
    const char *folder = getenv("QSTEREO_GOLDEN");
    char path[4096];
    snprintf(path, sizeof path, "%s/%s.qcf", folder ? folder : "tests/golden", name);
    FILE *file = fopen(path, "rb");
    PROMISE(file != NULL);
    size_t size = fread(to->file, 1, sizeof to->file, file);
    fclose(file);
    PROMISE(qs_qubo_open(to->file, size, UINT64_MAX, &to->qubo, NULL) == QS_OK);
    size_t bytes = qs_index_workspace(&to->qubo);
    /* All memory is kept to the end of the process. */
    PROMISE(qs_index_build(&to->qubo, malloc(bytes + 1), bytes, &to->index) == QS_OK);
    to->optimum = find_optimum(&to->index);
    to->work = qs_certificate_workspace(&to->index);
    to->workspace = malloc(to->work + 1);
    to->left = malloc(to->qubo.variables + (size_t)to->qubo.groups + 1);
}

static void load_all(void)
{
    static const char *const names[PROBLEMS] = {"good-grid-sparse",     "good-edges-table",
                                                "good-masked-weighted", "recoded-domain-wall",
                                                "recoded-nothing",      "good-smallest"};
    for (int i = 0; i < PROBLEMS && problems[i].qubo.size == 0; i++) {
        load(names[i], &problems[i]);
    }
}

static void check(const problem *of, const qs_certificate *certificate)
{
    qs_verdict verdict;
    qs_fault fault = {0, NULL};
    qs_status status = qs_certificate_check(&of->index, certificate, of->workspace, of->work,
                                            &verdict, of->left, &fault);
    PROMISE(status == QS_OK || status == QS_E_CORRUPT || status == QS_E_OVERFLOW);
    if (status == QS_OK && verdict.valid) {
        PROMISE(verdict.lower_bound <= of->optimum && verdict.energy >= of->optimum);
    } else {
        PROMISE(status != QS_OK || verdict.why != NULL);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    qs_certificate certificate;
    qs_fault fault = {0, NULL};
    load_all();
    qs_status status = qs_certificate_open(data, size, &certificate, &fault);
    PROMISE((status == QS_OK) == (fault.what == NULL) && fault.offset <= size);
    for (int i = 0; status == QS_OK && i < PROBLEMS; i++) {
        check(&problems[i], &certificate);
    }
    return 0;
}
