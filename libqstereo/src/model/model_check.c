#include "model_check.h"

#include <string.h>

#include "../qubo/blocks.h"

/* Whether the labels left to a group's site are neighbours, one after another. */
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

bool qs_encoding_fits(const qs_building *b)
{
    qs_smoothness smoothness = b->labels->pairwise.smoothness;
    return b->labels->encoding == QS_ONE_HOT || smoothness == QS_POTTS ||
           smoothness == QS_TRUNCATED_LINEAR;
}

/* The entry of the labels d and e; of a wall also of the labels left before them. */
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

/* Notes an entry of a table; false where it is below 0 or has been noted otherwise. */
static bool note_entry(const qs_building *b, uint32_t d, uint32_t e, int32_t entry)
{
    int32_t *noted = &b->table[(size_t)d * b->labels->labels + e];
    bool fits = entry >= 0 && (*noted < 0 || *noted == entry);
    *noted = fits ? entry : *noted;
    return fits;
}

/* Whether the entries of some rows are what they must be: of a wall row and column 0 are the second
 * labels left. */
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

/* A coupling with a later group. Where both sites' labels are ranges the cost depends on the
 * difference alone, and of a Toeplitz block the first row and column say all. */
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

/* The chain of a wall: a negative weight on each pair of neighbours. */
static bool chain_agrees(const qs_building *b, uint32_t group, const qs_neighbour *near)
{
    uint32_t variables = b->index->start[group + 1] - b->index->start[group];
    bool table = qs_block_is_table(b->index->qubo->blocks + b->index->block_at[near->block]);
    for (uint32_t i = 0; i < (table ? variables : 1);
         i++) { /* of a Toeplitz block the first row says all above the diagonal */
        for (uint32_t j = i + 1; j < variables; j++) {
            int64_t entry = (int64_t)qs_index_block(b->index, near->block, i, j) * near->weight;
            if (j == i + 1 ? entry >= 0 : entry != 0) {
                return false;
            }
        }
    }
    return qs_has_walls(b);
}

/* The labels of two groups' sites are the same as those of two others. */
static bool same_labels(const qs_building *b, uint32_t g, uint32_t h)
{
    size_t labels = b->labels->labels;
    return !b->model.kept ||
           memcmp(b->kept + b->site_of[g] * labels, b->kept + b->site_of[h] * labels, labels) == 0;
}

/* All blocks beside the pairwise cost; most pairs are like the one before and need no other look.
 */
bool qs_couplings_agree(const qs_building *b)
{
    const qs_index *index = b->index;
    uint32_t last_group = 0;
    const qs_neighbour *last = NULL;
    for (uint32_t g = 0; g < index->qubo->groups; g++) {
        bool chained = !qs_has_walls(b) || qs_labels_left(b, g) < 3;
        for (uint32_t n = index->near_start[g]; n < index->near_start[g + 1]; n++) {
            const qs_neighbour *near = &index->near[n];
            if (near->group == g) {
                chained = true;
                if (!chain_agrees(b, g, near)) {
                    return false;
                }
                continue;
            }
            if (near->weight < 0) {
                return false;
            }
            if ((near->block & QS_TRANSPOSED) != 0 ||
                (last && last->block == near->block && same_labels(b, g, last_group) &&
                 same_labels(b, near->group, last->group))) {
                continue;
            }
            if (!block_agrees(b, g, near)) {
                return false;
            }
            last = near;
            last_group = g;
        }
        if (!chained) {
            return false;
        }
    }
    return true;
}

/* A whole problem without couplings has its table all the same: block 0, which nothing has looked
 * at; false where it is no table of costs. */
static bool note_lone_table(const qs_building *b)
{
    const qs_index *index = b->index;
    uint32_t labels = b->labels->labels;
    if (b->model.kept || index->qubo->couplings > 0 || index->qubo->block_count == 0) {
        return true;
    }
    const uint8_t *block = index->qubo->blocks + index->block_at[0];
    bool fits = qs_block_rows(block) == labels && qs_block_columns(block) == labels;
    for (uint32_t d = 0; d < labels; d++) {
        for (uint32_t e = 0; fits && e < labels; e++) {
            fits = note_entry(b, d, e, qs_block_entry(block, d, e));
        }
    }
    return fits;
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
