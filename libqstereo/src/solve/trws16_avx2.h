/* What a pass of TRW-S computes at one site, as in trws16_site.h, with sixteen labels in a register
 * of AVX2. A round of the lower envelope needs labels that are a few apart: they come from the
 * registers, because memory that was just written is slow to read at another place. */
#ifndef QS_TRWS16_AVX2_H
#define QS_TRWS16_AVX2_H

#include "trws16_site.h"

#if QS_HAVE_AVX2

enum {
    QS_LANES16 = 16,
    QS_TRWS16_RUNS = 16, /* registers of labels, at most */
    QS_TRWS16_REACH = 16 /* of the smoothness, at most */
};
typedef int16_t qs_lanes16 __attribute__((vector_size(32)));
typedef uint16_t qs_lanes16u __attribute__((vector_size(32)));
typedef int16_t qs_loose16 __attribute__((vector_size(32), aligned(2), may_alias));
typedef uint8_t qs_bytes16 __attribute__((vector_size(16), aligned(1), may_alias));

#if defined(__clang__)
#define QS_PICK16(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define QS_PICK16(a, b, ...) __builtin_shuffle(a, b, (qs_lanes16){__VA_ARGS__})
#endif

QS_WIDE qs_lanes16 qs_lanes16_all(int16_t v)
{
    return (qs_lanes16){v, v, v, v, v, v, v, v, v, v, v, v, v, v, v, v};
}

QS_WIDE qs_lanes16 qs_lanes16_min(qs_lanes16 a, qs_lanes16 b)
{
#if defined(__clang__)
    return __builtin_elementwise_min(a, b);
#else
    return __builtin_ia32_pminsw256(a, b);
#endif
}

QS_WIDE qs_lanes16 qs_lanes16_max(qs_lanes16 a, qs_lanes16 b)
{
#if defined(__clang__)
    return __builtin_elementwise_max(a, b);
#else
    return __builtin_ia32_pmaxsw256(a, b);
#endif
}

QS_WIDE qs_lanes16 qs_lanes16_load(const int16_t *from)
{
    return (qs_lanes16) * (const qs_loose16 *)from;
}

QS_WIDE void qs_lanes16_store(int16_t *to, qs_lanes16 value)
{
    *(qs_loose16 *)to = value;
}

QS_WIDE qs_lanes16 qs_lanes16_widen(const uint8_t *from)
{
    return (qs_lanes16) __builtin_convertvector(*(const qs_bytes16 *)from, qs_lanes16u);
}

/* The least of each of two, in all lanes of it. */
QS_WIDE void qs_lanes16_least(qs_lanes16 *a, qs_lanes16 *b)
{
    qs_lanes16 both = qs_lanes16_min(
        QS_PICK16(*a, *b, 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23),
        QS_PICK16(*a, *b, 8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 26, 27, 28, 29, 30, 31));
    both = qs_lanes16_min(
        both, QS_PICK16(both, both, 4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11));
    both = qs_lanes16_min(
        both, QS_PICK16(both, both, 2, 3, 0, 1, 6, 7, 4, 5, 10, 11, 8, 9, 14, 15, 12, 13));
    both = qs_lanes16_min(
        both, QS_PICK16(both, both, 1, 0, 3, 2, 5, 4, 7, 6, 9, 8, 11, 10, 13, 12, 15, 14));
    *a = QS_PICK16(both, both, 0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7);
    *b = QS_PICK16(both, both, 8, 9, 10, 11, 12, 13, 14, 15, 8, 9, 10, 11, 12, 13, 14, 15);
}

/* Two bits for each lane in which both are equal. */
QS_WIDE uint32_t qs_lanes16_mask(qs_lanes16 a, qs_lanes16 b)
{
    typedef char bytes __attribute__((vector_size(32)));
    return (uint32_t)__builtin_ia32_pmovmskb256((bytes)(a == b));
}

/* Sixteen labels, from `step` before or behind those of `at`. */
QS_WIDE qs_lanes16 qs_lanes16_before(qs_lanes16 other, qs_lanes16 at, uint32_t step)
{
    switch (step) {
    case 1:
        return QS_PICK16(other, at, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30);
    case 2:
        return QS_PICK16(other, at, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29);
    case 4:
        return QS_PICK16(other, at, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27);
    default:
        return QS_PICK16(other, at, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23);
    }
}

QS_WIDE qs_lanes16 qs_lanes16_behind(qs_lanes16 at, qs_lanes16 other, uint32_t step)
{
    switch (step) {
    case 1: return QS_PICK16(at, other, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16);
    case 2: return QS_PICK16(at, other, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17);
    case 4: return QS_PICK16(at, other, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19);
    default:
        return QS_PICK16(at, other, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23);
    }
}

/* Large numbers for the labels of a last register that there are not, else 0. */
QS_WIDE qs_lanes16 qs_lanes16_tail(uint32_t labels, uint32_t runs)
{
    qs_lanes16 order = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    int16_t last = (int16_t)(labels - (runs - 1) * QS_LANES16);
    return (qs_lanes16)(order >= last) & QS_TRWS16_MOST;
}

/* A round of the lower envelope in place: as qs_trws16_spread. */
QS_WIDE void qs_trws16_round(qs_lanes16 *costs, uint32_t runs, uint32_t step, int16_t weight)
{
    qs_lanes16 more = qs_lanes16_all((int16_t)((int32_t)step * weight)),
               none = qs_lanes16_all(QS_TRWS16_MOST), before = none;
    for (uint32_t i = 0; i < runs; i++) {
        qs_lanes16 at = costs[i], next = i + 1 < runs ? costs[i + 1] : none;
        qs_lanes16 other =
            qs_lanes16_min(qs_lanes16_before(before, at, step), qs_lanes16_behind(at, next, step));
        costs[i] = qs_lanes16_min(at, other + more);
        before = at;
    }
}

/* As qs_trws16_send. The steps together may reach further than needed: the cap does the same. */
QS_WIDE void qs_trws16_send_lanes(const qs_trws16_rule *rule, qs_lanes16 *costs, uint32_t runs,
                                  qs_lanes16 least, int16_t weight, int16_t *message)
{
    qs_lanes16 cap = qs_lanes16_all((int16_t)(weight * (int32_t)rule->reach));
    for (uint32_t i = 0; i < runs; i++) {
        costs[i] = qs_lanes16_min(costs[i] - least, cap);
    }
    if (rule->reach > 1) {
        qs_trws16_round(costs, runs, 1, weight);
    }
    if (rule->reach > 2) {
        qs_trws16_round(costs, runs, 2, weight);
    }
    if (rule->reach > 4) {
        qs_trws16_round(costs, runs, 4, weight);
    }
    if (rule->reach > 8) {
        qs_trws16_round(costs, runs, 8, weight);
    }
    for (uint32_t i = 0; i < runs; i++) {
        qs_lanes16_store(message + i * QS_LANES16, costs[i]);
    }
}

/* As qs_trws16_visit_site. A compiler keeps all in registers if it knows `runs` and that they are
 * few. */
QS_WIDE int64_t qs_trws16_visit_lanes(const qs_trws16_rule *rule, const qs_trws16_visit *v,
                                      uint32_t runs, bool is_first)
{
    qs_lanes16 row[QS_TRWS16_RUNS], column[QS_TRWS16_RUNS], least = qs_lanes16_all(INT16_MAX),
                                                            over_least = least;
    qs_lanes16 tail = qs_lanes16_tail(rule->labels, runs), unit = qs_lanes16_all(rule->unit),
               share = qs_lanes16_all(v->both ? -1 : v->row_share), zero = {0};
    int half = v->both;
    for (uint32_t i = 0; i < runs; i++) {
        uint32_t at = i * QS_LANES16;
        qs_lanes16 back = is_first ? zero : qs_lanes16_load(v->row_out + at),
                   over = is_first ? zero : qs_lanes16_load(v->column_out + at);
        qs_lanes16 sum = qs_lanes16_widen(v->costs + at) * unit + qs_lanes16_load(v->row_in + at) +
                         qs_lanes16_load(v->column_in + at);
        qs_lanes16 total = sum + back + over, part = (total >> half) & share;
        if (v->sums) {
            qs_lanes16_store(v->sums + at, sum);
        }
        row[i] = part - back;
        column[i] = total - part - over;
        if (i + 1 == runs) {
            row[i] += tail;
            column[i] += tail;
        }
        least = qs_lanes16_min(least, row[i]);
        over_least = qs_lanes16_min(over_least, column[i]);
    }
    qs_lanes16_least(&least, &over_least);
    qs_trws16_send_lanes(rule, row, runs, least, v->row_weight, v->row_out);
    if (!v->row_only) {
        qs_trws16_send_lanes(rule, column, runs, over_least, v->column_weight, v->column_out);
    }
    return (int64_t)least[0] + over_least[0];
}

/* What a label costs beside another one. */
QS_WIDE qs_lanes16 qs_trws16_apart(qs_lanes16 labels, uint16_t other, int16_t reach, int16_t weight)
{
    qs_lanes16 off = labels - qs_lanes16_all((int16_t)other);
    off = qs_lanes16_min(qs_lanes16_max(off, -off), qs_lanes16_all(reach));
    return off * weight;
}

/* As qs_trws16_cheapest. */
QS_WIDE uint16_t qs_trws16_cheapest_lanes(const qs_trws16_rule *rule, const int16_t *sums,
                                          const qs_trws16_beside *near, uint32_t runs)
{
    qs_lanes16 costs[QS_TRWS16_RUNS],
        least = qs_lanes16_all(INT16_MAX), none = least,
        labels = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    int16_t reach = (int16_t)rule->reach;
    for (uint32_t i = 0; i < runs; i++) {
        costs[i] = qs_lanes16_load(sums + i * QS_LANES16) +
                   qs_trws16_apart(labels, near->row, reach, near->row_weight) +
                   qs_trws16_apart(labels, near->column, reach, near->column_weight);
        if (i + 1 == runs) {
            costs[i] += qs_lanes16_tail(rule->labels, runs);
        }
        least = qs_lanes16_min(least, costs[i]);
        labels += QS_LANES16;
    }
    qs_lanes16_least(&least, &none);
    for (uint32_t i = 0; i + 1 < runs; i++) {
        uint32_t found = qs_lanes16_mask(costs[i], least);
        if (found != 0) {
            return (uint16_t)(i * QS_LANES16 + (uint32_t)__builtin_ctz(found) / 2);
        }
    }
    uint32_t found = qs_lanes16_mask(costs[runs - 1], least);
    return (uint16_t)((runs - 1) * QS_LANES16 + (uint32_t)__builtin_ctz(found) / 2);
}
#endif

#endif
