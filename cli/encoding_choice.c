#include "encoding_choice.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "text/fail.h"
#include "text/names.h"
#include "text/numbers.h"

void smoothness_write(const qs_pairwise *pairwise, char text[SMOOTHNESS_SIZE])
{
    int used = snprintf(text, SMOOTHNESS_SIZE, "%s",
                        name_of(&smoothness_names, (int)pairwise->smoothness));
    if (pairwise->truncation > 0) {
        (void)snprintf(text + used, SMOOTHNESS_SIZE - (size_t)used, ", truncated at %" PRIu32,
                       pairwise->truncation);
    }
}

static bool can_be_default(qs_penalty penalty, qs_encoding encoding, const coded_problem *of)
{
    return penalty != QS_PENALTY_GIVEN &&
           qs_encoding_allows_penalty(encoding, penalty, &of->pairwise);
}

static bool holds(qs_encoding encoding, const void *context)
{
    const coded_problem *of = context;
    return qs_encoding_holds(encoding, &of->pairwise, of->labels);
}

static int fail_encoding(qs_encoding encoding, const coded_problem *of)
{
    char smoothness[SMOOTHNESS_SIZE], list[ENCODING_LIST_SIZE];
    smoothness_write(&of->pairwise, smoothness);
    encodings_write(holds, of, list);
    return fail_usage("--encoding %s cannot hold the smoothness%s%s (%s), but these can: %s",
                      encoding_name(encoding), of->file != NULL ? " of " : "",
                      of->file != NULL ? of->file : "", smoothness, list);
}

static int read_encoding(const char *name, const coded_problem *of, qs_encoding *encoding)
{
    *encoding = of->encoding;
    if (name != NULL) {
        TRY(encoding_read(name, encoding));
    }
    return qs_encoding_holds(*encoding, &of->pairwise, of->labels) ? DONE
                                                                   : fail_encoding(*encoding, of);
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
    return *alpha > 0 ? DONE : fail_usage("--penalty %s is not above 0", text);
}

static int read_penalty_value(const char *text, uint32_t scale, qs_encode_options *asked)
{
    int value = QS_PENALTY_GIVEN;
    if (strchr("0123456789.+-", text[0]) != NULL) {
        TRY(read_alpha(text, scale, &asked->alpha));
    } else {
        TRY(name_read(&penalty_names, text, ", or a number", &value));
    }
    asked->penalty = (qs_penalty)value;
    return DONE;
}

static int read_penalty(const char *text, const coded_problem *of, qs_encode_options *asked)
{
    qs_encoding encoding = asked->encoding;
    if (text == NULL) {
        asked->penalty = can_be_default(of->penalty, encoding, of) ? of->penalty : QS_PENALTY_LOCAL;
        return DONE;
    }
    TRY(read_penalty_value(text, of->scale, asked));
    if (!qs_encoding_has_penalty(encoding, asked->penalty)) {
        return fail_usage("--penalty %s does not go with --encoding %s: choose local or minimal",
                          text, encoding_name(encoding));
    }
    if (!qs_encoding_allows_penalty(encoding, asked->penalty, &of->pairwise)) {
        return fail_usage("--penalty paper goes with --encoding one-hot-sparse only for potts "
                          "smoothness: choose local or minimal, or --encoding one-hot");
    }
    return DONE;
}

static int read_gap(const char *text, const coded_problem *of, qs_encode_options *asked)
{
    bool keeps_gap = qs_penalty_keeps_gap(asked->penalty);
    asked->gap = keeps_gap ? of->gap : 1;
    if (text == NULL) {
        return DONE;
    }
    if (!keeps_gap) {
        return fail_usage("--gap goes with --penalty local or minimal, not with %s, which keeps "
                          "no gap",
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
    TRY(read_encoding(encoding, of, &asked->encode.encoding));
    TRY(read_penalty(values[CODING_PENALTY], of, &asked->encode));
    TRY(read_gap(values[CODING_GAP], of, &asked->encode));
    asked->truncate = of->truncate || values[CODING_TRUNCATE] != NULL;
    return DONE;
}

static qs_status recode(const laid_out *problem, const qs_recode_options *options, uint64_t left,
                        growing_file *grown)
{
    size_t size = qs_recode_workspace(&problem->model, options);
    void *workspace = size <= left ? malloc(size > 0 ? size : 1) : NULL;
    *grown = growing_begin(left - (workspace != NULL ? size : 0));
    const qs_sink sink = {growing_append, grown};
    if (workspace == NULL) {
        grown->over = size > left;
        grown->refused = size <= left;
        return QS_E_IO;
    }
    qs_status status =
        qs_recode(&problem->model, &problem->labels, options, &sink, workspace, size, NULL);
    free(workspace);
    return status;
}

qs_status recode_quietly(const laid_out *problem, const qs_recode_options *options,
                         const budget *limit, file_bytes *made)
{
    growing_file grown;
    qs_status status = recode(problem, options, limit->left, &grown);
    if (status != QS_OK) {
        file_free(&grown.file);
        return status == QS_E_IO && grown.over ? QS_E_LIMIT : status;
    }
    *made = grown.file;
    return QS_OK;
}

static int fail_recode(const char *name, uint32_t scale, const char *mend, qs_status status)
{
    if (status == QS_E_LIMIT) {
        return fail(BAD_INPUT, name,
                    "has more than %u variables in this encoding: choose another encoding, or a "
                    "smaller window",
                    QS_VARIABLES_MAX);
    }
    if (status == QS_E_OVERFLOW) {
        return fail(BAD_INPUT, name,
                    "the coefficients overflow (their sum is above 2^53): %schoose a smaller %s",
                    fewer_decimals(mend, scale), mend);
    }
    return fail_status(name, status);
}

int recode_problem(const laid_out *problem, const qs_recode_options *options, const char *mend,
                   budget *limit, problem_file *made)
{
    const char *name = problem->name;
    growing_file grown;
    memset(made, 0, sizeof *made);
    qs_status written = recode(problem, options, limit->left, &grown);
    if (written != QS_OK && written != QS_E_IO) {
        file_free(&grown.file);
        return fail_recode(name, problem->scale, mend, written);
    }
    TRY(growing_end(&grown, name, limit));
    return problem_check(name, grown.file, limit, made);
}
