#include "../../include/qstereo/segment.h"

#include <stdbool.h>
#include <string.h>

#include "../base/arena.h"
#include "../base/minmax.h"
#include "logarithm.h"

/* A histogram has 16 levels a channel. A pixel counts PIXEL, so that the 1 that each bin gets on
 * top is a sixteenth of a pixel. */
enum { LEVEL_BITS = 4, PIXEL = 16, SCALE_MAX = 1000000 };

/* The number of steps of the table of exponentials in one unit of the exponent. */
enum { EXP_STEP = 32 };

typedef struct segmenter {
    qs_segment segment;
    uint32_t bins;
    int32_t *right, *down; /* weights of the edges of each pixel */
    uint8_t *allowed; /* pixels x classes */
    uint32_t *counts; /* classes x bins: pixels */
    uint32_t *totals; /* classes: pixels */
    uint32_t *costs; /* bins x classes: each less the least of its bin */
    int32_t *least; /* bins */
} segmenter;

static uint64_t pixels_of(const qs_segment *segment)
{
    return (uint64_t)segment->width * segment->height;
}

/* The parts of the workspace: returns its first one. */
static segmenter *lay_out(qs_arena *arena, const qs_segment *segment, segmenter *s)
{
    uint64_t pixels = pixels_of(segment), classes = segment->classes;
    s->segment = *segment;
    s->bins = 1u << (LEVEL_BITS * segment->channels);
    segmenter *self = qs_arena_take(arena, 1, sizeof *self);
    s->right = qs_arena_take(arena, pixels, sizeof *s->right);
    s->down = qs_arena_take(arena, pixels, sizeof *s->down);
    s->allowed = qs_arena_take(arena, segment->strokes ? pixels : 0, classes);
    s->counts = qs_arena_take(arena, classes * s->bins, sizeof *s->counts);
    s->totals = qs_arena_take(arena, classes, sizeof *s->totals);
    s->costs = qs_arena_take(arena, classes * s->bins, sizeof *s->costs);
    s->least = qs_arena_take(arena, s->bins, sizeof *s->least);
    return self;
}

static bool is_segment(const qs_segment *segment)
{
    return segment && segment->photo && segment->width > 0 && segment->height > 0 &&
           segment->width <= INT32_MAX && segment->height <= INT32_MAX &&
           (segment->channels == 1 || segment->channels == 3) &&
           segment->stride / segment->channels >= segment->width && segment->classes >= 2 &&
           segment->classes <= QS_CLASSES_MAX && (segment->strokes || segment->costs) &&
           segment->scale >= 1 && segment->scale <= SCALE_MAX && segment->weight >= 0;
}

size_t qs_segment_workspace(const qs_segment *segment)
{
    qs_arena arena = {0};
    segmenter s;
    if (!is_segment(segment)) {
        return SIZE_MAX;
    }
    (void)lay_out(&arena, segment, &s);
    return qs_arena_size(&arena);
}

static const uint8_t *pixel_at(const qs_segment *segment, uint32_t x, uint32_t y)
{
    return segment->photo + y * segment->stride + (size_t)x * segment->channels;
}

/* ---- weights ---- */

/* |I_p - I_q|^2. */
static uint32_t contrast(const qs_segment *segment, const uint8_t *p, const uint8_t *q)
{
    uint32_t sum = 0;
    for (unsigned c = 0; c < segment->channels; c++) {
        int apart = p[c] - q[c];
        sum += (uint32_t)(apart * apart);
    }
    return sum;
}

/* Puts the contrast of every edge where its weight will be. Returns their sum, and how many edges
 * there are. */
static uint64_t measure_contrast(segmenter *s, uint64_t *edges)
{
    const qs_segment *segment = &s->segment;
    uint64_t sum = 0;
    size_t at = 0;
    for (uint32_t y = 0; y < segment->height; y++) {
        for (uint32_t x = 0; x < segment->width; x++, at++) {
            const uint8_t *pixel = pixel_at(segment, x, y);
            bool right = x + 1 < segment->width, down = y + 1 < segment->height;
            s->right[at] = right ? (int32_t)contrast(segment, pixel, pixel + segment->channels) : 0;
            s->down[at] = down ? (int32_t)contrast(segment, pixel, pixel + segment->stride) : 0;
            sum += (uint64_t)s->right[at] + (uint64_t)s->down[at];
            *edges += (uint64_t)right + down;
        }
    }
    return sum;
}

/* lambda exp(-beta contrast), where beta = edges / (2 sum): of half a step and more the next step
 * of the table is taken. */
static int32_t weight_of(const qs_segment *segment, const uint32_t *exponential, uint32_t contrast,
                         uint64_t edges, uint64_t sum)
{
    uint64_t step = sum > 0 ? ((uint64_t)contrast * edges * EXP_STEP + sum) / (2 * sum) : 0;
    uint64_t factor = step < QS_EXP_STEPS ? exponential[step] : 0;
    return (int32_t)(((uint64_t)segment->weight * factor + (1u << 29)) >> 30);
}

static void weigh_edges(segmenter *s)
{
    uint32_t exponential[QS_EXP_STEPS];
    uint64_t edges = 0, sum = measure_contrast(s, &edges);
    qs_exp_table(exponential);
    for (uint64_t i = 0; i < pixels_of(&s->segment); i++) {
        s->right[i] = weight_of(&s->segment, exponential, (uint32_t)s->right[i], edges, sum);
        s->down[i] = weight_of(&s->segment, exponential, (uint32_t)s->down[i], edges, sum);
    }
}

/* ---- costs ---- */

static uint32_t bin_of(const qs_segment *segment, const uint8_t *pixel)
{
    uint32_t bin = 0;
    for (unsigned c = 0; c < segment->channels; c++) {
        bin = bin << LEVEL_BITS | pixel[c] >> (8 - LEVEL_BITS);
    }
    return bin;
}

/* -ln((PIXEL count + 1) / (PIXEL total + bins)) in units of 1 / scale. */
static uint32_t surprise(const segmenter *s, uint32_t count, uint32_t total)
{
    uint64_t bits = qs_log2((uint64_t)PIXEL * total + s->bins) -
                    qs_log2((uint64_t)PIXEL * count + 1); /* at most 36 * 2^16 */
    uint64_t nats = bits * QS_LN_2 >> 16; /* in units of 2^-32 */
    return (uint32_t)((nats * s->segment.scale + (UINT64_C(1) << 31)) >> 32);
}

static void fill_costs(segmenter *s)
{
    uint32_t classes = s->segment.classes;
    for (uint32_t bin = 0; bin < s->bins; bin++) {
        uint32_t *costs = s->costs + (size_t)bin * classes, least = UINT32_MAX;
        for (uint32_t c = 0; c < classes; c++) {
            costs[c] = surprise(s, s->counts[(size_t)c * s->bins + bin], s->totals[c]);
            least = qs_min_u32(least, costs[c]);
        }
        for (uint32_t c = 0; c < classes; c++) {
            costs[c] -= least;
        }
        s->least[bin] = (int32_t)least;
    }
}

static void count_pixel(segmenter *s, uint32_t class, uint32_t bin)
{
    s->counts[(size_t)class * s->bins + bin]++;
    s->totals[class]++;
}

/* Counts the pixels with a stroke. Then the pixels without one make the histogram of the classes
 * that have none. */
static void count_strokes(segmenter *s)
{
    const qs_segment *segment = &s->segment;
    uint32_t classes = segment->classes;
    bool marked[QS_CLASSES_MAX] = {false};
    for (uint64_t i = 0; i < pixels_of(segment); i++) {
        if (segment->strokes[i] > 0) {
            marked[segment->strokes[i] - 1] = true;
        }
    }
    const uint8_t *stroke = segment->strokes;
    for (uint32_t y = 0; y < segment->height; y++) {
        for (uint32_t x = 0; x < segment->width; x++, stroke++) {
            uint32_t bin = bin_of(segment, pixel_at(segment, x, y));
            if (*stroke > 0) {
                count_pixel(s, *stroke - 1u, bin);
            }
            for (uint32_t c = 0; *stroke == 0 && c < classes; c++) {
                if (!marked[c]) {
                    count_pixel(s, c, bin);
                }
            }
        }
    }
}

static void segment_row(void *context, uint32_t row, void *costs, int32_t *least)
{
    const segmenter *s = context;
    const qs_segment *segment = &s->segment;
    size_t bytes = segment->classes * sizeof *s->costs;
    for (uint32_t x = 0; x < segment->width; x++) {
        uint32_t bin = bin_of(segment, pixel_at(segment, x, row));
        memcpy((uint8_t *)costs + x * bytes, s->costs + (size_t)bin * segment->classes, bytes);
        least[x] = s->least[bin];
    }
}

/* ---- the problem ---- */

static bool strokes_exist(const qs_segment *segment)
{
    for (uint64_t i = 0; segment->strokes && i < pixels_of(segment); i++) {
        if (segment->strokes[i] > segment->classes) {
            return false;
        }
    }
    return true;
}

static void allow(segmenter *s)
{
    uint32_t classes = s->segment.classes;
    const uint8_t *strokes = s->segment.strokes;
    memset(s->allowed, 1, (size_t)pixels_of(&s->segment) * classes);
    for (uint64_t i = 0; i < pixels_of(&s->segment); i++) {
        if (strokes[i] > 0) {
            memset(s->allowed + i * classes, 0, classes);
            s->allowed[i * classes + strokes[i] - 1] = 1;
        }
    }
}

static qs_problem problem_of(segmenter *s)
{
    const qs_segment *segment = &s->segment;
    qs_problem made = {
        .labels = segment->classes,
        .scale = segment->scale,
        .grid = {segment->width, segment->height, NULL, s->right, s->down},
        .costs = segment->costs,
        .allowed = segment->strokes ? s->allowed : NULL,
        .frame = {.picture_width = segment->width, .picture_height = segment->height, .first = 1},
        .meaning = {.kind = QS_MEANS_CLASS},
    };
    if (!segment->costs) {
        made.source = (qs_cost_source){segment_row, s, sizeof *s->costs, 0, 0, NULL};
    }
    return made;
}

qs_status qs_segment_problem(const qs_segment *segment, void *workspace, size_t workspace_size,
                             qs_problem *problem)
{
    qs_arena arena = {.base = workspace};
    segmenter s;
    if (!is_segment(segment) || !workspace || !problem || !strokes_exist(segment)) {
        return QS_E_ARGUMENT;
    }
    if (pixels_of(segment) * segment->classes > QS_VARIABLES_MAX) {
        return QS_E_LIMIT;
    }
    if (workspace_size < qs_segment_workspace(segment)) {
        return QS_E_WORKSPACE;
    }
    segmenter *self = lay_out(&arena, segment, &s);
    *self = s;
    weigh_edges(self);
    if (segment->strokes) {
        allow(self);
    }
    if (!segment->costs) {
        memset(self->counts, 0, (size_t)segment->classes * self->bins * sizeof *self->counts);
        memset(self->totals, 0, segment->classes * sizeof *self->totals);
        count_strokes(self);
        fill_costs(self);
    }
    qs_problem made = problem_of(self);
    qs_status status = qs_problem_check(&made);
    if (status == QS_OK) {
        *problem = made;
    }
    return status;
}

/* ---- refitting ---- */

/* Empties the histograms of the classes that have pixels. */
static qs_status empty_histograms(segmenter *s, const uint16_t *labelling)
{
    bool present[QS_CLASSES_MAX] = {false};
    for (uint64_t i = 0; i < pixels_of(&s->segment); i++) {
        if (labelling[i] >= s->segment.classes) {
            return QS_E_ARGUMENT;
        }
        present[labelling[i]] = true;
    }
    for (uint32_t c = 0; c < s->segment.classes; c++) {
        if (present[c]) {
            memset(s->counts + (size_t)c * s->bins, 0, s->bins * sizeof *s->counts);
            s->totals[c] = 0;
        }
    }
    return QS_OK;
}

qs_status qs_segment_refit(void *workspace, const uint16_t *labelling)
{
    segmenter *s = workspace;
    if (!s || !labelling) {
        return QS_E_ARGUMENT;
    }
    if (s->segment.costs) {
        return QS_OK;
    }
    qs_status status = empty_histograms(s, labelling);
    if (status != QS_OK) {
        return status;
    }
    const uint16_t *label = labelling;
    for (uint32_t y = 0; y < s->segment.height; y++) {
        for (uint32_t x = 0; x < s->segment.width; x++, label++) {
            count_pixel(s, *label, bin_of(&s->segment, pixel_at(&s->segment, x, y)));
        }
    }
    fill_costs(s);
    return QS_OK;
}
