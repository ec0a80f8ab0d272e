/* Tiny random problems, and every one of their states: the oracle of the tests. */
#ifndef TINY_H
#define TINY_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
/* cmocka needs the four headers above first. */
#include <cmocka.h>

#include <qstereo.h>

enum { TINY_SITES = 12, TINY_LABELS = 6, TINY_EDGES = 24, TINY_FILE = 16384, TINY_INDEX = 8192 };

/* A problem with memory of its own. */
typedef struct tiny {
    qs_problem problem;
    int32_t costs[TINY_SITES * TINY_LABELS];
    int32_t table[TINY_LABELS * TINY_LABELS];
    int32_t right[TINY_SITES], down[TINY_SITES];
    uint8_t mask[TINY_SITES];
    qs_edge edges[TINY_EDGES];
} tiny;

/* An encoded problem, opened. */
typedef struct tiny_qubo {
    uint8_t file[TINY_FILE];
    size_t size;
    uint64_t memory[TINY_INDEX / 8];
    qs_qubo qubo;
    qs_index index;
} tiny_qubo;

uint32_t tiny_random(uint64_t *state, uint32_t below);

/* A random problem of at most `bits` variables: grid, masked grid, weighted grid or list of edges;
 * costs of one of several kinds (uniform, peaked, zero, binary: many ties). With `potts` every
 * smoothness is Potts. */
void tiny_make(tiny *t, uint64_t *state, uint32_t bits, bool potts);

/* Encodes and opens; fails the test where either fails. */
void tiny_encode(const qs_problem *problem, qs_encode_options options, tiny_qubo *q);

/* The least F over all labellings. */
int64_t tiny_minimum(const qs_problem *problem);

/* Bits of a state, packed as in a file. */
void tiny_bits(uint32_t state, uint8_t bits[4]);

/* H computed naively from the definition of the encoding, without the library's file: the penalties
 * are those of the index. */
int64_t tiny_energy(const qs_problem *problem, bool sparse, const qs_index *index, uint32_t state);

/* Sites and labels of each edge, in the order of the problem. */
typedef struct tiny_edge {
    uint32_t p, q;
    int64_t weight;
} tiny_edge;
size_t tiny_edges(const qs_problem *problem, tiny_edge edges[TINY_EDGES]);

#endif
