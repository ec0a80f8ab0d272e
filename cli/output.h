/* Files that appear whole or not at all: written under a temporary name in the same folder, then
 * renamed. The temporary is removed on failure and when a signal ends the command. Standard output
 * and whatever is no regular file (a device, a FIFO) are written straight. */
#ifndef OUTPUT_H
#define OUTPUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

typedef struct output {
    FILE *file;
    const char *name; /* for messages */
    char *target; /* what the temporary becomes; NULL = written straight */
    int slot; /* of the temporary's name */
    int error; /* errno of the first write that was refused */
} output;

/* The most that may be open at a time. */
enum { OUTPUTS_MAX = 64 };

/* Removes temporaries when SIGINT, SIGTERM, SIGHUP, SIGQUIT or SIGPIPE ends the command. Once,
 * before any output is opened. */
void output_watch_signals(void);

/* Whether a path is where standard output goes, so that nothing else may be printed. */
bool output_is_standard(const char *path);

/* Whether a path is written straight: standard output, a device, a FIFO. */
bool output_is_straight(const char *path);

/* Opens an output; its path is borrowed. Refuses to write to a terminal, and over a file that was
 * read. Returns DONE, BAD_USAGE or NO_RESOURCE; only after DONE it must be committed or abandoned.
 */
int output_open(output *out, const char *path);

/* Writes bytes; false = the system refused, which output_commit reports. */
bool output_write(output *out, const void *bytes, size_t size);

/* Makes all outputs appear, after what was printed on standard output has got there: all or, on
 * failure, none. They are closed in any case. Returns DONE or NO_RESOURCE. */
int output_commit(output *outs, size_t count);

/* Closes an output and removes what was written. */
void output_abandon(output *out);

/* Makes the folder `path`, borrowed, for outputs where there is none; one at a time. Until
 * output_keep_folder it is removed by output_drop_folder or a signal that ends the command. Returns
 * DONE or NO_RESOURCE. */
int output_make_folder(const char *path);
void output_keep_folder(void);
void output_drop_folder(void);

/* Flushes standard output. Returns DONE or NO_RESOURCE. */
int output_flush_standard(void);

#endif
