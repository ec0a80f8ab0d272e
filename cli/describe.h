/* What `info` says of the two files, and `encode` of the one that it wrote. */
#ifndef DESCRIBE_H
#define DESCRIBE_H

#include "inputs.h"

/* After problem_index; the second prints an object, the third its keys alone. */
void describe_problem(const problem_file *described);
void describe_problem_json(const problem_file *described);
void describe_problem_keys(const problem_file *described);

void describe_samples(const samples_file *described);
void describe_samples_json(const samples_file *described);

#endif
