/* Models of tiny problems, and of files of them in which some labels are left. */
#ifndef MODELLED_H
#define MODELLED_H

#include "slow.h"

enum { ROUNDS = 400, BITS = 24, MEMORY = 1 << 16 };

static tiny t;
static tiny_qubo q;
static uint64_t model_memory[MEMORY / 8];
static qs_model model;

static inline void make_model(uint64_t *state, bool potts, qs_encoding encoding)
{
    tiny_make(&t, state, BITS, potts);
    tiny_encode(&t.problem, (qs_encode_options){.encoding = encoding}, &q);
    assert_true(qs_model_workspace(&q.qubo) <= sizeof model_memory);
    assert_int_equal(qs_model_build(&q.index, model_memory, qs_model_workspace(&q.qubo), &model),
                     QS_OK);
}

static slow_qubo written;
static slow_request request;

/* A model of a file in which some labels are left. */
static inline void make_reduced(uint64_t *state, qs_encoding encoding)
{
    do {
        tiny_make(&t, state, BITS, false);
    } while (!slow_fits(&t.problem, encoding));
    request = (slow_request){.problem = &t.problem,
                             .encoding = encoding,
                             .gap = 1,
                             .truncate = tiny_random(state, 3) == 0};
    slow_choose_labels(&request, state);
    slow_encode(&request, &written);
    assert_true(qs_model_workspace(&written.qubo) <= sizeof model_memory);
    assert_int_equal(
        qs_model_build(&written.index, model_memory, qs_model_workspace(&written.qubo), &model),
        QS_OK);
}

/* The site of each of the model's, -1 where it is masked. */
static inline void sites_of_model(int site[TINY_SITES])
{
    int next = 0;
    for (uint32_t p = 0; p < model.sites; p++) {
        bool masked = model.mask && (model.mask[p / 8] >> p % 8 & 1) == 0;
        site[p] = masked ? -1 : next++;
    }
    assert_int_equal(next, qs_problem_sites(&t.problem));
}

#endif
