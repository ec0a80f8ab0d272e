/* qstereo: the commands and what is common to them. */
#include <stdio.h>
#include <string.h>

#include "command.h"
#include "completion.h"
#include "output.h"
#include "pictures/picture_library.h"
#include "progress_line.h"
#include "text/fail.h"
#include "text/names.h"

static const command *const commands[] = {
    &cmd_encode,  &cmd_reduce, &cmd_info,    &cmd_solve,   &cmd_validate, &cmd_verify,
    &cmd_decode,  &cmd_score,  &cmd_match,   &cmd_rectify, &cmd_depth,    &cmd_compare,
    &cmd_restore, &cmd_label,  &cmd_segment, &cmd_flow,    &cmd_register, &cmd_detect,
};
enum { COMMANDS = sizeof commands / sizeof commands[0] };

static void print_overview(FILE *file)
{
    fputs("usage: qstereo COMMAND [ARGUMENT]...\n\n"
          "Turns stereo matching and other labelling problems of computer vision into QUBOs\n"
          "for quantum annealers, and their samples into disparity maps, masks, pictures,\n"
          "flow fields and boxes.\n\nCommands:\n",
          file);
    for (size_t i = 0; i < COMMANDS; i++) {
        fprintf(file, "  %-10s%s\n", commands[i]->line.name, commands[i]->summary);
    }
    fputs("\nOptions:\n"
          "  -h, --help            print this text\n"
          "  -V, --version         print the version\n"
          "      --completion SH   print the completion script of a shell, bash or zsh\n\n"
          "qstereo COMMAND --help, or qstereo help COMMAND, explains a command.\n"
          "Exit status: 0 done, 1 the answer is no, 2 wrong usage, 3 bad input,\n"
          "4 files or resources.\n",
          file);
}

static int print_version(void)
{
    printf("qstereo %s (file format %d, pictures: %s)\n", QS_VERSION, QS_FORMAT_VERSION,
           picture_library_name());
    return DONE;
}

static int fail_unknown(const char *name)
{
    char list[256] = "";
    const char *kind = name[0] == '-' ? "option" : "command";
    suggestion suggested = suggest_for(name);
    for (size_t i = 0; i < COMMANDS; i++) {
        const char *known = commands[i]->line.name;
        size_t used = strlen(list);
        (void)snprintf(list + used, sizeof list - used, " %s", known);
        suggest_offer(&suggested, known);
    }
    if (suggested.nearest != NULL) {
        return fail_usage("unknown %s %s: did you mean %s? The commands are:%s", kind, name,
                          suggested.nearest, list);
    }
    return fail_usage("unknown %s %s: the commands are:%s", kind, name, list);
}

static int run_command(const char *name, int argc, char **argv)
{
    for (size_t i = 0; i < COMMANDS; i++) {
        if (strcmp(commands[i]->line.name, name) == 0) {
            const command *found =
                commands[i] == &cmd_encode ? encode_variant(argc, argv) : commands[i];
            return command_run(found, argc, argv);
        }
    }
    return fail_unknown(name);
}

static int run_help(int argc, char **argv)
{
    char help[] = "--help";
    char *words[] = {help, NULL};
    if (argc > 0) {
        return run_command(argv[0], 1, words);
    }
    print_overview(stdout);
    return DONE;
}

/* `shell` is the argument of --completion, NULL = none. */
static int print_completion(const char *shell)
{
    if (shell != NULL && strcmp(shell, "bash") == 0) {
        completion_bash(commands, COMMANDS);
        return DONE;
    }
    if (shell != NULL && strcmp(shell, "zsh") == 0) {
        completion_zsh(commands, COMMANDS);
        return DONE;
    }
    return fail_usage("--completion needs the name of a shell: bash or zsh");
}

static int run(int argc, char **argv)
{
    if (argc == 0) {
        print_overview(stderr);
        return BAD_USAGE;
    }
    if (strcmp(argv[0], "help") == 0 || strcmp(argv[0], "--help") == 0 ||
        strcmp(argv[0], "-h") == 0) {
        return run_help(argc - 1, argv + 1);
    }
    if (strcmp(argv[0], "--version") == 0 || strcmp(argv[0], "-V") == 0) {
        return print_version();
    }
    if (strcmp(argv[0], "--completion") == 0) {
        return print_completion(argc > 1 ? argv[1] : NULL);
    }
    return run_command(argv[0], argc - 1, argv + 1);
}

int main(int argc, char **argv)
{
    progress_start_command();
    output_watch_signals();
    int status = run(argc - 1, argv + 1);
    /* A result that could not be printed is a failure, unless there was one before. */
    if (status == DONE || status == ANSWER_NO) {
        int flushed = output_flush_standard();
        status = flushed != DONE ? flushed : status;
    }
    return status;
}
