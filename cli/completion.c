#include "completion.h"

#include <stdio.h>
#include <string.h>

#include "presets.h"
#include "solving.h"
#include "text/names.h"

static const char *smoothness_at(size_t index)
{
    return name_at(&smoothness_names, index);
}

static const char *penalty_at(size_t index)
{
    return name_at(&penalty_names, index);
}

static const char *palette_at(size_t index)
{
    return name_at(&palette_names, index);
}

static const char *unit_at(size_t index)
{
    return name_at(&unit_names, index);
}

/* The options that take one of some names. All others take a number or a file. */
static const struct {
    const char *option;
    const char *(*name_at)(size_t index);
} named_options[] = {
    {"encoding", encoding_at}, {"smoothness", smoothness_at}, {"penalty", penalty_at},
    {"solver", solver_at},     {"preset", preset_at},         {"palette", palette_at},
    {"unit", unit_at},
};
enum { NAMED_OPTIONS = sizeof named_options / sizeof named_options[0] };

/* Prints the names that an option takes: `before`, the names with blanks between, `after`. Prints
 * `instead` if it takes none. */
static void print_choices(const char *option_name, const char *before, const char *after,
                          const char *instead)
{
    for (size_t i = 0; i < NAMED_OPTIONS; i++) {
        if (strcmp(named_options[i].option, option_name) == 0) {
            fputs(before, stdout);
            for (size_t n = 0; named_options[i].name_at(n) != NULL; n++) {
                printf(n > 0 ? " %s" : "%s", named_options[i].name_at(n));
            }
            fputs(after, stdout);
            return;
        }
    }
    fputs(instead, stdout);
}

static void print_names(const command *const *commands, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        printf("%s ", commands[i]->line.name);
    }
    fputs("help", stdout);
}

/* The spellings of all options of a command: all, or those that take an argument. */
static void print_options(const command_line *line, bool with_argument, const char *separator)
{
    const char *between = "";
    for (size_t i = 0; i < line->option_count; i++) {
        const option *known = &line->options[i];
        if (with_argument && known->argument == NULL) {
            continue;
        }
        if (known->letter != 0) {
            printf("%s-%c", between, known->letter);
            between = separator;
        }
        printf("%s--%s", between, known->name);
        between = separator;
    }
    if (!with_argument) {
        printf("%s-h%s--help", between, separator);
    }
}

/* Every command has options with an argument, so that no pattern of the case is empty. */
void completion_bash(const command *const *commands, size_t count)
{
    fputs("# bash completion for qstereo, printed by qstereo --completion bash\n"
          "_qstereo()\n{\n"
          "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} options=\n"
          "    COMPREPLY=()\n"
          "    if [ \"$COMP_CWORD\" -eq 1 ] || { [ \"$COMP_CWORD\" -eq 2 ] && "
          "[ \"$before\" = help ]; }; then\n"
          "        COMPREPLY=($(compgen -W \"",
          stdout);
    print_names(commands, count);
    fputs(" -h --help -V --version --completion\" -- \"$word\"))\n        return\n    fi\n"
          "    local names=\n"
          "    case $before in\n"
          "    --completion) names=\"bash zsh\" ;;\n",
          stdout);
    for (size_t i = 0; i < NAMED_OPTIONS; i++) {
        printf("    --%s) names=", named_options[i].option);
        print_choices(named_options[i].option, "\"", "\" ;;\n", "");
    }
    fputs("    esac\n"
          "    if [ \"$names\" ]; then\n"
          "        COMPREPLY=($(compgen -W \"$names\" -- \"$word\"))\n        return\n    fi\n"
          "    case ${COMP_WORDS[1]} in\n",
          stdout);
    for (size_t i = 0; i < count; i++) {
        printf("    %s)\n        case $before in ", commands[i]->line.name);
        print_options(&commands[i]->line, true, "|");
        fputs(") ;; *) options=\"", stdout);
        print_options(&commands[i]->line, false, " ");
        fputs("\" ;; esac ;;\n", stdout);
    }
    fputs("    esac\n"
          "    case $word in\n"
          "    -*) COMPREPLY=($(compgen -W \"$options\" -- \"$word\")) ;;\n"
          "    *) COMPREPLY=($(compgen -f -- \"$word\")) ;;\n"
          "    esac\n}\n"
          "complete -o filenames -F _qstereo qstereo\n",
          stdout);
}

/* Text between single quotes inside of brackets or after a colon of zsh's _arguments. */
static void print_quoted(const char *text)
{
    for (; *text != '\0'; text++) {
        switch (*text) {
        case '\'': fputs("'\\''", stdout); break;
        case ':':
        case '[':
        case ']':
        case '\\': printf("\\%c", *text); break;
        default: putchar(*text);
        }
    }
}

static void print_zsh_spelling(const option *known, const char *spelling)
{
    printf(" \\\n            '*%s[", spelling);
    print_quoted(known->help);
    putchar(']');
    if (known->argument != NULL) {
        putchar(':');
        print_quoted(known->argument);
        print_choices(known->name, ":(", ")", ":_files");
    }
    putchar('\'');
}

static void print_zsh_command(const command_line *line)
{
    char spelling[64];
    printf("    %s)\n        _arguments", line->name);
    for (size_t i = 0; i < line->option_count; i++) {
        const option *known = &line->options[i];
        if (known->letter != 0) {
            (void)snprintf(spelling, sizeof spelling, "-%c", known->letter);
            print_zsh_spelling(known, spelling);
        }
        (void)snprintf(spelling, sizeof spelling, "--%s", known->name);
        print_zsh_spelling(known, spelling);
    }
    fputs(" \\\n            '(-h --help)'{-h,--help}'[print the help]' '*:file:_files' ;;\n",
          stdout);
}

void completion_zsh(const command *const *commands, size_t count)
{
    fputs("#compdef qstereo\n"
          "# zsh completion for qstereo, printed by qstereo --completion zsh\n"
          "_qstereo()\n{\n"
          "    local -a commands\n"
          "    commands=(\n",
          stdout);
    for (size_t i = 0; i < count; i++) {
        printf("        '%s:", commands[i]->line.name);
        print_quoted(commands[i]->summary);
        fputs("'\n", stdout);
    }
    fputs("        'help:explain a command'\n    )\n"
          "    if (( CURRENT == 2 )); then\n"
          "        _describe command commands\n"
          "        _arguments '(-h --help)'{-h,--help}'[print the help]' \\\n"
          "            '(-V --version)'{-V,--version}'[print the version]' \\\n"
          "            '--completion[print a completion script]:shell:(bash zsh)'\n"
          "        return\n    fi\n"
          "    shift words\n"
          "    (( CURRENT-- ))\n"
          "    case $words[1] in\n"
          "    help) _describe command commands ;;\n",
          stdout);
    for (size_t i = 0; i < count; i++) {
        print_zsh_command(&commands[i]->line);
    }
    fputs("    esac\n}\n"
          "if [ \"$funcstack[1]\" = _qstereo ]; then\n"
          "    _qstereo \"$@\"\n"
          "else\n"
          "    compdef _qstereo qstereo\n"
          "fi\n",
          stdout);
}
