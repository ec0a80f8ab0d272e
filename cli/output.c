/* realpath stands in the XSI part of POSIX. */
#define _XOPEN_SOURCE 700

#include "output.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "progress_line.h"
#include "text/fail.h"

/* What a signal handler has to remove. They change only while the signals are blocked. */
static char *temporaries[OUTPUTS_MAX];
static const char *made_folder;

static const int fatal_signals[] = {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE};
enum { FATAL_SIGNALS = sizeof fatal_signals / sizeof fatal_signals[0] };

static void remove_and_exit(int signal_number)
{
    for (int i = 0; i < OUTPUTS_MAX; i++) {
        if (temporaries[i] != NULL) {
            (void)unlink(temporaries[i]);
        }
    }
    if (made_folder != NULL) {
        (void)rmdir(made_folder);
    }
    progress_interrupt();
    _exit(128 + signal_number);
}

static sigset_t fatal_set(void)
{
    sigset_t set;
    (void)sigemptyset(&set);
    for (int i = 0; i < FATAL_SIGNALS; i++) {
        (void)sigaddset(&set, fatal_signals[i]);
    }
    return set;
}

void output_watch_signals(void)
{
    struct sigaction action, before;
    memset(&action, 0, sizeof action);
    action.sa_handler = remove_and_exit;
    action.sa_mask = fatal_set();
    for (int i = 0; i < FATAL_SIGNALS; i++) {
        /* A signal that the caller ignores, as nohup does, stays ignored. */
        if (sigaction(fatal_signals[i], NULL, &before) == 0 && before.sa_handler != SIG_IGN) {
            (void)sigaction(fatal_signals[i], &action, NULL);
        }
    }
    /* A write over the file size limit must fail. The signal would end the command and leave the
     * temporary behind. */
    action.sa_handler = SIG_IGN;
    (void)sigaction(SIGXFSZ, &action, NULL);
}

static sigset_t block_signals(void)
{
    sigset_t set = fatal_set(), before;
    (void)sigprocmask(SIG_BLOCK, &set, &before);
    return before;
}

static void unblock_signals(const sigset_t *before)
{
    (void)sigprocmask(SIG_SETMASK, before, NULL);
}

bool output_is_standard(const char *path)
{
    struct stat there, standard;
    if (strcmp(path, "-") == 0) {
        return true;
    }
    return stat(path, &there) == 0 && fstat(STDOUT_FILENO, &standard) == 0 &&
           there.st_dev == standard.st_dev && there.st_ino == standard.st_ino;
}

bool output_is_straight(const char *path)
{
    struct stat about;
    return output_is_standard(path) ||
           (stat(path, &about) == 0 && !S_ISREG(about.st_mode) && !S_ISDIR(about.st_mode));
}

/* A name in the folder of `target`, short enough for every file system. */
static char *temporary_name(const char *target, unsigned attempt)
{
    const char *slash = strrchr(target, '/');
    size_t folder = slash != NULL ? (size_t)(slash - target) + 1 : 0;
    char *name = malloc(folder + 64);
    if (name != NULL) {
        memcpy(name, target, folder);
        (void)snprintf(name + folder, 64, ".qstereo-%ld-%u.tmp", (long)getpid(), attempt);
    }
    return name;
}

/* Creates the temporary under a name that is not in use. It has the mode of a new file. */
static int create_temporary(output *out)
{
    int descriptor = -1;
    for (unsigned attempt = 0; attempt < 100 && descriptor < 0; attempt++) {
        char *name = temporary_name(out->target, attempt);
        if (name == NULL) {
            return -1;
        }
        sigset_t before = block_signals();
        descriptor = open(name, O_WRONLY | O_CREAT | O_EXCL, 0666);
        if (descriptor >= 0) {
            temporaries[out->slot] = name;
        }
        unblock_signals(&before);
        if (descriptor < 0) {
            int reason = errno;
            free(name);
            errno = reason;
            if (reason != EEXIST) {
                break;
            }
        }
    }
    return descriptor;
}

static void forget_temporary(output *out)
{
    free(temporaries[out->slot]);
    temporaries[out->slot] = NULL;
    free(out->target);
    out->target = NULL;
}

static void remove_temporary(output *out)
{
    if (out->target == NULL) {
        return;
    }
    sigset_t before = block_signals();
    (void)unlink(temporaries[out->slot]);
    forget_temporary(out);
    unblock_signals(&before);
}

static int free_slot(void)
{
    int slot = 0;
    while (slot + 1 < OUTPUTS_MAX && temporaries[slot] != NULL) {
        slot++;
    }
    return slot;
}

/* Follows a link, so that the file is replaced and not the link. A link that leads nowhere is
 * replaced itself. */
static char *resolved(const char *path, bool exists)
{
    char *target = exists ? realpath(path, NULL) : malloc(strlen(path) + 1);
    if (!exists && target != NULL) {
        memcpy(target, path, strlen(path) + 1);
    }
    return target;
}

/* Returns a descriptor to write to, -1 = see errno. */
static int open_target(output *out, const char *path)
{
    struct stat about;
    bool exists = stat(path, &about) == 0;
    if (output_is_standard(path)) {
        return dup(STDOUT_FILENO);
    }
    if (exists && !S_ISREG(about.st_mode)) {
        return open(path, O_WRONLY);
    }
    if (exists && access(path, W_OK) != 0) {
        return -1;
    }
    out->target = resolved(path, exists);
    if (out->target == NULL) {
        return -1;
    }
    int descriptor = create_temporary(out);
    if (descriptor >= 0 && exists) {
        (void)fchmod(descriptor, about.st_mode & 0777);
    }
    return descriptor;
}

int output_open(output *out, const char *path)
{
    *out = (output){NULL, output_name(path), NULL, free_slot(), 0};
    if (!output_is_standard(path) && file_was_read(path)) {
        return fail(BAD_USAGE, out->name,
                    "is an input of this command: name another file to write");
    }
    int descriptor = open_target(out, path);
    if (descriptor < 0) {
        int status = fail_system(out->name, "cannot be written");
        free(out->target);
        return status;
    }
    if (isatty(descriptor)) {
        (void)close(descriptor);
        return fail(
            BAD_USAGE, out->name,
            "is a terminal, which cannot show binary data: name a file or redirect the output");
    }
    out->file = fdopen(descriptor, "wb");
    if (out->file == NULL) {
        (void)close(descriptor);
        remove_temporary(out);
        return fail_memory(out->name);
    }
    (void)setvbuf(out->file, NULL, _IOFBF, 65536);
    return DONE;
}

bool output_write(output *out, const void *bytes, size_t size)
{
    if (fwrite(bytes, 1, size, out->file) == size) {
        return true;
    }
    out->error = errno;
    return false;
}

void output_write_file(output *out, const file_bytes *file)
{
    (void)output_write(out, file->bytes, file->size); /* output_commit reports a failure */
}

bool output_sink(void *out, const void *bytes, size_t size)
{
    return output_write(out, bytes, size);
}

static int close_output(output *out)
{
    int status = DONE;
    /* Some file systems cannot sync (EINVAL): that is not a failure. */
    if (out->error == 0 &&
        (fflush(out->file) != 0 ||
         (out->target != NULL && fsync(fileno(out->file)) != 0 && errno != EINVAL))) {
        out->error = errno;
    }
    if (fclose(out->file) != 0 && out->error == 0) {
        out->error = errno;
    }
    out->file = NULL;
    if (out->error != 0) {
        errno = out->error;
        status = fail_system(out->name, "cannot be written");
    }
    return status;
}

static int rename_temporary(output *out)
{
    if (out->target == NULL) {
        return DONE;
    }
    if (rename(temporaries[out->slot], out->target) != 0) {
        return fail_system(out->name, "cannot be written");
    }
    forget_temporary(out);
    return DONE;
}

int output_commit(output *outs, size_t count)
{
    int status = DONE;
    for (size_t i = 0; i < count; i++) {
        int closed = close_output(&outs[i]);
        if (status == DONE) {
            status = closed;
        }
    }
    if (status == DONE) {
        status = output_flush_standard();
    }
    sigset_t before = block_signals();
    for (size_t i = 0; i < count && status == DONE; i++) {
        status = rename_temporary(&outs[i]);
    }
    for (size_t i = 0; i < count; i++) {
        remove_temporary(&outs[i]);
    }
    unblock_signals(&before);
    return status;
}

void output_abandon(output *out)
{
    (void)fclose(out->file);
    out->file = NULL;
    remove_temporary(out);
}

int output_make_folder(const char *path)
{
    struct stat about;
    if (stat(path, &about) == 0 && S_ISDIR(about.st_mode)) {
        return DONE;
    }
    sigset_t before = block_signals();
    bool made = mkdir(path, 0777) == 0;
    int reason = errno;
    if (made) {
        made_folder = path;
    }
    unblock_signals(&before);
    errno = reason;
    return made ? DONE : fail_system(path, "cannot be made");
}

void output_keep_folder(void)
{
    made_folder = NULL;
}

void output_drop_folder(void)
{
    if (made_folder != NULL) {
        (void)rmdir(made_folder);
        made_folder = NULL;
    }
}

int output_flush_standard(void)
{
    if (fflush(stdout) != 0) {
        return fail_system("standard output", "cannot be written");
    }
    return ferror(stdout) ? fail(NO_RESOURCE, "standard output", "cannot be written") : DONE;
}
