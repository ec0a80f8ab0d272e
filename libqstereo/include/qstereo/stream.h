/* Where a writer's bytes go: one callback. */
#ifndef QSTEREO_STREAM_H
#define QSTEREO_STREAM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Takes the bytes of a file, piece after piece in their order. */
typedef struct qs_sink {
    /* Returns false to stop the writer, which then returns QS_E_IO and calls it
     * no more. */
    bool (*write)(void *context, const void *bytes, size_t size);
    void *context; /* given to each call */
} qs_sink;

/* Memory to write into: set `bytes` and `capacity`, and `size` to 0. Then
 * `size` says how much has been written. */
typedef struct qs_buffer {
    uint8_t *bytes;
    size_t capacity;
    size_t size;
} qs_buffer;

/* A sink that appends to `buffer` and refuses what does not fit. It borrows the
 * buffer for as long as it is used. */
qs_sink qs_buffer_sink(qs_buffer *buffer);

#ifdef __cplusplus
}
#endif

#endif
