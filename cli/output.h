/* Files that appear whole or not at all. They are written under a temporary name in the same
 * folder, then renamed. The temporary is removed on failure, and if a signal ends the command.
 * Standard output and everything that is not a regular file (a device, a FIFO) are written
 * straight. */
#ifndef OUTPUT_H
#define OUTPUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "files.h"

typedef struct output {
    FILE *file;
    const char *name; /* for messages */
    char *target; /* the name that the temporary gets; NULL = written straight */
    char *backup; /* a second name of the file that was there; NULL = there is none */
    bool placed; /* the new file has its name */
    bool replaced; /* there was a file, and it has no second name */
    int slot; /* where the name of the temporary is kept */
    int error; /* errno of the first write that was refused */
} output;

/* The most that may be open at a time. */
enum { OUTPUTS_MAX = 65 };

/* Removes temporaries when a signal ends the command. Once, before any output is opened. */
void output_watch_signals(void);

/* Returns true if a path is where standard output goes, so that nothing else may be printed. */
bool output_is_standard(const char *path);

/* Returns true if a path is written straight: standard output, a device, a FIFO. */
bool output_is_straight(const char *path);

/* Opens an output; its path is borrowed. Refuses to write to a terminal, and over a file that was
 * read. Returns DONE, BAD_USAGE or NO_RESOURCE. After DONE it must be committed or abandoned, after
 * a failure not. */
int output_open(output *out, const char *path);

/* Returns true if two open outputs would be one file, under whatever names: the same name in the
 * same folder, two names (hard links) of a file that is there, or the same stream. A device is
 * never the same: what is written there is not mixed up with what else is. */
bool output_is_same(const output *a, const output *b);

/* Writes bytes. Returns false if the system refused them, which output_commit reports. */
bool output_write(output *out, const void *bytes, size_t size);

/* The same for a whole file. */
void output_write_file(output *out, const file_bytes *file);

/* The same as a qs_sink, whose context is the output. */
bool output_sink(void *out, const void *bytes, size_t size);

/* Closes all outputs and gives them their names: a success may be printed after that, not before.
 * From the first name on signals wait for output_settle. Returns DONE or NO_RESOURCE. */
int output_commit(output *outs, size_t count);

/* The end of all outputs, whether they were committed or not.
 *
 * keep  true = they stay; false = none of them does: what was there before is there again, but for
 *       a file on a file system without hard links, which stays replaced if it was committed
 * last  the command ends after it: if they stay, a signal comes too late, and the exit status is
 *       that of what happened */
void output_settle(output *outs, size_t count, bool keep, bool last);

/* Makes the folder `path` for outputs, if it does not exist; only one per command. `path` is
 * borrowed. Until output_keep_folder is called, output_drop_folder removes the folder, and so does
 * a signal that ends the command. Returns DONE or NO_RESOURCE. */
int output_make_folder(const char *path);
void output_keep_folder(void);
void output_drop_folder(void);

/* Flushes standard output. Returns DONE or NO_RESOURCE. */
int output_flush_standard(void);

#endif
