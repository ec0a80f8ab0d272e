#define _XOPEN_SOURCE 700

#include "threads.h"

#include <errno.h>
#include <pthread.h>
#include <signal.h>

#include "text/fail.h"

/* The solvers need far less. The usual stack may be as large as a memory limit of the system. */
enum { STACK_SIZE = 1 << 20 };

typedef struct task {
    void (*work)(void *);
    void *with;
} task;

static void *do_task(void *begun)
{
    const task *given = begun;
    given->work(given->with);
    return NULL;
}

/* A thread that no signal comes to. Returns an error number. */
static int start(task *given, pthread_t *thread)
{
    sigset_t all, before;
    pthread_attr_t small;
    int failed = pthread_attr_init(&small);
    if (failed != 0) {
        return failed;
    }
    (void)sigfillset(&all);
    (void)pthread_attr_setstacksize(&small, STACK_SIZE);
    (void)pthread_sigmask(SIG_SETMASK, &all, &before);
    failed = pthread_create(thread, &small, do_task, given);
    (void)pthread_sigmask(SIG_SETMASK, &before, NULL);
    (void)pthread_attr_destroy(&small);
    return failed;
}

int threads_both(void (*work)(void *), void *first, void *second)
{
    pthread_t thread;
    task other = {work, second};
    int failed = start(&other, &thread);
    if (failed != 0) {
        errno = failed;
        return fail_system("--threads", "the system has no second thread");
    }
    work(first);
    (void)pthread_join(thread, NULL);
    return DONE;
}
