#define _XOPEN_SOURCE 700

#include "progress.h"

#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

#include "decimal.h"
#include "gap.h"

enum { PERIOD = 200000, LINE_SIZE = 80 };

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
    return (progress){solver, scale, now, limit, now + PERIOD, isatty(STDERR_FILENO) != 0, false};
}

static void show(progress *shown, const qs_progress *now, int64_t elapsed)
{
    char line[LINE_SIZE], energy[DECIMAL_SIZE], bound[DECIMAL_SIZE], gap[GAP_SIZE];
    decimal_write(now->energy, shown->scale, energy);
    int used = snprintf(line, sizeof line, "%s: %.1f s, iteration %" PRIu64 ", energy %s", shown->solver,
                        (double)elapsed / 1e6, now->iteration, energy);
    if (now->lower_bound != QS_NO_BOUND && used < LINE_SIZE) {
        decimal_write(now->lower_bound, shown->scale, bound);
        gap_write(now->energy, now->lower_bound, shown->scale, gap);
        (void)snprintf(line + used, sizeof line - (size_t)used, ", bound %s, gap %s", bound, gap);
    }
    line_stands = 1;
    fprintf(stderr, "%s%s", clear_line, line);
    (void)fflush(stderr);
}

bool progress_watch(void *context, const qs_progress *now)
{
    progress *watched = context;
    int64_t time = microseconds();
    if (watched->terminal && time >= watched->next) {
        show(watched, now, time - watched->begin);
        watched->shown = true;
        watched->next = time + PERIOD;
    }
    return watched->limit == 0 || time - watched->begin < watched->limit;
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
