/* What a problem costs in each encoding: Table 1 of Heidari, Dinneen and Delmas, with the
 * coefficients. */
#ifndef COMPLEXITY_H
#define COMPLEXITY_H

#include "solving.h"

/* Prints the table, or a list `encodings` in a JSON object. Each row is measured on the QUBO
 * itself, which is made in memory, where it fits the limit. */
void complexity_print(const laid_out *problem, budget limit);
void complexity_json(const laid_out *problem, budget limit);

#endif
