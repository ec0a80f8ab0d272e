#define _XOPEN_SOURCE 700

#include "progress_line.h"

#include <inttypes.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "text/numbers.h"
#include "text/fail.h"

/* Lines fit the narrowest usual terminal. */
enum { PERIOD = 200000, LINE_WIDTH = 79, LINE_SIZE = LINE_WIDTH + 1 };

/* Goes to the beginning of the line and clears it. */
static const char clear_line[] = "\r\033[K";

static volatile sig_atomic_t line_stands;

/* A signal handler and other threads see these two. */
static int keep_on_interrupt, interrupted;

static bool is_set(const int *flag)
{
    return __atomic_load_n(flag, __ATOMIC_RELAXED) != 0;
}

static void set(int *flag, bool on)
{
    __atomic_store_n(flag, on ? 1 : 0, __ATOMIC_RELAXED);
}

static int64_t command_begin;

static int64_t read_clock(clockid_t clock)
{
    struct timespec now = {0, 0};
    (void)clock_gettime(clock, &now);
    return (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000;
}

int64_t progress_clock(void)
{
    return read_clock(CLOCK_MONOTONIC);
}

/* Before main the libraries were loaded, which with OpenCV takes long. */
void progress_start_command(void)
{
    command_begin = progress_clock() - read_clock(CLOCK_PROCESS_CPUTIME_ID);
}

void progress_start_part(void)
{
    command_begin = progress_clock();
}

int64_t progress_since_command(void)
{
    return progress_clock() - command_begin;
}

progress progress_begin(const char *solver, uint32_t scale, int64_t limit, bool whole)
{
    int64_t now = progress_clock();
    return (progress){.solver = solver,
                      .scale = scale,
                      .begin = now,
                      .end = limit > 0 ? limit + (whole ? command_begin : now) : 0,
                      .gap = -1,
                      .next = now + PERIOD,
                      .terminal = isatty(STDERR_FILENO) != 0};
}

void progress_keep_on_interrupt(bool on)
{
    set(&keep_on_interrupt, on);
}

bool progress_takes_signal(int signal_number)
{
    bool taken = is_set(&keep_on_interrupt) && !is_set(&interrupted) &&
                 (signal_number == SIGINT || signal_number == SIGTERM);
    if (taken) {
        set(&interrupted, true);
    }
    return taken;
}

/* Appends to a line, if all of it fits: half of a number would be another number. */
PRINTF_LIKE(2, 3) static void append(char line[LINE_SIZE], const char *format, ...)
{
    char part[LINE_SIZE];
    va_list values;
    va_start(values, format);
    int size = vsnprintf(part, sizeof part, format, values);
    va_end(values);
    if (size >= 0 && strlen(line) + (size_t)size < LINE_SIZE) {
        strcat(line, part);
    }
}

static void begin_line(const progress *shown, int64_t time, uint64_t iteration,
                       char line[LINE_SIZE])
{
    line[0] = '\0';
    append(line, "%s: %.1f s, iteration %" PRIu64, shown->solver,
           (double)(time - shown->begin) / 1e6, iteration);
}

static void append_bound(const progress *shown, int64_t energy, int64_t lower_bound,
                         char line[LINE_SIZE])
{
    char bound[DECIMAL_SIZE], gap[GAP_SIZE];
    if (lower_bound != QS_NO_BOUND) {
        decimal_write(lower_bound, shown->scale, bound);
        gap_write(energy, lower_bound, shown->scale, gap);
        append(line, ", bound %s", bound);
        append(line, ", gap %s", gap);
    }
}

/* Appends the gap in percent, which is short at any scale. An energy of 0 has no percentage. */
static void append_gap(const progress *shown, int64_t energy, int64_t lower_bound,
                       char line[LINE_SIZE])
{
    char gap[DECIMAL_SIZE];
    if (lower_bound != QS_NO_BOUND && energy != 0) {
        append(line, ", gap %.4f %%", gap_percent(energy, lower_bound));
    } else if (lower_bound != QS_NO_BOUND) {
        decimal_write(energy - lower_bound, shown->scale, gap);
        append(line, ", gap %s", gap);
    }
}

static void show(progress *shown, const char *line)
{
    line_stands = 1;
    fprintf(stderr, "%s%s", clear_line, line);
    (void)fflush(stderr);
    shown->shown = true;
    shown->next = progress_clock() + PERIOD;
}

static bool is_due(const progress *watched, int64_t time)
{
    return watched->terminal && time >= watched->next;
}

static bool has_time(progress *watched, int64_t time)
{
    watched->out_of_time = watched->end > 0 && time >= watched->end;
    watched->interrupted = is_set(&interrupted);
    return !watched->out_of_time && !watched->interrupted;
}

/* A gap of 0 is a proof, and the solver stops by itself. */
static bool is_in_gap(progress *watched, const qs_progress *now)
{
    watched->in_gap = watched->gap >= 0 && now->lower_bound != QS_NO_BOUND && now->energy != 0 &&
                      now->energy > now->lower_bound &&
                      gap_percent(now->energy, now->lower_bound) <= watched->gap;
    return watched->in_gap;
}

bool progress_watch(void *context, const qs_progress *now)
{
    progress *watched = context;
    int64_t time = progress_clock();
    const trace_point point = {time - watched->begin, now->iteration, now->energy, now->lower_bound,
                               TRACE_NO_VARIABLES};
    char line[LINE_SIZE], energy[DECIMAL_SIZE];
    trace_add(watched->traced, &point);
    if (is_due(watched, time)) {
        decimal_write(now->energy, watched->scale, energy);
        begin_line(watched, time, now->iteration, line);
        append(line, ", energy %s", energy);
        append_bound(watched, now->energy, now->lower_bound, line);
        show(watched, line);
    }
    return has_time(watched, time) && !is_in_gap(watched, now);
}

uint32_t progress_spent(void *context)
{
    const progress *watched = context;
    int64_t time = progress_clock();
    if (time >= watched->end) { /* perhaps before the solver began */
        return QS_ALL_TIME;
    }
    double part = (double)(time - watched->begin) / (double)(watched->end - watched->begin);
    return (uint32_t)(part * QS_ALL_TIME);
}

bool progress_watch_reduction(void *context, const qs_reduction *now)
{
    progress *watched = context;
    int64_t time = progress_clock();
    const trace_point point = {time - watched->begin, now->iterations, now->upper_bound,
                               now->lower_bound, now->variables};
    char line[LINE_SIZE];
    trace_add(watched->traced, &point);
    if (is_due(watched, time)) {
        begin_line(watched, time, now->iterations, line);
        append(line, ", %" PRIu64 " variables left", now->variables);
        append_gap(watched, now->upper_bound, now->lower_bound, line);
        show(watched, line);
    }
    return has_time(watched, time);
}

int64_t progress_end(progress *ended)
{
    int64_t elapsed = progress_clock() - ended->begin;
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
        /* If this fails, the terminal is gone, and there is nothing to clear. */
        ssize_t written = write(STDERR_FILENO, clear_line, sizeof clear_line - 1);
        (void)written;
    }
}
