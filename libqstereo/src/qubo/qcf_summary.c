#include "../../include/qstereo/qubo.h"

#include "../base/minmax.h"
#include "qcf_runs.h"

/* Makes a range hold a value too; the first value is the range. */
static void widen(int64_t *min, int64_t *max, int64_t value, bool first)
{
    *min = first || value < *min ? value : *min;
    *max = first || value > *max ? value : *max;
}

static void summarise_linear(const qs_qubo *q, qs_qubo_summary *s)
{
    uint32_t variable = 0;
    for (qs_penalty_piece piece = {0}; qs_penalty_piece_next(q, &piece);) {
        for (uint64_t i = 0; i < piece.count * piece.size; i++, variable++) {
            int64_t value = qs_qubo_linear(q, variable) - (int64_t)piece.a;
            widen(&s->linear_min, &s->linear_max, value, variable == 0);
        }
    }
}

static void add_terms(qs_qubo_summary *s, uint64_t terms, int64_t min, int64_t max)
{
    if (terms > 0) {
        widen(&s->quadratic_min, &s->quadratic_max, min, s->quadratic_terms == 0);
        widen(&s->quadratic_min, &s->quadratic_max, max, false);
        s->quadratic_terms += terms;
    }
}

static void summarise_penalties(const qs_qubo *q, qs_qubo_summary *s)
{
    bool first = true;
    for (qs_penalty_piece piece = {0}; qs_penalty_piece_next(q, &piece);) {
        if (piece.a == 0 && piece.b == 0) {
            continue;
        }
        int64_t a = (int64_t)piece.a, b = (int64_t)piece.b;
        widen(&s->penalty_min, &s->penalty_max, a, first);
        widen(&s->pair_penalty_min, &s->pair_penalty_max, b, first);
        first = false;
        s->offset += a * (int64_t)piece.count;
        add_terms(s, b == 0 ? 0 : piece.count * (piece.size * (piece.size - 1) / 2), b, b);
    }
}

static void summarise_run(const qs_run_view *run, const qs_block_cursor *cursor, qs_qubo_summary *s)
{
    for (uint32_t r = 0; r < run->head.repeat; r++) {
        for (uint32_t c = 0; c < run->head.count; c++) {
            uint32_t first, second;
            qs_run_pair(run, r, c, &first, &second);
            const qs_block_facts *facts = first == second ? &cursor->upper : &cursor->whole;
            int64_t weight = qs_run_weight(run, r, c), low = weight * facts->min,
                    high = weight * facts->max;
            add_terms(s, weight == 0 ? 0 : facts->terms, qs_min_i64(low, high),
                      qs_max_i64(low, high));
        }
    }
}

void qs_qubo_summarise(const qs_qubo *qubo, qs_qubo_summary *summary)
{
    qs_qubo_summary s = {.offset = qubo->offset};
    summarise_linear(qubo, &s);
    summarise_penalties(qubo, &s);
    const uint8_t *at = qubo->coupling_runs;
    qs_block_cursor cursor = {0};
    for (uint32_t i = 0; i < qubo->coupling_run_count; i++) {
        qs_run_view run = qs_run_at(at);
        qs_block_seek(qubo, &cursor, run.head.block);
        summarise_run(&run, &cursor, &s);
        at += run.size;
    }
    *summary = s;
}
