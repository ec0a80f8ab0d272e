/* Completion scripts for shells, made from the tables of commands and options. */
#ifndef COMPLETION_H
#define COMPLETION_H

#include "command.h"

/* Print a script to standard output. It completes the names of commands, their options, the names
 * that options take, and files everywhere else. */
void completion_bash(const command *const *commands, size_t count);
void completion_zsh(const command *const *commands, size_t count);

#endif
