/* A library to preload (LD_PRELOAD) in which time stands still: x86-64 Linux. CLOCK_SPENT is how
 * many seconds of processor time a program has had when it asks. */
#include <stdlib.h>
#include <time.h>

int clock_gettime(clockid_t which, struct timespec *now)
{
    const char *spent = getenv("CLOCK_SPENT");
    now->tv_sec = which == CLOCK_PROCESS_CPUTIME_ID ? (spent != NULL ? atol(spent) : 0) : 100000;
    now->tv_nsec = 0;
    return 0;
}
