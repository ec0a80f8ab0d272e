#include "makers/uai.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "text/fail.h"
#include "text/numbers.h"

/* ---- Words. ---- */

/* The text of a file, word by word. Lines that begin with # or the letter c alone are comments. */
typedef struct words {
    const char *name; /* of the file, for messages */
    char *at;
    const char *end; /* of the text */
    bool in_line; /* a word stands before `at` in its line */
    uint32_t ahead; /* the line of `at` */
    uint32_t line; /* of the last word */
} words;

static bool is_space(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/* Goes one letter on. */
static void step(words *from)
{
    if (*from->at++ == '\n') {
        from->ahead++;
        from->in_line = false;
    }
}

static bool is_comment(const words *from)
{
    return !from->in_line &&
           (*from->at == '#' || (*from->at == 'c' && (is_space(from->at[1]) || !from->at[1])));
}

/* Goes to the next word, past comments. */
static void skip_space(words *from)
{
    while (is_space(*from->at) || is_comment(from)) {
        if (is_comment(from)) {
            from->at += strcspn(from->at, "\n");
        } else {
            step(from);
        }
    }
}

/* The next word, ended by a 0 byte; NULL after the last. */
static char *next_word(words *from)
{
    skip_space(from);
    char *word = from->at;
    size_t length = strcspn(word, " \t\r\n");
    if (length == 0) {
        return NULL;
    }
    from->line = from->ahead;
    from->in_line = true;
    from->at += length;
    if (*from->at != '\0') {
        char *end = from->at;
        step(from);
        *end = '\0';
    }
    return word;
}

static int read_count(words *from, const char *what, uint32_t least, uint32_t most, uint32_t *count)
{
    const char *word = next_word(from);
    if (word == NULL) {
        return fail(BAD_INPUT, from->name, "ends before %s", what);
    }
    if (!numbers_read(word, ' ', count, 1) || *count < least || *count > most) {
        return fail(BAD_INPUT, from->name,
                    "line %" PRIu32 ": %s is %s, not a whole number from %" PRIu32 " to %" PRIu32,
                    from->line, what, word, least, most);
    }
    return DONE;
}

/* Whether so many words may follow, each with what parts it from the next. This comes before memory
 * is asked for: more memory would not mend a file that ends too early. */
static int check_promise(const words *from, uint32_t count, const char *what, uint64_t follow)
{
    uint64_t left = (uint64_t)(from->end - from->at);
    if (follow > (left + 1) / 2) {
        return fail(BAD_INPUT, from->name,
                    "line %" PRIu32 ": %" PRIu32 " %s do not fit in the %" PRIu64
                    " bytes that follow: the file is cut short, or the number is wrong",
                    from->line, count, what, left);
    }
    return DONE;
}

/* A factor's entry as a cost in units. *zero = the entry is 0. */
static int read_cost(words *from, uint32_t scale, int32_t *cost, bool *zero)
{
    const char *word = next_word(from);
    char *end;
    if (word == NULL) {
        return fail(BAD_INPUT, from->name, "ends before the last entry of a factor");
    }
    double value = strtod(word, &end);
    if (*end != '\0' || !isfinite(value) || value < 0) {
        return fail(BAD_INPUT, from->name,
                    "line %" PRIu32 ": the entry %s is not a finite number from 0", from->line,
                    word);
    }
    *zero = value == 0;
    double units = *zero ? 0 : nearbyint(-log(value) * scale);
    if (fabs(units) > INT32_MAX / 4) {
        return fail(BAD_INPUT, from->name,
                    "line %" PRIu32 ": -log of %s is too large in units of 1/%" PRIu32
                    ": choose a smaller --scale",
                    from->line, word, scale);
    }
    *cost = (int32_t)units;
    return DONE;
}

/* ---- The network. ---- */

/* The scope of a factor: no, one or two variables. */
typedef struct scope {
    uint32_t size, variables[2];
} scope;

typedef struct network {
    words from;
    uint32_t scale;
    qs_problem *problem;
    uint32_t *labels; /* of each variable */
    uint32_t factors, pairs;
    scope *scopes;
    int32_t *costs, *tables;
    uint8_t *allowed;
    qs_edge *edges;
} network;

static int read_variables(network *net, budget *limit)
{
    qs_problem *problem = net->problem;
    const char *kind = next_word(&net->from);
    if (kind == NULL || strcmp(kind, "MARKOV") != 0) {
        return fail(BAD_INPUT, net->from.name,
                    "is not a Markov network of the UAI format, which begins with MARKOV");
    }
    TRY(read_count(&net->from, "the number of variables", 1, QS_VARIABLES_MAX, &problem->sites));
    TRY(check_promise(&net->from, problem->sites, "variables", problem->sites));
    net->labels = budget_take(limit, net->from.name, problem->sites * sizeof *net->labels);
    if (net->labels == NULL) {
        return NO_RESOURCE;
    }
    for (uint32_t v = 0; v < problem->sites; v++) {
        TRY(read_count(&net->from, "a variable's number of values", 1, QS_LABELS_MAX,
                       &net->labels[v]));
        problem->labels = net->labels[v] > problem->labels ? net->labels[v] : problem->labels;
    }
    if ((uint64_t)problem->sites * problem->labels > QS_VARIABLES_MAX) {
        return fail(BAD_INPUT, net->from.name, "variables x values are more than %u",
                    QS_VARIABLES_MAX);
    }
    return DONE;
}

static uint64_t entries_of(const network *net, const scope *of)
{
    uint64_t entries = 1;
    for (uint32_t i = 0; i < of->size; i++) {
        entries *= net->labels[of->variables[i]];
    }
    return entries;
}

static int read_scopes(network *net, budget *limit)
{
    words *from = &net->from;
    TRY(read_count(from, "the number of factors", 0, QS_VARIABLES_MAX, &net->factors));
    /* A factor's number of variables, its number of entries and one entry. */
    TRY(check_promise(from, net->factors, "factors", 3 * (uint64_t)net->factors));
    uint64_t entries = 0;
    net->scopes = budget_take(limit, from->name, net->factors * sizeof *net->scopes);
    if (net->scopes == NULL) {
        return NO_RESOURCE;
    }
    for (uint32_t f = 0; f < net->factors; f++) {
        scope *read = &net->scopes[f];
        TRY(read_count(from, "a factor's number of variables", 0, UINT32_MAX, &read->size));
        if (read->size > 2) {
            return fail(BAD_INPUT, from->name,
                        "line %" PRIu32 ": a factor of %" PRIu32
                        " variables: only pairwise networks can be labelling problems",
                        from->line, read->size);
        }
        for (uint32_t i = 0; i < read->size; i++) {
            TRY(read_count(from, "a variable of a factor", 0, net->problem->sites - 1,
                           &read->variables[i]));
        }
        if (read->size == 2 && read->variables[0] == read->variables[1]) {
            return fail(BAD_INPUT, from->name, "line %" PRIu32 ": a factor of one variable twice",
                        from->line);
        }
        net->pairs += read->size == 2;
        entries += entries_of(net, read);
    }
    return check_promise(from, net->factors, "factors with their entries", entries + net->factors);
}

/* Room for the problem. Values that a variable does not have are forbidden. */
static int take_room(network *net, budget *limit)
{
    const qs_problem *problem = net->problem;
    size_t labels = problem->labels, all = problem->sites * labels;
    uint64_t each =
        bytes_sum(bytes_product(labels * labels, sizeof *net->tables), sizeof *net->edges);
    uint64_t need =
        bytes_sum(bytes_product(all, sizeof *net->costs + 1), bytes_product(net->pairs, each));
    TRY(budget_need(limit, net->from.name, need));
    if (need > SIZE_MAX) {
        return fail_memory(net->from.name);
    }
    size_t entries = net->pairs * labels * labels;
    net->costs = budget_take(limit, net->from.name, all * sizeof *net->costs);
    net->allowed = budget_take(limit, net->from.name, all);
    net->tables = budget_take(limit, net->from.name, entries * sizeof *net->tables);
    net->edges = budget_take(limit, net->from.name, net->pairs * sizeof *net->edges);
    if (net->costs == NULL || net->allowed == NULL || net->tables == NULL || net->edges == NULL) {
        return NO_RESOURCE;
    }
    memset(net->costs, 0, all * sizeof *net->costs);
    memset(net->tables, 0, entries * sizeof *net->tables);
    for (size_t i = 0; i < all; i++) {
        net->allowed[i] = i % labels < net->labels[i / labels];
    }
    return DONE;
}

/* Adds to the cost of a label; costs of several factors may overflow together. */
static int add_cost(const network *net, uint32_t site, uint32_t label, int32_t cost)
{
    int32_t *sum = &net->costs[(size_t)site * net->problem->labels + label];
    if (cost > 0 ? *sum > INT32_MAX / 2 - cost : *sum < -(INT32_MAX / 2) - cost) {
        return fail(BAD_INPUT, net->from.name,
                    "the costs of variable %" PRIu32 " overflow: choose a smaller --scale", site);
    }
    *sum += cost;
    return DONE;
}

/* A factor of one variable; an entry of 0 forbids the value. */
static int read_unary(network *net, uint32_t site)
{
    for (uint32_t d = 0; d < net->labels[site]; d++) {
        int32_t cost;
        bool zero;
        TRY(read_cost(&net->from, net->scale, &cost, &zero));
        TRY(add_cost(net, site, d, cost));
        if (zero) {
            net->allowed[(size_t)site * net->problem->labels + d] = 0;
        }
    }
    return DONE;
}

/* A factor of two variables. Its least cost goes to the labels of the first one, so that no cost of
 * two labels is below 0. */
static int read_pair(network *net, const scope *of, uint32_t pair)
{
    uint32_t u = of->variables[0], v = of->variables[1];
    size_t labels = net->problem->labels;
    int32_t *table = net->tables + pair * labels * labels, least = INT32_MAX;
    for (uint32_t a = 0; a < net->labels[u]; a++) {
        for (uint32_t b = 0; b < net->labels[v]; b++) {
            int32_t *entry = u < v ? &table[a * labels + b] : &table[b * labels + a];
            bool zero;
            TRY(read_cost(&net->from, net->scale, entry, &zero));
            if (zero) {
                return fail(BAD_INPUT, net->from.name,
                            "line %" PRIu32 ": a factor of two variables has an entry 0, which no "
                            "finite cost says: give it a small probability",
                            net->from.line);
            }
            least = *entry < least ? *entry : least;
        }
    }
    for (uint32_t a = 0; a < net->labels[u]; a++) {
        TRY(add_cost(net, u, a, least));
        for (uint32_t b = 0; b < net->labels[v]; b++) {
            *(u < v ? &table[a * labels + b] : &table[b * labels + a]) -= least;
        }
    }
    net->edges[pair] = u < v ? (qs_edge){u, v, 1} : (qs_edge){v, u, 1};
    return DONE;
}

static int read_constant(network *net)
{
    int32_t cost;
    bool zero;
    TRY(read_cost(&net->from, net->scale, &cost, &zero));
    if (zero) {
        return fail(BAD_INPUT, net->from.name, "line %" PRIu32 ": a constant factor is 0",
                    net->from.line);
    }
    for (uint32_t d = 0; d < net->labels[0]; d++) {
        TRY(add_cost(net, 0, d, cost));
    }
    return DONE;
}

static int read_factors(network *net)
{
    for (uint32_t f = 0, pair = 0; f < net->factors; f++) {
        const scope *of = &net->scopes[f];
        uint64_t entries = entries_of(net, of);
        uint32_t stated;
        TRY(read_count(&net->from, "a factor's number of entries", 1, UINT32_MAX, &stated));
        if (stated != entries) {
            return fail(BAD_INPUT, net->from.name,
                        "line %" PRIu32 ": a factor has %" PRIu32 " entries, but its variables "
                        "have %" PRIu64 " values together",
                        net->from.line, stated, entries);
        }
        switch (of->size) {
        case 0: TRY(read_constant(net)); break;
        case 1: TRY(read_unary(net, of->variables[0])); break;
        default: TRY(read_pair(net, of, pair++)); break;
        }
    }
    const char *more = next_word(&net->from);
    return more == NULL ? DONE
                        : fail(BAD_INPUT, net->from.name,
                               "line %" PRIu32
                               ": %s stands behind the last factor: give evidence as a factor "
                               "of one variable, 1 for its value and 0 for all others",
                               net->from.line, more);
}

/* A value is left to each variable. */
static int check_allowed(const network *net)
{
    size_t labels = net->problem->labels;
    for (uint32_t v = 0; v < net->problem->sites; v++) {
        if (memchr(net->allowed + v * labels, 1, labels) == NULL) {
            return fail(BAD_INPUT, net->from.name,
                        "variable %" PRIu32 " has a factor that is 0 for all its values", v);
        }
    }
    return DONE;
}

static int read_network(network *net, budget *limit)
{
    qs_problem *problem = net->problem;
    TRY(read_variables(net, limit));
    TRY(read_scopes(net, limit));
    TRY(take_room(net, limit));
    TRY(read_factors(net));
    TRY(check_allowed(net));
    problem->edges = net->edges;
    problem->edge_count = net->pairs;
    problem->costs = net->costs;
    problem->tables = net->tables;
    problem->allowed = net->allowed;
    return DONE;
}

static int uai_read(const char *const *operands, const char *const *values, void *state)
{
    uai_network *asked = state;
    asked->path = operands[0];
    return number_read("--scale", values[UAI_SCALE], 1, DECIMAL_DENOMINATOR_MAX, &asked->scale);
}

static int uai_open(void *state, budget *limit, made_problem *opened)
{
    uai_network *asked = state;
    file_bytes file;
    opened->name = input_name(asked->path);
    opened->mend = "--scale";
    opened->problem = (qs_problem){.scale = asked->scale,
                                   .pairwise = {.smoothness = QS_TABLES},
                                   .meaning = {.kind = QS_MEANS_NUMBER}};
    TRY(file_read(asked->path, limit, &file));
    char *text = budget_take(limit, opened->name, file.size + 1);
    if (text == NULL) {
        return NO_RESOURCE;
    }
    memcpy(text, file.bytes, file.size);
    text[file.size] = '\0';
    network net = {.from = {opened->name, text, text + file.size, false, 1, 1},
                   .scale = asked->scale,
                   .problem = &opened->problem};
    TRY(read_network(&net, limit));
    qs_status status = qs_problem_check(&opened->problem);
    return status == QS_OK ? DONE : made_fail(opened, "take a smaller network", status);
}

const maker uai_maker = {sizeof(uai_network), uai_read, uai_open, NULL};
