#include "reducing.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "progress_line.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/names.h"
#include "text/numbers.h"

/* A target counts variables as the reduction leaves them, which encodings with a model have. */
static int read_target(const char *text, qs_encoding into, uint64_t *target)
{
    const qs_encoding_facts *facts = qs_encoding_facts_of(into);
    if (!facts->has_model) {
        char list[ENCODING_LIST_SIZE];
        encodings_with_model_write(list);
        return fail_usage("--target does not go with --encoding %s, but with these: %s",
                          facts->name, list);
    }
    return number64_read("--target", text, 1, QS_VARIABLES_MAX, target);
}

int reducing_read(const char *const *values, qs_encoding into, reducing *asked)
{
    memset(asked, 0, sizeof *asked);
    asked->into = into;
    if (values[REDUCING_TARGET] != NULL) {
        TRY(read_target(values[REDUCING_TARGET], into, &asked->target));
    }
    if (values[REDUCING_TIME_LIMIT] != NULL) {
        TRY(seconds_read("--time-limit", values[REDUCING_TIME_LIMIT], &asked->time_limit));
    }
    return DONE;
}

static int run_reduction(const laid_out *problem, const reducing *asked, budget *work,
                         reduced *made)
{
    const char *name = problem->name;
    size_t size = qs_reduce_workspace(&problem->model);
    void *workspace = budget_take(work, name, size);
    if (workspace == NULL) {
        return NO_RESOURCE;
    }
    progress watched = progress_begin("reduce", problem->scale, asked->time_limit, true);
    watched.traced = asked->traced;
    trace_begin(asked->traced, "reduce");
    const qs_reduce_options options = {.iterations = asked->iterations,
                                       .target = asked->target,
                                       .walls =
                                           qs_encoding_facts_of(asked->into)->code == QS_CODE_WALL,
                                       .watch = progress_watch_reduction,
                                       .context = &watched,
                                       .start = asked->start,
                                       .witness = asked->witness};
    qs_status ran = qs_reduce(&problem->model, &options, workspace, size, made->kept,
                              made->labelling, &made->found);
    qs_model_sites(&problem->model, made->labelling, made->labelling);
    made->microseconds = progress_end(&watched);
    made->out_of_time = watched.out_of_time;
    made->target = asked->target;
    made->most = asked->iterations > 0 ? asked->iterations : QS_REDUCE_ITERATIONS;
    if (ran != QS_OK) {
        return fail_status(name, ran);
    }
    /* A reduction never removes all optima: if one labelling is left, it is optimal. */
    if (made->found.undecided == 0) {
        made->found.lower_bound = made->found.upper_bound;
    }
    trace_end(asked->traced,
              &(trace_point){made->microseconds, made->found.iterations, made->found.upper_bound,
                             made->found.lower_bound, made->found.variables});
    return DONE;
}

uint64_t reduce_bytes(const laid_out *problem)
{
    const qs_model *model = &problem->model;
    uint64_t kept = bytes_product(model->sites, model->labels + sizeof(uint16_t));
    return bytes_sum(kept, qs_reduce_workspace(model));
}

int reduce_problem(const laid_out *problem, const reducing *asked, budget *limit, reduced *made)
{
    const qs_model *model = &problem->model;
    memset(made, 0, sizeof *made);
    made->kept = budget_take(limit, problem->name, (size_t)model->sites * model->labels);
    if (made->kept == NULL) {
        return NO_RESOURCE;
    }
    made->labelling = budget_take(limit, problem->name, sizeof *made->labelling * model->sites);
    if (made->labelling == NULL) {
        return NO_RESOURCE;
    }
    budget work = budget_inside(limit);
    int status = run_reduction(problem, asked, &work, made);
    budget_free(&work);
    return status;
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

/* Why the reduction ended. Where the proof is complete it may still have gone on to tell ties
 * apart, but that is not what anybody waits for. */
typedef struct ending {
    const char *word, *sentence;
} ending;

static ending ending_of(const reduced *made)
{
    if (is_proven(made)) {
        return (ending){"proven", "the best labelling is proven"};
    }
    if (made->out_of_time) {
        return (ending){"time", "the time limit"};
    }
    if (made->target > 0 && made->found.variables <= made->target) {
        return (ending){"target", "so few variables are left as were asked for"};
    }
    return made->found.iterations >= made->most
               ? (ending){"iterations", "the limit of iterations"}
               : (ending){"no-gain", "half of all iterations have gained nothing"};
}

void reduced_json(const reduced *made, const laid_out *before, const problem_file *after)
{
    const qs_labels *all = &before->labels, *left = &after->qubo.labels;
    json_count("variables_before", before->variables);
    json_count("variables_after", after->qubo.variables);
    json_count("sites_before", all->undecided);
    json_count("sites_after", left->undecided);
    json_count("labels_before", labels_left(all));
    json_count("labels_after", labels_left(left));
    json_count("variables_left", made->found.variables);
    json_units_or_null("lower_bound", has_bound(made), made->found.lower_bound, before->scale);
    json_units("upper_bound", made->found.upper_bound, before->scale);
    json_truth("proven_optimal", is_proven(made));
    if (made->target > 0) {
        json_count("target", made->target);
        json_truth("target_reached", at_target(made, after));
    } else {
        json_null("target");
        json_null("target_reached");
    }
    const char *ended = ending_of(made).word;
    json_text("ended", ended, strlen(ended));
    json_count("iterations", made->found.iterations);
    json_units("seconds", made->microseconds, 1000000);
}

/* A label that is left is one that no proof excluded; it need not be in any optimum. */
static void print_left(const reduced *made, const char *lower, const char *upper,
                       uint32_t undecided)
{
    if (undecided == 0) {
        puts("left        nothing: the optimum is proven, and there is no other");
    } else if (is_proven(made)) {
        printf("left        labels that may tie: the best labelling is proven optimal, and no "
               "labelling\n"
               "            that is left costs less than %s\n",
               upper);
    } else if (has_bound(made)) {
        printf("left        an open problem: the optimum lies between %s and %s\n", lower, upper);
    } else {
        printf("left        an open problem: the optimum costs at most %s (the costs are too "
               "large\n"
               "            for a lower bound)\n",
               upper);
    }
}

/* Prints why the target was missed. */
static void print_target(const reduced *made)
{
    printf("target      %" PRIu64 " not reached: ", made->target);
    if (made->out_of_time) { /* perhaps after the proof, which goes on to tell ties apart */
        puts("the time limit stopped the reduction");
    } else if (is_proven(made)) {
        puts("the proof is complete, and only labels that may tie are left");
    } else if (has_bound(made)) {
        printf("stopped after %" PRIu64 " iteration%s\n", made->found.iterations,
               plural(made->found.iterations));
    } else {
        puts("no more can be proven without a lower bound");
    }
}

static double share(uint64_t part, uint64_t whole)
{
    return whole > 0 ? 100.0 * (double)part / (double)whole : 0;
}

static void print_sites(const qs_labels *before, const qs_labels *after)
{
    printf("sites       %" PRIu32 " undecided, %" PRIu32 " before: ", after->undecided,
           before->undecided);
    if (after->labels == 1) {
        printf("each of all %" PRIu32 " has only one label\n", after->sites);
    } else {
        printf("%.4g %% of all %" PRIu32 " are decided by proof\n",
               share(after->sites - after->undecided, after->sites), after->sites);
    }
}

void reduced_print(const reduced *made, const laid_out *before, const char *form,
                   const problem_file *after)
{
    const qs_labels *all = &before->labels, *left = &after->qubo.labels;
    char lower[DECIMAL_SIZE] = "none", upper[DECIMAL_SIZE], gap[GAP_SIZE];
    decimal_write(made->found.upper_bound, before->scale, upper);
    printf("variables   %" PRIu32 " (%s), %" PRIu64 " before (%s)\n", after->qubo.variables,
           encoding_name(left->encoding), before->variables, form);
    print_sites(all, left);
    printf("labels      %" PRIu64 " left, %" PRIu64 " before\n", labels_left(left),
           labels_left(all));
    printf("bounds      ");
    if (has_bound(made)) {
        decimal_write(made->found.lower_bound, before->scale, lower);
        gap_write(made->found.upper_bound, made->found.lower_bound, before->scale, gap);
        printf("lower %s, upper %s, gap %s\n", lower, upper, gap);
    } else {
        printf("upper %s, no lower bound\n", upper);
    }
    print_left(made, lower, upper, left->undecided);
    if (made->target > 0 && !at_target(made, after)) {
        print_target(made);
    }
    printf("ended       %s\n", ending_of(made).sentence);
    printf("%" PRIu64 " iteration%s, %.3f s\n", made->found.iterations,
           plural(made->found.iterations), (double)made->microseconds / 1e6);
}
