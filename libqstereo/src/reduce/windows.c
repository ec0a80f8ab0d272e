#include "windows.h"

#include "../base/minmax.h"
#include "block.h"

/* The cells from `begin` on, of those before `all`; begins and ends outside are cut off. */
static uint32_t cut(int64_t begin, uint32_t side, uint32_t all, uint32_t *length)
{
    int64_t from = qs_max_i64(begin, 0), to = qs_min_i64(begin + side, all);
    *length = (uint32_t)qs_max_i64(to - from, 0);
    return (uint32_t)from;
}

/* Whether a site of the window has two labels or more. */
static bool has_open(const qs_elimination *e, const qs_block *b)
{
    for (uint32_t c = 0; c < b->model.sites; c++) {
        if (qs_eliminate_count(e, qs_block_site(b, &e->model, c)) > 1) {
            return true;
        }
    }
    return false;
}

/* Solves one window. Returns what that gained. */
static int64_t improve(const qs_elimination *e, qs_rectangle at, uint16_t *labelling, void *memory,
                       size_t size, qs_look *look)
{
    qs_block b;
    if (at.width == 0 || at.height == 0 || !qs_block_take(&b, &e->model, at, memory, size) ||
        !has_open(e, &b) || !qs_block_hold(&b, &e->model, labelling)) {
        return 0;
    }
    int64_t before = b.energy;
    qs_block_solve(&b, look);
    for (uint32_t c = 0; c < b.model.sites && b.energy < before; c++) {
        labelling[qs_block_site(&b, &e->model, c)] = b.labelling[c];
    }
    return before - b.energy;
}

int64_t qs_windows_improve(const qs_elimination *e, qs_rectangle first, uint16_t *labelling,
                           void *memory, size_t size, qs_look *look)
{
    int64_t all = 0;
    for (int64_t y = -(int64_t)first.y; y < e->model.height; y += first.height) {
        for (int64_t x = -(int64_t)first.x; x < e->model.width; x += first.width) {
            qs_rectangle at;
            at.x = cut(x, first.width, e->model.width, &at.width);
            at.y = cut(y, first.height, e->model.height, &at.height);
            if (!qs_look_up(look, (uint64_t)at.width * at.height * e->model.labels)) {
                return all;
            }
            all += improve(e, at, labelling, memory, size, look);
        }
    }
    return all;
}
