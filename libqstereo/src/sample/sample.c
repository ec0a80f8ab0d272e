#include "../../include/qstereo/sample.h"

#include <string.h>

#include "../base/bits.h"
#include "../base/bytes.h"
#include "site_code.h"
#include "terminals.h"

static uint32_t wrong_terminals(const qs_index *index, const uint8_t *bits)
{
    const qs_labels *l = &index->qubo->labels;
    uint32_t wrong = 0;
    for (uint32_t t = 0; l->encoding == QS_MULTIWAY_CUT && l->undecided > 0 && t < l->labels; t++) {
        uint32_t from = index->start[l->undecided + t], end = index->start[l->undecided + t + 1];
        wrong +=
            qs_bit_next(bits, from, end) != from + t || qs_bit_next(bits, from + t + 1, end) != end;
    }
    return wrong;
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
    const qs_labels *l = &index->qubo->labels;
    if (!index->qubo->has_labels) {
        return unlabelled_groups(index, bits);
    }
    uint32_t infeasible = 0;
    qs_site site = {.labels = l};
    while (qs_site_next(&site)) {
        infeasible += site.is_undecided && qs_site_read(&site, bits) == site.count;
    }
    if (qs_is_cut(l->encoding) && l->undecided > 0) {
        uint32_t source = (uint32_t)site.next_variable;
        infeasible += !qs_bit(bits, source) + (uint32_t)qs_bit(bits, source + 1);
    }
    return infeasible + wrong_terminals(index, bits);
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
        *labelling++ =
            (uint16_t)(site.is_undecided ? qs_site_label_at(&site, qs_site_read(&site, bits))
                                         : site.fixed);
    }
    return QS_OK;
}

qs_status qs_sample_encode(const qs_index *index, const uint16_t *labelling, uint8_t *bits)
{
    const qs_qubo *qubo = index->qubo;
    const qs_labels *l = &qubo->labels;
    if (!qubo->has_labels) {
        return QS_E_UNSUPPORTED;
    }
    qs_site site = {.labels = l};
    while (qs_site_next(&site)) {
        uint32_t label = labelling[site.next - 1];
        if (label >= l->labels || !qs_site_has(&site, label)) {
            return QS_E_ARGUMENT;
        }
    }
    memset(bits, 0, ((size_t)qubo->variables + 7) / 8);
    for (site = (qs_site){.labels = l}; qs_site_next(&site);) {
        if (site.is_undecided) {
            qs_site_write(&site, qs_site_rank(&site, labelling[site.next - 1]), bits);
        }
    }
    qs_set_auxiliary_bits(index, (uint32_t)site.next_variable, bits);
    return QS_OK;
}

int64_t qs_sample_trimmed(const qs_qubo *qubo, const uint16_t *labelling)
{
    int64_t trimmed = 0;
    const uint8_t *at = qubo->labels.trimmed;
    for (qs_site site = {.labels = &qubo->labels}; at && qs_site_next(&site);) {
        if (site.is_undecided) {
            uint32_t label = labelling[site.next - 1], bytes = qubo->labels.trimmed_bytes;
            trimmed += qs_site_has(&site, label)
                           ? (int64_t)qs_load_unsigned(
                                 at + (size_t)qs_site_rank(&site, label) * bytes, bytes)
                           : 0;
            at += (size_t)site.count * bytes;
        }
    }
    return trimmed;
}
