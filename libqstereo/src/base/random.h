/* Numbers that look as if they were drawn by chance, the same on every machine. */
#ifndef QS_RANDOM_H
#define QS_RANDOM_H

#include <stdint.h>

/* SplitMix64 (Steele, Lea and Flood 2014). Returns 64 bits.
 *
 * state  any number to begin with */
static inline uint64_t qs_draw(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

/* A number below `below`, which is at least 1. */
static inline uint32_t qs_draw_below(uint64_t *state, uint32_t below)
{
    return (uint32_t)((qs_draw(state) >> 32) * below >> 32);
}

#endif
