#define _XOPEN_SOURCE 700

#include "progress.h"

#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "decimal.h"
#include "gap.h"

/* A line longer than the shortest of terminals is cut. */
enum { PERIOD = 200000, LINE_WIDTH = 79, LINE_SIZE = 512 };

/* To the beginning of the line, and nothing behind. */
static const char clear_line[] = "\r\033[K";

static volatile sig_atomic_t line_stands;

static int64_t microseconds(void)
{
    struct timespec now = {0, 0};
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000;
}

progress progress_begin(const char *solver, uint32_t scale, int64_t limit)
{
    int64_t now = microseconds();
    return (progress){solver, scale, now, limit, now + PERIOD, isatty(STDERR_FILENO) != 0, false, false};
}

/* Appends to a line of LINE_SIZE: ", bound B, gap G", where there is a bound. */
static void append_bound(const progress *shown, int64_t energy, int64_t lower_bound, char *line)
{
    char bound[DECIMAL_SIZE], gap[GAP_SIZE];
    size_t used = strlen(line);
    if (lower_bound != QS_NO_BOUND) {
        decimal_write(lower_bound, shown->scale, bound);
        gap_write(energy, lower_bound, shown->scale, gap);
        (void)snprintf(line + used, LINE_SIZE - used, ", bound %s, gap %s", bound, gap);
    }
}

static void show(progress *shown, const char *line)
{
    line_stands = 1;
    fprintf(stderr, "%s%.*s", clear_line, LINE_WIDTH, line);
    (void)fflush(stderr);
    shown->shown = true;
    shown->next = microseconds() + PERIOD;
}

static bool is_due(const progress *watched, int64_t time)
{
    return watched->terminal && time >= watched->next;
}

static bool has_time(progress *watched, int64_t time)
{
    watched->out_of_time = watched->limit > 0 && time - watched->begin >= watched->limit;
    return !watched->out_of_time;
}

bool progress_watch(void *context, const qs_progress *now)
{
    progress *watched = context;
    int64_t time = microseconds();
    char line[LINE_SIZE], energy[DECIMAL_SIZE];
    if (is_due(watched, time)) {
        decimal_write(now->energy, watched->scale, energy);
        (void)snprintf(line, sizeof line, "%s: %.1f s, iteration %" PRIu64 ", energy %s", watched->solver,
                       (double)(time - watched->begin) / 1e6, now->iteration, energy);
        append_bound(watched, now->energy, now->lower_bound, line);
        show(watched, line);
    }
    return has_time(watched, time);
}

bool progress_watch_reduction(void *context, const qs_reduction *now)
{
    progress *watched = context;
    int64_t time = microseconds();
    char line[LINE_SIZE];
    if (is_due(watched, time)) {
        (void)snprintf(line, sizeof line, "%s: %.1f s, iteration %" PRIu64 ", %" PRIu64 " variables left", watched->solver,
                       (double)(time - watched->begin) / 1e6, now->iterations, now->variables);
        append_bound(watched, now->upper_bound, now->lower_bound, line);
        show(watched, line);
    }
    return has_time(watched, time);
}

int64_t progress_end(progress *ended)
{
    int64_t elapsed = microseconds() - ended->begin;
    if (ended->shown) {
        fputs(clear_line, stderr);
        (void)fflush(stderr);
        line_stands = 0;
    }
    return elapsed;
}

void progress_interrupt(void)
{
    if (line_stands) {
        /* Where the terminal is gone, nothing is left to be cleared. */
        ssize_t written = write(STDERR_FILENO, clear_line, sizeof clear_line - 1);
        (void)written;
    }
}
