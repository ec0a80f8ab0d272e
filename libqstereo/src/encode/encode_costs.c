#include "../base/bytes.h"
#include "../base/minmax.h"
#include "../base/saturate.h"
#include "../problem/cost_strips.h"
#include "encoder.h"

/* ---- Planning. ---- */

/* Of the shifted costs. */
typedef struct survey {
    uint32_t any; /* the bits of all together: as wide as the largest */
    uint64_t sum;
    uint64_t paper; /* the first sum of the paper's bound, over each site's largest cost;
                       saturated */
} survey;

static void survey_words(survey *s, const uint32_t *costs, size_t count)
{
    uint32_t any = 0;
    uint64_t sum = 0;
    for (size_t i = 0; i < count; i++) {
        any |= costs[i];
        sum += costs[i];
    }
    s->any |= any;
    s->sum += sum;
}

static void survey_bytes(survey *s, const uint8_t *costs, size_t count)
{
    s->any |= UINT8_MAX;
    for (size_t i = 0; i < count; i++) {
        s->sum += costs[i];
    }
}

static void survey_sites(survey *s, const qs_strip *strip, uint32_t labels)
{
    for (uint32_t i = 0; i < strip->sites; i++) {
        uint64_t largest = 0;
        for (uint32_t d = 0; d < labels; d++) {
            uint64_t cost = (uint64_t)qs_strip_cost(strip, (size_t)i * labels + d);
            largest = qs_max_u64(largest, cost);
        }
        /* The paper's costs are never negative. Where these are, the shifted costs give a bound. */
        qs_grow(&s->paper, 1, largest + (uint64_t)qs_max_i32(strip->least[i], 0));
    }
}

static survey survey_costs(const qs_encoder *e)
{
    survey s = {0};
    for (qs_strip strip = qs_strip_first(e->problem, e->costs); qs_strip_next(&strip);) {
        size_t count = (size_t)strip.sites * e->problem->labels;
        if (strip.bytes == 4) {
            survey_words(&s, strip.costs, count);
        } else {
            survey_bytes(&s, strip.costs, count);
        }
        if (e->penalty == QS_PENALTY_PAPER) {
            survey_sites(&s, &strip, e->problem->labels);
        }
    }
    return s;
}

/* The paper's alpha: above what any labelling costs. */
static uint64_t paper_alpha(const qs_encoder *e, uint64_t costs)
{
    uint64_t bound = costs;
    qs_grow(&bound, 1, e->edge_sum);
    return bound + 1;
}

void qs_plan_costs(qs_encoder *e)
{
    bool bytes = !e->problem->costs && e->problem->source.bytes == 1;
    /* Costs that are made as bytes need no pass of their own: they are written as they are. */
    survey s = {.any = UINT8_MAX, .sum = e->qcf.variables * UINT8_MAX};
    if (!bytes || e->penalty == QS_PENALTY_PAPER) {
        s = survey_costs(e);
    }
    e->qcf.linear_bytes = qs_bytes_of(s.any);
    if (e->penalty == QS_PENALTY_PAPER) {
        e->alpha = paper_alpha(e, s.paper);
    }
    qs_grow(&e->magnitude, 1, s.sum);
}

/* ---- Putting. ---- */

/* Narrows a strip's costs, in place, to the file's width. */
static void narrow(const qs_strip *strip, size_t count, unsigned bytes)
{
    const uint32_t *wide = strip->costs;
    uint8_t *out = strip->costs;
    for (size_t i = 0; i < count; i++) {
        uint32_t cost = wide[i];
        if (bytes == 1) {
            out[i] = (uint8_t)cost;
        } else if (bytes == 2) {
            qs_store_u16(out + 2 * i, cost);
        } else {
            qs_store_u32(out + 4 * i, cost);
        }
    }
}

void qs_put_the_costs(qs_writer *writer, const void *encoder)
{
    const qs_encoder *e = encoder;
    unsigned bytes = e->qcf.linear_bytes;
    int64_t least_sum = 0; /* |sum| < 2^31 sites x 2^31 */
    for (qs_strip strip = qs_strip_first(e->problem, e->costs);
         !writer->failed && qs_strip_next(&strip);) {
        size_t count = (size_t)strip.sites * e->problem->labels;
        if (strip.bytes == 4) {
            narrow(&strip, count, bytes);
        }
        qs_put(writer, strip.costs, count * bytes);
        least_sum += strip.least_sum;
    }
    *e->offset = least_sum + (int64_t)qs_band_sum(e);
}
