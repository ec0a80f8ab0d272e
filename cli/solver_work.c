#include "solver_work.h"

#include <string.h>

#include "text/fail.h"
#include "text/numbers.h"

static bool is_straight(const solver_work *work)
{
    return work->by->run_straight != NULL;
}

static uint32_t sites_of(const laid_out *problem)
{
    return problem->model.sites == 0 ? problem->labels.sites : problem->model.sites;
}

/* A first cycle of moves takes long, and from the cheapest label of each site it begins far off. So
 * where the time is limited, expansion starts from what messages find in a few iterations. */
static bool starts_from_messages(const solver *by, const search *how)
{
    return by->run == qs_expansion && how->time_limit > 0 && how->start == NULL;
}

/* Room for the solver, and for messages before it. */
static size_t workspace_of(const laid_out *problem, const solver *by, uint64_t iterations)
{
    if (by->run_straight != NULL) {
        return by->straight_workspace(problem->problem, iterations);
    }
    size_t size = by->workspace(&problem->model),
           first = by->run == qs_expansion ? qs_trws_workspace(&problem->model) : 0;
    return first > size ? first : size;
}

/* Room to compute the energy again: the sample, of a problem that is a file, is found->bits. */
static size_t check_size_of(const laid_out *problem)
{
    return problem->file != NULL ? 0 : qs_problem_workspace(problem->problem);
}

uint64_t solve_bytes(const laid_out *problem, const solver *by, uint64_t iterations)
{
    uint64_t labelling = sizeof(uint16_t) * (uint64_t)sites_of(problem);
    uint64_t bits = problem->file != NULL ? ((uint64_t)problem->variables + 7) / 8 : 0;
    return bytes_sum(workspace_of(problem, by, iterations),
                     labelling + bits + check_size_of(problem));
}

/* Room for the labelling of the model, which has more sites than a masked problem, and for the
 * sample. */
static int take_room(const laid_out *problem, budget *limit, solved *found)
{
    size_t size = sizeof *found->labelling * sites_of(problem);
    found->labelling = budget_take(limit, problem->name, size);
    if (found->labelling == NULL || problem->file == NULL) {
        return found->labelling != NULL ? DONE : NO_RESOURCE;
    }
    found->bits = budget_take(limit, problem->name, ((size_t)problem->variables + 7) / 8);
    return found->bits != NULL ? DONE : NO_RESOURCE;
}

/* The labelling of the problem's sites, and what it costs by the QUBO or the problem. */
static void find_energy(solver_work *work)
{
    const laid_out *problem = work->problem;
    solved *found = work->found;
    if (!is_straight(work)) {
        qs_model_sites(&problem->model, found->labelling, found->labelling);
    }
    if (problem->file == NULL) {
        work->checked = qs_problem_energy(problem->problem, found->labelling, work->check,
                                          work->check_size, &work->energy);
        return;
    }
    work->checked = qs_sample_encode(&problem->file->index, found->labelling, found->bits);
    if (work->checked == QS_OK) {
        found->qubo_energy = qs_qubo_energy(&problem->file->index, found->bits);
        work->energy =
            found->qubo_energy + qs_sample_trimmed(&problem->file->qubo, found->labelling);
    }
}

/* The cheapest label of each site. Of a problem that is solved straight, for which that takes about
 * as long as to solve it, the first one. */
static void set_first(const solver_work *work)
{
    if (is_straight(work)) {
        memset(work->found->labelling, 0, sizeof *work->found->labelling * sites_of(work->problem));
    } else {
        qs_model_winner(&work->problem->model, work->found->labelling);
    }
}

/* Checks a first labelling, to see how long that takes. Behind a solver come the same check, the
 * end of its memory and the output, which together take about twice as long, and the end of the
 * command. Returns the microseconds that the solver must leave. */
static int64_t measure_end(solver_work *work)
{
    enum { TIMES = 2, COMMAND_END = 20000 };
    int64_t begin = progress_clock();
    set_first(work);
    find_energy(work);
    return TIMES * (progress_clock() - begin) + COMMAND_END;
}

/* The time that the solver has, from the command's beginning or its own. */
static void set_limit(solver_work *work)
{
    const search *how = work->how;
    work->limit = how->time_limit;
    if (how->time_limit > 0 && how->whole_command) {
        int64_t reserved = measure_end(work);
        int64_t spent = progress_since_command(), left = how->time_limit - reserved - spent;
        work->limit = left > 0 ? spent + left / (how->follow_up ? 2 : 1) : 1;
    }
}

/* The half pixels are made in the memory of the solver. */
static size_t work_size(const laid_out *problem, const solver *by, const search *how,
                        const halves *finer)
{
    size_t size = workspace_of(problem, by, how->iterations),
           after = finer != NULL ? halves_workspace(finer) : 0;
    return after > size ? after : size;
}

int work_begin(const laid_out *problem, const solver *by, const search *how, halves *finer,
               budget *limit, solved *found, solver_work *begun)
{
    memset(found, 0, sizeof *found);
    found->solver = by->name;
    *begun = (solver_work){.problem = problem,
                           .by = by,
                           .how = how,
                           .found = found,
                           .finer = finer,
                           .size = work_size(problem, by, how, finer),
                           .check_size = check_size_of(problem)};
    TRY(take_room(problem, limit, found));
    begun->memory = budget_inside(limit);
    begun->workspace =
        budget_take(&begun->memory, problem->name, begun->size > 0 ? begun->size : 1);
    if (begun->workspace == NULL) {
        return NO_RESOURCE;
    }
    begun->check =
        budget_take(&begun->memory, problem->name, begun->check_size > 0 ? begun->check_size : 1);
    if (begun->check == NULL) {
        return NO_RESOURCE;
    }
    set_limit(begun);
    progress_keep_on_interrupt(how->keep_on_interrupt);
    return DONE;
}

/* How the solver is to search. What it points to is borrowed. */
static qs_solve_options options_of(const solver_work *work, progress *watched)
{
    const search *how = work->how;
    watched->gap = how->gap;
    watched->traced = how->traced;
    return (qs_solve_options){.iterations = how->iterations,
                              .seed = how->seed,
                              .watch = progress_watch,
                              .context = watched,
                              .spent = how->time_limit > 0 ? progress_spent : NULL,
                              .start = how->start,
                              .witness = how->witness,
                              .together = work->team != NULL ? team_together : NULL,
                              .helpers = work->team,
                              .workers = work->workers};
}

static void begin_labelling(const solver_work *work)
{
    const uint16_t *start = work->how->start;
    if (start != NULL) {
        memcpy(work->found->labelling, start, sizeof *start * work->problem->model.sites);
    } else {
        qs_model_winner(&work->problem->model, work->found->labelling);
    }
}

static qs_status run_messages(const solver_work *work, const qs_solve_options *options)
{
    enum { FEW = 4 };
    qs_solve_options few = *options;
    few.iterations = FEW;
    few.witness = NULL; /* the proof would be none of expansion */
    return qs_trws(&work->problem->model, &few, work->workspace, work->size, work->found->labelling,
                   &work->found->solution);
}

/* Starts from the labelling that is known, or else from the cheapest label of each site, if the
 * solver starts from a labelling. */
static qs_status run(const solver_work *work, const qs_solve_options *options)
{
    const laid_out *problem = work->problem;
    solved *found = work->found;
    if (is_straight(work)) {
        return work->by->run_straight(problem->problem, options, work->workspace, work->size,
                                      found->labelling, &found->solution);
    }
    begin_labelling(work);
    qs_status ran = starts_from_messages(work->by, work->how) ? run_messages(work, options) : QS_OK;
    return ran != QS_OK ? ran
                        : work->by->run(&problem->model, options, work->workspace, work->size,
                                        found->labelling, &found->solution);
}

/* Some solvers begin without a labelling, and may end above the start. */
static void keep_start(const solver_work *work)
{
    const qs_model *model = &work->problem->model;
    const uint16_t *start = work->how->start;
    int64_t energy = start != NULL ? qs_model_energy(model, start) : INT64_MAX;
    if (energy < work->found->solution.energy) {
        memcpy(work->found->labelling, start, sizeof *start * model->sites);
        work->found->solution.energy = energy;
    }
}

static void take_down(solver_work *work)
{
    progress *watched = &work->watched;
    solved *found = work->found;
    found->microseconds = progress_end(watched);
    found->out_of_time = watched->out_of_time;
    found->in_gap = watched->in_gap;
    found->interrupted = watched->interrupted;
    found->own_limit = work->how->iterations == 0;
}

static void end_trace(const search *how, const solved *found)
{
    trace_end(how->traced, &(trace_point){found->microseconds, found->solution.iterations,
                                          found->solution.energy, found->solution.lower_bound,
                                          TRACE_NO_VARIABLES});
}

void work_do(void *begun)
{
    solver_work *work = begun;
    const search *how = work->how;
    const char *name = work->by->name;
    work->watched = progress_begin(name, work->problem->scale, work->limit, how->whole_command);
    work->watched.terminal = work->watched.terminal && !work->hidden;
    trace_begin(how->traced, name);
    const qs_solve_options options = options_of(work, &work->watched);
    work->ran = run(work, &options);
    take_down(work);
    if (work->ran == QS_OK) {
        keep_start(work);
        end_trace(how, work->found);
        find_energy(work);
        if (work->finer != NULL) {
            halves_do(work->finer, work->found->labelling, work->workspace, work->size);
        }
    }
}

/* Whatever a solver says, the energy that counts is that of the QUBO or the problem. */
int work_check(solver_work *done)
{
    const laid_out *problem = done->problem;
    solved *found = done->found;
    char said[DECIMAL_SIZE], given[DECIMAL_SIZE];
    if (done->ran == QS_E_ENCODING || done->ran == QS_E_OVERFLOW) {
        found->refusal = done->ran;
        return DONE;
    }
    if (done->ran != QS_OK || done->checked != QS_OK) {
        return fail_status(problem->name, done->ran != QS_OK ? done->ran : done->checked);
    }
    if (done->energy == found->solution.energy) {
        return done->finer != NULL ? halves_check(done->finer) : DONE;
    }
    decimal_write(found->solution.energy, problem->scale, said);
    decimal_write(done->energy, problem->scale, given);
    return fail(NO_RESOURCE, problem->name,
                "internal error: %s found the energy %s, but the problem gives it %s; please "
                "report this",
                found->solver, said, given);
}

void work_end(solver_work *ended)
{
    progress_keep_on_interrupt(false);
    budget_free(&ended->memory);
}

int work_whole(const laid_out *problem, const solver *by, const search *how, halves *finer,
               budget *limit, solved *found)
{
    solver_work work;
    int status = work_begin(problem, by, how, finer, limit, found, &work);
    if (status == DONE) {
        work_do(&work);
        status = work_check(&work);
    }
    work_end(&work);
    return status;
}

int solve_problem(const laid_out *problem, const solver *by, const search *how, budget *limit,
                  solved *found)
{
    return work_whole(problem, by, how, NULL, limit, found);
}
