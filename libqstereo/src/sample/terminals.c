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

/* Each group of terminals has as many variables as there are labels. */
static void set_terminals(uint32_t labels, uint32_t end, uint8_t *bits)
{
    for (uint32_t t = 0; t < labels; t++) {
        for (uint32_t d = 0; d < labels; d++) {
            qs_bit_set(bits, end + t * labels + d, d == t);
        }
    }
}

void qs_set_auxiliary_bits(const qs_index *index, uint32_t end, uint8_t *bits)
{
    const qs_qubo *qubo = index->qubo;
    const qs_labels *l = &qubo->labels;
    if (l->encoding == QS_MULTIWAY_CUT && l->undecided > 0) {
        set_terminals(l->labels, end, bits);
    } else if (qs_is_cut(l->encoding) && l->undecided > 0) {
        qs_bit_set(bits, end, true);
        qs_bit_set(bits, end + 1, false);
        for (uint32_t z = end + 2; z < qubo->variables; z++) {
            qs_bit_set(bits, z, false);
            qs_bit_set(bits, z, qs_field(index, bits, z, z) < 0);
        }
    }
}
