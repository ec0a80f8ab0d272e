#define _XOPEN_SOURCE 700

#include "threads.h"

#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>

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

struct team {
    pthread_mutex_t lock; /* of all that follows */
    pthread_cond_t called, done;
    qs_part *part;
    void *work;
    uint32_t next, parts; /* the next part to do */
    uint32_t running; /* parts that are not done yet */
    bool over;
    task begun; /* of each thread */
    uint32_t count;
    pthread_t threads[];
};

/* Does parts while there are some. The lock is held before and after. */
static void do_parts(team *of)
{
    while (of->next < of->parts) {
        uint32_t part = of->next++;
        (void)pthread_mutex_unlock(&of->lock);
        of->part(of->work, part);
        (void)pthread_mutex_lock(&of->lock);
        of->running--;
    }
}

static void help(void *with)
{
    team *of = with;
    (void)pthread_mutex_lock(&of->lock);
    while (!of->over) {
        do_parts(of);
        if (of->running == 0) {
            (void)pthread_cond_signal(&of->done);
        }
        while (of->next == of->parts && !of->over) {
            (void)pthread_cond_wait(&of->called, &of->lock);
        }
    }
    (void)pthread_mutex_unlock(&of->lock);
}

static bool prepare(team *of)
{
    if (pthread_mutex_init(&of->lock, NULL) != 0) {
        return false;
    }
    if (pthread_cond_init(&of->called, NULL) == 0) {
        if (pthread_cond_init(&of->done, NULL) == 0) {
            return true;
        }
        (void)pthread_cond_destroy(&of->called);
    }
    (void)pthread_mutex_destroy(&of->lock);
    return false;
}

int team_begin(uint32_t helpers, team **begun)
{
    team *made = calloc(1, sizeof *made + helpers * sizeof *made->threads);
    if (made == NULL || !prepare(made)) {
        free(made);
        return fail_memory("--threads");
    }
    made->begun = (task){help, made};
    int failed = 0;
    while (failed == 0 && made->count < helpers) {
        failed = start(&made->begun, &made->threads[made->count]);
        made->count += failed == 0;
    }
    if (failed != 0) {
        errno = failed;
        int status = fail_system("--threads", "the system has no more threads");
        team_end(made);
        return status;
    }
    *begun = made;
    return DONE;
}

void team_together(void *helpers, qs_part *part, void *work, uint32_t parts)
{
    team *of = helpers;
    (void)pthread_mutex_lock(&of->lock);
    of->part = part;
    of->work = work;
    of->next = 0;
    of->parts = of->running = parts;
    (void)pthread_cond_broadcast(&of->called);
    do_parts(of);
    while (of->running > 0) {
        (void)pthread_cond_wait(&of->done, &of->lock);
    }
    (void)pthread_mutex_unlock(&of->lock);
}

void team_end(team *ended)
{
    if (ended == NULL) {
        return;
    }
    (void)pthread_mutex_lock(&ended->lock);
    ended->over = true;
    (void)pthread_cond_broadcast(&ended->called);
    (void)pthread_mutex_unlock(&ended->lock);
    for (uint32_t i = 0; i < ended->count; i++) {
        (void)pthread_join(ended->threads[i], NULL);
    }
    (void)pthread_cond_destroy(&ended->done);
    (void)pthread_cond_destroy(&ended->called);
    (void)pthread_mutex_destroy(&ended->lock);
    free(ended);
}
