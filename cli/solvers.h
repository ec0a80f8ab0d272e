/* The library's solvers by their names. */
#ifndef SOLVERS_H
#define SOLVERS_H

#include "names.h"
#include "qstereo.h"

typedef struct solver {
    const char *name;
    qs_solver *run;
    size_t (*workspace)(const qs_model *model);
} solver;

enum { SOLVERS = 8 };

/* In the order in which they are compared. */
extern const solver solvers[SOLVERS];

/* A row for a table of options. */
#define SOLVER_OPTION                                                                              \
    {"solver", 0, false, "NAME", "best", "icm, anneal, swap, expansion, bp, trws, cut or best"}

/* The argument of --solver. Returns DONE, or BAD_USAGE having listed the known ones. */
int solver_read(const char *text, const solver **chosen);

/* One name, `length` letters of `text`, of the argument of --solvers. */
int solvers_read(const char *text, size_t length, const solver **chosen);

#endif
