/* Whether tables of costs are metrics, beside the definition. */
#include "tiny.h"

#include "model/metric.h"

enum { ROUNDS = 3000, LABELS = 6 };

static int32_t table[LABELS * LABELS];
static uint64_t state = 1;

static uint32_t below(uint32_t most)
{
    return tiny_random(&state, most);
}

static bool by_definition(int labels)
{
    for (int a = 0; a < labels; a++) {
        for (int b = 0; b < labels; b++) {
            int32_t ab = table[a * labels + b];
            if (ab < 0 || (a == b) != (ab == 0) || ab != table[b * labels + a]) {
                return false;
            }
            for (int c = 0; c < labels; c++) {
                if (table[a * labels + c] > (int64_t)ab + table[b * labels + c]) {
                    return false;
                }
            }
        }
    }
    return true;
}

/* Distances on a line, up to a bound, of which one pair perhaps is changed by 1. */
static void make_table(int labels, bool changed)
{
    int32_t place[LABELS], bound = (int32_t)below(40) + 1;
    for (int a = 0; a < labels; a++) {
        place[a] = 9 * a + (int32_t)below(9);
    }
    for (int i = 0; i < labels * labels; i++) {
        int32_t apart = place[i / labels] - place[i % labels];
        apart = apart < 0 ? -apart : apart;
        table[i] = apart < bound ? apart : bound;
    }
    int a = (int)below((uint32_t)labels), b = (int)below((uint32_t)labels);
    if (changed && a != b) {
        table[a * labels + b] += 1;
        table[b * labels + a] += below(4) > 0;
    }
}

static void is_what_the_definition_says(void **unused)
{
    unsigned metrics = 0;
    (void)unused;
    for (unsigned round = 0; round < ROUNDS; round++) {
        int labels = 1 + (int)below(LABELS);
        make_table(labels, round % 2 == 1);
        const qs_model model = {.labels = (uint32_t)labels,
                                .pairwise = {.smoothness = QS_TABLE, .table = table}};
        bool metric = qs_is_metric(&model);
        assert_int_equal(metric, by_definition(labels));
        metrics += metric;
    }
    assert_in_range(metrics, ROUNDS / 2, ROUNDS - ROUNDS / 20);
}

/* Entries near the largest number overflow nothing. */
static void takes_the_largest_entries(void **unused)
{
    (void)unused;
    const int32_t entries[] = {0, INT32_MAX, 1, INT32_MAX, 0, INT32_MAX, 1, INT32_MAX, 0};
    qs_model model = {.labels = 3, .pairwise = {.smoothness = QS_TABLE, .table = entries}};
    assert_true(qs_is_metric(&model));
    const int32_t far[] = {0, INT32_MAX, 1, INT32_MAX, 0, 1, 1, 1, 0};
    model.pairwise.table = far;
    assert_false(qs_is_metric(&model));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(is_what_the_definition_says),
        cmocka_unit_test(takes_the_largest_entries),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
