/* How long a solver may search: the options of every command that solves. */
#ifndef SEARCH_H
#define SEARCH_H

#include <stddef.h>
#include <stdint.h>

/* Rows for a table of options, one behind the other. */
enum { SEARCH_TIME_LIMIT, SEARCH_ITERATIONS, SEARCH_SEED, SEARCH_OPTIONS };
#define SEARCH_OPTION_ROWS                                                                         \
    {"time-limit", 0,                                                                              \
     false,        "S",                                                                            \
     NULL,         "stop a solver after S seconds and take its best so far (default no limit)"},   \
        {"iterations", 0,    false,                                                                \
         "N",          NULL, "stop a solver after N iterations (default its own limit)"},          \
        {"seed", 0,   false,                                                                       \
         "N",    "0", "of the random numbers of anneal; the same seed gives the same answer"}

typedef struct search {
    int64_t time_limit; /* microseconds; 0 = none */
    uint64_t iterations; /* 0 = the solver's own limit */
    uint64_t seed;
} search;

/* Reads the arguments of the rows. Returns DONE or BAD_USAGE. */
int search_read(const char *const *values, search *asked);

#endif
