#include "eliminate.h"

#include <string.h>

#include "lanes.h"
#include "local.h"

/* Parts of the workspace, in bytes. */
typedef struct layout {
    uint64_t high, unary, due, end;
} layout;

static layout lay_out(const qs_model *model)
{
    uint64_t labels = model->labels, sites = model->sites;
    layout l = {.high = sizeof(int64_t) * labels};
    l.unary = 2 * l.high;
    l.due = l.unary + sizeof(int32_t) * sites * labels;
    l.end = l.due + sites;
    return l;
}

uint64_t qs_eliminate_workspace(const qs_model *model)
{
    return lay_out(model).end;
}

static bool is_masked(const qs_model *model, uint32_t site)
{
    return model->mask && (model->mask[site / 8] >> site % 8 & 1) == 0;
}

/* The most that a site's edges can cost. */
static int64_t edges_of(const qs_model *model, uint32_t site)
{
    int64_t weights = 0;
    qs_beside beside;
    for (uint32_t at = 0; qs_local_neighbour(model, site, at, &beside); at++) {
        weights += beside.weight;
    }
    return model->pairwise_max > 0 && weights > INT64_MAX / 4 / model->pairwise_max ? INT64_MAX / 4 : weights * model->pairwise_max;
}

/* After a site's set has changed: its costs, from 0 for the cheapest label that is kept, and above all others for those that are out. */
static void settle(qs_elimination *e, uint32_t site)
{
    uint32_t labels = e->model.labels;
    const uint8_t *kept = e->kept + (size_t)site * labels;
    int32_t *unary = e->unary + (size_t)site * labels, least = INT32_MAX, highest = 0;
    for (uint32_t d = 0; d < labels; d++) {
        least = kept[d] ? qs_min32(least, unary[d]) : least;
        highest = kept[d] && unary[d] > highest ? unary[d] : highest;
    }
    int64_t above = (int64_t)highest - least + edges_of(&e->model, site) + 1;
    int32_t out = above < INT32_MAX ? (int32_t)above : INT32_MAX;
    for (uint32_t d = 0; d < labels; d++) {
        unary[d] = kept[d] ? unary[d] - least : out;
    }
    e->model.constant += least;
    qs_local_mend(&e->model, e->labelling, site);
}

static void alarm_neighbours(qs_elimination *e, uint32_t site)
{
    qs_beside beside;
    for (uint32_t at = 0; qs_local_neighbour(&e->model, site, at, &beside); at++) {
        e->due[beside.site] = 1;
    }
}

void qs_eliminate_begin(qs_elimination *e, const qs_model *model, void *workspace, uint8_t *kept, uint16_t *labelling)
{
    layout l = lay_out(model);
    char *base = workspace;
    size_t all = (size_t)model->sites * model->labels;
    *e = (qs_elimination){.model = *model, .kept = kept, .labelling = labelling};
    e->low = workspace;
    e->high = (int64_t *)(void *)(base + l.high);
    e->unary = (int32_t *)(void *)(base + l.unary);
    e->due = (uint8_t *)base + l.due;
    memcpy(e->unary, model->unary, sizeof *e->unary * all);
    if (model->kept) {
        memcpy(kept, model->kept, all);
    } else {
        memset(kept, 1, all);
    }
    memset(e->due, 1, model->sites);
    e->model.unary = e->unary;
    e->model.kept = kept;
    qs_model_winner(model, labelling);
    for (uint32_t p = 0; p < model->sites; p++) {
        if (is_masked(model, p)) {
            memset(kept + (size_t)p * model->labels, 0, model->labels);
            kept[(size_t)p * model->labels] = 1;
        }
        settle(e, p);
    }
}

/* An edge of Potts costs is free where the neighbour has the same label: it may, or must where it has no other. */
static void add_potts(const qs_elimination *e, const qs_beside *beside)
{
    uint32_t labels = e->model.labels, count = 0, last = 0;
    const uint8_t *kept = e->kept + (size_t)beside->site * labels;
    for (uint32_t d = 0; d < labels; d++) {
        e->low[d] -= kept[d] ? beside->weight : 0;
        count += kept[d];
        last = kept[d] ? d : last;
    }
    e->high[last] -= count == 1 ? beside->weight : 0;
}

/* Whether labels of the site leave: those that cost more, whatever the neighbours, than another one costs at most. That one stays. */
static bool look(qs_elimination *e, uint32_t site)
{
    uint32_t labels = e->model.labels;
    const int32_t *unary = e->unary + (size_t)site * labels;
    uint8_t *kept = e->kept + (size_t)site * labels;
    bool potts = e->model.pairwise.smoothness == QS_POTTS, changed = false;
    int64_t edges = potts ? 0 : edges_of(&e->model, site), least = INT64_MAX;
    for (uint32_t d = 0; d < labels; d++) {
        e->high[d] = unary[d];
        e->low[d] = unary[d] - edges;
    }
    qs_beside beside;
    for (uint32_t at = 0; potts && qs_local_neighbour(&e->model, site, at, &beside); at++) {
        add_potts(e, &beside);
    }
    for (uint32_t d = 0; d < labels; d++) {
        least = kept[d] && e->high[d] < least ? e->high[d] : least;
    }
    for (uint32_t d = 0; d < labels; d++) {
        bool leaves = kept[d] && e->low[d] > least;
        kept[d] = leaves ? 0 : kept[d];
        changed = changed || leaves;
    }
    return changed;
}

void qs_eliminate_goldstein(qs_elimination *e)
{
    for (bool again = true; again;) {
        again = false;
        for (uint32_t p = 0; p < e->model.sites; p++) {
            if (e->due[p] == 0) {
                continue;
            }
            e->due[p] = 0;
            if (look(e, p)) {
                settle(e, p);
                alarm_neighbours(e, p);
                again = true;
            }
        }
    }
}

void qs_eliminate_above(qs_elimination *e, const uint32_t *excess, int64_t room)
{
    uint32_t labels = e->model.labels;
    for (uint32_t p = 0; p < e->model.sites; p++) {
        uint8_t *kept = e->kept + (size_t)p * labels, changed = 0;
        const uint32_t *more = excess + (size_t)p * labels;
        for (uint32_t d = 0; d < labels; d++) {
            uint8_t leaves = kept[d] & (more[d] > room);
            kept[d] ^= leaves;
            changed |= leaves;
        }
        if (changed) {
            settle(e, p);
            alarm_neighbours(e, p);
        }
    }
}

uint32_t qs_eliminate_open(const qs_elimination *e, bool walls, uint64_t *variables)
{
    uint32_t labels = e->model.labels, open = 0;
    *variables = 0;
    for (uint32_t p = 0; p < e->model.sites; p++) {
        const uint8_t *kept = e->kept + (size_t)p * labels;
        uint32_t count = 0;
        for (uint32_t d = 0; d < labels; d++) {
            count += kept[d];
        }
        open += count > 1;
        *variables += count > 1 ? count - walls : 0;
    }
    return open;
}
