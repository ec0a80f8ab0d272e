#include "blocks.h"

#include "../base/bytes.h"
#include "../base/minmax.h"
#include "../files/qcf_layout.h"

/* Where the fields of a block stand. */
enum { KIND_AT = 8, FILL_AT = 12, FIRST_AT = 16, COUNT_AT = 20 };

bool qs_block_is_table(const uint8_t *p)
{
    return qs_load_u32(p + KIND_AT) == QS_BLOCK_IS_TABLE;
}

uint32_t qs_block_rows(const uint8_t *p)
{
    return qs_load_u32(p);
}

uint32_t qs_block_columns(const uint8_t *p)
{
    return qs_load_u32(p + 4);
}

static bool toeplitz_fits(const uint8_t *p)
{
    int64_t first = qs_load_i32(p + FIRST_AT), count = qs_load_u32(p + COUNT_AT);
    if (count == 0) {
        return first == 0;
    }
    return first > -(int64_t)qs_block_rows(p) && first + count <= (int64_t)qs_block_columns(p);
}

uint64_t qs_block_size(const uint8_t *p, uint64_t left)
{
    if (left < QS_TABLE_HEAD || qs_block_rows(p) == 0 || qs_block_columns(p) == 0) {
        return 0;
    }
    uint64_t size = 0;
    if (qs_block_is_table(p)) {
        uint64_t cells = (uint64_t)qs_block_rows(p) * qs_block_columns(p);
        size = cells <= left / 4 ? QS_TABLE_HEAD + 4 * cells : 0;
    } else if (qs_load_u32(p + KIND_AT) == QS_BLOCK_IS_TOEPLITZ && left >= QS_TOEPLITZ_HEAD &&
               toeplitz_fits(p)) {
        size = QS_TOEPLITZ_HEAD + 4 * (uint64_t)qs_load_u32(p + COUNT_AT);
    }
    return size <= left ? size : 0;
}

/* t of all entries with column - row = apart. */
static int32_t toeplitz_value(const uint8_t *p, int64_t apart)
{
    int64_t at = apart - qs_load_i32(p + FIRST_AT);
    bool listed = at >= 0 && at < (int64_t)qs_load_u32(p + COUNT_AT);
    return qs_load_i32(listed ? p + QS_TOEPLITZ_HEAD + 4 * at : p + FILL_AT);
}

int32_t qs_block_entry(const uint8_t *p, uint32_t row, uint32_t column)
{
    if (qs_block_is_table(p)) {
        return qs_load_i32(p + QS_TABLE_HEAD + 4 * ((uint64_t)row * qs_block_columns(p) + column));
    }
    return toeplitz_value(p, (int64_t)column - row);
}

static void count_entries(qs_block_facts *facts, uint64_t cells, int64_t value)
{
    const uint64_t most = (uint64_t)1 << 63;
    uint64_t size = value < 0 ? (uint64_t)-value : (uint64_t)value;
    if (cells == 0 || value == 0) {
        return;
    }
    bool first = facts->terms == 0;
    facts->min = first ? value : qs_min_i64(facts->min, value);
    facts->max = first ? value : qs_max_i64(facts->max, value);
    facts->terms += cells;
    facts->absolute =
        cells > (most - facts->absolute) / size ? most : facts->absolute + cells * size;
}

/* Number of cells with column - row = apart. */
static uint64_t diagonal(const uint8_t *p, int64_t apart)
{
    int64_t rows = qs_block_rows(p), columns = qs_block_columns(p);
    int64_t from = qs_max_i64(-apart, 0), to = qs_min_i64(columns - apart, rows);
    return (uint64_t)qs_max_i64(to - from, 0);
}

/* Cells above the diagonal. */
static uint64_t triangle(const uint8_t *p)
{
    uint64_t rows = qs_block_rows(p), columns = qs_block_columns(p);
    uint64_t both = qs_min_u64(rows, columns);
    return both * columns - both * (both + 1) / 2;
}

static qs_block_facts summary(const uint8_t *p, bool upper)
{
    qs_block_facts facts = {0};
    uint32_t rows = qs_block_rows(p), columns = qs_block_columns(p);
    if (qs_block_is_table(p)) {
        for (uint32_t r = 0; r < rows; r++) {
            for (uint32_t c = upper ? r + 1 : 0; c < columns; c++) {
                count_entries(&facts, 1, qs_block_entry(p, r, c));
            }
        }
        return facts;
    }
    uint64_t filled = upper ? triangle(p) : (uint64_t)rows * columns;
    int64_t first = qs_load_i32(p + FIRST_AT);
    for (uint32_t i = 0; i < qs_load_u32(p + COUNT_AT); i++) {
        uint64_t cells = upper && first + i <= 0 ? 0 : diagonal(p, first + i);
        count_entries(&facts, cells, qs_load_i32(p + QS_TOEPLITZ_HEAD + 4 * (uint64_t)i));
        filled -= cells;
    }
    count_entries(&facts, filled, qs_load_i32(p + FILL_AT));
    return facts;
}

qs_block_facts qs_block_summary(const uint8_t *p)
{
    return summary(p, false);
}

qs_block_facts qs_block_upper(const uint8_t *p)
{
    return summary(p, true);
}

/* From one row to the next the window of diagonals moves by one, so each sum follows from the one
 * before it. The same holds for columns. */
static void toeplitz_sums(const uint8_t *p, int64_t *rows, int64_t *columns)
{
    int64_t height = qs_block_rows(p), width = qs_block_columns(p);
    rows[0] = columns[0] = 0;
    for (int64_t c = 0; c < width; c++) {
        rows[0] += toeplitz_value(p, c);
    }
    for (int64_t r = 1; r < height; r++) {
        rows[r] = rows[r - 1] + toeplitz_value(p, -r) - toeplitz_value(p, width - r);
    }
    for (int64_t r = 0; r < height; r++) {
        columns[0] += toeplitz_value(p, -r);
    }
    for (int64_t c = 1; c < width; c++) {
        columns[c] = columns[c - 1] + toeplitz_value(p, c) - toeplitz_value(p, c - height);
    }
}

void qs_block_sums(const uint8_t *p, int64_t *rows, int64_t *columns)
{
    if (!qs_block_is_table(p)) {
        toeplitz_sums(p, rows, columns);
        return;
    }
    for (uint32_t c = 0; c < qs_block_columns(p); c++) {
        columns[c] = 0;
    }
    for (uint32_t r = 0; r < qs_block_rows(p); r++) {
        rows[r] = 0;
        for (uint32_t c = 0; c < qs_block_columns(p); c++) {
            rows[r] += qs_block_entry(p, r, c);
            columns[c] += qs_block_entry(p, r, c);
        }
    }
}

void qs_block_own_sums(const uint8_t *p, int64_t *sums)
{
    uint32_t size = qs_block_rows(p);
    for (uint32_t i = 0; i < size; i++) {
        sums[i] = 0;
    }
    if (!qs_block_is_table(p)) {
        /* Row i has the diagonals 1 to size - 1 - i, column i those from 1 to i. */
        int64_t sum = 0;
        for (uint32_t i = 0; i < size; i++) {
            sum += i > 0 ? toeplitz_value(p, i) : 0;
            sums[i] += sum;
            sums[size - 1 - i] += sum;
        }
        return;
    }
    for (uint32_t r = 0; r < size; r++) {
        for (uint32_t c = r + 1; c < size; c++) {
            sums[r] += qs_block_entry(p, r, c);
            sums[c] += qs_block_entry(p, r, c);
        }
    }
}
