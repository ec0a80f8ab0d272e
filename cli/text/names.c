#include "text/names.h"

#include <stdio.h>
#include <string.h>

#include "pictures/colour_map.h"
#include "text/fail.h"

#define TABLE(what, names, untyped)                                                                \
    {what, names, sizeof names / sizeof names[0], sizeof names / sizeof names[0] - (untyped)}

static const named smoothnesses[] = {{"potts", QS_POTTS},
                                     {"linear", QS_TRUNCATED_LINEAR},
                                     {"quadratic", QS_TRUNCATED_QUADRATIC},
                                     {"table", QS_TABLE},
                                     {"tables", QS_TABLES}};
static const named penalties[] = {{"local", QS_PENALTY_LOCAL},
                                  {"minimal", QS_PENALTY_MINIMAL},
                                  {"paper", QS_PENALTY_PAPER},
                                  {"given", QS_PENALTY_GIVEN}};
static const named palettes[] = {{"turbo", PALETTE_TURBO}, {"viridis", PALETTE_VIRIDIS}};
static const named units[] = {{"m", 1000}, {"cm", 10}, {"mm", 1}};

const name_table smoothness_names = TABLE("smoothness", smoothnesses, 2);
const name_table penalty_names = TABLE("penalty", penalties, 1);
const name_table palette_names = TABLE("palette", palettes, 0);
const name_table unit_names = TABLE("unit", units, 0);

const char *name_of(const name_table *table, int value)
{
    for (size_t i = 0; i < table->count; i++) {
        if (table->names[i].value == value) {
            return table->names[i].name;
        }
    }
    return NULL;
}

const char *name_at(const name_table *table, size_t index)
{
    return index < table->typed ? table->names[index].name : NULL;
}

const char *encoding_name(qs_encoding encoding)
{
    const qs_encoding_facts *facts = qs_encoding_facts_of(encoding);
    return facts != NULL ? facts->name : NULL;
}

const char *encoding_at(size_t index)
{
    return index < QS_ENCODINGS ? encoding_name((qs_encoding)(index + 1)) : NULL;
}

void encodings_write(encoding_belongs *belongs, const void *context, char list[ENCODING_LIST_SIZE])
{
    int used = 0;
    list[0] = '\0';
    for (int i = 1; i <= QS_ENCODINGS; i++) {
        if (belongs((qs_encoding)i, context)) {
            used += snprintf(list + used, ENCODING_LIST_SIZE - (size_t)used, "%s%s",
                             used > 0 ? ", " : "", encoding_name((qs_encoding)i));
        }
    }
}

static bool has_model(qs_encoding encoding, const void *context)
{
    (void)context;
    return qs_encoding_facts_of(encoding)->has_model;
}

void encodings_with_model_write(char list[ENCODING_LIST_SIZE])
{
    encodings_write(has_model, NULL, list);
}

int encoding_read(const char *text, qs_encoding *encoding)
{
    named names[QS_ENCODINGS];
    int value;
    for (int i = 0; i < QS_ENCODINGS; i++) {
        names[i] = (named){encoding_name((qs_encoding)(i + 1)), i + 1};
    }
    const name_table table = {"encoding", names, QS_ENCODINGS, QS_ENCODINGS};
    TRY(name_read(&table, text, "", &value));
    *encoding = (qs_encoding)value;
    return DONE;
}

int name_read(const name_table *table, const char *text, const char *also, int *value)
{
    char list[256] = "";
    suggestion suggested = suggest_for(text);
    for (size_t i = 0; i < table->typed; i++) {
        size_t used = strlen(list);
        if (strcmp(table->names[i].name, text) == 0) {
            *value = table->names[i].value;
            return DONE;
        }
        (void)snprintf(list + used, sizeof list - used, " %s", table->names[i].name);
        suggest_offer(&suggested, table->names[i].name);
    }
    if (suggested.nearest != NULL) {
        return fail_usage("--%s %s is unknown: did you mean %s? It can be:%s%s", table->what, text,
                          suggested.nearest, list, also);
    }
    return fail_usage("--%s %s is unknown: it can be:%s%s", table->what, text, list, also);
}

enum { LONGEST = 31 };

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* The edit distance (Levenshtein) of two short names; LONGEST + 1 if one is too long for that. */
static size_t distance(const char *a, const char *b)
{
    size_t m = strlen(a), n = strlen(b);
    size_t row[LONGEST + 1];
    if (m > LONGEST || n > LONGEST) {
        return LONGEST + 1;
    }
    for (size_t j = 0; j <= n; j++) {
        row[j] = j;
    }
    for (size_t i = 1; i <= m; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= n; j++) {
            size_t changed = diagonal + (a[i - 1] != b[j - 1]);
            diagonal = row[j];
            row[j] = least(changed, least(row[j], row[j - 1]) + 1);
        }
    }
    return row[n];
}

suggestion suggest_for(const char *typed)
{
    /* If more than a third of the letters are wrong, it is another name and not a slip. */
    size_t slips = (strlen(typed) + 1) / 3;
    return (suggestion){typed, NULL, (slips < 1 ? 1 : slips) + 1};
}

void suggest_offer(suggestion *suggested, const char *name)
{
    size_t found = distance(suggested->typed, name);
    if (found < suggested->distance) {
        suggested->distance = found;
        suggested->nearest = name;
    }
}
