#include <string.h>

#include "../base/bits.h"
#include "../base/bytes.h"
#include "qcf_runs.h"
#include "sites.h"

void qs_qubo_known_state(const qs_qubo *qubo, uint8_t *bits)
{
    const uint8_t *at = qubo->known.labels;
    bool wall = qs_code_of(&qubo->labels) == QS_CODE_WALL;
    uint32_t variable = 0;
    memset(bits, 0, (size_t)qs_bit_bytes(qubo->variables));
    for (size_t r = 0; r < qubo->group_run_count; r++) {
        qs_group_run run = qs_group_run_at(qubo, r);
        for (uint32_t g = 0; g < run.count; g++) {
            uint32_t label = (uint32_t)qs_load_unsigned(at, qubo->known.bytes);
            for (uint32_t i = wall ? 0 : label; i < label + !wall; i++) {
                qs_bit_set(bits, variable + i, true);
            }
            at += qubo->known.bytes;
            variable += run.size;
        }
    }
}
