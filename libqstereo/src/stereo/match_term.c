#include "match_term.h"

#include <string.h>

#include "../base/minmax.h"
#include "../base/simd.h"

enum { TILE = QS_MATCH_TILE };

QS_KERNEL uint16_t cut_and_weighed(uint16_t cost, uint16_t truncation, uint16_t weight)
{
    return (uint16_t)((cost < truncation ? cost : truncation) * (unsigned)weight);
}

QS_KERNEL uint8_t apart(uint8_t a, uint8_t b)
{
    return (uint8_t)((a > b ? a : b) - (a < b ? a : b));
}

QS_KERNEL void add_ad(const uint8_t *restrict left, const uint8_t *restrict right,
                      uint16_t truncation, uint16_t weight, uint16_t *restrict sum)
{
    for (int i = 0; i < TILE; i++) {
        sum[i] = (uint16_t)(sum[i] + cut_and_weighed(apart(left[i], right[i]), truncation, weight));
    }
}

QS_KERNEL void add_sd(const uint8_t *restrict left, const uint8_t *restrict right,
                      uint16_t truncation, uint16_t weight, uint16_t *restrict sum)
{
    for (int i = 0; i < TILE; i++) {
        unsigned off = apart(left[i], right[i]);
        sum[i] = (uint16_t)(sum[i] + cut_and_weighed((uint16_t)(off * off), truncation, weight));
    }
}

QS_KERNEL int16_t largest(int16_t a, int16_t b)
{
    return a > b ? a : b;
}

/* How far a doubled sample is from a range. */
QS_KERNEL int16_t outside(uint8_t grey, int16_t low, int16_t high)
{
    int16_t twice = (int16_t)(2 * grey);
    return largest(0, largest((int16_t)(twice - high), (int16_t)(low - twice)));
}

QS_KERNEL void add_bt(const qs_match_row *left_row, size_t l, const qs_match_row *right_row,
                      size_t r, uint16_t truncation, uint16_t weight, uint16_t *restrict sum)
{
    const uint8_t *restrict left = left_row->grey + l, *restrict right = right_row->grey + r;
    const int16_t *restrict left_low = left_row->low + l, *restrict left_high = left_row->high + l;
    const int16_t *restrict low = right_row->low + r, *restrict high = right_row->high + r;
    for (int i = 0; i < TILE; i++) {
        int16_t a = outside(left[i], low[i], high[i]);
        int16_t b = outside(right[i], left_low[i], left_high[i]);
        sum[i] =
            (uint16_t)(sum[i] + cut_and_weighed((uint16_t)(a < b ? a : b), truncation, weight));
    }
}

/* Of each bit of three numbers, the two digits of their sum (a full adder). */
QS_KERNEL void add_three(uint64_t a, uint64_t b, uint64_t c, uint64_t *ones, uint64_t *twos)
{
    *ones = a ^ b ^ c;
    *twos = (a & b) | ((a ^ b) & c);
}

/* How many bits each byte has, for eight bytes at once. */
QS_KERNEL uint64_t bits_of_bytes(uint64_t x)
{
    x -= x >> 1 & 0x5555555555555555u;
    x = (x & 0x3333333333333333u) + (x >> 2 & 0x3333333333333333u);
    return (x + (x >> 4)) & 0x0F0F0F0F0F0F0F0Fu;
}

QS_KERNEL uint64_t eight_bytes(const uint8_t *from)
{
    uint64_t word;
    memcpy(&word, from, sizeof word);
    return word;
}

/* How many of the 48 bits of each pixel differ. Eight pixels are a word; no byte of a sum reaches
 * the next one, so the order of bytes in a word does not matter. */
QS_KERNEL void add_census(const qs_match_row *left_row, size_t l, const qs_match_row *right_row,
                          size_t r, uint16_t truncation, uint16_t weight, uint16_t *restrict sum)
{
    uint8_t count[TILE];
    uint64_t off[QS_CENSUS_BYTES], ones, twos, more_ones, more_twos;
    for (int i = 0; i < TILE; i += 8) {
        for (int b = 0; b < QS_CENSUS_BYTES; b++) {
            off[b] = eight_bytes(left_row->census[b] + l + i) ^
                     eight_bytes(right_row->census[b] + r + i);
        }
        add_three(off[0], off[1], off[2], &ones, &twos);
        add_three(off[3], off[4], off[5], &more_ones, &more_twos);
        uint64_t counts = bits_of_bytes(ones) + bits_of_bytes(more_ones) +
                          2 * (bits_of_bytes(twos) + bits_of_bytes(more_twos));
        memcpy(count + i, &counts, sizeof counts);
    }
    for (int i = 0; i < TILE; i++) {
        sum[i] = (uint16_t)(sum[i] + cut_and_weighed(count[i], truncation, weight));
    }
}

/* The symmetric difference of add_bt. */
static uint32_t bt_of(const qs_match_row *left_row, size_t l, const qs_match_row *right_row,
                      size_t r)
{
    int16_t a = outside(left_row->grey[l], right_row->low[r], right_row->high[r]);
    int16_t b = outside(right_row->grey[r], left_row->low[l], left_row->high[l]);
    return (uint32_t)(a < b ? a : b);
}

static uint32_t census_of(uint64_t left, uint64_t right)
{
    return (uint32_t)(bits_of_bytes(left ^ right) * 0x0101010101010101u >> 56);
}

static uint32_t cut(const qs_match_term *term, uint32_t cost)
{
    return term->weight * (term->truncation > 0 ? qs_min_u32(cost, term->truncation) : cost);
}

static void pick_census(const qs_match_term *term, const uint64_t *left,
                        const qs_match_row right_rows[], const qs_match_place *places,
                        uint32_t count, uint32_t *sum)
{
    for (uint32_t i = 0; i < count; i++) {
        sum[i] += cut(term, census_of(left[i], right_rows[places[i].part].words[places[i].at]));
    }
}

static void pick_bt(const qs_match_term *term, const qs_match_row *left_row, size_t left,
                    const qs_match_row right_rows[], const qs_match_place *places, uint32_t count,
                    uint32_t *sum)
{
    for (uint32_t i = 0; i < count; i++) {
        const qs_match_row *right_row = &right_rows[places[i].part];
        sum[i] += cut(term, bt_of(left_row, left + i, right_row, places[i].at));
    }
}

static void pick_difference(const qs_match_term *term, const uint8_t *left,
                            const qs_match_row right_rows[], const qs_match_place *places,
                            uint32_t count, uint32_t *sum)
{
    for (uint32_t i = 0; i < count; i++) {
        uint32_t off = apart(left[i], right_rows[places[i].part].grey[places[i].at]);
        sum[i] += cut(term, term->cost == QS_MATCH_SD ? off * off : off);
    }
}

void qs_match_term_pick(const qs_match_term *term, const qs_match_row *left_row, size_t left,
                        const qs_match_row right_rows[], const qs_match_place *places,
                        uint32_t count, uint32_t *sum)
{
    switch (term->cost) {
    case QS_MATCH_CENSUS:
        pick_census(term, left_row->words + left, right_rows, places, count, sum);
        break;
    case QS_MATCH_BT: pick_bt(term, left_row, left, right_rows, places, count, sum); break;
    case QS_MATCH_AD:
    case QS_MATCH_SD:
        pick_difference(term, left_row->grey + left, right_rows, places, count, sum);
        break;
    }
}

uint32_t qs_match_term_most(const qs_match_term *term)
{
    switch (term->cost) {
    case QS_MATCH_AD: return UINT8_MAX;
    case QS_MATCH_SD: return UINT8_MAX * UINT8_MAX;
    case QS_MATCH_BT: return 2 * UINT8_MAX;
    case QS_MATCH_CENSUS: break;
    }
    return term->width * term->height - 1;
}

QS_KERNEL void add_term(const qs_match_term *term, const qs_match_row *left_row, size_t left,
                        const qs_match_row *right_row, size_t right, uint16_t *sum)
{
    uint32_t most = qs_match_term_most(term);
    uint32_t end = term->truncation > 0 ? qs_min_u32(term->truncation, most) : most;
    uint16_t truncation = (uint16_t)end, weight = (uint16_t)term->weight;
    const uint8_t *l = left_row->grey + left, *r = right_row->grey + right;
    switch (term->cost) {
    case QS_MATCH_AD: add_ad(l, r, truncation, weight, sum); return;
    case QS_MATCH_SD: add_sd(l, r, truncation, weight, sum); return;
    case QS_MATCH_BT: add_bt(left_row, left, right_row, right, truncation, weight, sum); return;
    case QS_MATCH_CENSUS: break;
    }
    add_census(left_row, left, right_row, right, truncation, weight, sum);
}

void qs_match_term_add(const qs_match_term *term, const qs_match_row *left_row, size_t left,
                       const qs_match_row *right_row, size_t right, uint16_t sum[QS_MATCH_TILE])
{
    add_term(term, left_row, left, right_row, right, sum);
}

QS_AVX2 void qs_match_term_add_avx2(const qs_match_term *term, const qs_match_row *left_row,
                                    size_t left, const qs_match_row *right_row, size_t right,
                                    uint16_t sum[QS_MATCH_TILE])
{
    add_term(term, left_row, left, right_row, right, sum);
}
