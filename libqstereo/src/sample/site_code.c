#include "site_code.h"

#include "../base/bits.h"

static uint32_t end_of(const qs_site *site)
{
    return (uint32_t)site->variable + qs_site_variables(site->labels->encoding, site->count);
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

uint32_t qs_site_read(const qs_site *site, const uint8_t *bits)
{
    uint32_t from = (uint32_t)site->variable, end = end_of(site),
             ones = leading_ones(bits, from, end);
    if (qs_is_cut(site->labels->encoding)) {
        /* All at 1 is the sentinel. */
        return ones > 0 && qs_bit_next(bits, from + ones, end) == end ? ones - 1 : site->count;
    }
    if (site->labels->encoding == QS_DOMAIN_WALL) {
        return qs_bit_next(bits, from + ones, end) == end ? ones : site->count;
    }
    uint32_t first = qs_bit_next(bits, from, end);
    return first < end && qs_bit_next(bits, first + 1, end) == end ? first - from : site->count;
}

void qs_site_write(const qs_site *site, uint32_t rank, uint8_t *bits)
{
    uint32_t from = (uint32_t)site->variable, end = end_of(site);
    bool cut = qs_is_cut(site->labels->encoding), wall = site->labels->encoding == QS_DOMAIN_WALL;
    for (uint32_t i = from; i < end; i++) {
        qs_bit_set(bits, i, cut || wall ? i - from < rank + cut : i - from == rank);
    }
}

uint32_t qs_site_rank(const qs_site *site, uint32_t label)
{
    uint32_t rank = 0;
    for (uint32_t d = qs_site_label(site, 0); d < label; d = qs_site_label(site, d + 1)) {
        rank++;
    }
    return rank;
}

uint32_t qs_site_label_at(const qs_site *site, uint32_t rank)
{
    uint32_t label = qs_site_label(site, 0);
    for (; rank > 0; rank--) {
        label = qs_site_label(site, label + 1);
    }
    return label;
}
