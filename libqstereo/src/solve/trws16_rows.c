/* Rows of TRW-S in 16 bits, by the labels of a register or one by one. */
#include "trws16_state.h"

typedef qs_trws16_state state;
typedef qs_trws16_stretch stretch;

/* The message of a site along its row; site -1 has one, too. */
QS_KERNEL int16_t *row_at(const state *s, uint32_t y)
{
    size_t length = (size_t)s->width + 1;
    return s->rows + (length * (y % s->row_count) + 1) * s->pitch;
}

QS_KERNEL int16_t *column_at(const state *s, uint32_t site)
{
    return s->columns + site * s->pitch;
}

/* What a pass reads and writes at a site: as qs_visit_of in trws_visit.h.
 *
 * row  row_at of its row */
QS_KERNEL qs_trws16_visit visit_of(const state *s, const stretch *of, int16_t *row, uint32_t x)
{
    bool forward = of->forward;
    uint32_t y = of->y, site = y * s->width + x;
    size_t pitch = s->pitch;
    int32_t right = qs_trws16_right(s, x, site), below = qs_trws16_below(s, y, site),
            left = qs_trws16_left(s, x, site), above = qs_trws16_above(s, y, site);
    int16_t *own = row + pitch * x, *before = own - pitch, *under = column_at(s, site),
            *over = under - pitch * s->width;
    int32_t along = forward ? right : left, across = forward ? below : above;
    bool both = (left != 0 && above != 0) || (right != 0 && below != 0);
    return (qs_trws16_visit){
        .costs = s->costs + pitch * site,
        .row_in = forward ? before : own,
        .row_out = forward ? own : before,
        .column_in = forward ? over : under,
        .column_out = forward ? under : over,
        .row_weight = (int16_t)(along * (1 << s->shift)),
        .column_weight = (int16_t)(across * (1 << s->shift)),
        .row_share = both || along != 0 || across == 0 ? -1 : 0,
        .both = both,
        .row_only = of->again,
        .sums = s->is_once && !forward ? under : NULL,
    };
}

/* Has memory fetched that the pass needs soon. */
QS_KERNEL void fetch(const state *s, uint32_t site, bool forward)
{
#if QS_HAVE_AVX2
    enum { AHEAD = 6, LINE = 64 };
    uint32_t ahead = forward ? site + AHEAD : site - AHEAD;
    if (ahead < s->sites) {
        const char *costs = (const char *)(s->costs + s->pitch * ahead),
                   *columns = (const char *)column_at(s, ahead);
        for (uint32_t i = 0; i < s->labels; i += LINE) {
            __builtin_prefetch(costs + i);
        }
        for (uint32_t i = 0; i < 2 * s->labels; i += LINE) {
            __builtin_prefetch(columns + i);
        }
    }
#else
    (void)s;
    (void)site;
    (void)forward;
#endif
}

QS_KERNEL qs_trws16_rule rule_of(const state *s, const stretch *of)
{
    return (qs_trws16_rule){s->labels, s->reach, (int16_t)(1 << s->shift), of->is_first,
                            of->scratch};
}

QS_KERNEL uint32_t column_of(const stretch *of, uint32_t i)
{
    return of->forward ? of->begin + i : of->end - 1 - i;
}

static int64_t plain_pass(const state *s, const stretch *of)
{
    const qs_trws16_rule rule = rule_of(s, of);
    int16_t *row = row_at(s, of->y);
    int64_t bound = 0;
    for (uint32_t i = 0; i < of->end - of->begin; i++) {
        const qs_trws16_visit v = visit_of(s, of, row, column_of(of, i));
        bound += qs_trws16_visit_site(&rule, &v);
    }
    return bound;
}

#if QS_HAVE_AVX2
QS_WIDE int64_t pass_of_runs(const state *s, const stretch *of, uint32_t runs, bool is_first,
                             bool again)
{
    const qs_trws16_rule rule = rule_of(s, of);
    int16_t *row = row_at(s, of->y);
    int64_t bound = 0;
    for (uint32_t i = 0; i < of->end - of->begin; i++) {
        uint32_t x = column_of(of, i);
        qs_trws16_visit v = visit_of(s, of, row, x);
        v.row_only = again;
        fetch(s, of->y * s->width + x, of->forward);
        bound += qs_trws16_visit_lanes(&rule, &v, runs, is_first);
    }
    return bound;
}

/* Of some numbers of runs a compiler makes code of their own. */
enum { FEW = 2, SOME = 4, MANY = 8 };

QS_AVX2 static int64_t wide_pass(const state *s, const stretch *of)
{
    uint32_t runs = (uint32_t)(s->pitch / QS_TRWS16_RUN);
    if (of->again) {
        return runs == SOME ? pass_of_runs(s, of, SOME, true, true)
                            : pass_of_runs(s, of, runs, true, true);
    }
    if (of->is_first) {
        return runs == FEW    ? pass_of_runs(s, of, FEW, true, false)
               : runs == SOME ? pass_of_runs(s, of, SOME, true, false)
               : runs == MANY ? pass_of_runs(s, of, MANY, true, false)
                              : pass_of_runs(s, of, runs, true, false);
    }
    return runs == FEW    ? pass_of_runs(s, of, FEW, false, false)
           : runs == SOME ? pass_of_runs(s, of, SOME, false, false)
           : runs == MANY ? pass_of_runs(s, of, MANY, false, false)
                          : pass_of_runs(s, of, runs, false, false);
}
#endif

int64_t qs_trws16_pass_stretch(const qs_trws16_state *s, const qs_trws16_stretch *of)
{
#if QS_HAVE_AVX2
    return s->wide ? wide_pass(s, of) : plain_pass(s, of);
#else
    return plain_pass(s, of);
#endif
}

/* The costs of a site and the messages of the later neighbours. Where a pass that was stopped has
 * not been, there are no messages. */
QS_KERNEL const int16_t *sums_of(const state *s, const stretch *of, const int16_t *row, uint32_t x)
{
    uint32_t site = of->y * s->width + x;
    const int16_t *column = column_at(s, site);
    if (of->y >= s->summed) {
        return column;
    }
    bool met = !s->is_once && of->y < s->reached;
    const uint8_t *costs = s->costs + s->pitch * site;
    int16_t *sums = of->scratch + qs_trws16_row(s->labels);
    row += s->pitch * x;
    for (size_t d = 0, end = s->wide ? s->pitch : s->labels; d < end; d++) {
        int32_t cost = costs[d] << s->shift;
        sums[d] = (int16_t)(met ? cost + row[d] + column[d] : cost);
    }
    return sums;
}

QS_KERNEL qs_trws16_beside beside_of(const state *s, uint32_t x, uint32_t y,
                                     const uint16_t *labelling)
{
    uint32_t site = y * s->width + x;
    int32_t unit = 1 << s->shift;
    return (qs_trws16_beside){labelling[x > 0 ? site - 1 : site],
                              labelling[y > 0 ? site - s->width : site],
                              (int16_t)(qs_trws16_left(s, x, site) * unit),
                              (int16_t)(qs_trws16_above(s, y, site) * unit)};
}

static void plain_labels(const state *s, const stretch *of, uint16_t *labelling)
{
    const qs_trws16_rule rule = rule_of(s, of);
    const int16_t *row = row_at(s, of->y);
    for (uint32_t x = of->begin; x < of->end; x++) {
        const qs_trws16_beside near = beside_of(s, x, of->y, labelling);
        labelling[of->y * s->width + x] = qs_trws16_cheapest(&rule, sums_of(s, of, row, x), &near);
    }
}

#if QS_HAVE_AVX2
QS_WIDE void labels_of_runs(const state *s, const stretch *of, uint32_t runs, uint16_t *labelling)
{
    const qs_trws16_rule rule = rule_of(s, of);
    const int16_t *row = row_at(s, of->y);
    for (uint32_t x = of->begin; x < of->end; x++) {
        const qs_trws16_beside near = beside_of(s, x, of->y, labelling);
        labelling[of->y * s->width + x] =
            qs_trws16_cheapest_lanes(&rule, sums_of(s, of, row, x), &near, runs);
    }
}

QS_AVX2 static void wide_labels(const state *s, const stretch *of, uint16_t *labelling)
{
    uint32_t runs = (uint32_t)(s->pitch / QS_TRWS16_RUN);
    if (runs == SOME) {
        labels_of_runs(s, of, SOME, labelling);
    } else {
        labels_of_runs(s, of, runs, labelling);
    }
}
#endif

void qs_trws16_label_stretch(const qs_trws16_state *s, const qs_trws16_stretch *of,
                             uint16_t *labelling)
{
#if QS_HAVE_AVX2
    if (s->wide) {
        wide_labels(s, of, labelling);
        return;
    }
#endif
    plain_labels(s, of, labelling);
}
