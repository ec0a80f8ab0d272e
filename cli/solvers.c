#include "solvers.h"

#include <stdio.h>

const solver solvers[SOLVERS] = {
    {"icm", qs_icm, qs_icm_workspace},    {"anneal", qs_anneal, qs_anneal_workspace},
    {"swap", qs_swap, qs_swap_workspace}, {"expansion", qs_expansion, qs_expansion_workspace},
    {"bp", qs_bp, qs_bp_workspace},       {"trws", qs_trws, qs_trws_workspace},
    {"cut", qs_min_cut, qs_min_cut_workspace},
    {"best", qs_best, qs_best_workspace},
};

static int read_name(const char *what, const char *text, const solver **chosen)
{
    named names[SOLVERS];
    int index = 0;
    for (int i = 0; i < SOLVERS; i++) {
        names[i] = (named){solvers[i].name, i};
    }
    const name_table table = {what, names, SOLVERS, SOLVERS};
    int status = name_read(&table, text, "", &index);
    *chosen = &solvers[index];
    return status;
}

int solver_read(const char *text, const solver **chosen)
{
    return read_name("solver", text, chosen);
}

int solvers_read(const char *text, size_t length, const solver **chosen)
{
    char name[64];
    (void)snprintf(name, sizeof name, "%.*s", length < sizeof name ? (int)length : (int)sizeof name,
                   text);
    return read_name("solvers", name, chosen);
}
