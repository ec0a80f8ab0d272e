#include "text/options.h"

#include <stdio.h>
#include <string.h>

#include "text/fail.h"
#include "text/names.h"

enum { HELP_WIDTH = 80 };

/* Prints what stands before the help of an option: "  -o, --output FILE". Returns its width. Prints
 * nothing if `file` is NULL. */
static int print_option(FILE *file, const option *known)
{
    char text[80];
    char letter[5] = "    ";
    if (known->letter != 0) {
        (void)snprintf(letter, sizeof letter, "-%c, ", known->letter);
    }
    int width = snprintf(text, sizeof text, "  %s--%s%s%s", letter, known->name,
                         known->argument != NULL ? " " : "",
                         known->argument != NULL ? known->argument : "");
    if (file != NULL) {
        fputs(text, file);
    }
    return width;
}

static size_t operand_count(const command_line *line)
{
    size_t count = 0;
    while (count < OPERANDS_MAX && line->operands[count] != NULL) {
        count++;
    }
    return count;
}

static void print_usage(const command_line *line)
{
    size_t count = operand_count(line);
    printf("usage: qstereo %s", line->name);
    for (size_t i = 0; i < count; i++) {
        printf(i + line->optional < count ? " %s" : " [%s]", line->operands[i]);
    }
    for (size_t i = 0; i < line->option_count; i++) {
        const option *known = &line->options[i];
        char letter[3] = {'-', known->letter, '\0'};
        if (known->required) {
            printf(" %s%s %s", known->letter != 0 ? letter : "--",
                   known->letter != 0 ? "" : known->name, known->argument);
        }
    }
    puts(" [OPTION]...");
}

/* Prints a text from the column `indent` on, and breaks its lines before HELP_WIDTH. */
static void print_wrapped(const char *text, int indent)
{
    int column = indent;
    while (*text != '\0') {
        int word = (int)strcspn(text, " \n");
        if (column > indent && column + 1 + word > HELP_WIDTH) {
            printf("\n%*s", indent, "");
            column = indent;
        } else if (column > indent) {
            putchar(' ');
            column++;
        }
        printf("%.*s", word, text);
        column += word;
        text += word;
        if (*text == '\n') {
            printf("\n%*s", indent, "");
            column = indent;
        }
        text += *text != '\0';
    }
}

static void print_option_help(const option *known, int indent)
{
    char text[512];
    int width = print_option(stdout, known);
    (void)snprintf(text, sizeof text, "%s%s%s%s", known->help,
                   known->preset != NULL ? " (default " : "",
                   known->preset != NULL ? known->preset : "", known->preset != NULL ? ")" : "");
    printf("%*s", indent - width, "");
    print_wrapped(text, indent);
    putchar('\n');
}

static void print_help(const command_line *line)
{
    static const option help = {.name = "help", .letter = 'h', .help = "print this text"};
    int widest = print_option(NULL, &help);
    for (size_t i = 0; i < line->option_count; i++) {
        int width = print_option(NULL, &line->options[i]);
        widest = width > widest ? width : widest;
    }
    print_usage(line);
    putchar('\n');
    print_wrapped(line->about, 0);
    puts("\nOptions, before or after the operands (-- ends them):");
    for (size_t i = 0; i < line->option_count; i++) {
        print_option_help(&line->options[i], widest + 2);
    }
    print_option_help(&help, widest + 2);
    printf("\nExamples:\n%s", line->examples);
}

size_t options_find(const command_line *line, const char *name, size_t length)
{
    for (size_t i = 0; i < line->option_count; i++) {
        const char *known = line->options[i].name;
        if (strlen(known) == length && memcmp(known, name, length) == 0) {
            return i;
        }
    }
    return line->option_count;
}

static size_t find_letter(const command_line *line, char letter)
{
    size_t i = 0;
    while (i < line->option_count && line->options[i].letter != letter) {
        i++;
    }
    return i;
}

static int fail_unknown(const command_line *line, const char *text, size_t length)
{
    char list[1024] = "", typed[64];
    (void)snprintf(typed, sizeof typed, "%.*s",
                   (int)(length < sizeof typed ? length : sizeof typed), text);
    suggestion suggested = suggest_for(typed + strspn(typed, "-"));
    for (size_t i = 0; i < line->option_count; i++) {
        size_t used = strlen(list);
        (void)snprintf(list + used, sizeof list - used, " --%s", line->options[i].name);
        suggest_offer(&suggested, line->options[i].name);
    }
    if (suggested.nearest != NULL) {
        return fail_usage("unknown option %s: did you mean --%s?", typed, suggested.nearest);
    }
    return fail_usage("unknown option %s: the options are:%s", typed, list);
}

/* Where the parser is: argv[next] is the next word to read. */
typedef struct cursor {
    const command_line *line;
    int argc, next;
    char **argv;
    arguments *read;
    size_t operand_count;
} cursor;

static int keep_value(arguments *read, size_t index, const char *value)
{
    if (read->given_count == GIVEN_MAX) {
        return fail_usage("more than %d options are given: that is the most", GIVEN_MAX);
    }
    read->values[index] = value;
    read->given[read->given_count].index = index;
    read->given[read->given_count++].value = value;
    return DONE;
}

/* Takes the argument of an option, after its = or from the next word. */
static int take_value(cursor *at, size_t index, const char *spelled, const char *attached)
{
    const option *known = &at->line->options[index];
    if (known->argument == NULL) {
        return attached == NULL ? keep_value(at->read, index, "")
                                : fail_usage("--%s takes no argument", known->name);
    }
    if (attached == NULL) {
        /* A word that looks like a long option is hardly meant to be the argument. */
        if (at->next == at->argc || strncmp(at->argv[at->next], "--", 2) == 0) {
            return fail_usage("%s needs an argument: %s", spelled, known->argument);
        }
        attached = at->argv[at->next++];
    }
    if (*attached == '\0') {
        return fail_usage("%s: the argument %s is empty", spelled, known->argument);
    }
    return keep_value(at->read, index, attached);
}

static int take_values(cursor *at, size_t index, const char *spelled, const char *attached)
{
    TRY(take_value(at, index, spelled, attached));
    return at->line->options[index].twice ? take_value(at, index, spelled, NULL) : DONE;
}

static int take_long(cursor *at, const char *word)
{
    const char *equals = strchr(word, '=');
    size_t length = equals != NULL ? (size_t)(equals - word) : strlen(word);
    size_t index = options_find(at->line, word + 2, length - 2);
    char spelled[64];
    if (index == at->line->option_count) {
        return fail_unknown(at->line, word, length);
    }
    (void)snprintf(spelled, sizeof spelled, "--%s", at->line->options[index].name);
    return take_values(at, index, spelled, equals != NULL ? equals + 1 : NULL);
}

static int take_short(cursor *at, const char *word)
{
    size_t index = find_letter(at->line, word[1]);
    const char spelled[3] = {'-', word[1], '\0'};
    if (index == at->line->option_count) {
        return fail_unknown(at->line, word, strlen(word));
    }
    return take_values(at, index, spelled, word[2] != '\0' ? word + 2 : NULL);
}

static int take_operand(cursor *at, const char *word)
{
    if (at->operand_count == OPERANDS_MAX || at->line->operands[at->operand_count] == NULL) {
        return fail_usage("%s is one operand too many: leave it out", word);
    }
    if (*word == '\0') {
        return fail_usage("the operand %s is empty", at->line->operands[at->operand_count]);
    }
    at->read->operands[at->operand_count++] = word;
    return DONE;
}

static int fail_missing(const option *missing)
{
    return missing->letter != 0
               ? fail_usage("-%c %s is missing", missing->letter, missing->argument)
               : fail_usage("--%s %s is missing", missing->name, missing->argument);
}

static int check_needs(const cursor *at)
{
    for (size_t i = 0; i < at->read->given_count; i++) {
        const option *given = &at->line->options[at->read->given[i].index];
        size_t other = given->needs != NULL
                           ? options_find(at->line, given->needs, strlen(given->needs))
                           : at->line->option_count;
        if (other < at->line->option_count && at->read->values[other] == NULL) {
            return fail_usage("--%s goes with --%s: add --%s", given->name, given->needs,
                              given->needs);
        }
    }
    return DONE;
}

static int check_complete(const cursor *at)
{
    const command_line *line = at->line;
    size_t standard_inputs = 0;
    if (at->operand_count + line->optional < operand_count(line)) {
        return fail_usage("the operand %s is missing", line->operands[at->operand_count]);
    }
    for (size_t i = 0; i < line->option_count; i++) {
        if (line->options[i].required && at->read->values[i] == NULL) {
            return fail_missing(&line->options[i]);
        }
    }
    TRY(check_needs(at));
    for (size_t i = 0; i < at->operand_count; i++) {
        standard_inputs += strcmp(at->read->operands[i], "-") == 0;
    }
    return standard_inputs > 1 ? fail_usage("only one operand can be -, which is standard input")
                               : DONE;
}

static int take_words(cursor *at)
{
    bool options_ended = false;
    while (at->next < at->argc) {
        const char *word = at->argv[at->next++];
        if (options_ended || word[0] != '-' || word[1] == '\0') {
            TRY(take_operand(at, word));
        } else if (strcmp(word, "--") == 0) {
            options_ended = true;
        } else if (word[1] == '-') {
            TRY(take_long(at, word));
        } else {
            TRY(take_short(at, word));
        }
    }
    return check_complete(at);
}

static bool asks_for_help(int argc, char **argv)
{
    for (int i = 0; i < argc && strcmp(argv[i], "--") != 0; i++) {
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
            return true;
        }
    }
    return false;
}

bool options_read(const command_line *line, int argc, char **argv, arguments *read, int *status)
{
    cursor at = {line, argc, 0, argv, read, 0};
    if (asks_for_help(argc, argv)) {
        print_help(line);
        *status = DONE;
        return false;
    }
    memset(read, 0, sizeof *read);
    for (size_t i = 0; i < line->option_count; i++) {
        read->values[i] = line->options[i].preset;
    }
    *status = take_words(&at);
    return *status == DONE;
}

const char *options_next(const arguments *read, size_t index, size_t *at)
{
    while (*at < read->given_count && read->given[*at].index != index) {
        ++*at;
    }
    return *at < read->given_count ? read->given[(*at)++].value : NULL;
}
