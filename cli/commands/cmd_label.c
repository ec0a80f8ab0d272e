#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "makers/labelling.h"
#include "one_go.h"
#include "pictures/picture_write.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/numbers.h"

static const option options[] = {
    [ONE_GO_OUTPUT] = {"output", 'o', true, "LABELS.npy", NULL,
                       "the label of each site, 32-bit integers, -1 for masked cells; - is "
                       "standard output"},
    ONE_GO_OPTION_ROWS("labels.npy to compare with: how many labels differ, and its energy"),
    [ONE_GO_MAKER] = LABELLING_OPTION_ROWS,
};

/* An array of one label for each site or cell. */
typedef struct label_array {
    uint64_t shape[2];
    unsigned dimensions;
    int32_t *labels;
    size_t count;
} label_array;

/* The labels as an array: of a grid all its cells. */
static int make_array(const one_go *run, budget *limit, label_array *made)
{
    const qs_problem *problem = &run->made.problem;
    const qs_grid *grid = &problem->grid;
    bool is_grid = grid->width > 0;
    const uint16_t *labelling = run->found.labelling;
    made->count = is_grid ? (size_t)grid->width * grid->height : problem->sites;
    made->dimensions = is_grid ? 2 : 1;
    made->shape[0] = is_grid ? grid->height : problem->sites;
    made->shape[1] = grid->width;
    made->labels = budget_take(limit, run->made.name, made->count * sizeof *made->labels);
    if (made->labels == NULL) {
        return NO_RESOURCE;
    }
    for (size_t i = 0; i < made->count; i++) {
        bool masked = is_grid && grid->mask != NULL && grid->mask[i] == 0;
        made->labels[i] = masked ? -1 : *labelling++;
    }
    return DONE;
}

static void write_array(const label_array *written, output *out)
{
    uint8_t head[NPY_HEAD];
    size_t size = npy_head_write(written->shape, written->dimensions, head);
    (void)(output_write(out, head, size) &&
           output_write(out, written->labels, written->count * sizeof *written->labels));
}

/* ---- The truth. ---- */

/* Reads it, before the problem is solved. */
static int read_truth(const one_go *run, budget *limit, const int32_t **truth)
{
    const units as = {{1, 1}, "a label", "give the number of a label", true, false};
    const qs_problem *problem = &run->made.problem;
    npy_array array;
    bool grid = problem->grid.width > 0;
    TRY(npy_open(run->truth, limit, &array));
    bool same = grid ? array.dimensions == 2 && array.shape[0] == problem->grid.height &&
                           array.shape[1] == problem->grid.width
                     : array.dimensions == 1 && array.shape[0] == problem->sites;
    if (!same) {
        char shape[NPY_TEXT];
        npy_shape_write(&array, shape);
        return fail(BAD_INPUT, array.name, "has the shape %s, but a label for each %s is needed",
                    shape, grid ? "cell, H x W," : "site");
    }
    return units_read(&array, &as, limit, truth);
}

/* What there is to say of the truth beside what was found. */
typedef struct score {
    uint64_t sites, wrong;
    bool has_energy; /* each of its labels exists and is allowed */
    int64_t energy; /* F of the truth */
} score;

/* F of the truth. */
static int find_energy(const one_go *run, uint16_t *labelling, budget *limit, score *found)
{
    const qs_problem *problem = &run->made.problem;
    size_t size = qs_problem_workspace(problem);
    void *workspace = budget_take(limit, run->made.name, size);
    if (workspace == NULL) {
        return NO_RESOURCE;
    }
    found->has_energy =
        qs_problem_energy(problem, labelling, workspace, size, &found->energy) == QS_OK;
    return DONE;
}

static int find_score(const one_go *run, const label_array *labels, const int32_t *truth,
                      budget *limit, score *found)
{
    uint16_t *labelling = budget_take(limit, run->made.name, labels->count * sizeof *labelling);
    bool exist = true;
    memset(found, 0, sizeof *found);
    if (labelling == NULL) {
        return NO_RESOURCE;
    }
    for (size_t i = 0; i < labels->count; i++) {
        if (labels->labels[i] >= 0) {
            found->wrong += labels->labels[i] != truth[i];
            exist = exist && truth[i] >= 0 && (uint32_t)truth[i] < run->made.problem.labels;
            labelling[found->sites++] = (uint16_t)truth[i];
        }
    }
    return exist ? find_energy(run, labelling, limit, found) : DONE;
}

static void print_score(const job *at, const score *found, uint32_t scale)
{
    if (at->json) {
        json_count("sites", found->sites);
        json_count("wrong", found->wrong);
        json_units_or_null("truth_energy", found->has_energy, found->energy, scale);
        return;
    }
    printf("%" PRIu64 " of %" PRIu64 " label%s differ (%.2f %%)", found->wrong, found->sites,
           plural(found->sites), 100.0 * (double)found->wrong / (double)found->sites);
    if (found->has_energy) {
        char energy[DECIMAL_SIZE];
        decimal_write(found->energy, scale, energy);
        printf(", the truth has energy %s", energy);
    }
    putchar('\n');
}

static int run_label(job *at)
{
    one_go run;
    labelling_request asked;
    label_array found;
    score compared;
    const int32_t *truth = NULL;
    output *out;
    const char *path = at->values[ONE_GO_OUTPUT];
    if (!path_ends(path, ".npy") && !output_is_straight(path)) {
        return fail_usage("-o %s: the name of an array ends in .npy", path);
    }
    TRY(one_go_read(at, &run));
    TRY(one_go_open(at, &labelling_maker, &asked, &run));
    if (run.truth != NULL) {
        TRY(read_truth(&run, &at->limit, &truth));
    }
    TRY(job_open_output(at, at->values[ONE_GO_OUTPUT], &out));
    TRY(one_go_solve(at, &run));
    TRY(make_array(&run, &at->limit, &found));
    if (truth != NULL) {
        TRY(find_score(&run, &found, truth, &at->limit, &compared));
    }
    write_array(&found, out);
    TRY(job_commit(at));
    if (!one_go_print(at, &run)) {
        return DONE;
    }
    if (truth != NULL) {
        print_score(at, &compared, run.laid.scale);
    }
    one_go_end(at);
    return DONE;
}

const command cmd_label = {
    .line =
        {
            .name = "label",
            .operands = {"COSTS.npy"},
            .about =
                "Solves any labelling problem: each site takes one of K labels. COSTS.npy holds "
                "what each label costs at each site, H x W x K for the cells of a grid; "
                "neighbours p and q cost lambda weight_pq V(label of p, label of q). Of V, a "
                "table or a weight the first site is the left or upper one, or the first of the "
                "edge. qstereo solve --help describes the solvers.\n\n"
                "Arrays are .npy files of any integers, or of floats of 32 or 64 bits, in C order. "
                "An "
                "infinite cost forbids a label. Integers stay exact; floats are rounded to "
                "1 / --scale.\n",
            OPTIONS(options),
            .examples =
                "  qstereo label costs.npy -o labels.npy --lambda 2.5\n"
                "  qstereo label costs.npy -o labels.npy --smoothness linear --truncation 2 \\\n"
                "      --weights right.npy,down.npy\n"
                "  qstereo label costs.npy -o labels.npy --edges edges.npy --tables tables.npy\n",
        },
    .summary = "solve any labelling problem, given as arrays of numpy",
    .run = run_label,
};
