/* Where a writer's bytes go: one callback. */
#ifndef QSTEREO_STREAM_H
#define QSTEREO_STREAM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Writers call `write` in file order and never seek. It returns false to stop
 * the writer, which then returns QS_E_IO. */
typedef struct qs_sink {
    bool (*write)(void *context, const void *bytes, size_t size);
    void *context;
} qs_sink;

/* A sink into memory: make one with qs_buffer_sink, then `size` says how much
 * has been written. */
typedef struct qs_buffer {
    uint8_t *bytes;
    size_t capacity;
    size_t size;
} qs_buffer;

/* The sink that appends to `buffer` and refuses what does not fit. The buffer
 * is borrowed while the sink is in use. */
qs_sink qs_buffer_sink(qs_buffer *buffer);

#ifdef __cplusplus
}
#endif

#endif
