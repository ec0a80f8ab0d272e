/* qstereo: the commands and what is common to them. */
#include <stdio.h>
#include <string.h>

#include "command.h"
#include "messages.h"
#include "output.h"
#include "picture.h"
#include "suggest.h"

static const command commands[] = {
    {"encode", cmd_encode, "turn a stereo pair into a QUBO file (.qcf)"},
    {"reduce", cmd_reduce, "leave out of a .qcf what is proven, so that little is left to solve"},
    {"info", cmd_info, "say what a .qcf or .qsf holds"},
    {"solve", cmd_solve, "solve a .qcf on this machine, with a lower bound of every energy"},
    {"validate", cmd_validate,
     "check the samples of a .qsf: which are feasible, are the energies true"},
    {"decode", cmd_decode, "turn a sample into a disparity map"},
    {"score", cmd_score, "compare a disparity map with the truth"},
    {"match", cmd_match, "encode, solve and decode in one go: a disparity map from a stereo pair"},
    {"compare", cmd_compare, "run solvers on one problem and print how good each is"},
};
enum { COMMANDS = sizeof commands / sizeof commands[0] };

static void print_overview(FILE *file)
{
    fputs("usage: qstereo COMMAND [ARGUMENT]...\n\nStereo matching as QUBOs for quantum "
          "annealers.\n\nCommands:\n",
          file);
    for (size_t i = 0; i < COMMANDS; i++) {
        fprintf(file, "  %-10s%s\n", commands[i].name, commands[i].summary);
    }
    fputs("\nqstereo COMMAND --help (or qstereo help COMMAND) explains a command, qstereo "
          "--version names the version.\n"
          "Exit status: 0 done, 1 the answer is no, 2 usage, 3 bad input, 4 files or resources.\n",
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
    suggestion suggested = suggest_for(name);
    for (size_t i = 0; i < COMMANDS; i++) {
        size_t used = strlen(list);
        (void)snprintf(list + used, sizeof list - used, " %s", commands[i].name);
        suggest_offer(&suggested, commands[i].name);
    }
    if (suggested.nearest != NULL) {
        return fail_usage("%s is no command: did you mean %s? The commands:%s", name,
                          suggested.nearest, list);
    }
    return fail_usage("%s is no command. The commands:%s", name, list);
}

static int run_command(const char *name, int argc, char **argv)
{
    for (size_t i = 0; i < COMMANDS; i++) {
        if (strcmp(commands[i].name, name) == 0) {
            messages_of(name);
            return commands[i].run(argc, argv);
        }
    }
    return fail_unknown(name);
}

static int run_help(int argc, char **argv)
{
    char help[] = "--help";
    char *arguments[] = {help, NULL};
    if (argc > 0) {
        return run_command(argv[0], 1, arguments);
    }
    print_overview(stdout);
    return DONE;
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
    if (strcmp(argv[0], "--version") == 0) {
        return print_version();
    }
    return run_command(argv[0], argc - 1, argv + 1);
}

int main(int argc, char **argv)
{
    output_watch_signals();
    int status = run(argc - 1, argv + 1);
    /* A result that did not get out is no result; but the first error wins. */
    if (status == DONE || status == ANSWER_NO) {
        int flushed = output_flush_standard();
        status = flushed != DONE ? flushed : status;
    }
    return status;
}
