#include "names.h"

#include <stdio.h>
#include <string.h>

#include "messages.h"
#include "suggest.h"

#define TABLE(what, names, untyped)                                                                \
    {what, names, sizeof names / sizeof names[0], sizeof names / sizeof names[0] - (untyped)}

static const named encodings[] = {
    {"one-hot", QS_ONE_HOT},         {"one-hot-sparse", QS_ONE_HOT_SPARSE},
    {"domain-wall", QS_DOMAIN_WALL}, {"multiway-cut", QS_MULTIWAY_CUT},
    {"st-cut", QS_ST_CUT},           {"st-cut-arcs", QS_ST_CUT_ARCS}};
static const named smoothnesses[] = {{"potts", QS_POTTS},
                                     {"linear", QS_TRUNCATED_LINEAR},
                                     {"quadratic", QS_TRUNCATED_QUADRATIC},
                                     {"table", QS_TABLE}};
static const named penalties[] = {{"local", QS_PENALTY_LOCAL},
                                  {"minimal", QS_PENALTY_MINIMAL},
                                  {"paper", QS_PENALTY_PAPER},
                                  {"given", QS_PENALTY_GIVEN}};
static const named costs[] = {{"ad", QS_COST_AD}};

const name_table encoding_names = TABLE("encoding", encodings, 0);
const name_table smoothness_names = TABLE("smoothness", smoothnesses, 1);
const name_table penalty_names = TABLE("penalty", penalties, 1);
const name_table cost_names = TABLE("cost", costs, 0);

const char *name_of(const name_table *table, int value)
{
    for (size_t i = 0; i < table->count; i++) {
        if (table->names[i].value == value) {
            return table->names[i].name;
        }
    }
    return NULL;
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
        return fail_usage("--%s %s is not known: did you mean %s? The known ones:%s%s", table->what,
                          text, suggested.nearest, list, also);
    }
    return fail_usage("--%s %s is not known. The known ones:%s%s", table->what, text, list, also);
}
