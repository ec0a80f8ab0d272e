#include "trace.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "command.h"
#include "text/fail.h"
#include "text/numbers.h"

int trace_open(struct job *at, const char *path, uint32_t scale, trace *made)
{
    static const char heading[] = "solver,seconds,iteration,energy,bound,variables\n";
    memset(made, 0, sizeof *made);
    if (path == NULL) {
        return DONE;
    }
    made->scale = scale;
    TRY(job_open_beside(at, "trace", path, &made->out));
    (void)output_write(made->out, heading, sizeof heading - 1);
    return DONE;
}

static bool is_on(const trace *to)
{
    return to != NULL && to->out != NULL;
}

void trace_begin(trace *to, const char *solver)
{
    if (is_on(to)) {
        to->solver = solver;
        to->begun = false;
    }
}

/* A write that is refused is reported when the outputs get their names. */
static void write_row(trace *to, const trace_point *now)
{
    enum { ROW_SIZE = 256 };
    char row[ROW_SIZE], seconds[DECIMAL_SIZE], energy[DECIMAL_SIZE], bound[DECIMAL_SIZE] = "",
                                                                     variables[24] = "";
    decimal_write(now->microseconds, 1000000, seconds);
    decimal_write(now->energy, to->scale, energy);
    if (now->bound != QS_NO_BOUND) {
        decimal_write(now->bound, to->scale, bound);
    }
    if (now->variables != TRACE_NO_VARIABLES) {
        (void)snprintf(variables, sizeof variables, "%" PRIu64, now->variables);
    }
    int size = snprintf(row, sizeof row, "%s,%s,%" PRIu64 ",%s,%s,%s\n", to->solver, seconds,
                        now->iteration, energy, bound, variables);
    (void)output_write(to->out, row, (size_t)size);
    to->last = *now;
    to->begun = true;
}

void trace_add(trace *to, const trace_point *now)
{
    if (is_on(to) && (!to->begun || now->energy != to->last.energy ||
                      now->bound != to->last.bound || now->variables != to->last.variables)) {
        write_row(to, now);
    }
}

void trace_end(trace *to, const trace_point *now)
{
    if (is_on(to)) {
        write_row(to, now);
    }
}
