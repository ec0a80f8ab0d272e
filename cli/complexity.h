/* The size of a problem in each encoding: Table 1 of Heidari, Dinneen and Delmas, with the
 * coefficients. */
#ifndef COMPLEXITY_H
#define COMPLEXITY_H

#include "solving.h"

/* Print the table, or a list `encodings` in a JSON object. Each row is measured on the QUBO itself,
 * which is made in memory if it fits the limit. Return DONE, or NO_RESOURCE, after a message, if
 * there is no memory. */
int complexity_print(const laid_out *problem, const budget *limit);
int complexity_json(const laid_out *problem, const budget *limit);

#endif
