#include "core_made.h"

#include <string.h>

#include "text/fail.h"

/* Small files may be larger than the problem, whose chunks have less to say. */
#define SMALL ((size_t)1 << 20)

static bool is_larger(const laid_out *problem, const file_bytes *file)
{
    return file->size > SMALL && file->size > problem->file->file.size;
}

/* Gives the undecided sites all labels that they came with. */
static void keep_labels(const qs_model *model, uint8_t *kept)
{
    for (size_t site = 0; site < model->sites; site++) {
        uint8_t *own = kept + site * model->labels;
        uint32_t left = 0;
        for (uint32_t d = 0; d < model->labels; d++) {
            left += own[d] != 0;
        }
        for (uint32_t d = 0; left > 1 && d < model->labels; d++) {
            own[d] = model->kept == NULL || model->kept[site * model->labels + d] != 0;
        }
    }
}

static int count_terms(const char *name, const file_bytes *file, const budget *limit,
                       uint64_t *terms)
{
    problem_file opened;
    qs_qubo_summary summary;
    TRY(problem_check(name, *file, limit, &opened));
    qs_qubo_summarise(&opened.qubo, &summary);
    *terms = summary.quadratic_terms;
    return DONE;
}

/* Of the encodings that can hold the problem, the one with the fewest terms among those that are no
 * larger than the problem. No bytes = there is none. */
static int make_sparsest(const laid_out *problem, const qs_recode_options *coding,
                         const budget *limit, file_bytes *best)
{
    const qs_pairwise *pairwise = &problem->model.pairwise;
    uint64_t fewest = UINT64_MAX, terms;
    *best = (file_bytes){NULL, 0};
    for (int encoding = 1; encoding <= QS_ENCODINGS; encoding++) {
        qs_recode_options tried = *coding;
        file_bytes file;
        tried.encode.encoding = (qs_encoding)encoding;
        if (!qs_encoding_facts_of(tried.encode.encoding)->has_model ||
            !qs_encoding_allows_penalty(tried.encode.encoding, tried.encode.penalty, pairwise) ||
            recode_quietly(problem, &tried, limit, &file) != QS_OK) {
            continue;
        }
        int status = count_terms(problem->name, &file, limit, &terms);
        if (status != DONE || terms >= fewest || is_larger(problem, &file)) {
            file_free(&file);
            TRY(status);
            continue;
        }
        file_free(best);
        *best = file;
        fewest = terms;
    }
    return DONE;
}

/* In the encoding of the problem, if that is no larger than the problem. */
static int make_same(const laid_out *problem, const qs_recode_options *coding, budget *limit,
                     file_bytes *made)
{
    problem_file written;
    TRY(recode_problem(problem, coding, "--penalty or --gap", limit, &written));
    *made = written.file;
    if (is_larger(problem, made)) {
        *made = (file_bytes){NULL, 0};
    }
    return DONE;
}

static int make_at(const laid_out *problem, const qs_recode_options *coding, budget *limit,
                   file_bytes *made)
{
    if (problem->model.pairwise.smoothness == QS_POTTS) {
        return make_same(problem, coding, limit, made);
    }
    TRY(make_sparsest(problem, coding, limit, made));
    return made->bytes != NULL ? budget_own(limit, problem->name, made->bytes, made->size) : DONE;
}

int core_make(const laid_out *problem, const qs_recode_options *coding, const reduced *smaller,
              budget *limit, problem_file *made, core_detail *detail)
{
    const qs_model *model = &problem->model;
    qs_recode_options at = *coding;
    file_bytes file;
    at.kept = smaller->kept;
    *detail = CORE_LABELS;
    TRY(make_at(problem, &at, limit, &file));
    if (file.bytes == NULL) {
        size_t size = (size_t)model->sites * model->labels;
        uint8_t *kept = budget_take(limit, problem->name, size);
        if (kept == NULL) {
            return NO_RESOURCE;
        }
        memcpy(kept, smaller->kept, size);
        keep_labels(model, kept);
        at.kept = kept;
        *detail = CORE_SITES;
        TRY(make_at(problem, &at, limit, &file));
    }
    if (file.bytes == NULL) {
        *detail = CORE_NOTHING;
        *made = *problem->file;
        return DONE;
    }
    return problem_check(problem->name, file, limit, made);
}
