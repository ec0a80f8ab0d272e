#include "terminals.h"

#include "../base/bits.h"
#include "../qubo/qubo_energy.h"
#include "../qubo/sites.h"

bool qs_is_one_hot(const qs_index *index, uint32_t group)
{
    int64_t a, b;
    qs_index_penalty(index, group, &a, &b);
    return a != 0 || b != 0;
}

/* A terminal has a variable for each label. */
static void set_terminals(uint32_t labels, uint32_t end, uint8_t *bits)
{
    for (uint32_t t = 0; t < labels; t++) {
        for (uint32_t d = 0; d < labels; d++) {
            qs_bit_set(bits, end + t * labels + d, d == t);
        }
    }
}

/* An arc's group is its variable alone, and it is coupled only with the two ends of its edge. */
static void set_arcs(const qs_index *index, uint32_t from, uint8_t *bits)
{
    for (uint32_t z = from; z < index->qubo->variables; z++) {
        qs_bit_set(bits, z, false);
        qs_bit_set(bits, z, qs_field(index, bits, z, z) < 0);
    }
}

void qs_set_auxiliary_bits(const qs_index *index, uint32_t end, uint8_t *bits)
{
    const qs_labels *labels = &index->qubo->labels;
    switch (qs_auxiliaries_of(labels)) {
    case QS_NO_AUXILIARIES: break;
    case QS_TERMINALS: set_terminals(labels->labels, end, bits); break;
    case QS_SOURCE_AND_SINK:
    case QS_SOURCE_SINK_AND_ARCS:
        qs_bit_set(bits, end, true);
        qs_bit_set(bits, end + 1, false);
        set_arcs(index, end + 2, bits);
        break;
    }
}
