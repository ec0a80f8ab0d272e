#include "describe.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "meanings.h"
#include "text/numbers.h"
#include "text/plain.h"
#include "text/json.h"
#include "text/names.h"

enum { HEX_SIZE = 2 * QS_DIGEST_SIZE + 1 };

static void to_hex(const uint8_t digest[QS_DIGEST_SIZE], char text[HEX_SIZE])
{
    for (size_t i = 0; i < QS_DIGEST_SIZE; i++) {
        (void)snprintf(text + 2 * i, 3, "%02x", digest[i]);
    }
}

/* Prints "least to most" in real units, or one number if they are equal. */
static void print_range(const char *name, int64_t least, int64_t most, uint32_t scale)
{
    char from[DECIMAL_SIZE], to[DECIMAL_SIZE];
    decimal_write(least, scale, from);
    decimal_write(most, scale, to);
    if (least == most) {
        printf("%-17s%s\n", name, from);
    } else {
        printf("%-17s%s to %s\n", name, from, to);
    }
}

/* The penalties of an encoding: a and b of one-hot groups, or kappa of walls. The penalties of the
 * cuts are arcs among others. */
typedef struct penalties {
    bool single, pair; /* which of the two exist */
    int64_t single_min, single_max, pair_min, pair_max;
} penalties;

/* kappa is the weight of the couplings of a chain with itself. There are none if no site has three
 * labels left. */
static penalties chain_penalties(const qs_index *index)
{
    penalties found = {.single = false};
    for (uint32_t group = 0; group < index->qubo->groups; group++) {
        for (uint32_t i = index->near_start[group]; i < index->near_start[group + 1]; i++) {
            const qs_neighbour *near = &index->near[i];
            if (near->group != group) {
                continue;
            }
            int64_t kappa = llabs((long long)near->weight *
                                  qs_index_block(index, near->block & ~QS_TRANSPOSED, 0, 1));
            found.single_min = !found.single || kappa < found.single_min ? kappa : found.single_min;
            found.single_max = !found.single || kappa > found.single_max ? kappa : found.single_max;
            found.single = true;
        }
    }
    return found;
}

static penalties find_penalties(const problem_file *described, const qs_qubo_summary *summary)
{
    const qs_qubo *qubo = &described->qubo;
    /* Groups without labels have the penalties of one-hot. */
    qs_encoding encoding = qubo->has_labels ? qubo->labels.encoding : QS_ONE_HOT;
    qs_site_code code = qs_encoding_facts_of(encoding)->code;
    if (code == QS_CODE_WALL) {
        return chain_penalties(&described->index);
    }
    bool there = code == QS_CODE_ONE_HOT;
    return (penalties){there,
                       there,
                       summary->penalty_min,
                       summary->penalty_max,
                       summary->pair_penalty_min,
                       summary->pair_penalty_max};
}

static void print_penalties(const penalties *printed, bool walls, uint32_t scale)
{
    if (printed->single) {
        print_range(walls ? "penalty kappa" : "penalty a", printed->single_min, printed->single_max,
                    scale);
    }
    if (printed->pair) {
        print_range("penalty b", printed->pair_min, printed->pair_max, scale);
    }
}

/* Says where the penalty that is proven for a domain wall grows with the labels left: where costs
 * are neither Potts nor linear. */
static void print_growing_kappa(const problem_file *described)
{
    const qs_labels *labels = &described->qubo.labels;
    qs_smoothness smoothness = labels->pairwise.smoothness;
    uint32_t most = 0;
    for (uint32_t g = 0; g < described->qubo.groups; g++) {
        uint32_t size = described->index.start[g + 1] - described->index.start[g] + 1;
        most = size > most ? size : most;
    }
    if (most > 3 && smoothness != QS_POTTS && smoothness != QS_TRUNCATED_LINEAR) {
        printf("%17ssites have up to %" PRIu32 " labels: with this smoothness kappa grows\n"
               "%17swith their number, and one-hot may have the smaller penalties\n",
               "", most, "");
    }
}

static void print_displacements(const qs_labels *labels)
{
    const qs_meaning *meaning = &labels->meaning;
    uint32_t rows = (labels->labels + meaning->columns - 1) / meaning->columns;
    char from[2][DECIMAL_SIZE], to[2][DECIMAL_SIZE];
    decimal_write(meaning->x, meaning->unit, from[0]);
    decimal_write((int64_t)meaning->x + meaning->columns - 1, meaning->unit, to[0]);
    decimal_write(meaning->y, meaning->unit, from[1]);
    decimal_write((int64_t)meaning->y + rows - 1, meaning->unit, to[1]);
    printf(", displacements: dx %s to %s, dy %s to %s pixels; a site every %" PRIu32 " pixels\n",
           from[0], to[0], from[1], to[1], meaning->step);
}

/* What the labels stand for. */
static void print_meaning(const qs_labels *labels)
{
    int64_t first = labels->frame.first, last = labels->labels - 1;
    switch (labels->meaning.kind) {
    case QS_MEANS_NUMBER: printf(", numbers 0 to %" PRId64 "\n", last); return;
    case QS_MEANS_GREY:
        printf(", greys 0 to %" PRId64 " in steps of %" PRIu32 "\n", last * labels->meaning.step,
               labels->meaning.step);
        return;
    case QS_MEANS_CLASS:
        printf(", classes %" PRId64 " to %" PRId64 "\n", first, first + last);
        return;
    case QS_MEANS_DISPLACEMENT: print_displacements(labels); return;
    case QS_MEANS_KEEP: puts(": 0 drop, 1 keep"); return;
    case QS_MEANS_DISPARITY: break;
    }
    uint32_t unit = labels->meaning.unit > 0 ? labels->meaning.unit : 1;
    char ends[2][DECIMAL_SIZE], step[DECIMAL_SIZE] = "";
    decimal_write(first, unit, ends[0]);
    decimal_write(first + last, unit, ends[1]);
    decimal_write(1, unit, step);
    printf(", disparities %s to %s%s%s\n", ends[0], ends[1], unit > 1 ? " in steps of " : "",
           unit > 1 ? step : "");
}

static void print_labels(const qs_labels *labels)
{
    char lambda[DECIMAL_SIZE] = "differs by edge";
    const qs_frame *frame = &labels->frame;
    if (labels->weight >= 0) {
        decimal_write(labels->weight, labels->scale, lambda);
    }
    printf("%-17s%" PRIu32, "sites", labels->sites);
    if (labels->width > 0) {
        printf(", grid %" PRIu32 " x %" PRIu32 " at (%" PRIu32 ", %" PRIu32
               ") of a picture %" PRIu32 " x %" PRIu32,
               labels->width, labels->height, frame->x, frame->y, frame->picture_width,
               frame->picture_height);
    }
    if (labels->fixed_bytes > 0) {
        printf("\n%-17s%" PRIu32 ", fixed %" PRIu32, "sites undecided", labels->undecided,
               labels->sites - labels->undecided);
    }
    printf("\n%-17s%" PRIu32, "labels", labels->labels);
    print_meaning(labels);
    printf("%-17s%s", "smoothness", name_of(&smoothness_names, (int)labels->pairwise.smoothness));
    if (labels->pairwise.truncation > 0) {
        printf(", truncated at %" PRIu32, labels->pairwise.truncation);
    }
    printf(", lambda %s\n", lambda);
    if (labels->scale > 1) {
        printf("%-17s1/%" PRIu32 "\n", "integer unit", labels->scale);
    }
    printf("%-17s%s, penalty %s, gap %" PRIu32 "\n", "encoding", encoding_name(labels->encoding),
           name_of(&penalty_names, (int)labels->penalty), labels->gap);
    if (labels->trimmed_bytes > 0) {
        printf("%-17scosts that no optimum pays are lowered\n", "truncated");
    }
}

static void print_known(const known_best *known, uint32_t scale)
{
    char energy[DECIMAL_SIZE], bound[DECIMAL_SIZE];
    if (known->labelling == NULL) {
        return;
    }
    decimal_write(known->energy, scale, energy);
    printf("%-17senergy %s", "best known", energy);
    if (known->lower_bound != QS_NO_BOUND) {
        decimal_write(known->lower_bound, scale, bound);
        printf("; the file states the lower bound %s, without a proof", bound);
    }
    putchar('\n');
}

void describe_problem(const problem_file *described, const known_best *known)
{
    const qs_qubo *qubo = &described->qubo;
    uint32_t scale = described->scale;
    uint8_t digest[QS_DIGEST_SIZE];
    char hex[HEX_SIZE];
    qs_qubo_summary summary;
    qs_qubo_summarise(qubo, &summary);
    qs_digest(described->file.bytes, described->file.size, digest);
    to_hex(digest, hex);
    printf("%s: a QUBO (.qcf version %d), %zu bytes\n", plain(described->name), QS_FORMAT_VERSION,
           described->file.size);
    if (qubo->has_labels) {
        print_labels(&qubo->labels);
    }
    printf("%-17s%" PRIu32 " in %" PRIu32 " group%s\n", "variables", qubo->variables, qubo->groups,
           plural(qubo->groups));
    printf("%-17s%" PRIu64 ", from %" PRIu64 " couplings of groups\n", "quadratic terms",
           summary.quadratic_terms, qubo->couplings);
    penalties found = find_penalties(described, &summary);
    print_penalties(&found, qubo->has_labels && qubo->labels.encoding == QS_DOMAIN_WALL, scale);
    if (qubo->has_labels && qubo->labels.encoding == QS_DOMAIN_WALL) {
        print_growing_kappa(described);
    }
    print_range("offset", summary.offset, summary.offset, scale);
    print_range("linear", summary.linear_min, summary.linear_max, scale);
    print_range("quadratic", summary.quadratic_min, summary.quadratic_max, scale);
    print_known(known, scale);
    printf("%-17s%s\n", "digest", hex);
}

static void json_grid(const qs_qubo *qubo)
{
    const qs_labels *labels = &qubo->labels;
    static const char *const keys[] = {"width", "height",        "x",
                                       "y",     "picture_width", "picture_height"};
    const uint32_t values[] = {labels->width,
                               labels->height,
                               labels->frame.x,
                               labels->frame.y,
                               labels->frame.picture_width,
                               labels->frame.picture_height};
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++) {
        if (qubo->has_labels && labels->width > 0) {
            json_count(keys[i], values[i]);
        } else {
            json_null(keys[i]);
        }
    }
}

static void json_meaning(const qs_labels *labels)
{
    json_count("sites", labels->sites);
    json_count("sites_open", labels->undecided);
    json_count("labels", labels->labels);
    json_name("meaning", meaning_name(labels->meaning.kind));
    if (labels->meaning.kind == QS_MEANS_DISPARITY) {
        uint32_t unit = labels->meaning.unit > 0 ? labels->meaning.unit : 1;
        json_units("disparity_min", labels->frame.first, unit);
        json_units("disparity_max", (int64_t)labels->frame.first + labels->labels - 1, unit);
    } else {
        json_null("disparity_min");
        json_null("disparity_max");
    }
    json_name("encoding", encoding_name(labels->encoding));
    json_name("smoothness", name_of(&smoothness_names, (int)labels->pairwise.smoothness));
    json_count("truncation", labels->pairwise.truncation);
    json_name("penalty", name_of(&penalty_names, (int)labels->penalty));
    json_count("gap", labels->gap);
    json_truth("truncated", labels->trimmed_bytes > 0);
    json_units_or_null("lambda", labels->weight >= 0, labels->weight, labels->scale);
}

/* The same keys, all null, for a file that does not say what its variables mean. */
static void json_no_meaning(void)
{
    static const char *const keys[] = {"sites",         "sites_open",    "labels",   "meaning",
                                       "disparity_min", "disparity_max", "encoding", "smoothness",
                                       "truncation",    "penalty",       "gap",      "truncated",
                                       "lambda"};
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++) {
        json_null(keys[i]);
    }
}

static void json_range(const char *least_key, const char *most_key, bool there, int64_t least,
                       int64_t most, uint32_t scale)
{
    json_units_or_null(least_key, there, least, scale);
    json_units_or_null(most_key, there, most, scale);
}

static void json_summary(const problem_file *described)
{
    uint32_t scale = described->scale;
    qs_qubo_summary summary;
    qs_qubo_summarise(&described->qubo, &summary);
    penalties found = find_penalties(described, &summary);
    json_count("quadratic_terms", summary.quadratic_terms);
    json_range("penalty_min", "penalty_max", found.single, found.single_min, found.single_max,
               scale);
    json_range("pair_penalty_min", "pair_penalty_max", found.pair, found.pair_min, found.pair_max,
               scale);
    json_units("offset", summary.offset, scale);
    json_range("linear_min", "linear_max", true, summary.linear_min, summary.linear_max, scale);
    json_range("quadratic_min", "quadratic_max", true, summary.quadratic_min, summary.quadratic_max,
               scale);
}

static void json_digest(const char *key, const uint8_t digest[QS_DIGEST_SIZE])
{
    char hex[HEX_SIZE];
    to_hex(digest, hex);
    json_name(key, hex);
}

static void json_known(const known_best *known, uint32_t scale)
{
    bool there = known->labelling != NULL;
    json_units_or_null("known_energy", there, known->energy, scale);
    json_units_or_null("stated_lower_bound", there && known->lower_bound != QS_NO_BOUND,
                       known->lower_bound, scale);
}

void describe_problem_keys(const problem_file *described, const known_best *known)
{
    const qs_qubo *qubo = &described->qubo;
    uint8_t digest[QS_DIGEST_SIZE];
    qs_digest(described->file.bytes, described->file.size, digest);
    json_name("format", "qcf");
    json_count("version", QS_FORMAT_VERSION);
    json_count("file_bytes", described->file.size);
    json_digest("digest", digest);
    json_count("variables", qubo->variables);
    json_count("groups", qubo->groups);
    json_count("couplings", qubo->couplings);
    json_count("scale", described->scale);
    json_grid(qubo);
    if (qubo->has_labels) {
        json_meaning(&qubo->labels);
    } else {
        json_no_meaning();
    }
    json_summary(described);
    json_known(known, described->scale);
}

void describe_problem_json(const problem_file *described, const known_best *known)
{
    json_begin();
    describe_problem_keys(described, known);
    json_end();
}

/* The least energy that the file states, in integer units. Returns false if it has no sample. */
static bool best_stated(const qs_samples_view *samples, int64_t *best)
{
    *best = INT64_MAX;
    for (uint32_t sample = 0; sample < samples->count; sample++) {
        int64_t energy = qs_samples_record(samples, sample).energy;
        if (energy < *best) {
            *best = energy;
        }
    }
    return samples->count > 0;
}

/* A table that prints its title before its first line. */
typedef struct table {
    const char *title; /* NULL = it is printed */
    const char *unit;
} table;

static void print_line(void *context, const char *name, size_t size, double number)
{
    table *to = context;
    if (to->title != NULL) {
        printf("%s\n", to->title);
        to->title = NULL;
    }
    printf("  %-40s%12.10g%s\n", plain_text(name, size), number, to->unit);
}

static void print_broken_chains(const qs_samples_view *samples)
{
    double broken = 0;
    uint64_t reads = 0, whole = 0;
    for (uint32_t sample = 0; sample < samples->count; sample++) {
        qs_record record = qs_samples_record(samples, sample);
        if (record.chain_breaks != QS_NO_CHAINS) {
            reads += record.occurrences;
            whole += record.chain_breaks == 0 ? record.occurrences : 0;
            broken += 1e-9 * record.chain_breaks * record.occurrences;
        }
    }
    if (reads > 0) {
        printf("%-17s%.2f %% on average; none in %" PRIu64 " of %" PRIu64 " reads\n",
               "broken chains", 100 * broken / (double)reads, whole, reads);
    }
}

void describe_samples(const samples_file *described)
{
    const qs_samples_view *samples = &described->view;
    char hex[HEX_SIZE];
    int64_t best;
    to_hex(samples->problem, hex);
    printf("%s: samples (.qsf version %d), %zu bytes\n", plain(described->name), QS_FORMAT_VERSION,
           described->file.size);
    printf("%-17s%" PRIu32 " of %" PRIu32 " variable%s\n", "samples", samples->count,
           samples->variables, plural(samples->variables));
    printf("%-17s%s\n", "solver", plain_text(samples->solver, samples->solver_size));
    if (best_stated(samples, &best)) {
        printf("%-17s%" PRId64 ", in integer units of its .qcf (validate shows real units)\n",
               "best energy", best);
    }
    print_broken_chains(samples);
    /* The services of D-Wave give all times in microseconds. */
    table parameters = {"parameters", ""}, timing = {"timing", " us"};
    json_each_number(samples->info, samples->info_size, "parameters", print_line, &parameters);
    json_each_number(samples->info, samples->info_size, "timing", print_line, &timing);
    printf("%-17s", "info");
    plain_print(stdout, samples->info, samples->info_size);
    putchar('\n');
    printf("%-17s%s\n", "problem digest", hex);
}

void describe_samples_json(const samples_file *described)
{
    const qs_samples_view *samples = &described->view;
    int64_t best;
    json_begin();
    json_name("format", "qsf");
    json_count("version", QS_FORMAT_VERSION);
    json_count("file_bytes", described->file.size);
    json_count("samples", samples->count);
    json_count("variables", samples->variables);
    json_text("solver", samples->solver, samples->solver_size);
    if (best_stated(samples, &best)) {
        json_integer("best_energy", best);
    } else {
        json_null("best_energy");
    }
    json_object("info", samples->info, samples->info_size);
    json_digest("problem_digest", samples->problem);
    json_end();
}
