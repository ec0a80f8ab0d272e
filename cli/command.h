/* What every command shares: its row in the table of main.c, and the frame that it runs in. */
#ifndef COMMAND_H
#define COMMAND_H

#include "inputs.h"
#include "output.h"
#include "text/options.h"

/* A command at work: what the frame has opened for it, and what the frame closes when it ends. */
typedef struct job {
    const arguments *given;
    const char *const *values; /* of the options, by index in the command's table */
    bool json; /* --json was given */
    budget limit; /* of --memory-limit: it owns the memory of the command */
    answer both; /* the files, after job_open_problem and job_open_samples */
    output outs[OUTPUTS_MAX]; /* appear if the command ends with DONE, else they are removed */
    size_t out_count;
    bool committed; /* they have their names */
} job;

typedef struct command {
    command_line line; /* its operands and options */
    const char *summary; /* a line of qstereo --help */
    int (*run)(job *at); /* returns an exit status */
} command;

/* Runs a command: reads its command line, or answers --help, opens its budget, does its work,
 * and closes everything. Returns an exit status. */
int command_run(const command *run, int argc, char **argv);

/* Opens the .qcf that is the first operand, and the .qsf that is the second one. Return DONE,
 * BAD_INPUT or NO_RESOURCE. */
int job_open_problem(job *at);
int job_open_samples(job *at);

/* Opens one more output; `path` is borrowed. Returns what output_open does, and BAD_USAGE if
 * another output is the same file. A command opens its outputs before long work, so that the work
 * is not in vain. */
int job_open_output(job *at, const char *path, output **opened);

/* The same for an output beside that of -o, which the option `long_name` asks for. Not standard
 * output: what the command says, or its other output, may go there. */
int job_open_beside(job *at, const char *long_name, const char *path, output **opened);

/* Gives the outputs their names. A command that prints a success calls it before that. If what is
 * printed cannot be, the frame takes the files back. Returns DONE or NO_RESOURCE. */
int job_commit(job *at);

/* Begins a line with the names of the outputs, `first` before the others: "map.png, mask.png: ". */
void job_print_outputs(const job *at, const char *first);

/* A part of a command's work whose outputs stay even if a later part fails: a frame of a sequence.
 * It has what memory the whole has left. The end makes its outputs stay if `status` is DONE, and
 * returns what became of it. */
job job_begin_part(const job *whole);
int job_end_part(job *part, int status);

/* A table of options, and how many there are. */
#define OPTIONS(table) .options = (table), .option_count = sizeof(table) / sizeof((table)[0])

/* The command encode for the --problem that is given, since each problem has operands and options
 * of its own. */
const command *encode_variant(int argc, char **argv);

extern const command cmd_encode;
extern const command cmd_reduce;
extern const command cmd_info;
extern const command cmd_solve;
extern const command cmd_validate;
extern const command cmd_verify;
extern const command cmd_decode;
extern const command cmd_score;
extern const command cmd_match;
extern const command cmd_rectify;
extern const command cmd_depth;
extern const command cmd_compare;
extern const command cmd_restore;
extern const command cmd_label;
extern const command cmd_segment;
extern const command cmd_flow;
extern const command cmd_register;
extern const command cmd_detect;

#endif
