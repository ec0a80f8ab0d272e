#include "complexity.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "encoding_choice.h"
#include "text/fail.h"
#include "text/numbers.h"
#include "text/plain.h"
#include "text/json.h"
#include "text/names.h"
#include "text/table.h"

/* The rows of the table. */
static const struct {
    qs_encoding encoding;
    qs_penalty penalty;
} forms[] = {
    {QS_ONE_HOT, QS_PENALTY_LOCAL},        {QS_ONE_HOT, QS_PENALTY_PAPER},
    {QS_ONE_HOT_SPARSE, QS_PENALTY_LOCAL}, {QS_ONE_HOT_SPARSE, QS_PENALTY_MINIMAL},
    {QS_DOMAIN_WALL, QS_PENALTY_LOCAL},    {QS_MULTIWAY_CUT, QS_PENALTY_LOCAL},
    {QS_ST_CUT, QS_PENALTY_LOCAL},         {QS_ST_CUT_ARCS, QS_PENALTY_LOCAL},
};
enum { FORMS = sizeof forms / sizeof forms[0] };

/* What is known of one QUBO. */
typedef struct figures {
    uint64_t variables, terms; /* 0 = not counted, if it was not made */
    qs_qubo_summary summary;
    double unit; /* 0 = every coefficient is 0 */
    bool as_linear; /* the counts are those of linear smoothness */
    bool made; /* else only the counts are known */
    char why_not[80]; /* why it was not made */
} figures;

/* The two cuts of Ishikawa's graph. */
static bool is_st_cut(qs_encoding encoding)
{
    return qs_encoding_facts_of(encoding)->code == QS_CODE_CHAIN;
}

/* Edges between undecided sites. */
static uint64_t count_edges(const qs_model *model)
{
    uint64_t count = 0;
    if (model->width == 0) {
        for (uint64_t i = 0; i < 2 * (uint64_t)model->edges; i++) {
            count += model->links[i].weight != 0;
        }
        return count / 2;
    }
    for (uint32_t site = 0; site < model->sites; site++) {
        count += (uint64_t)(model->right[site] != 0) + (model->down[site] != 0);
    }
    return count;
}

static uint64_t labels_of_undecided(const qs_labels *labels)
{
    return labels_left(labels) - (labels->sites - labels->undecided);
}

/* Counts a QUBO without making it. A cut of Ishikawa's graph is counted only if the problem has all
 * its labels, because then each edge has the same number of thresholds. */
static void count(const laid_out *problem, qs_encoding encoding, figures *counted)
{
    const qs_labels *labels = &problem->labels;
    bool cut = is_st_cut(encoding);
    uint64_t edges = cut ? count_edges(&problem->model) : 0;
    const qs_encoding_counts counts = {labels->labels, labels->undecided,
                                       labels_of_undecided(labels), edges,
                                       edges * ((uint64_t)labels->labels + 1)};
    if (!cut || problem->model.kept == NULL) {
        const qs_encoding_size size = qs_encoding_measure(encoding, &counts);
        counted->variables = size.variables;
        counted->terms = cut ? size.couplings : 0;
    }
}

/* What one real unit becomes when h is scaled into [-4, 4] and J into [-2, 1], the ranges of a
 * quantum processor. */
static double scaled_unit(const qs_ising *ising, uint32_t scale)
{
    const double least[] = {(double)ising->field_min / -4, (double)ising->field_max / 4,
                            (double)ising->coupling_min / -2, (double)ising->coupling_max};
    double largest = 0;
    for (size_t i = 0; i < sizeof least / sizeof least[0]; i++) {
        largest = least[i] > largest ? least[i] : largest;
    }
    /* The four numbers of the Ising form are 4 times the coefficients. */
    return largest > 0 ? 4 * (double)scale / largest : 0;
}

/* Returns QS_E_LIMIT if the work does not fit into `left` bytes, QS_E_IO if there is no memory. */
static qs_status look_at(const file_bytes *file, uint64_t left, figures *seen)
{
    qs_qubo qubo;
    qs_index index;
    qs_ising ising;
    qs_status status = qs_qubo_open(file->bytes, file->size, left, &qubo, NULL);
    if (status != QS_OK) {
        return status;
    }
    size_t index_size = qs_index_workspace(&qubo), ising_size = qs_ising_workspace(&qubo);
    if (index_size > left || ising_size > left - index_size) {
        return QS_E_LIMIT;
    }
    void *workspace = malloc(index_size + 1);
    void *sums = malloc(ising_size + 1);
    status = workspace != NULL && sums != NULL
                 ? qs_index_build(&qubo, workspace, index_size, &index)
                 : QS_E_IO;
    if (status == QS_OK) {
        status = qs_qubo_ising(&index, sums, ising_size, &ising);
    }
    if (status == QS_OK) {
        qs_qubo_summarise(&qubo, &seen->summary);
        seen->variables = qubo.variables;
        seen->terms = seen->summary.quadratic_terms;
        seen->unit = scaled_unit(&ising, qubo.labels.scale);
    }
    free(sums);
    free(workspace);
    return status;
}

static const char *reason(qs_status status, uint64_t variables)
{
    if (status == QS_E_LIMIT) {
        return variables > QS_VARIABLES_MAX
                   ? "more than 2147483647 variables"
                   : "over the memory limit, so that the rest cannot be measured";
    }
    return status == QS_E_OVERFLOW ? "coefficients above 2^53" : qs_status_text(status);
}

/* Returns DONE, or NO_RESOURCE if there is no memory: that says nothing about the problem. */
static int measure(const laid_out *problem, size_t form, bool truncate, const budget *limit,
                   figures *measured)
{
    const qs_labels *labels = &problem->labels;
    qs_encoding encoding = forms[form].encoding;
    const qs_recode_options options = {.encode = {encoding, forms[form].penalty, 0, labels->gap},
                                       .truncate = truncate};
    file_bytes file = {NULL, 0};
    memset(measured, 0, sizeof *measured);
    if (!qs_encoding_holds(encoding, &labels->pairwise, labels->labels)) {
        (void)snprintf(measured->why_not, sizeof measured->why_not, "%s only",
                       qs_encoding_facts_of(encoding)->holds);
        if (is_st_cut(encoding)) {
            count(problem, encoding, measured);
            measured->as_linear = measured->terms > 0;
        }
        return DONE;
    }
    qs_status status = recode_quietly(problem, &options, limit, &file);
    if (status == QS_OK) {
        status = look_at(&file, limit->left - file.size, measured);
    }
    file_free(&file);
    if (status == QS_E_IO) {
        return fail_memory(problem->name);
    }
    measured->made = status == QS_OK;
    if (!measured->made) {
        count(problem, encoding, measured);
        (void)snprintf(measured->why_not, sizeof measured->why_not, "%s",
                       reason(status, measured->variables));
    }
    return DONE;
}

enum { NAME, VARIABLES, TERMS, LINEAR, QUADRATIC, UNIT, TRUNCATED, NOTE, COLUMNS };

static bool is_counted(const figures *of, uint64_t count)
{
    return of->made || count > 0;
}

static void write_count(const figures *of, uint64_t count, table_cell cell)
{
    if (is_counted(of, count)) {
        (void)snprintf(cell, TABLE_CELL_SIZE, "%" PRIu64, count);
    }
}

static void write_range(int64_t least, int64_t most, uint32_t scale, table_cell cell)
{
    char from[DECIMAL_SIZE], to[DECIMAL_SIZE];
    decimal_write(least, scale, from);
    decimal_write(most, scale, to);
    (void)snprintf(cell, TABLE_CELL_SIZE, "%s..%s", from, to);
}

static void write_unit(const figures *of, table_cell cell)
{
    if (of->made && of->unit > 0) {
        (void)snprintf(cell, TABLE_CELL_SIZE, "%.3g", of->unit);
    }
}

static void fill_row(size_t form, const figures *whole, const figures *truncated, uint32_t scale,
                     table_cell *cells)
{
    qs_penalty penalty = forms[form].penalty;
    for (size_t i = 0; i < NOTE; i++) {
        (void)snprintf(cells[i], TABLE_CELL_SIZE, "-");
    }
    (void)snprintf(cells[NAME], TABLE_CELL_SIZE, "%s%s%s", encoding_name(forms[form].encoding),
                   penalty == QS_PENALTY_LOCAL ? "" : ", ",
                   penalty == QS_PENALTY_LOCAL ? "" : name_of(&penalty_names, (int)penalty));
    (void)snprintf(cells[NOTE], TABLE_CELL_SIZE, "%s", "");
    write_count(whole, whole->variables, cells[VARIABLES]);
    write_count(whole, whole->terms, cells[TERMS]);
    if (whole->made) {
        write_range(whole->summary.linear_min, whole->summary.linear_max, scale, cells[LINEAR]);
        write_range(whole->summary.quadratic_min, whole->summary.quadratic_max, scale,
                    cells[QUADRATIC]);
    }
    write_unit(whole, cells[UNIT]);
    write_unit(truncated, cells[TRUNCATED]);
}

int complexity_print(const laid_out *problem, const budget *limit)
{
    static const table_cell heading[COLUMNS] = {"encoding",  "variables", "terms",     "linear",
                                                "quadratic", "unit",      "truncated", ""};
    static table_cell cells[(FORMS + 1) * COLUMNS];
    const qs_labels *labels = &problem->labels;
    char smoothness[SMOOTHNESS_SIZE];
    figures whole[FORMS], truncated;
    smoothness_write(&labels->pairwise, smoothness);
    memcpy(cells, heading, sizeof heading);
    for (size_t form = 0; form < FORMS; form++) {
        TRY(measure(problem, form, false, limit, &whole[form]));
        TRY(measure(problem, form, true, limit, &truncated));
        fill_row(form, &whole[form], &truncated, labels->scale, &cells[(form + 1) * COLUMNS]);
    }
    printf("%s: %" PRIu32 " undecided sites, %" PRIu64 " labels left to them; smoothness: %s\n"
           "Coefficients are in real units. Penalties are local unless the row names another one,\n"
           "with the gap %" PRIu32 " of the file.\n"
           "unit: what an energy of 1 becomes when h is scaled into [-4, 4] and J into [-2, 1].\n"
           "truncated: the unit with --truncate.\n\n",
           plain(problem->name), labels->undecided, labels_of_undecided(labels), smoothness,
           labels->gap);
    table_print(cells, FORMS + 1, COLUMNS, NULL);
    for (size_t form = 0; form < FORMS; form++) {
        if (!whole[form].made) {
            printf("%s: %s%s\n", cells[(form + 1) * COLUMNS + NAME], whole[form].why_not,
                   whole[form].as_linear ? "; the counts are those of that smoothness" : "");
        }
    }
    return DONE;
}

static void json_counted(const char *key, const figures *of, uint64_t count)
{
    if (is_counted(of, count)) {
        json_count(key, count);
    } else {
        json_null(key);
    }
}

static void json_ranges(const figures *of, uint32_t scale)
{
    const qs_qubo_summary *s = &of->summary;
    const int64_t values[] = {s->linear_min, s->linear_max, s->quadratic_min, s->quadratic_max};
    static const char *const keys[] = {"linear_min", "linear_max", "quadratic_min",
                                       "quadratic_max"};
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++) {
        if (of->made) {
            json_units(keys[i], values[i], scale);
        } else {
            json_null(keys[i]);
        }
    }
    if (of->made && of->unit > 0) {
        json_real("unit", of->unit);
    } else {
        json_null("unit");
    }
}

static void json_figures(const laid_out *problem, size_t form, bool truncate,
                         const figures *measured)
{
    json_item();
    json_name("encoding", encoding_name(forms[form].encoding));
    json_name("penalty", name_of(&penalty_names, (int)forms[form].penalty));
    json_truth("truncated", truncate);
    json_name("why_not", measured->made ? NULL : measured->why_not);
    json_counted("variables", measured, measured->variables);
    json_counted("quadratic_terms", measured, measured->terms);
    json_ranges(measured, problem->scale);
    json_item_end();
}

int complexity_json(const laid_out *problem, const budget *limit)
{
    figures measured[2 * FORMS];
    for (size_t i = 0; i < 2 * FORMS; i++) {
        TRY(measure(problem, i / 2, i % 2 == 1, limit, &measured[i]));
    }
    json_begin();
    json_list("encodings");
    for (size_t i = 0; i < 2 * FORMS; i++) {
        json_figures(problem, i / 2, i % 2 == 1, &measured[i]);
    }
    json_list_end();
    json_end();
    return DONE;
}
