/* Messages to stderr, one line each: `qstereo CMD: FILE: reason`. Each function returns the exit
 * status that it was given or stands for, so that a caller can say `return fail(...)`. */
#ifndef MESSAGES_H
#define MESSAGES_H

#include "command.h"
#include "qstereo.h"

#if defined(__GNUC__)
#define PRINTF_LIKE(text, first) __attribute__((format(printf, text, first)))
#else
#define PRINTF_LIKE(text, first)
#endif

/* The command that the messages to come are of; NULL = qstereo itself. */
void messages_of(const char *name);

/* place  the file or option concerned; NULL = none */
int fail(int status, const char *place, const char *format, ...) PRINTF_LIKE(3, 4);

/* A wrong command line: names the help beside the reason. */
int fail_usage(const char *format, ...) PRINTF_LIKE(1, 2);

/* The system refused something: `doing` and what errno says. */
int fail_system(const char *place, const char *doing);

int fail_memory(const char *place);

/* A status of the library that the caller has no better words for. */
int fail_status(const char *place, qs_status status);

/* The name of a file for messages: "-" as what it stands for. */
const char *input_name(const char *path);
const char *output_name(const char *path);

#endif
