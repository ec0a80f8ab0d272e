/* A site waits for the one before it and the one above it. So tiles of some rows and columns are
 * done diagonal by diagonal: those of one diagonal do not wait for each other. Whoever does them in
 * whatever order, each site sees the same numbers. */
#include "trws16_wave.h"

#include "../base/minmax.h"

typedef qs_trws16_state state;

typedef struct wave {
    const state *s;
    bool forward;
    uint16_t *labelling; /* to be made; NULL = messages are passed */
    uint32_t band, bands, blocks; /* rows of a tile; tiles in a column and in a row */
    uint32_t step; /* the tiles of diagonal step - 1 are done, */
    uint32_t first, tiles; /* which begin in this band, */
    uint32_t again; /* and so many rows of band `step` are prepared */
    int64_t bounds[QS_TRWS16_PARTS];
} wave;

void qs_trws16_together(const qs_solve_options *options, qs_part *part, void *work, uint32_t parts)
{
    if (options && options->together && parts > 1) {
        options->together(options->helpers, part, work, parts);
        return;
    }
    for (uint32_t i = 0; i < parts; i++) {
        part(work, i);
    }
}

static wave wave_of(const state *s, const qs_solve_options *options, bool forward)
{
    bool alone = !options || !options->together;
    uint32_t band = alone ? 1 : QS_TRWS16_BAND, workers = alone ? 1 : options->workers;
    uint32_t blocks = qs_min_u32(qs_max_u32(workers, 1), QS_TRWS16_BLOCKS);
    return (wave){.s = s,
                  .forward = forward,
                  .band = band,
                  .bands = (s->height + band - 1) / band,
                  .blocks = qs_min_u32(blocks, s->width)};
}

uint32_t qs_trws16_flight(const qs_trws16_state *s, const qs_solve_options *options)
{
    wave w = wave_of(s, options, true);
    return w.band * (w.blocks + 1);
}

/* Row i in the order of the pass. */
static uint32_t row_of(const wave *w, uint32_t i)
{
    return w->forward ? i : w->s->height - 1 - i;
}

static uint32_t rows_before(const wave *w, uint32_t band)
{
    return qs_min_u32(band * w->band, w->s->height);
}

/* Whether the rows of a pass back need the messages that the pass before sent along them. */
static bool makes_again(const wave *w)
{
    return w->s->is_once && !w->forward && !w->labelling;
}

static int16_t *scratch_of(const wave *w, uint32_t part)
{
    return w->s->scratch + qs_trws16_scratch(w->s->labels) * part;
}

static void do_tile(wave *w, uint32_t part)
{
    uint32_t band = w->first + part, block = w->step - 1 - band;
    uint64_t width = w->s->width;
    uint32_t begin = (uint32_t)(width * block / w->blocks),
             end = (uint32_t)(width * (block + 1) / w->blocks);
    qs_trws16_stretch of = {.begin = w->forward ? begin : (uint32_t)width - end,
                            .end = w->forward ? end : (uint32_t)width - begin,
                            .forward = w->forward,
                            .is_first = w->s->is_first,
                            .scratch = scratch_of(w, part)};
    for (uint32_t i = rows_before(w, band); i < rows_before(w, band + 1); i++) {
        of.y = row_of(w, i);
        if (w->labelling) {
            qs_trws16_label_stretch(w->s, &of, w->labelling);
        } else {
            w->bounds[part] += qs_trws16_pass_stretch(w->s, &of);
        }
    }
}

static void do_part(void *work, uint32_t part)
{
    wave *w = work;
    if (part < w->tiles) {
        do_tile(w, part);
        return;
    }
    const qs_trws16_stretch again = {.y = row_of(w, rows_before(w, w->step) + part - w->tiles),
                                     .end = w->s->width,
                                     .forward = true,
                                     .again = true,
                                     .is_first = true,
                                     .scratch = scratch_of(w, part)};
    (void)qs_trws16_pass_stretch(w->s, &again);
}

static void do_step(wave *w, const qs_solve_options *options)
{
    uint32_t end = qs_min_u32(w->step, w->bands);
    w->first = w->step > w->blocks ? w->step - w->blocks : 0;
    w->tiles = w->first < end ? end - w->first : 0;
    w->again = makes_again(w)
                   ? rows_before(w, w->step + 1) - rows_before(w, qs_min_u32(w->step, w->bands))
                   : 0;
    qs_trws16_together(options, do_part, w, w->tiles + w->again);
}

static uint32_t steps_of(const wave *w)
{
    return w->bands + w->blocks;
}

int64_t qs_trws16_pass(qs_trws16_state *s, const qs_solve_options *options, bool forward)
{
    wave w = wave_of(s, options, forward);
    uint64_t work = 2 * (uint64_t)s->width * s->labels * w.band;
    int64_t bound = 0;
    for (; w.step < steps_of(&w) && qs_look_up(s->look, work); w.step++) {
        do_step(&w, options);
    }
    uint32_t done = rows_before(&w, w.step > w.blocks ? w.step - w.blocks : 0);
    if (forward) {
        s->reached = qs_max_u32(s->reached, done);
    } else if (s->is_once) {
        s->summed = s->height - done;
    }
    for (int i = 0; i < QS_TRWS16_PARTS; i++) {
        bound += w.bounds[i];
    }
    return bound;
}

void qs_trws16_label(const qs_trws16_state *s, const qs_solve_options *options, uint16_t *labelling)
{
    wave w = wave_of(s, options, true);
    w.labelling = labelling;
    for (w.step = 1; w.step < steps_of(&w); w.step++) {
        do_step(&w, options);
    }
}
