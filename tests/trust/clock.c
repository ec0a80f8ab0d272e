/* A library to preload (LD_PRELOAD) in which time stands still: x86-64 Linux. CLOCK_SPENT is how
 * many seconds of processor time a program has had when it asks. */
#include <stdlib.h>
#include <time.h>

int clock_gettime(clockid_t which, struct timespec *now)
{
    const char *spent = getenv("CLOCK_SPENT");
    now->tv_sec = 100000;
    now->tv_nsec = 0;
    if (which == CLOCK_PROCESS_CPUTIME_ID) {
        double seconds = spent != NULL ? atof(spent) : 0;
        now->tv_sec = (time_t)seconds;
        now->tv_nsec = (long)((seconds - (double)now->tv_sec) * 1e9);
    }
    return 0;
}
