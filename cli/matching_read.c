#include "matching_read.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "text/fail.h"
#include "text/numbers.h"

static const char *const cost_names[] = {"ad", "sd", "bt", "census"};
enum { COSTS = sizeof cost_names / sizeof cost_names[0], TEXT_MAX = 64, LARGEST = INT32_MAX / 2 };

/* The part of a text before its last or only STEP; false if it is too long. */
static bool split_step(const char *text, char range[TEXT_MAX], const char **step)
{
    const char *first = strchr(text, ':');
    const char *second = first != NULL ? strchr(first + 1, ':') : NULL;
    size_t length = second != NULL ? (size_t)(second - text) : strlen(text);
    if (length >= TEXT_MAX) {
        return false;
    }
    memcpy(range, text, length);
    range[length] = '\0';
    *step = second != NULL ? second + 1 : *step;
    return true;
}

int disparity_range_read(const char *text, const char *step, qs_matching *matching)
{
    char range[TEXT_MAX];
    int32_t ends[2];
    fraction one;
    if (!split_step(text, range, &step) || !range_read(range, ends) || ends[0] < -LARGEST ||
        ends[1] > LARGEST) {
        return fail_usage("--disparity %s is not MIN:MAX, two whole numbers from -%ld to %ld, or "
                          "MIN:MAX:STEP",
                          text, (long)LARGEST, (long)LARGEST);
    }
    if (decimal_read(step, 1, 2, &one) != DECIMAL_OK || one.numerator != 1) {
        return fail_usage("--disparity %s: the step is 1 or 0.5", text);
    }
    if (ends[0] > ends[1]) {
        return fail_usage("--disparity %s is empty: MIN is above MAX", text);
    }
    matching->parts = one.denominator;
    matching->disparity_min = ends[0] * (int32_t)matching->parts;
    matching->disparity_max = ends[1] * (int32_t)matching->parts;
    int64_t labels = (int64_t)matching->disparity_max - matching->disparity_min + 1;
    if (labels > QS_LABELS_MAX) {
        return fail_usage("--disparity %s has %" PRId64 " labels: %u is the most", text, labels,
                          QS_LABELS_MAX);
    }
    return DONE;
}

static int fail_cost(const char *text)
{
    return fail_usage("--cost %s is not a sum of one or two terms [WEIGHT*]NAME[:TRUNCATION], with "
                      "the names ad, sd, bt, or census:WxH: bt:40+2*census:7x7",
                      text);
}

/* Reads a number with nothing behind it. */
static bool whole(const char *text, uint32_t *number)
{
    return numbers_read(text, ',', number, 1) && *number >= 1;
}

/* The part of a text up to a letter, which becomes its end; returns what is behind it, NULL if the
 * letter is not there. */
static char *cut_at(char *text, char letter)
{
    char *found = strchr(text, letter);
    if (found == NULL) {
        return NULL;
    }
    *found = '\0';
    return found + 1;
}

static bool read_name(const char *name, qs_match_cost *cost)
{
    for (int i = 0; i < COSTS; i++) {
        if (strcmp(cost_names[i], name) == 0) {
            *cost = (qs_match_cost)i;
            return true;
        }
    }
    return false;
}

/* [WEIGHT*]NAME[:WxH][:TRUNCATION] */
static bool read_term(char *text, qs_match_term *term)
{
    char *name = cut_at(text, '*');
    uint32_t window[2];
    *term = (qs_match_term){.weight = 1};
    if (name != NULL && (!whole(text, &term->weight) || term->weight > 255)) {
        return false;
    }
    name = name != NULL ? name : text;
    char *rest = cut_at(name, ':');
    if (!read_name(name, &term->cost)) {
        return false;
    }
    if (term->cost == QS_MATCH_CENSUS) {
        char *behind = rest != NULL ? cut_at(rest, ':') : NULL;
        if (rest == NULL || !numbers_read(rest, 'x', window, 2)) {
            return false;
        }
        term->width = window[0];
        term->height = window[1];
        rest = behind;
    }
    return rest == NULL || whole(rest, &term->truncation);
}

int cost_read(const char *text, qs_matching *matching)
{
    char terms[TEXT_MAX], *next = terms;
    if (strlen(text) >= TEXT_MAX) {
        return fail_cost(text);
    }
    memcpy(terms, text, strlen(text) + 1);
    for (matching->term_count = 0; next != NULL; matching->term_count++) {
        char *term = next;
        next = cut_at(term, '+');
        if (matching->term_count == QS_MATCH_TERMS ||
            !read_term(term, &matching->terms[matching->term_count])) {
            return fail_cost(text);
        }
    }
    uint32_t most = qs_matching_most(matching);
    if (most == 0) {
        return fail_usage("--cost %s: the window of census has 1, 3, 5 or 7 columns and rows, and "
                          "more than one pixel",
                          text);
    }
    if (most > UINT16_MAX) {
        return fail_usage("--cost %s can be %lu, above 65535: lower weights or truncations", text,
                          (unsigned long)most);
    }
    const qs_match_term *a = &matching->terms[0], *b = &matching->terms[1];
    if (matching->term_count == 2 && a->cost == QS_MATCH_CENSUS && b->cost == QS_MATCH_CENSUS &&
        (a->width != b->width || a->height != b->height)) {
        return fail_usage("--cost %s: two terms of census have the same window", text);
    }
    return DONE;
}

int contrast_read(const char *text, qs_matching *matching)
{
    uint32_t numbers[2];
    if (text == NULL || strcmp(text, "none") == 0) {
        return DONE;
    }
    if (!numbers_read(text, ',', numbers, 2) || numbers[0] < 1 || numbers[0] > 256 ||
        numbers[1] < 1 || numbers[1] > 65535) {
        return fail_usage("--contrast %s is not GREYS,TIMES, whole numbers from 1 to 256 and to "
                          "65535, or none",
                          text);
    }
    matching->contrast_below = numbers[0];
    matching->contrast_times = numbers[1];
    return DONE;
}

int border_read(const char *text, qs_matching *matching)
{
    bool keep = strcmp(text, "keep") == 0;
    if (!keep && strcmp(text, "leave-out") != 0) {
        return fail_usage("--border %s: there are keep and leave-out", text);
    }
    if (keep && (matching->terms[0].truncation == 0 || matching->terms[0].truncation > 65535)) {
        return fail_usage("--border keep needs a truncation of the first term of --cost, which is "
                          "what a match outside the right picture costs: ad:40");
    }
    matching->border = keep ? QS_BORDER_KEEP : QS_BORDER_LEAVE_OUT;
    return DONE;
}
