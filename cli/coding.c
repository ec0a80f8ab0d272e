#include "coding.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "messages.h"
#include "names.h"
#include "numbers.h"

bool encoding_holds(qs_encoding encoding, const qs_pairwise *pairwise, uint32_t labels)
{
    bool potts = pairwise->smoothness == QS_POTTS,
         linear = pairwise->smoothness == QS_TRUNCATED_LINEAR;
    switch (encoding) {
    case QS_ONE_HOT: return true;
    case QS_ONE_HOT_SPARSE:
    case QS_DOMAIN_WALL: return potts || linear;
    case QS_MULTIWAY_CUT: return potts;
    case QS_ST_CUT:
    case QS_ST_CUT_ARCS: /* a truncation that no two labels go beyond is none, and of two labels
                            potts is linear */
        return (linear && (pairwise->truncation == 0 || pairwise->truncation >= labels - 1)) ||
               (potts && labels <= 2);
    case QS_ENCODING_DEFAULT: break;
    }
    return false;
}

/* Whether an encoding has the penalty, for one pairwise cost or another. */
static bool encoding_has_penalty(qs_encoding encoding, qs_penalty penalty)
{
    bool one_alpha = penalty == QS_PENALTY_PAPER || penalty == QS_PENALTY_GIVEN;
    return !one_alpha || encoding == QS_ONE_HOT || encoding == QS_ONE_HOT_SPARSE ||
           encoding == QS_MULTIWAY_CUT;
}

/* In one-hot-sparse of linear smoothness the paper's alpha is too small (docs/MATHS.md). */
static bool penalty_holds(qs_encoding encoding, qs_penalty penalty, const qs_pairwise *pairwise)
{
    return encoding != QS_ONE_HOT_SPARSE || penalty != QS_PENALTY_PAPER ||
           pairwise->smoothness == QS_POTTS;
}

void smoothness_write(const qs_pairwise *pairwise, char text[SMOOTHNESS_SIZE])
{
    int used = snprintf(text, SMOOTHNESS_SIZE, "%s",
                        name_of(&smoothness_names, (int)pairwise->smoothness));
    if (pairwise->truncation > 0) {
        (void)snprintf(text + used, SMOOTHNESS_SIZE - (size_t)used, " truncated at %" PRIu32,
                       pairwise->truncation);
    }
}

/* What the smoothness does not allow can be mended where it is said: on the command line, else in
 * the file. */
static int fail_smoothness(const coded_problem *of, const char *reason)
{
    return of->file == NULL ? fail_usage("%s", reason) : fail(BAD_INPUT, of->file, "%s", reason);
}

static bool can_be_default(qs_penalty penalty, qs_encoding encoding, const coded_problem *of)
{
    return penalty != QS_PENALTY_GIVEN && encoding_has_penalty(encoding, penalty) &&
           penalty_holds(encoding, penalty, &of->pairwise);
}

static int fail_encoding(qs_encoding encoding, const coded_problem *of)
{
    char smoothness[SMOOTHNESS_SIZE], list[256] = "", reason[512];
    smoothness_write(&of->pairwise, smoothness);
    for (size_t i = 0; i < encoding_names.count; i++) {
        const named *other = &encoding_names.names[i];
        if (encoding_holds((qs_encoding)other->value, &of->pairwise, of->labels)) {
            size_t used = strlen(list);
            (void)snprintf(list + used, sizeof list - used, "%s%s", used > 0 ? ", " : "",
                           other->name);
        }
    }
    (void)snprintf(reason, sizeof reason, "--encoding %s cannot hold %s smoothness: %s can",
                   name_of(&encoding_names, (int)encoding), smoothness, list);
    return fail_smoothness(of, reason);
}

static int read_encoding(const char *name, const coded_problem *of, qs_encoding *encoding)
{
    int value = (int)of->encoding;
    int status = name != NULL ? name_read(&encoding_names, name, "", &value) : DONE;
    *encoding = (qs_encoding)value;
    if (status == DONE && !encoding_holds(*encoding, &of->pairwise, of->labels)) {
        return fail_encoding(*encoding, of);
    }
    return status;
}

/* An alpha has to be a whole number of integer units. */
static int read_alpha(const char *text, uint32_t scale, int64_t *alpha)
{
    char held[128];
    fraction given;
    decimal_status status = decimal_read(text, QS_ENERGY_MAX, scale, &given);
    if (status == DECIMAL_OK && scale % given.denominator != 0) {
        status = DECIMAL_TOO_FINE;
    }
    if (status == DECIMAL_OK &&
        given.numerator > (uint64_t)QS_ENERGY_MAX / (scale / given.denominator)) {
        status = DECIMAL_TOO_LARGE;
    }
    (void)snprintf(held, sizeof held,
                   "any multiple above 0 of 1/%" PRIu32
                   ", the integer unit of this lambda, up to 2^53 units",
                   scale);
    if (status != DECIMAL_OK) {
        return decimal_fail("--penalty", text, status, held);
    }
    *alpha = (int64_t)(given.numerator * (scale / given.denominator));
    return *alpha > 0 ? DONE : fail_usage("--penalty %s: not above 0", text);
}

static int read_penalty(const char *text, const coded_problem *of, qs_encode_options *asked)
{
    int value = QS_PENALTY_GIVEN;
    int status = DONE;
    if (text == NULL) {
        asked->penalty =
            can_be_default(of->penalty, asked->encoding, of) ? of->penalty : QS_PENALTY_LOCAL;
        return DONE;
    }
    if (strchr("0123456789.+-", text[0]) != NULL) {
        status = read_alpha(text, of->scale, &asked->alpha);
    } else {
        status = name_read(&penalty_names, text, ", or a number", &value);
    }
    asked->penalty = (qs_penalty)value;
    if (status == DONE && !encoding_has_penalty(asked->encoding, asked->penalty)) {
        return fail_usage("--penalty %s: --encoding %s has local and minimal only", text,
                          name_of(&encoding_names, (int)asked->encoding));
    }
    if (status == DONE && !penalty_holds(asked->encoding, asked->penalty, &of->pairwise)) {
        return fail_smoothness(of, "--penalty paper: --encoding one-hot-sparse has it for potts "
                                   "smoothness only: choose local or "
                                   "minimal, or --encoding one-hot");
    }
    return status;
}

static int read_gap(const char *text, const coded_problem *of, qs_encode_options *asked)
{
    bool keeps_gap = asked->penalty == QS_PENALTY_LOCAL || asked->penalty == QS_PENALTY_MINIMAL;
    asked->gap = keeps_gap ? of->gap : 1;
    if (text == NULL) {
        return DONE;
    }
    if (!keeps_gap) {
        return fail_usage(
            "--gap goes with --penalty local or minimal, not with %s: no other keeps a gap",
            name_of(&penalty_names, (int)asked->penalty));
    }
    return number_read("--gap", text, 1, INT32_MAX, &asked->gap);
}

coded_problem coded_in_file(const problem_file *problem)
{
    const qs_labels *labels = &problem->qubo.labels;
    return (coded_problem){
        .file = problem->name,
        .pairwise = labels->pairwise,
        .labels = labels->labels,
        .scale = labels->scale,
        .encoding = labels->encoding,
        .penalty = labels->penalty,
        .gap = labels->gap,
        .truncate = labels->trimmed_bytes > 0,
    };
}

int coding_read(const char *encoding, const char *const *values, const coded_problem *of,
                qs_recode_options *asked)
{
    memset(asked, 0, sizeof *asked);
    int status = read_encoding(encoding, of, &asked->encode.encoding);
    if (status == DONE) {
        status = read_penalty(values[CODING_PENALTY], of, &asked->encode);
    }
    if (status == DONE) {
        status = read_gap(values[CODING_GAP], of, &asked->encode);
    }
    asked->truncate = of->truncate || values[CODING_TRUNCATE] != NULL;
    return status;
}
