/* What the benchmarks in C share. */
#ifndef BENCH_H
#define BENCH_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <qstereo.h>

/* Zeroed memory that is touched already, so that no run pays for first touching it. Ends the
 * program if there is none. */
static inline void *memory(size_t size)
{
    void *bytes = malloc(size);
    if (!bytes) {
        fprintf(stderr, "no memory\n");
        exit(4);
    }
    memset(bytes, 0, size);
    return bytes;
}

/* Ends the program unless the status is QS_OK. */
static inline void demand(qs_status status)
{
    if (status != QS_OK) {
        fprintf(stderr, "%s\n", qs_status_text(status));
        exit(3);
    }
}

#endif
