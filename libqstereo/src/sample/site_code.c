#include "site_code.h"

#include "../base/bits.h"

static uint32_t end_of(const qs_site *site)
{
    return (uint32_t)site->variable +
           qs_encoding_site_variables(site->labels->encoding, site->count);
}

/* How many variables are 1 before the first 0. */
static uint32_t leading_ones(const uint8_t *bits, uint32_t from, uint32_t end)
{
    uint32_t at = from;
    while (at < end && qs_bit(bits, at)) {
        at++;
    }
    return at - from;
}

static bool all_zero(const uint8_t *bits, uint32_t from, uint32_t end)
{
    return qs_bit_next(bits, from, end) == end;
}

uint32_t qs_site_read(const qs_site *site, const uint8_t *bits)
{
    uint32_t from = (uint32_t)site->variable, end = end_of(site), ones, first;
    switch (qs_code_of(site->labels)) {
    case QS_CODE_WALL:
        ones = leading_ones(bits, from, end);
        return all_zero(bits, from + ones, end) ? ones : site->count;
    case QS_CODE_CHAIN:
        /* With all at 1 the result is `count`: it has count + 1 variables. */
        ones = leading_ones(bits, from, end);
        return ones > 0 && all_zero(bits, from + ones, end) ? ones - 1 : site->count;
    case QS_CODE_ONE_HOT: break;
    }
    first = qs_bit_next(bits, from, end);
    return first < end && all_zero(bits, first + 1, end) ? first - from : site->count;
}

void qs_site_write(const qs_site *site, uint32_t rank, uint8_t *bits)
{
    uint32_t from = (uint32_t)site->variable, end = end_of(site);
    qs_site_code code = qs_code_of(site->labels);
    uint32_t ones_from = code == QS_CODE_ONE_HOT ? from + rank : from;
    uint32_t ones_end = code == QS_CODE_WALL ? from + rank : from + rank + 1;
    for (uint32_t i = from; i < end; i++) {
        qs_bit_set(bits, i, i >= ones_from && i < ones_end);
    }
}

uint32_t qs_site_rank(const qs_site *site, uint32_t label)
{
    uint32_t rank = 0;
    for (uint32_t d = qs_site_label_from(site, 0); d < label; d = qs_site_label_from(site, d + 1)) {
        rank++;
    }
    return rank;
}

uint32_t qs_site_label_at(const qs_site *site, uint32_t rank)
{
    uint32_t label = qs_site_label_from(site, 0);
    for (; rank > 0; rank--) {
        label = qs_site_label_from(site, label + 1);
    }
    return label;
}
