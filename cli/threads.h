/* Threads of the command. The library has none: what runs here at the same time shares nothing. */
#ifndef THREADS_H
#define THREADS_H

/* Does the same with two objects at the same time, and returns when both are done. Signals come to
 * the thread that calls it. Returns DONE, or NO_RESOURCE, after a message, if the system has no
 * thread; then nothing is done. */
int threads_both(void (*work)(void *), void *first, void *second);

#endif
