/* Threads of the command. The library has none: what runs here at the same time shares nothing, or
 * is handed out by the library in parts that may. No signal comes to them. */
#ifndef THREADS_H
#define THREADS_H

#include "qstereo.h"

/* Does the same with two objects at the same time, and returns when both are done. Signals come to
 * the thread that calls it. Returns DONE, or NO_RESOURCE, after a message, if the system has no
 * thread; then nothing is done. */
int threads_both(void (*work)(void *), void *first, void *second);

/* Threads that wait for parts of a work. */
typedef struct team team;

/* Begins a team of so many threads, beside the one that calls it later. Returns DONE or
 * NO_RESOURCE, after a message. */
int team_begin(uint32_t helpers, team **begun);

/* A qs_together: the caller and the team do all parts. One thread at a time calls it. */
void team_together(void *helpers, qs_part *part, void *work, uint32_t parts);

/* Ends the threads. NULL is fine. */
void team_end(team *ended);

#endif
