#include "model_check.h"

#include <string.h>

#include "../qubo/blocks.h"

/* Returns true if the labels left to a group's site follow one another without a gap. */
static bool is_range(const qs_building *b, uint32_t group)
{
    uint32_t first = qs_next_label(b, group, 0), size = qs_labels_left(b, group);
    for (uint32_t d = first; d < first + size; d++) {
        if (qs_next_label(b, group, d) != d) {
            return false;
        }
    }
    return true;
}

/* What the block's entry for the labels d and e must be. For walls it depends on the labels left
 * before them, too. */
static int64_t expected_entry(const qs_building *b, uint32_t before_d, uint32_t d,
                              uint32_t before_e, uint32_t e)
{
    switch (b->labels->encoding) {
    case QS_DOMAIN_WALL:
        return qs_value(b, d, e) - qs_value(b, before_d, e) - qs_value(b, d, before_e) +
               qs_value(b, before_d, before_e);
    case QS_ONE_HOT_SPARSE: return qs_value(b, d, e) - b->tau;
    default: return qs_value(b, d, e);
    }
}

/* Notes an entry of a table. Returns false if it is below 0, or has been noted with another
 * value. */
static bool note_entry(const qs_building *b, uint32_t d, uint32_t e, int32_t entry)
{
    int32_t *noted = &b->table[(size_t)d * b->labels->labels + e];
    bool fits = entry >= 0 && (*noted < 0 || *noted == entry);
    *noted = fits ? entry : *noted;
    return fits;
}

/* Returns true if the entries of the first rows and columns are what they must be. In walls row 0
 * and column 0 belong to the second label left. */
static bool rows_agree(const qs_building *b, uint32_t group, const qs_neighbour *near,
                       uint32_t rows, uint32_t columns)
{
    uint32_t before_d = qs_next_label(b, group, 0),
             d = qs_has_walls(b) ? qs_next_label(b, group, before_d + 1) : before_d;
    for (uint32_t i = 0; i < rows; i++) {
        uint32_t before_e = qs_next_label(b, near->group, 0),
                 e = qs_has_walls(b) ? qs_next_label(b, near->group, before_e + 1) : before_e;
        for (uint32_t j = 0; j < columns; j++) {
            int32_t entry = qs_index_block(b->index, near->block, i, j);
            bool table = b->labels->pairwise.smoothness == QS_TABLE;
            if (table ? !note_entry(b, d, e, entry)
                      : entry != expected_entry(b, before_d, d, before_e, e)) {
                return false;
            }
            before_e = e;
            e = qs_next_label(b, near->group, e + 1);
        }
        before_d = d;
        d = qs_next_label(b, group, d + 1);
    }
    return true;
}

/* A coupling with a later group. If the labels of both sites have no gaps, the cost depends on the
 * difference of the labels alone; then the first row and column of a Toeplitz block say all. */
static bool block_agrees(const qs_building *b, uint32_t group, const qs_neighbour *near)
{
    const qs_index *index = b->index;
    uint32_t rows = index->start[group + 1] - index->start[group],
             columns = index->start[near->group + 1] - index->start[near->group];
    bool toeplitz = !qs_block_is_table(index->qubo->blocks + index->block_at[near->block]) &&
                    b->labels->pairwise.smoothness != QS_TABLE;
    if (toeplitz && is_range(b, group) && is_range(b, near->group)) {
        return rows_agree(b, group, near, 1, columns) && rows_agree(b, group, near, rows, 1);
    }
    return rows_agree(b, group, near, rows, columns);
}

/* The chain of a wall: below 0 for each pair of neighbours, else 0. Of a Toeplitz block the first
 * row says all above the diagonal. */
static bool chain_agrees(const qs_building *b, uint32_t group, const qs_neighbour *near)
{
    uint32_t variables = b->index->start[group + 1] - b->index->start[group];
    bool table = qs_block_is_table(b->index->qubo->blocks + b->index->block_at[near->block]);
    uint32_t rows = table ? variables : 1;
    for (uint32_t i = 0; i < rows; i++) {
        for (uint32_t j = i + 1; j < variables; j++) {
            int64_t entry = (int64_t)qs_index_block(b->index, near->block, i, j) * near->weight;
            if (j == i + 1 ? entry >= 0 : entry != 0) {
                return false;
            }
        }
    }
    return qs_has_walls(b);
}

/* Returns true if the same labels are left to the sites of two groups. */
static bool same_labels(const qs_building *b, uint32_t g, uint32_t h)
{
    size_t labels = b->labels->labels;
    return !b->model.kept ||
           memcmp(b->kept + b->site_of[g] * labels, b->kept + b->site_of[h] * labels, labels) == 0;
}

/* The last two groups whose block has been compared. Most pairs are like the pair before. */
typedef struct compared {
    uint32_t group;
    const qs_neighbour *near; /* NULL = none yet */
} compared;

static bool is_like(const qs_building *b, uint32_t group, const qs_neighbour *near,
                    const compared *last)
{
    return last->near && last->near->block == near->block && same_labels(b, group, last->group) &&
           same_labels(b, near->group, last->near->group);
}

static bool coupling_agrees(const qs_building *b, uint32_t group, const qs_neighbour *near,
                            compared *last)
{
    if (near->group == group) {
        return chain_agrees(b, group, near);
    }
    if (near->weight < 0) {
        return false;
    }
    /* A transposed one is compared at its other group. */
    if ((near->block & QS_TRANSPOSED) != 0 || is_like(b, group, near, last)) {
        return true;
    }
    *last = (compared){group, near};
    if (b->labels->pairwise.smoothness == QS_TABLES) {
        return true; /* what is no table of costs is refused when it is copied */
    }
    return block_agrees(b, group, near);
}

bool qs_couplings_agree(const qs_building *b)
{
    const qs_index *index = b->index;
    compared last = {0};
    for (uint32_t g = 0; g < index->qubo->groups; g++) {
        bool chained = !qs_has_walls(b) || qs_labels_left(b, g) < 3; /* a chain, if one is needed */
        for (uint32_t n = index->near_start[g]; n < index->near_start[g + 1]; n++) {
            const qs_neighbour *near = &index->near[n];
            if (!coupling_agrees(b, g, near, &last)) {
                return false;
            }
            chained |= near->group == g;
        }
        if (!chained) {
            return false;
        }
    }
    return true;
}

static bool copy_plain_table(const qs_building *b, uint32_t block, uint32_t first, uint32_t second,
                             int32_t *table)
{
    uint32_t labels = b->labels->labels, row = 0;
    bool fits = true;
    memset(table, 0, sizeof *table * labels * labels);
    for (uint32_t d = qs_next_label_of(b, first, 0); d < labels; row++) {
        uint32_t column = 0;
        for (uint32_t e = qs_next_label_of(b, second, 0); e < labels; column++) {
            int32_t entry = qs_index_block(b->index, block, row, column);
            table[(size_t)d * labels + e] = entry;
            fits &= entry >= 0;
            e = qs_next_label_of(b, second, e + 1);
        }
        d = qs_next_label_of(b, first, d + 1);
    }
    return fits;
}

/* Subtracts from each row of the labels left its least entry. */
static void lift_rows(const qs_building *b, uint32_t first, uint32_t second, int32_t *table)
{
    uint32_t labels = b->labels->labels;
    for (uint32_t d = qs_next_label_of(b, first, 0); d < labels;
         d = qs_next_label_of(b, first, d + 1)) {
        int32_t *row = table + (size_t)d * labels, least = INT32_MAX;
        for (uint32_t e = qs_next_label_of(b, second, 0); e < labels;
             e = qs_next_label_of(b, second, e + 1)) {
            least = row[e] < least ? row[e] : least;
        }
        for (uint32_t e = qs_next_label_of(b, second, 0); e < labels;
             e = qs_next_label_of(b, second, e + 1)) {
            row[e] -= least;
        }
    }
}

static void lift_columns(const qs_building *b, uint32_t first, uint32_t second, int32_t *table)
{
    uint32_t labels = b->labels->labels;
    for (uint32_t e = qs_next_label_of(b, second, 0); e < labels;
         e = qs_next_label_of(b, second, e + 1)) {
        int32_t least = INT32_MAX;
        for (uint32_t d = qs_next_label_of(b, first, 0); d < labels;
             d = qs_next_label_of(b, first, d + 1)) {
            int32_t entry = table[(size_t)d * labels + e];
            least = entry < least ? entry : least;
        }
        for (uint32_t d = qs_next_label_of(b, first, 0); d < labels;
             d = qs_next_label_of(b, first, d + 1)) {
            table[(size_t)d * labels + e] -= least;
        }
    }
}

/* In a domain wall: the table that the block of variables makes, 0 where either label is the first
 * left. A part that depends on one label alone is moved away from it until no entry is below 0: it
 * is a cost of that site, as what the encoding has moved there is. So the result has an entry 0 in
 * each row and each column, and 0 for the first two labels. Returns false if an entry does not
 * fit. */
static bool copy_wall_table(const qs_building *b, uint32_t block, uint32_t first, uint32_t second,
                            int32_t *table)
{
    uint32_t labels = b->labels->labels, row = 0, above = labels;
    bool fits = true;
    memset(table, 0, sizeof *table * labels * labels);
    for (uint32_t d = qs_next_label_of(b, first, 0); d < labels; row++) {
        uint32_t column = 0;
        int64_t sum = 0;
        for (uint32_t e = qs_next_label_of(b, second, 0); e < labels; column++) {
            if (row > 0 && column > 0) {
                sum += qs_index_block(b->index, block, row - 1, column - 1);
                int64_t entry = sum + table[(size_t)above * labels + e];
                fits &= entry >= INT32_MIN / 2 && entry <= INT32_MAX / 2;
                table[(size_t)d * labels + e] = fits ? (int32_t)entry : 0;
            }
            e = qs_next_label_of(b, second, e + 1);
        }
        above = d;
        d = qs_next_label_of(b, first, d + 1);
    }
    lift_rows(b, first, second, table);
    lift_columns(b, first, second, table);
    return fits;
}

bool qs_copy_table(const qs_building *b, uint32_t block, uint32_t first, uint32_t second,
                   int32_t *table)
{
    return qs_has_walls(b) ? copy_wall_table(b, block, first, second, table)
                           : copy_plain_table(b, block, first, second, table);
}

/* A whole problem without couplings has its table all the same: it is block 0, which no coupling
 * has led to. Returns false if that is not a table of costs. */
static bool note_lone_table(const qs_building *b)
{
    const qs_index *index = b->index;
    uint32_t labels = b->labels->labels;
    if (b->model.kept || index->qubo->couplings > 0 || index->qubo->block_count == 0) {
        return true;
    }
    const uint8_t *block = index->qubo->blocks + index->block_at[0];
    if (qs_block_rows(block) != labels || qs_block_columns(block) != labels) {
        return false;
    }
    for (uint32_t d = 0; d < labels; d++) {
        for (uint32_t e = 0; e < labels; e++) {
            if (!note_entry(b, d, e, qs_block_entry(block, d, e))) {
                return false;
            }
        }
    }
    return true;
}

bool qs_finish_table(const qs_building *b)
{
    if (!note_lone_table(b)) {
        return false;
    }
    for (size_t i = 0; i < (size_t)b->labels->labels * b->labels->labels; i++) {
        b->table[i] = b->table[i] < 0 ? 0 : b->table[i]; /* of labels that meet nowhere */
    }
    return true;
}
