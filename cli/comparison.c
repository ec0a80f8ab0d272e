#include "comparison.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "text/numbers.h"
#include "text/plain.h"
#include "text/json.h"
#include "text/fail.h"
#include "text/table.h"

int comparison_add(comparison *to, const char *solver, size_t solver_size, result **added)
{
    if (to->count == RESULTS_MAX) {
        return fail_usage("%d solvers and samples files are the most", RESULTS_MAX);
    }
    *added = &to->results[to->count++];
    memset(*added, 0, sizeof **added);
    memcpy((*added)->solver, solver, solver_size);
    (*added)->lower_bound = QS_NO_BOUND;
    (*added)->microseconds = -1;
    return DONE;
}

/* The best lower bound of all. QS_NO_BOUND is less than every bound. */
static int64_t best_bound(const comparison *of)
{
    int64_t best = QS_NO_BOUND;
    for (size_t i = 0; i < of->count; i++) {
        best = of->results[i].lower_bound > best ? of->results[i].lower_bound : best;
    }
    return best;
}

/* A labelling whose energy is equal to the bound is optimal, whichever solver found it. */
static bool is_proven(const result *shown, int64_t bound)
{
    return shown->feasible > 0 && bound != QS_NO_BOUND && shown->energy == bound;
}

static void json_result(const comparison *of, const result *shown, int64_t bound)
{
    bool answered = shown->feasible > 0;
    json_item();
    json_name("solver", shown->solver);
    json_name("file", shown->file);
    json_truth("usable", shown->refusal == QS_OK);
    json_units_or_null("energy", answered, shown->energy, of->scale);
    bool has_gap = answered && bound != QS_NO_BOUND;
    json_units_or_null("gap", has_gap, has_gap ? shown->energy - bound : 0, of->scale);
    json_units_or_null("lower_bound", shown->lower_bound != QS_NO_BOUND, shown->lower_bound,
                       of->scale);
    json_count("feasible", shown->feasible);
    json_count("samples", shown->samples);
    json_truth("proven_optimal", is_proven(shown, bound));
    map_errors_json(&shown->errors);
    json_units_or_null("seconds", shown->microseconds >= 0, shown->microseconds, 1000000);
    json_name("map", shown->has_map ? shown->map : NULL);
    json_item_end();
}

void comparison_json(const comparison *shown)
{
    int64_t bound = best_bound(shown);
    json_begin();
    json_units_or_null("lower_bound", bound != QS_NO_BOUND, bound, shown->scale);
    json_name("trace", shown->trace);
    json_list("results");
    for (size_t i = 0; i < shown->count; i++) {
        json_result(shown, &shown->results[i], bound);
    }
    json_list_end();
    json_end();
}

enum { METHOD, ENERGY, GAP, PERCENT, FEASIBLE, RMS, BAD_HALF, BAD_ONE, SECONDS, NOTE, COLUMNS };

static void fill_errors(const map_errors *errors, table_cell *cells)
{
    if (errors->pixels > 0) {
        (void)snprintf(cells[RMS], TABLE_CELL_SIZE, "%.4f", errors->of[ERROR_RMS]);
        (void)snprintf(cells[BAD_HALF], TABLE_CELL_SIZE, "%.2f", errors->of[ERROR_BAD_HALF]);
        (void)snprintf(cells[BAD_ONE], TABLE_CELL_SIZE, "%.2f", errors->of[ERROR_BAD_ONE]);
    }
}

static void fill_row(const comparison *of, const result *shown, int64_t bound, table_cell *cells)
{
    const char *file = shown->file != NULL ? plain(shown->file) : "";
    for (size_t i = 0; i < NOTE; i++) {
        (void)snprintf(cells[i], TABLE_CELL_SIZE, "-");
    }
    (void)snprintf(cells[NOTE], TABLE_CELL_SIZE, "%s", file);
    (void)snprintf(cells[METHOD], TABLE_CELL_SIZE, "%s", plain(shown->solver));
    if (shown->refusal != QS_OK) {
        (void)snprintf(cells[NOTE], TABLE_CELL_SIZE,
                       shown->refusal == QS_E_ENCODING ? "not for this pairwise cost"
                                                       : "costs too large");
        return;
    }
    (void)snprintf(cells[FEASIBLE], TABLE_CELL_SIZE, "%" PRIu32 "/%" PRIu32, shown->feasible,
                   shown->samples);
    if (shown->microseconds >= 0) {
        (void)snprintf(cells[SECONDS], TABLE_CELL_SIZE, "%.3f", (double)shown->microseconds / 1e6);
    }
    if (shown->feasible == 0) {
        return;
    }
    decimal_write(shown->energy, of->scale, cells[ENERGY]);
    if (bound != QS_NO_BOUND) {
        decimal_write(shown->energy - bound, of->scale, cells[GAP]);
        if (shown->energy != 0) {
            (void)snprintf(cells[PERCENT], TABLE_CELL_SIZE, "%.4f",
                           gap_percent(shown->energy, bound));
        }
    }
    fill_errors(&shown->errors, cells);
    if (is_proven(shown, bound)) {
        (void)snprintf(cells[NOTE], TABLE_CELL_SIZE, "optimal%s%s", *file != '\0' ? ", " : "",
                       file);
    }
}

void comparison_print(const comparison *shown)
{
    static const table_cell heading[COLUMNS] = {
        "method", "energy", "gap", "gap %", "feasible", "rms", "bad-0.5", "bad-1.0", "seconds", ""};
    static table_cell cells[(RESULTS_MAX + 1) * COLUMNS];
    bool hidden[COLUMNS] = {false};
    char text[DECIMAL_SIZE];
    int64_t bound = best_bound(shown);
    memcpy(cells, heading, sizeof heading);
    for (size_t i = 0; i < shown->count; i++) {
        fill_row(shown, &shown->results[i], bound, &cells[(i + 1) * COLUMNS]);
    }
    hidden[RMS] = hidden[BAD_HALF] = hidden[BAD_ONE] = !shown->scored;
    table_print(cells, shown->count + 1, COLUMNS, hidden);
    if (bound == QS_NO_BOUND) {
        puts("no lower bound: none of these solvers gives one");
        return;
    }
    decimal_write(bound, shown->scale, text);
    printf("best lower bound %s: no labelling has a lower energy\n", text);
}
