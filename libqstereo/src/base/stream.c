#include "../../include/qstereo/stream.h"

#include <string.h>

static bool append(void *context, const void *bytes, size_t size)
{
    qs_buffer *buffer = context;
    if (size > buffer->capacity - buffer->size) {
        return false;
    }
    memcpy(buffer->bytes + buffer->size, bytes, size);
    buffer->size += size;
    return true;
}

qs_sink qs_buffer_sink(qs_buffer *buffer)
{
    return (qs_sink){append, buffer};
}
