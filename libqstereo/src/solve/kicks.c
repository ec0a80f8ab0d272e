#include "kicks.h"

#include <string.h>

#include "../base/minmax.h"
#include "../base/random.h"

enum {
    IDLE = 64, /* rounds that gain nothing, at least, */
    IDLE_PART = 2, /* or this part of all before */
    RAREST = 7 /* kicks: one site in 2, 4, .. 2^RAREST */
};

/* What a round works on. */
typedef struct search {
    const qs_model *model;
    const uint32_t *sites;
    uint32_t count;
    qs_trees trees;
    qs_merger merger;
    uint16_t *other;
} search;

static bool take(search *s, void *memory, size_t size)
{
    qs_arena arena = {.base = memory};
    s->other = qs_arena_take(&arena, s->model->sites, sizeof *s->other);
    qs_trees_take(&s->trees, s->model, &arena);
    qs_merger_take(&s->merger, s->model, &arena);
    return qs_arena_size(&arena) <= size;
}

/* A label by chance, of those that are kept. */
static void kick(const qs_model *model, uint32_t site, uint64_t *random, uint16_t *labelling)
{
    uint32_t label = qs_draw_below(random, model->labels);
    if (!model->kept || model->kept[(size_t)site * model->labels + label]) {
        labelling[site] = (uint16_t)label;
    }
}

static int64_t round_of(search *s, qs_kicks *kicks, uint16_t *labelling)
{
    uint32_t one_in = 2u << kicks->rounds % RAREST;
    memcpy(s->other, labelling, sizeof *labelling * s->model->sites);
    for (uint32_t i = 0; i < s->count; i++) {
        if (qs_draw_below(&kicks->random, one_in) == 0) {
            kick(s->model, s->sites[i], &kicks->random, s->other);
        }
    }
    for (uint32_t i = 0; i < QS_KICKS_MOVES; i++) {
        qs_trees_move(&s->trees, s->sites, s->count, &kicks->random, s->other);
    }
    return qs_merge(&s->merger, labelling, s->other);
}

int64_t qs_kicks_improve(qs_kicks *kicks, const qs_model *model, const uint32_t *sites,
                         uint32_t count, uint64_t most, uint16_t *labelling, void *memory,
                         size_t size, qs_look *look)
{
    search s = {.model = model, .sites = sites, .count = count};
    if (!take(&s, memory, size)) {
        return 0;
    }
    qs_trees_begin(&s.trees);
    int64_t all = 0;
    uint64_t last = kicks->rounds;
    uint64_t numbers = QS_KICKS_MOVES * (uint64_t)model->labels * count;
    for (uint64_t i = 0; i < most && qs_look_up(look, numbers); i++) {
        int64_t gain = round_of(&s, kicks, labelling);
        kicks->rounds++;
        all += gain;
        last = gain > 0 ? kicks->rounds : last;
        if (kicks->rounds - last >= qs_max_u64(IDLE, last / IDLE_PART)) {
            break;
        }
    }
    return all;
}
