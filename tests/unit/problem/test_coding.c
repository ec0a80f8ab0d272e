/* The table of encodings. */
#include "tiny.h"

#include <string.h>

static const qs_pairwise potts = {QS_POTTS, 0, NULL}, linear = {QS_TRUNCATED_LINEAR, 0, NULL},
                         truncated = {QS_TRUNCATED_LINEAR, 2, NULL},
                         quadratic = {QS_TRUNCATED_QUADRATIC, 0, NULL};

static void test_every_encoding_has_one_row(void **state)
{
    (void)state;
    assert_null(qs_encoding_facts_of(QS_ENCODING_DEFAULT));
    assert_null(qs_encoding_facts_of((qs_encoding)(QS_ENCODINGS + 1)));
    for (int e = 1; e <= QS_ENCODINGS; e++) {
        const qs_encoding_facts *facts = qs_encoding_facts_of((qs_encoding)e);
        assert_non_null(facts);
        assert_int_equal(facts->encoding, e);
        for (int other = 1; other < e; other++) {
            assert_string_not_equal(facts->name, qs_encoding_facts_of((qs_encoding)other)->name);
        }
    }
}

static void test_what_each_encoding_holds(void **state)
{
    (void)state;
    static const struct {
        qs_encoding encoding;
        bool potts, linear, truncated, quadratic, potts_of_two;
    } expected[QS_ENCODINGS] = {
        {QS_ONE_HOT, true, true, true, true, true},
        {QS_ONE_HOT_SPARSE, true, true, true, false, true},
        {QS_DOMAIN_WALL, true, true, true, true, true},
        {QS_MULTIWAY_CUT, true, false, false, false, true},
        {QS_ST_CUT, false, true, false, false, true},
        {QS_ST_CUT_ARCS, false, true, false, false, true},
    };
    for (size_t i = 0; i < QS_ENCODINGS; i++) {
        qs_encoding e = expected[i].encoding;
        assert_int_equal(qs_encoding_holds(e, &potts, 4), expected[i].potts);
        assert_int_equal(qs_encoding_holds(e, &potts, 2), expected[i].potts_of_two);
        assert_int_equal(qs_encoding_holds(e, &linear, 4), expected[i].linear);
        assert_int_equal(qs_encoding_holds(e, &truncated, 4), expected[i].truncated);
        assert_int_equal(qs_encoding_holds(e, &truncated, 3), expected[i].linear);
        assert_int_equal(qs_encoding_holds(e, &quadratic, 4), expected[i].quadratic);
    }
    assert_false(qs_encoding_holds(QS_ENCODING_DEFAULT, &potts, 2));
    assert_int_equal(qs_encoding_default(&potts), QS_ONE_HOT_SPARSE);
    assert_int_equal(qs_encoding_default(&linear), QS_ONE_HOT);
}

static void test_which_penalties_go_with_it(void **state)
{
    (void)state;
    for (int e = 1; e <= QS_ENCODINGS; e++) {
        qs_encoding encoding = (qs_encoding)e;
        bool alpha = encoding <= QS_ONE_HOT_SPARSE || encoding == QS_MULTIWAY_CUT;
        assert_true(qs_encoding_has_penalty(encoding, QS_PENALTY_LOCAL));
        assert_true(qs_encoding_has_penalty(encoding, QS_PENALTY_MINIMAL));
        assert_int_equal(qs_encoding_has_penalty(encoding, QS_PENALTY_PAPER), alpha);
        assert_int_equal(qs_encoding_has_penalty(encoding, QS_PENALTY_GIVEN), alpha);
        assert_false(qs_encoding_has_penalty(encoding, (qs_penalty)4));
    }
    assert_true(qs_encoding_allows_penalty(QS_ONE_HOT_SPARSE, QS_PENALTY_PAPER, &potts));
    assert_false(qs_encoding_allows_penalty(QS_ONE_HOT_SPARSE, QS_PENALTY_PAPER, &linear));
    assert_true(qs_encoding_allows_penalty(QS_ONE_HOT_SPARSE, QS_PENALTY_GIVEN, &linear));
    assert_true(qs_encoding_allows_penalty(QS_ONE_HOT, QS_PENALTY_PAPER, &linear));
}

/* With n labels a site has n variables, but for the walls (a boundary between labels each) and the
 * chains (with one at either end). */
static void test_variables_of_a_site(void **state)
{
    (void)state;
    static const int more[QS_ENCODINGS + 1] = {
        [QS_DOMAIN_WALL] = -1, [QS_ST_CUT] = 1, [QS_ST_CUT_ARCS] = 1};
    for (int e = 1; e <= QS_ENCODINGS; e++) {
        for (int labels = 2; labels < 9; labels++) {
            assert_int_equal(qs_encoding_site_variables((qs_encoding)e, (uint32_t)labels),
                             labels + more[e]);
        }
    }
}

/* What docs/MATHS.md proves of each way of repair. */
static void test_how_samples_are_repaired(void **state)
{
    (void)state;
    static const struct {
        qs_encoding encoding;
        qs_penalty penalty;
        qs_repair potts, linear, truncated; /* truncated: where the encoding holds it */
    } expected[] = {
        {QS_ONE_HOT, QS_PENALTY_MINIMAL, QS_REPAIR_BY_FLIPS, QS_REPAIR_BY_FLIPS,
         QS_REPAIR_BY_FLIPS},
        {QS_ONE_HOT_SPARSE, QS_PENALTY_LOCAL, QS_REPAIR_BY_FLIPS, QS_REPAIR_BY_FLIPS,
         QS_REPAIR_BY_FLIPS},
        {QS_ONE_HOT_SPARSE, QS_PENALTY_MINIMAL, QS_REPAIR_BY_LABEL_ORDER, QS_REPAIR_SITE_BY_SITE,
         QS_REPAIR_SITE_BY_SITE},
        {QS_DOMAIN_WALL, QS_PENALTY_LOCAL, QS_REPAIR_BY_LABEL_ORDER, QS_REPAIR_BY_THRESHOLDS,
         QS_REPAIR_SITE_BY_SITE},
        {QS_ST_CUT, QS_PENALTY_LOCAL, QS_REPAIR_BY_THRESHOLDS, QS_REPAIR_BY_THRESHOLDS, 0},
    };
    for (size_t i = 0; i < sizeof expected / sizeof expected[0]; i++) {
        qs_encoding e = expected[i].encoding;
        qs_penalty p = expected[i].penalty;
        assert_int_equal(qs_encoding_repair(e, p, &potts, 4), expected[i].potts);
        assert_int_equal(qs_encoding_repair(e, p, &linear, 4), expected[i].linear);
        bool holds = qs_encoding_holds(e, &truncated, 4);
        if (holds) {
            assert_int_equal(qs_encoding_repair(e, p, &truncated, 4), expected[i].truncated);
        }
    }
}

/* A whole grid of n x m sites with k labels: the counts of the papers (coding.h, docs/MATHS.md). */
static void test_sizes_are_those_of_the_papers(void **state)
{
    (void)state;
    for (uint64_t n = 1; n <= 5; n++) {
        for (uint64_t m = 1; m <= 5; m++) {
            uint64_t k = n + m, sites = n * m, edges = n * (m - 1) + m * (n - 1);
            const qs_encoding_counts c = {(uint32_t)k, sites, sites * k, edges, edges * (k + 1)};
            assert_int_equal(qs_encoding_measure(QS_ONE_HOT, &c).variables, sites * k);
            assert_int_equal(qs_encoding_measure(QS_DOMAIN_WALL, &c).variables, sites * (k - 1));
            assert_int_equal(qs_encoding_measure(QS_MULTIWAY_CUT, &c).variables, sites * k + k * k);
            assert_int_equal(qs_encoding_measure(QS_ST_CUT, &c).variables, sites * (k + 1) + 2);
            assert_int_equal(qs_encoding_measure(QS_ST_CUT_ARCS, &c).variables,
                             7 * sites * k + 9 * sites - 2 * n * k - 2 * m * k - 2 * n - 2 * m + 2);
        }
    }
    const qs_encoding_counts none = {.labels = 9};
    for (int e = 1; e <= QS_ENCODINGS; e++) {
        assert_int_equal(qs_encoding_measure((qs_encoding)e, &none).variables, 0);
    }
}

static void test_defaults_are_filled_in(void **state)
{
    (void)state;
    qs_encode_options settled, none = {0}, given = {.penalty = QS_PENALTY_GIVEN, .gap = 7};
    assert_int_equal(qs_encode_settle(&none, &potts, 3, &settled), QS_OK);
    assert_int_equal(settled.encoding, QS_ONE_HOT_SPARSE);
    assert_int_equal(settled.gap, 1);
    assert_int_equal(qs_encode_settle(&given, &potts, 3, &settled), QS_E_ARGUMENT);
    given.alpha = QS_ENERGY_MAX;
    assert_int_equal(qs_encode_settle(&given, &potts, 3, &settled), QS_OK);
    assert_int_equal(settled.gap, 1);
    given.alpha++;
    assert_int_equal(qs_encode_settle(&given, &potts, 3, &settled), QS_E_OVERFLOW);
    none.encoding = QS_ST_CUT;
    assert_int_equal(qs_encode_settle(&none, &potts, 3, &settled), QS_E_ENCODING);
    none.encoding = (qs_encoding)(QS_ENCODINGS + 1);
    assert_int_equal(qs_encode_settle(&none, &potts, 3, &settled), QS_E_ARGUMENT);
    none = (qs_encode_options){.gap = (uint32_t)INT32_MAX + 1};
    assert_int_equal(qs_encode_settle(&none, &potts, 3, &settled), QS_E_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_encoding_has_one_row),
        cmocka_unit_test(test_what_each_encoding_holds),
        cmocka_unit_test(test_which_penalties_go_with_it),
        cmocka_unit_test(test_variables_of_a_site),
        cmocka_unit_test(test_how_samples_are_repaired),
        cmocka_unit_test(test_sizes_are_those_of_the_papers),
        cmocka_unit_test(test_defaults_are_filled_in),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
