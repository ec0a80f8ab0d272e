/* What the fuzz targets share. Each target is one function over bytes, as libFuzzer wants it;
 * replay.c runs it over a corpus in the normal tests. */
#ifndef FUZZ_H
#define FUZZ_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Makes the sizes and checksums of a changed .qcf or .qsf right again, so that its contents are
 * reached. Returns the new size; other bytes stay as they are. */
size_t fuzz_mend(uint8_t *file, size_t size);

/* A promise that holds whatever the bytes are. */
#define PROMISE(holds)                                                                             \
    do {                                                                                           \
        if (!(holds)) {                                                                            \
            fprintf(stderr, "%s:%d: broken promise: %s\n", __FILE__, __LINE__, #holds);            \
            abort();                                                                               \
        }                                                                                          \
    } while (0)

#endif
