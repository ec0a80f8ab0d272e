#include "text/fail.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "text/plain.h"

static const char *current_command;

void fail_as(const char *name)
{
    current_command = name;
}

static void begin(const char *place)
{
    fputs("qstereo", stderr);
    if (current_command != NULL) {
        fprintf(stderr, " %s", current_command);
    }
    fputs(": ", stderr);
    if (place != NULL) {
        plain_print(stderr, place, strlen(place));
        fputs(": ", stderr);
    }
}

/* A message names what it is about, so text from outside is in it. One that is too long is cut. */
PRINTF_LIKE(1, 0) static void print_reason(const char *format, va_list arguments)
{
    char text[8192];
    (void)vsnprintf(text, sizeof text, format, arguments);
    plain_print(stderr, text, strlen(text));
}

void fail_say(const char *place, const char *format, ...)
{
    va_list arguments;
    begin(place);
    va_start(arguments, format);
    print_reason(format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

void warn(const char *place, const char *format, ...)
{
    va_list arguments;
    begin(place);
    fputs("warning: ", stderr);
    va_start(arguments, format);
    print_reason(format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

void fail_say_usage(const char *format, ...)
{
    va_list arguments;
    begin(NULL);
    va_start(arguments, format);
    print_reason(format, arguments);
    va_end(arguments);
    if (current_command != NULL) {
        fprintf(stderr, " (help: qstereo %s --help)\n", current_command);
    } else {
        fputs(" (help: qstereo --help)\n", stderr);
    }
}

int fail_system(const char *place, const char *doing)
{
    const char *reason = strerror(errno);
    return fail(NO_RESOURCE, place, "%s: %s", doing, reason);
}

int fail_memory(const char *place)
{
    return fail(NO_RESOURCE, place, "not enough memory");
}

static int exit_status(qs_status status)
{
    switch (status) {
    case QS_OK: return DONE;
    case QS_E_INFEASIBLE: return ANSWER_NO;
    case QS_E_ENCODING: return BAD_USAGE;
    case QS_E_LIMIT:
    case QS_E_OVERFLOW:
    case QS_E_FORMAT:
    case QS_E_UNSUPPORTED:
    case QS_E_CORRUPT:
    case QS_E_TRUNCATED:
    case QS_E_GEOMETRY: return BAD_INPUT;
    case QS_E_ARGUMENT:
    case QS_E_WORKSPACE:
    case QS_E_IO: break;
    }
    return NO_RESOURCE;
}

int fail_status(const char *place, qs_status status)
{
    return fail(exit_status(status), place, "%s", qs_status_text(status));
}

const char *input_name(const char *path)
{
    return strcmp(path, "-") == 0 ? "standard input" : path;
}

const char *output_name(const char *path)
{
    return strcmp(path, "-") == 0 ? "standard output" : path;
}
