/* What every command of qstereo shares: its face in the table of main.c, and the exit statuses. */
#ifndef COMMAND_H
#define COMMAND_H

/* Exit statuses, told apart by who can mend it. */
enum {
    DONE = 0,
    ANSWER_NO = 1, /* the question was well posed and the answer is no */
    BAD_USAGE = 2, /* the command line */
    BAD_INPUT = 3, /* what the files hold */
    NO_RESOURCE = 4 /* files that cannot be read or written, room, memory */
};

typedef struct command {
    const char *name;
    int (*run)(int argc,
               char **argv); /* the arguments after the command's name; returns an exit status */
    const char *summary;
} command;

int cmd_encode(int argc, char **argv);
int cmd_reduce(int argc, char **argv);
int cmd_info(int argc, char **argv);
int cmd_solve(int argc, char **argv);
int cmd_validate(int argc, char **argv);
int cmd_decode(int argc, char **argv);
int cmd_score(int argc, char **argv);
int cmd_match(int argc, char **argv);
int cmd_compare(int argc, char **argv);

#endif
