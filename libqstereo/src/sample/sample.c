#include "../../include/qstereo/sample.h"

#include <string.h>

#include "../base/bits.h"
#include "../base/bytes.h"
#include "site_code.h"
#include "terminals.h"

/* ---- Feasibility. ---- */

/* Terminal t has its t-th variable at 1 and no other. */
static uint32_t wrong_terminals(const qs_index *index, const uint8_t *bits)
{
    const qs_labels *l = &index->qubo->labels;
    uint32_t wrong = 0;
    for (uint32_t t = 0; t < l->labels; t++) {
        uint32_t from = index->start[l->undecided + t], end = index->start[l->undecided + t + 1];
        bool own = qs_bit_next(bits, from, end) == from + t;
        wrong += !own || qs_bit_next(bits, from + t + 1, end) != end;
    }
    return wrong;
}

/* `end` is the first variable behind those of the sites. */
static uint32_t wrong_auxiliaries(const qs_index *index, uint32_t end, const uint8_t *bits)
{
    switch (qs_auxiliaries_of(&index->qubo->labels)) {
    case QS_NO_AUXILIARIES: break;
    case QS_TERMINALS: return wrong_terminals(index, bits);
    case QS_SOURCE_AND_SINK:
    case QS_SOURCE_SINK_AND_ARCS: return !qs_bit(bits, end) + (uint32_t)qs_bit(bits, end + 1);
    }
    return 0;
}

static uint32_t unlabelled_groups(const qs_index *index, const uint8_t *bits)
{
    uint32_t count = 0;
    for (uint32_t g = 0; g < index->qubo->groups; g++) {
        count += qs_is_one_hot(index, g) &&
                 qs_bit_count(bits, index->start[g], index->start[g + 1]) != 1;
    }
    return count;
}

uint32_t qs_sample_infeasible(const qs_index *index, const uint8_t *bits)
{
    if (!index->qubo->has_labels) {
        return unlabelled_groups(index, bits);
    }
    uint32_t infeasible = 0;
    qs_site site = {.labels = &index->qubo->labels};
    while (qs_site_next(&site)) {
        infeasible += site.is_undecided && qs_site_read(&site, bits) == site.count;
    }
    return infeasible + wrong_auxiliaries(index, (uint32_t)site.next_variable, bits);
}

/* ---- Samples and labellings. ---- */

static uint32_t label_in(const qs_site *site, const uint8_t *bits)
{
    return site->is_undecided ? qs_site_label_at(site, qs_site_read(site, bits)) : site->fixed;
}

qs_status qs_sample_decode(const qs_index *index, const uint8_t *bits, uint16_t *labelling)
{
    if (!index->qubo->has_labels) {
        return QS_E_UNSUPPORTED;
    }
    if (qs_sample_infeasible(index, bits) > 0) {
        return QS_E_INFEASIBLE;
    }
    for (qs_site site = {.labels = &index->qubo->labels}; qs_site_next(&site);) {
        *labelling++ = (uint16_t)label_in(&site, bits);
    }
    return QS_OK;
}

static bool all_left(const qs_labels *labels, const uint16_t *labelling)
{
    for (qs_site site = {.labels = labels}; qs_site_next(&site);) {
        uint32_t label = *labelling++;
        if (label >= labels->labels || !qs_site_has(&site, label)) {
            return false;
        }
    }
    return true;
}

qs_status qs_sample_encode(const qs_index *index, const uint16_t *labelling, uint8_t *bits)
{
    const qs_qubo *qubo = index->qubo;
    if (!qubo->has_labels) {
        return QS_E_UNSUPPORTED;
    }
    if (!all_left(&qubo->labels, labelling)) {
        return QS_E_ARGUMENT;
    }
    memset(bits, 0, (size_t)qs_bit_bytes(qubo->variables));
    qs_site site = {.labels = &qubo->labels};
    while (qs_site_next(&site)) {
        if (site.is_undecided) {
            qs_site_write(&site, qs_site_rank(&site, labelling[site.next - 1]), bits);
        }
    }
    qs_set_auxiliary_bits(index, (uint32_t)site.next_variable, bits);
    return QS_OK;
}

int64_t qs_sample_trimmed(const qs_qubo *qubo, const uint16_t *labelling)
{
    int64_t sum = 0;
    const uint8_t *at = qubo->labels.trimmed;
    uint32_t bytes = qubo->labels.trimmed_bytes;
    if (!at) {
        return 0;
    }
    for (qs_site site = {.labels = &qubo->labels}; qs_site_next(&site);) {
        if (!site.is_undecided) {
            continue;
        }
        uint32_t label = labelling[site.next - 1];
        if (qs_site_has(&site, label)) {
            size_t rank = qs_site_rank(&site, label);
            sum += (int64_t)qs_load_unsigned(at + rank * bytes, bytes);
        }
        at += (size_t)site.count * bytes;
    }
    return sum;
}
