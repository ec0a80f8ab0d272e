/* How a command fails: exit statuses, and messages on standard error, one line each, as
 * `qstereo CMD: FILE: reason`. Each function returns the exit status that belongs to its message,
 * so that a caller can say `return fail(...)`. */
#ifndef FAIL_H
#define FAIL_H

#include "qstereo.h"

/* Exit statuses, told apart by who can mend it. */
enum {
    DONE = 0,
    ANSWER_NO = 1, /* the question was well posed and the answer is no */
    BAD_USAGE = 2, /* the command line */
    BAD_INPUT = 3, /* what the files hold */
    NO_RESOURCE = 4 /* files that cannot be read or written, no room, no memory */
};

/* Runs a step that returns an exit status. If it failed, the function that stands around it
 * returns that status at once. So a function with something to close must not use it: it calls
 * another function that does, and closes afterwards. */
#define TRY(step)                                                                                  \
    do {                                                                                           \
        const int step_status = (step);                                                            \
        if (step_status != DONE) {                                                                 \
            return step_status;                                                                    \
        }                                                                                          \
    } while (0)

#if defined(__GNUC__)
#define PRINTF_LIKE(text, first) __attribute__((format(printf, text, first)))
#else
#define PRINTF_LIKE(text, first)
#endif

/* From now on messages come from the command `name`. */
void fail_as(const char *name);

/* fail(status, place, format, ...) prints the reason, and `place` before it: the file or option
 * concerned, NULL = none. It is the exit status `status`: as a macro, so that compilers and
 * analysers see that a step that failed is never DONE. */
#define fail(status, ...) (fail_say(__VA_ARGS__), (status))
void fail_say(const char *place, const char *format, ...) PRINTF_LIKE(2, 3);

/* fail_usage(format, ...), a wrong command line: prints the reason and how to get help. It is
 * BAD_USAGE. */
#define fail_usage(...) (fail_say_usage(__VA_ARGS__), BAD_USAGE)
void fail_say_usage(const char *format, ...) PRINTF_LIKE(1, 2);

/* Says something that may be a mistake, but does not stop the command. */
void warn(const char *place, const char *format, ...) PRINTF_LIKE(2, 3);

/* The system refused something: prints what was being done and what errno says. Returns
 * NO_RESOURCE, as fail_memory does. */
int fail_system(const char *place, const char *doing);
int fail_memory(const char *place);

/* The library returned a status for which the caller has no better words. */
int fail_status(const char *place, qs_status status);

/* The name of a file in messages: "-" is called standard input, or standard output. */
const char *input_name(const char *path);
const char *output_name(const char *path);

#endif
