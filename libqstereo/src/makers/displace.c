#include "../../include/qstereo/displace.h"

#include <stdbool.h>
#include <string.h>

#include "../base/arena.h"
#include "../base/minmax.h"

enum { STEP_MAX = 65535, WINDOW_MAX = 255, UNIT_MAX = 16, RADIUS_MAX = 1 << 16 };

/* The costs of a row of sites are box sums of absolute differences. First the differences of a
 * column of the box are summed up, for every pixel of the row and every dx of one dy; then `window`
 * neighbouring sums give the cost of a site. */
typedef struct displacer {
    qs_displace displace;
    uint32_t width, height; /* of the grid */
    uint32_t columns, rows; /* of the labels */
    uint32_t span; /* pixels of a row that boxes cover, from -window / 2 on */
    uint32_t margin; /* pixels that a displacement can reach beyond these */
    int32_t *table; /* V */
    int32_t *line; /* span: a row of the first picture, times unit^2 */
    int32_t *moved; /* span + 2 margin: a row of the second one, times unit */
    uint32_t *sums; /* columns x span */
} displacer;

static uint32_t cells_along(size_t pixels, uint32_t step)
{
    return (uint32_t)((pixels - 1 + step - 1) / step) + 1;
}

static void measure(const qs_displace *displace, displacer *d)
{
    d->displace = *displace;
    d->width = cells_along(displace->first.width, displace->step);
    d->height = cells_along(displace->first.height, displace->step);
    d->columns = 2 * displace->radius_x + 1;
    d->rows = 2 * displace->radius_y + 1;
    d->span = (d->width - 1) * displace->step + displace->window;
    d->margin = displace->radius_x / displace->unit + 2;
}

/* The parts of the workspace: returns its first one. */
static displacer *lay_out(qs_arena *arena, displacer *d)
{
    uint64_t labels = (uint64_t)d->columns * d->rows;
    displacer *self = qs_arena_take(arena, 1, sizeof *self);
    d->table = qs_arena_take(arena, labels * labels, sizeof *d->table);
    d->line = qs_arena_take(arena, d->span, sizeof *d->line);
    d->moved = qs_arena_take(arena, (uint64_t)d->span + 2 * (uint64_t)d->margin, sizeof *d->moved);
    d->sums = qs_arena_take(arena, (uint64_t)d->columns * d->span, sizeof *d->sums);
    return self;
}

static bool is_displace(const qs_displace *displace)
{
    return displace && qs_image_is_valid(&displace->first) &&
           qs_image_is_valid(&displace->second) && displace->step >= 1 &&
           displace->step <= STEP_MAX && displace->window % 2 == 1 &&
           displace->window <= WINDOW_MAX && displace->radius_x <= RADIUS_MAX &&
           displace->radius_y <= RADIUS_MAX && displace->unit >= 1 && displace->unit <= UNIT_MAX &&
           displace->scale >= 1;
}

/* Integer units in one grey level: the scale of the problem. 0 = it does not fit. */
static uint32_t scale_of(const qs_displace *displace)
{
    uint64_t scale = (uint64_t)displace->window * displace->window * displace->unit *
                     displace->unit * displace->scale;
    return scale <= UINT32_MAX ? (uint32_t)scale : 0;
}

static bool has_room_for_labels(const qs_displace *displace)
{
    return (2 * (uint64_t)displace->radius_x + 1) * (2 * (uint64_t)displace->radius_y + 1) <=
           QS_LABELS_MAX;
}

size_t qs_displace_workspace(const qs_displace *displace)
{
    qs_arena arena = {0};
    displacer d;
    if (!is_displace(displace) || !has_room_for_labels(displace)) {
        return SIZE_MAX;
    }
    measure(displace, &d);
    (void)lay_out(&arena, &d);
    return qs_arena_size(&arena);
}

/* ---- costs ---- */

static int32_t within(int64_t place, size_t count)
{
    return (int32_t)qs_max_i64(0, qs_min_i64(place, (int64_t)count - 1));
}

static void read_line(const displacer *d, int64_t y)
{
    const qs_image *first = &d->displace.first;
    const uint8_t *row = first->pixels + (size_t)within(y, first->height) * first->stride;
    int32_t unit = (int32_t)d->displace.unit;
    int64_t from = -(int64_t)(d->displace.window / 2);
    for (uint32_t i = 0; i < d->span; i++) {
        d->line[i] = row[within(from + i, first->width)] * unit * unit;
    }
}

/* Floor division by the unit: the pixel, and how far beyond it in parts. */
static int64_t pixel_of(int64_t place, uint32_t unit, int32_t *part)
{
    int64_t pixel = place >= 0 ? place / unit : -((-place + unit - 1) / unit);
    *part = (int32_t)(place - pixel * unit);
    return pixel;
}

/* A row of the second picture between two of its rows; y in parts of a pixel. */
static void read_moved(const displacer *d, int64_t y)
{
    const qs_image *second = &d->displace.second;
    int32_t unit = (int32_t)d->displace.unit, part;
    int64_t at = pixel_of(y, d->displace.unit, &part);
    const uint8_t *upper = second->pixels + (size_t)within(at, second->height) * second->stride,
                  *lower = second->pixels + (size_t)within(at + 1, second->height) * second->stride;
    int64_t from = -(int64_t)(d->displace.window / 2) - d->margin;
    for (uint32_t i = 0; i < d->span + 2 * d->margin; i++) {
        int32_t x = within(from + i, second->width);
        d->moved[i] = upper[x] * (unit - part) + lower[x] * part;
    }
}

/* Adds |first - second| of a row that is displaced by dx parts of a pixel. */
static void add_differences(const displacer *d, int32_t dx, uint32_t *restrict sums)
{
    int32_t unit = (int32_t)d->displace.unit, part;
    int64_t at = (int64_t)d->margin + pixel_of(dx, d->displace.unit, &part);
    const int32_t *restrict line = d->line, *restrict moved = d->moved + at;
    for (uint32_t i = 0; i < d->span; i++) {
        int32_t apart = line[i] - moved[i] * (unit - part) - moved[i + 1] * part;
        sums[i] += (uint32_t)(apart < 0 ? -apart : apart);
    }
}

/* The sums of all columns of the boxes around row y of the first picture, for the displacements of
 * one row of labels. */
static void sum_columns(const displacer *d, int64_t y, int32_t dy)
{
    int32_t half = (int32_t)(d->displace.window / 2);
    memset(d->sums, 0, (size_t)d->columns * d->span * sizeof *d->sums);
    for (int32_t j = -half; j <= half; j++) {
        read_line(d, y + j);
        read_moved(d, (y + j) * d->displace.unit + dy);
        for (uint32_t i = 0; i < d->columns; i++) {
            add_differences(d, (int32_t)i - (int32_t)d->displace.radius_x,
                            d->sums + (size_t)i * d->span);
        }
    }
}

/* The costs of one label at all sites of a row, `labels` apart. */
static void sum_boxes(const displacer *d, const uint32_t *sums, uint32_t *costs, size_t labels)
{
    const qs_displace *asked = &d->displace;
    for (uint32_t x = 0; x < d->width; x++) {
        uint32_t sum = 0;
        for (uint32_t i = 0; i < asked->window; i++) {
            sum += sums[(size_t)x * asked->step + i];
        }
        costs[x * labels] = sum * asked->scale;
    }
}

static void subtract_least(uint32_t *costs, uint32_t labels, int32_t *least)
{
    uint32_t lowest = costs[0];
    for (uint32_t i = 1; i < labels; i++) {
        lowest = qs_min_u32(lowest, costs[i]);
    }
    for (uint32_t i = 0; i < labels; i++) {
        costs[i] -= lowest;
    }
    *least = (int32_t)lowest;
}

static void displace_row(void *context, uint32_t row, void *costs, int32_t *least)
{
    const displacer *d = context;
    uint32_t labels = d->columns * d->rows, *to = costs;
    for (uint32_t k = 0; k < d->rows; k++) {
        sum_columns(d, (int64_t)row * d->displace.step, (int32_t)k - (int32_t)d->displace.radius_y);
        for (uint32_t i = 0; i < d->columns; i++) {
            sum_boxes(d, d->sums + (size_t)i * d->span, to + (size_t)k * d->columns + i, labels);
        }
    }
    for (uint32_t x = 0; x < d->width; x++) {
        subtract_least(to + (size_t)x * labels, labels, &least[x]);
    }
}

/* ---- the problem ---- */

static uint32_t apart(uint32_t a, uint32_t b)
{
    return a > b ? a - b : b - a;
}

static void fill_table(const displacer *d)
{
    uint32_t labels = d->columns * d->rows, most = d->displace.truncation;
    for (uint32_t a = 0; a < labels; a++) {
        for (uint32_t b = 0; b < labels; b++) {
            uint32_t v =
                apart(a % d->columns, b % d->columns) + apart(a / d->columns, b / d->columns);
            d->table[(size_t)a * labels + b] = (int32_t)(most > 0 ? qs_min_u32(v, most) : v);
        }
    }
}

/* The weight of an edge: lambda * scale costs one pixel, so a part of it costs 1 / unit of that. */
static bool find_weight(const qs_displace *displace, int32_t *weight)
{
    int64_t product =
        (int64_t)displace->weight * displace->window * displace->window * displace->unit;
    *weight = (int32_t)product;
    return product <= INT32_MAX;
}

static bool costs_fit(const qs_displace *displace)
{
    uint32_t scale = scale_of(displace);
    return scale != 0 && scale <= INT32_MAX / UINT8_MAX;
}

static qs_status check(const qs_displace *displace, const qs_problem *problem)
{
    if (!is_displace(displace) || !problem || displace->weight < 0) {
        return QS_E_ARGUMENT;
    }
    if (!has_room_for_labels(displace)) {
        return QS_E_LIMIT;
    }
    if (displace->first.width != displace->second.width ||
        displace->first.height != displace->second.height) {
        return QS_E_GEOMETRY;
    }
    return costs_fit(displace) ? QS_OK : QS_E_OVERFLOW;
}

static qs_meaning meaning_of(const displacer *d)
{
    return (qs_meaning){QS_MEANS_DISPLACEMENT,
                        d->displace.step,
                        d->columns,
                        d->displace.unit,
                        -(int32_t)d->displace.radius_x,
                        -(int32_t)d->displace.radius_y};
}

qs_status qs_displace_problem(const qs_displace *displace, void *workspace, size_t workspace_size,
                              qs_problem *problem)
{
    displacer d;
    int32_t weight;
    qs_status status = check(displace, problem);
    if (status != QS_OK) {
        return status;
    }
    if (!workspace) {
        return QS_E_ARGUMENT;
    }
    if (workspace_size < qs_displace_workspace(displace)) {
        return QS_E_WORKSPACE;
    }
    if (!find_weight(displace, &weight)) {
        return QS_E_OVERFLOW;
    }
    measure(displace, &d);
    qs_arena arena = {.base = workspace};
    displacer *self = lay_out(&arena, &d);
    *self = d;
    fill_table(self);
    qs_problem made = {
        .labels = d.columns * d.rows,
        .scale = scale_of(displace),
        .weight = weight,
        .pairwise = {QS_TABLE, 0, self->table},
        .grid = {.width = d.width, .height = d.height},
        .source = {displace_row, self, sizeof(uint32_t)},
        .frame = {.picture_width = (uint32_t)displace->first.width,
                  .picture_height = (uint32_t)displace->first.height},
        .meaning = meaning_of(self),
    };
    status = qs_problem_check(&made);
    if (status == QS_OK) {
        *problem = made;
    }
    return status;
}

/* ---- the field ---- */

/* A coordinate of the displacement of a label, in parts of a pixel. */
static int64_t part_of(const qs_meaning *meaning, uint32_t label, bool is_y)
{
    return is_y ? (int64_t)meaning->y + label / meaning->columns
                : (int64_t)meaning->x + label % meaning->columns;
}

/* Four cells around a pixel, and its place between them. */
typedef struct corners {
    uint16_t label[4];
    int64_t weight[4]; /* their sum is step^2 */
} corners;

static corners corners_of(const uint16_t *labelling, uint32_t width, uint32_t height, uint32_t step,
                          uint32_t x, uint32_t y)
{
    uint32_t i = x / step, k = y / step;
    int64_t right = x % step, down = y % step, left = step - right, up = step - down;
    size_t next = i + 1 < width ? i + 1 : i;
    const uint16_t *row = labelling + (size_t)k * width,
                   *below = k + 1 < height ? row + width : row;
    return (corners){{row[i], row[next], below[i], below[next]},
                     {left * up, right * up, left * down, right * down}};
}

static int32_t between(const qs_meaning *meaning, const corners *around, bool is_y)
{
    int64_t sum = 0;
    for (int i = 0; i < 4; i++) {
        sum += around->weight[i] * part_of(meaning, around->label[i], is_y);
    }
    return (int32_t)sum;
}

static int64_t magnitude(int64_t value)
{
    return value < 0 ? -value : value;
}

/* No displacement, times step^2, is beyond 32 bits. */
static bool field_fits(const qs_meaning *meaning)
{
    int64_t square = (int64_t)meaning->step * meaning->step;
    int64_t x =
        qs_max_i64(magnitude(meaning->x), magnitude((int64_t)meaning->x + meaning->columns));
    int64_t y = qs_max_i64(magnitude(meaning->y),
                           magnitude((int64_t)meaning->y + QS_LABELS_MAX / meaning->columns));
    return qs_max_i64(x, y) <= INT32_MAX / square;
}

qs_status qs_displace_field(const qs_meaning *meaning, uint32_t width, uint32_t height,
                            const uint16_t *labelling, uint32_t picture_width,
                            uint32_t picture_height, int32_t *field)
{
    if (!meaning || !labelling || !field || !qs_meaning_is_valid(meaning) ||
        meaning->kind != QS_MEANS_DISPLACEMENT || picture_width == 0 || picture_height == 0 ||
        width != cells_along(picture_width, meaning->step) ||
        height != cells_along(picture_height, meaning->step)) {
        return QS_E_ARGUMENT;
    }
    if (!field_fits(meaning)) {
        return QS_E_OVERFLOW;
    }
    for (uint32_t y = 0; y < picture_height; y++) {
        for (uint32_t x = 0; x < picture_width; x++, field += 2) {
            corners around = corners_of(labelling, width, height, meaning->step, x, y);
            field[0] = between(meaning, &around, false);
            field[1] = between(meaning, &around, true);
        }
    }
    return QS_OK;
}
