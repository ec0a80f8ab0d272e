#include "smoothness.h"

#include <stdio.h>

#include "text/fail.h"
#include "text/names.h"
#include "text/numbers.h"

int lambda_read(const char *text, uint32_t most_scale, uint32_t *scale, int32_t *weight)
{
    fraction lambda;
    char can_be[160];
    decimal_status status = decimal_read(text, INT32_MAX, most_scale, &lambda);
    if (status != DECIMAL_OK) {
        (void)snprintf(can_be, sizeof can_be,
                       "any decimal number from 0 that is n/s in lowest terms, with s up to %lu "
                       "and n up to 2147483647",
                       (unsigned long)most_scale);
        return decimal_fail("--lambda", text, status, can_be);
    }
    *scale = lambda.denominator;
    *weight = (int32_t)lambda.numerator;
    return DONE;
}

int smoothness_read(const char *name, const char *truncation, qs_pairwise *pairwise)
{
    int value;
    TRY(name_read(&smoothness_names, name, "", &value));
    pairwise->smoothness = (qs_smoothness)value;
    if (truncation == NULL) {
        return DONE;
    }
    if (pairwise->smoothness == QS_POTTS) {
        return fail_usage(
            "--truncation goes with --smoothness linear or quadratic: potts has nothing to "
            "truncate");
    }
    return number_read("--truncation", truncation, 1, INT32_MAX, &pairwise->truncation);
}
