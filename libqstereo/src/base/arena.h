/* Memory of the caller, handed out in parts. One function asks for all parts of a workspace. It is
 * called twice: with no memory it counts the bytes, with memory it hands them out. So a size and
 * the layout that needs it cannot differ. */
#ifndef QS_ARENA_H
#define QS_ARENA_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { QS_ARENA_ALIGNMENT = 16 }; /* of each part: enough for any type and for SSE registers */

typedef struct qs_arena {
    char *base; /* NULL = count only */
    uint64_t used;
    bool full; /* more was asked for than 64 bits can count */
} qs_arena;

/* The next part: room for `count` elements of `size` bytes each. NULL while counting. */
static inline void *qs_arena_take(qs_arena *arena, uint64_t count, uint64_t size)
{
    uint64_t at = arena->used;
    if (size != 0 && count > (UINT64_MAX / 2 - at) / size) {
        arena->full = true;
        return NULL;
    }
    uint64_t bytes = count * size;
    arena->used = at + (bytes + QS_ARENA_ALIGNMENT - 1) / QS_ARENA_ALIGNMENT * QS_ARENA_ALIGNMENT;
    return arena->base ? arena->base + at : NULL;
}

/* Bytes that were asked for. SIZE_MAX = more than this machine can address. */
static inline size_t qs_arena_size(const qs_arena *arena)
{
    return arena->full || arena->used > SIZE_MAX - 1 ? SIZE_MAX : (size_t)arena->used;
}

#endif
