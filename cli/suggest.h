/* The known name nearest to a mistyped one. */
#ifndef SUGGEST_H
#define SUGGEST_H

#include <stddef.h>

typedef struct suggestion {
    const char *typed;
    const char *nearest; /* of the names offered so far; NULL = none is near */
    size_t distance;
} suggestion;

suggestion suggest_for(const char *typed);
void suggest_offer(suggestion *suggested, const char *name);

#endif
