#include <string.h>

#include "../base/arena.h"
#include "../qubo/qubo_energy.h"
#include "candidates.h"
#include "repair.h"

/* The proofs for walls of any V (docs/MATHS.md, theorems 7 and 8) choose a label for each site such
 * that no energy is above H of the sample: the first candidate of all, or the last, or the one of
 * the number of ones. The file does not say which of them its penalties rely on, so all are tried;
 * and site by site, which is mostly better. */
typedef enum choice {
    FIRST_CANDIDATE,
    LAST_CANDIDATE,
    NUMBER_OF_ONES,
    SITE_BY_SITE,
    CHOICES
} choice;

typedef struct trial {
    uint8_t *sample, *best; /* bits, as they came and the cheapest so far */
    void *site_by_site; /* workspace */
} trial;

static size_t bytes_of(const qs_index *index)
{
    return ((size_t)index->qubo->variables + 7) / 8;
}

static trial take_trial(qs_arena *arena, const qs_index *index)
{
    return (trial){
        .site_by_site = qs_arena_take(arena, qs_site_by_site_workspace(index), 1),
        .sample = qs_arena_take(arena, bytes_of(index), 1),
        .best = qs_arena_take(arena, bytes_of(index), 1),
    };
}

size_t qs_choice_workspace(const qs_index *index)
{
    qs_arena arena = {0};
    take_trial(&arena, index);
    return qs_arena_size(&arena);
}

static uint32_t rank_of(const qs_index *index, const uint8_t *bits, uint32_t site, choice by)
{
    uint32_t from = index->start[site], end = index->start[site + 1], rank = 0;
    switch (by) {
    case NUMBER_OF_ONES: return qs_bit_count(bits, from, end);
    case LAST_CANDIDATE:
        for (rank = end - from; !qs_is_candidate(index, bits, site, rank); rank--) {
        }
        return rank;
    default:
        while (!qs_is_candidate(index, bits, site, rank)) {
            rank++;
        }
        return rank;
    }
}

static void choose(const qs_index *index, uint8_t *bits, choice by, void *site_by_site)
{
    if (by == SITE_BY_SITE) {
        qs_repair_site_by_site(index, bits, site_by_site);
        return;
    }
    for (uint32_t p = 0; p < index->qubo->groups; p++) {
        qs_choose_candidate(index, bits, p, rank_of(index, bits, p, by));
    }
}

void qs_repair_choice(const qs_index *index, uint8_t *bits, void *workspace)
{
    qs_arena arena = {.base = workspace};
    trial t = take_trial(&arena, index);
    int64_t least = INT64_MAX;
    memcpy(t.sample, bits, bytes_of(index));
    for (choice by = FIRST_CANDIDATE; by < CHOICES; by++) {
        memcpy(bits, t.sample, bytes_of(index));
        choose(index, bits, by, t.site_by_site);
        int64_t energy = qs_qubo_energy(index, bits);
        if (energy < least) {
            least = energy;
            memcpy(t.best, bits, bytes_of(index));
        }
    }
    memcpy(bits, t.best, bytes_of(index));
}
