/* Which things belong together: union-find, with each thing's number of another one of its set; one
 * of them, which stands for the set, has its own. */
#ifndef QS_SETS_H
#define QS_SETS_H

#include <stdint.h>

/* The one that stands for the set. The next time it is found in half as many steps. */
static inline uint32_t qs_set_of(uint32_t *set, uint32_t of)
{
    while (set[of] != of) {
        set[of] = set[set[of]];
        of = set[of];
    }
    return of;
}

/* Makes one set of two. The lowest number of all that it has stands for it, if that was so of
 * both. */
static inline void qs_set_join(uint32_t *set, uint32_t one, uint32_t other)
{
    uint32_t a = qs_set_of(set, one), b = qs_set_of(set, other);
    set[a > b ? a : b] = a > b ? b : a;
}

#endif
