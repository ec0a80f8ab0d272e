/* What `info` prints about the two files, and `encode` about the one that it wrote. */
#ifndef DESCRIBE_H
#define DESCRIBE_H

#include "known_best.h"

/* Print a problem, after problem_index, and what its file says is known of its optimum: lines for
 * people, a JSON object, or only its keys. */
void describe_problem(const problem_file *described, const known_best *known);
void describe_problem_json(const problem_file *described, const known_best *known);
void describe_problem_keys(const problem_file *described, const known_best *known);

void describe_samples(const samples_file *described);
void describe_samples_json(const samples_file *described);

#endif
