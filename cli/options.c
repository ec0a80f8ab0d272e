#include "options.h"

#include <stdio.h>
#include <string.h>

#include "messages.h"
#include "suggest.h"

/* What stands before an option's help: "  -o, --output FILE". Returns its width; prints nothing
 * where `file` is NULL.
 */
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
        if (line->options[i].required) {
            printf(" -%c %s", line->options[i].letter, line->options[i].argument);
        }
    }
    puts(" [OPTION]...");
}

static void print_help(const command_line *line)
{
    static const option help = {.name = "help", .letter = 'h', .help = "this text"};
    int widest = print_option(NULL, &help);
    for (size_t i = 0; i < line->option_count; i++) {
        int width = print_option(NULL, &line->options[i]);
        if (width > widest) {
            widest = width;
        }
    }
    print_usage(line);
    printf("\n%s\nOptions, before or after the operands (-- ends them):\n", line->about);
    for (size_t i = 0; i <= line->option_count; i++) {
        const option *known = i < line->option_count ? &line->options[i] : &help;
        printf("%*s%s", widest + 2 - print_option(stdout, known), "", known->help);
        if (known->preset != NULL) {
            printf(" (default %s)", known->preset);
        }
        putchar('\n');
    }
    printf("\nExamples:\n%s", line->examples);
}

/* The index of the option that `text` (after its dashes) names; option_count = unknown. */
static size_t find_long(const command_line *line, const char *text, size_t length)
{
    size_t i = 0;
    while (i < line->option_count && !(strlen(line->options[i].name) == length &&
                                       memcmp(line->options[i].name, text, length) == 0)) {
        i++;
    }
    return i;
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
        return fail_usage("%s is no option: did you mean --%s? The options:%s", typed,
                          suggested.nearest, list);
    }
    return fail_usage("%s is no option. The options:%s", typed, list);
}

/* Where the parser stands: argv[next] is the argument after the one being read. */
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
        return fail_usage("more than %d options", GIVEN_MAX);
    }
    read->values[index] = value;
    read->given[read->given_count].index = index;
    read->given[read->given_count++].value = value;
    return DONE;
}

/* Takes the option's argument, from after its = or from the next word. */
static int take_value(cursor *at, size_t index, const char *spelled, const char *attached)
{
    const option *known = &at->line->options[index];
    if (known->argument == NULL) {
        return attached == NULL ? keep_value(at->read, index, "")
                                : fail_usage("--%s takes no argument", known->name);
    }
    if (attached == NULL) {
        /* A word that looks like a long option was hardly meant as the argument. */
        if (at->next == at->argc || strncmp(at->argv[at->next], "--", 2) == 0) {
            return fail_usage("%s needs its argument, %s", spelled, known->argument);
        }
        attached = at->argv[at->next++];
    }
    if (*attached == '\0') {
        return fail_usage("%s: the argument %s is empty", spelled, known->argument);
    }
    return keep_value(at->read, index, attached);
}

static int take_long(cursor *at, const char *word)
{
    const char *equals = strchr(word, '=');
    size_t length = equals != NULL ? (size_t)(equals - word) : strlen(word);
    size_t index = find_long(at->line, word + 2, length - 2);
    char spelled[64];
    if (index == at->line->option_count) {
        return fail_unknown(at->line, word, length);
    }
    (void)snprintf(spelled, sizeof spelled, "--%s", at->line->options[index].name);
    return take_value(at, index, spelled, equals != NULL ? equals + 1 : NULL);
}

static int take_short(cursor *at, const char *word)
{
    size_t index = find_letter(at->line, word[1]);
    const char spelled[3] = {'-', word[1], '\0'};
    if (index == at->line->option_count) {
        return fail_unknown(at->line, word, strlen(word));
    }
    return take_value(at, index, spelled, word[2] != '\0' ? word + 2 : NULL);
}

static int take_operand(cursor *at, const char *word)
{
    if (at->operand_count == OPERANDS_MAX || at->line->operands[at->operand_count] == NULL) {
        return fail_usage("%s is one operand too many", word);
    }
    if (*word == '\0') {
        return fail_usage("the operand %s is empty", at->line->operands[at->operand_count]);
    }
    at->read->operands[at->operand_count++] = word;
    return DONE;
}

static int take_words(cursor *at)
{
    bool options_ended = false;
    int status = DONE;
    while (status == DONE && at->next < at->argc) {
        const char *word = at->argv[at->next++];
        if (options_ended || word[0] != '-' || word[1] == '\0') {
            status = take_operand(at, word);
        } else if (strcmp(word, "--") == 0) {
            options_ended = true;
        } else if (word[1] == '-') {
            status = take_long(at, word);
        } else {
            status = take_short(at, word);
        }
    }
    return status;
}

static int check_complete(const cursor *at)
{
    const command_line *line = at->line;
    size_t inputs = 0;
    if (at->operand_count + line->optional < operand_count(line)) {
        return fail_usage("the operand %s is missing", line->operands[at->operand_count]);
    }
    for (size_t i = 0; i < line->option_count; i++) {
        if (line->options[i].required && at->read->values[i] == NULL) {
            return fail_usage("-%c %s is missing", line->options[i].letter,
                              line->options[i].argument);
        }
    }
    for (size_t i = 0; i < at->operand_count; i++) {
        inputs += strcmp(at->read->operands[i], "-") == 0;
    }
    return inputs > 1 ? fail_usage("only one operand can be -, standard input") : DONE;
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
    if (*status == DONE) {
        *status = check_complete(&at);
    }
    return *status == DONE;
}

const char *options_next(const arguments *read, size_t index, size_t *at)
{
    while (*at < read->given_count && read->given[*at].index != index) {
        ++*at;
    }
    return *at < read->given_count ? read->given[(*at)++].value : NULL;
}
