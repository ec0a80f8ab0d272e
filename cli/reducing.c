#include "reducing.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "decimal.h"
#include "gap.h"
#include "json.h"
#include "messages.h"
#include "names.h"
#include "numbers.h"
#include "progress.h"

int reducing_read(const char *const *values, qs_encoding into, reducing *asked)
{
    memset(asked, 0, sizeof *asked);
    asked->into = into;
    int status = DONE;
    if (values[REDUCING_TARGET] != NULL) {
        if (into != QS_ONE_HOT && into != QS_ONE_HOT_SPARSE && into != QS_DOMAIN_WALL) {
            return fail_usage(
                "--target goes with --encoding one-hot, one-hot-sparse or domain-wall, not with %s",
                name_of(&encoding_names, (int)into));
        }
        status =
            number64_read("--target", values[REDUCING_TARGET], 1, QS_VARIABLES_MAX, &asked->target);
    }
    if (status == DONE && values[REDUCING_TIME_LIMIT] != NULL) {
        status = seconds_read("--time-limit", values[REDUCING_TIME_LIMIT], &asked->time_limit);
    }
    return status;
}

static int run_reduction(const laid_out *problem, const reducing *asked, void *workspace,
                         size_t size, uint16_t *labelling, reduced *made)
{
    progress watched = progress_begin("reduce", problem->problem->scale, asked->time_limit);
    const qs_reduce_options options = {asked->iterations, asked->target,
                                       asked->into == QS_DOMAIN_WALL, progress_watch_reduction,
                                       &watched};
    qs_status ran =
        qs_reduce(&problem->model, &options, workspace, size, made->kept, labelling, &made->found);
    made->microseconds = progress_end(&watched);
    made->out_of_time = watched.out_of_time;
    made->target = asked->target;
    if (ran != QS_OK) {
        return fail_status(problem->problem->name, ran);
    }
    /* An optimum is always left. */
    if (made->found.undecided == 0) {
        made->found.lower_bound = made->found.upper_bound;
    }
    return DONE;
}

int reduce_problem(const laid_out *problem, const reducing *asked, budget *limit, reduced *made)
{
    const qs_model *model = &problem->model;
    const char *name = problem->problem->name;
    void *kept = NULL, *workspace = NULL, *labelling = NULL;
    size_t size = qs_reduce_workspace(model);
    memset(made, 0, sizeof *made);
    int status = budget_allocate(limit, name, (size_t)model->sites * model->labels, &kept);
    made->kept = kept;
    budget work = *limit;
    if (status == DONE) {
        status = budget_allocate(&work, name, sizeof(uint16_t) * model->sites, &labelling);
    }
    if (status == DONE) {
        status = budget_allocate(&work, name, size, &workspace);
    }
    if (status == DONE) {
        status = run_reduction(problem, asked, workspace, size, labelling, made);
    }
    free(labelling);
    free(workspace);
    return status;
}

void reduced_free(reduced *freed)
{
    free(freed->kept);
    freed->kept = NULL;
}

static bool has_bound(const reduced *made)
{
    return made->found.lower_bound != QS_NO_BOUND;
}

static bool is_proven(const reduced *made)
{
    return made->found.lower_bound == made->found.upper_bound;
}

static bool at_target(const reduced *made, const problem_file *after)
{
    return after->qubo.variables <= made->target;
}

void reduced_json(const reduced *made, const problem_file *before, const problem_file *after)
{
    const qs_labels *all = &before->qubo.labels, *left = &after->qubo.labels;
    json_count("variables_before", before->qubo.variables);
    json_count("variables_after", after->qubo.variables);
    json_count("sites_before", all->undecided);
    json_count("sites_after", left->undecided);
    json_count("labels_before", labels_left(all));
    json_count("labels_after", labels_left(left));
    if (has_bound(made)) {
        json_units("lower_bound", made->found.lower_bound, before->scale);
    } else {
        json_null("lower_bound");
    }
    json_units("upper_bound", made->found.upper_bound, before->scale);
    json_truth("proven_optimal", is_proven(made));
    if (made->target > 0) {
        json_count("target", made->target);
        json_truth("target_reached", at_target(made, after));
    } else {
        json_null("target");
        json_null("target_reached");
    }
    json_count("iterations", made->found.iterations);
    json_units("seconds", made->microseconds, 1000000);
}

/* Labels that are left are those that no proof excluded, which does not put each of them into an
 * optimum. */
static void print_left(const reduced *made, const char *lower, const char *upper, uint32_t open)
{
    if (open == 0) {
        puts("left        nothing: the optimum is proven and unique");
    } else if (is_proven(made)) {
        printf("left        ties only, as far as the bound tells: the best labelling known is "
               "proven optimal, and what is left\n"
               "            costs %s or more\n",
               upper);
    } else if (has_bound(made)) {
        printf("left        open: the optimum lies between %s and %s\n", lower, upper);
    } else {
        printf("left        open: the optimum costs %s or less (the costs are too large for a "
               "lower bound)\n",
               upper);
    }
}

/* Why a target was missed. */
static void print_target(const reduced *made)
{
    printf("target      %" PRIu64 " not reached: ", made->target);
    if (made->out_of_time) { /* perhaps after the proof, which goes on to tell ties apart */
        puts("out of time");
    } else if (is_proven(made)) {
        puts("the proof is complete, and what is left is ties");
    } else if (has_bound(made)) {
        printf("stopped after %" PRIu64 " iteration%s\n", made->found.iterations,
               plural(made->found.iterations));
    } else {
        puts("without a lower bound no more is proven");
    }
}

static double share(uint64_t part, uint64_t whole)
{
    return whole > 0 ? 100.0 * (double)part / (double)whole : 0;
}

static void print_sites(const qs_labels *before, const qs_labels *after)
{
    printf("sites       %" PRIu32 " open, %" PRIu32 " before: ", after->undecided,
           before->undecided);
    if (after->labels == 1) {
        printf("all %" PRIu32 " have one label only, nothing is to be decided\n", after->sites);
    } else {
        printf("%.4g %% of all %" PRIu32 " are decided by proof\n",
               share(after->sites - after->undecided, after->sites), after->sites);
    }
}

void reduced_print(const reduced *made, const problem_file *before, const char *form,
                   const problem_file *after)
{
    const qs_labels *all = &before->qubo.labels, *left = &after->qubo.labels;
    char lower[DECIMAL_SIZE] = "none", upper[DECIMAL_SIZE], gap[GAP_SIZE];
    decimal_write(made->found.upper_bound, before->scale, upper);
    printf("variables   %" PRIu32 " (%s), %" PRIu32 " before (%s)\n", after->qubo.variables,
           name_of(&encoding_names, (int)left->encoding), before->qubo.variables, form);
    print_sites(all, left);
    printf("labels      %" PRIu64 " left, %" PRIu64 " before\n", labels_left(left),
           labels_left(all));
    printf("bounds      ");
    if (has_bound(made)) {
        decimal_write(made->found.lower_bound, before->scale, lower);
        gap_write(made->found.upper_bound, made->found.lower_bound, before->scale, gap);
        printf("lower %s, upper %s, gap %s\n", lower, upper, gap);
    } else {
        printf("upper %s, no lower one\n", upper);
    }
    print_left(made, lower, upper, left->undecided);
    if (made->target > 0 && !at_target(made, after)) {
        print_target(made);
    }
    printf("%" PRIu64 " iteration%s, %.3f s\n", made->found.iterations,
           plural(made->found.iterations), (double)made->microseconds / 1e6);
}
