#include "command.h"

#include <stdio.h>
#include <string.h>

#include "text/fail.h"
#include "text/plain.h"

int job_open_problem(job *at)
{
    return problem_open(at->given->operands[0], &at->limit, &at->both.problem);
}

int job_open_samples(job *at)
{
    return answer_open_samples(&at->both, at->given->operands[1], &at->limit);
}

int job_open_output(job *at, const char *path, output **opened)
{
    output *made = &at->outs[at->out_count];
    TRY(output_open(made, path));
    *opened = made;
    at->out_count++;
    for (const output *other = at->outs; other < made; other++) {
        if (output_is_same(other, made)) {
            return fail_usage("two outputs are one file, %s: give each its own name", made->name);
        }
    }
    return DONE;
}

int job_open_beside(job *at, const char *long_name, const char *path, output **opened)
{
    if (output_is_standard(path)) {
        return fail_usage("--%s cannot go to standard output: name a file", long_name);
    }
    return job_open_output(at, path, opened);
}

/* The argument of an option that commands share; NULL if it is not given, or if the command does
 * not have it. */
static const char *shared_value(const command_line *line, const arguments *given, const char *name)
{
    size_t index = options_find(line, name, strlen(name));
    return index < line->option_count ? given->values[index] : NULL;
}

static int open_job(const command_line *line, job *at)
{
    const char *limit = shared_value(line, at->given, "memory-limit");
    const char *path = shared_value(line, at->given, "output");
    at->json = shared_value(line, at->given, "json") != NULL;
    if (at->json && path != NULL && output_is_standard(path)) {
        return fail_usage("--json and --output cannot both go to standard output: "
                          "name a file with -o");
    }
    return limit != NULL ? budget_read(limit, &at->limit) : DONE;
}

int job_commit(job *at)
{
    at->committed = true;
    return output_commit(at->outs, at->out_count);
}

void job_print_outputs(const job *at, const char *first)
{
    printf("%s", plain(first));
    for (size_t i = 0; i < at->out_count; i++) {
        if (strcmp(at->outs[i].name, first) != 0) {
            printf(", %s", plain(at->outs[i].name));
        }
    }
    fputs(": ", stdout);
}

/* Makes the outputs and their folder stay, or removes them. */
static int end_outputs(job *at, int status, bool last)
{
    if (status == DONE && !at->committed) {
        status = job_commit(at);
    }
    if (status == DONE) {
        status = output_flush_standard();
    }
    output_settle(at->outs, at->out_count, status == DONE, last);
    if (status == DONE) {
        output_keep_folder();
    } else {
        output_drop_folder();
    }
    return status;
}

job job_begin_part(const job *whole)
{
    job part = {.given = whole->given, .values = whole->values, .json = whole->json};
    part.limit = budget_inside(&whole->limit);
    return part;
}

int job_end_part(job *part, int status)
{
    status = end_outputs(part, status, false);
    budget_free(&part->limit);
    return status;
}

int command_run(const command *run, int argc, char **argv)
{
    arguments given;
    job at;
    int status;
    fail_as(run->line.name);
    if (!options_read(&run->line, argc, argv, &given, &status)) {
        return status;
    }
    memset(&at, 0, sizeof at);
    at.given = &given;
    at.values = given.values;
    status = open_job(&run->line, &at);
    if (status == DONE) {
        status = run->run(&at);
    }
    status = end_outputs(&at, status, true);
    budget_free(&at.limit);
    return status;
}
