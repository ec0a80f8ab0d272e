#include "../../include/qstereo/certificate.h"

#include "../qubo/sites.h"

/* Returns true if a site of the smaller problem has all labels left of one of the whole problem.
 *
 * left  out: moves on behind the labels of the site */
static bool has_all(const qs_site *whole, const uint8_t **left, const qs_site *smaller)
{
    if (!whole->is_undecided) {
        return qs_site_has(smaller, whole->fixed);
    }
    bool all = true;
    for (uint32_t d = qs_site_label_from(whole, 0); d < whole->labels->labels;
         d = qs_site_label_from(whole, d + 1)) {
        bool is_left = *(*left)++ != 0;
        all = all && (!is_left || qs_site_has(smaller, d));
    }
    return all;
}

bool qs_certificate_covers(const qs_qubo *qubo, const uint8_t *left, const qs_qubo *smaller)
{
    if (!qubo->has_labels || !smaller->has_labels || qubo->labels.sites != smaller->labels.sites ||
        qubo->labels.labels != smaller->labels.labels) {
        return false;
    }
    bool all = true;
    qs_site other = {.labels = &smaller->labels};
    for (qs_site site = {.labels = &qubo->labels}; qs_site_next(&site);) {
        (void)qs_site_next(&other);
        all = has_all(&site, &left, &other) && all;
    }
    return all;
}
