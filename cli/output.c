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

/* All that end a command and may come from outside; SIGXCPU comes at the limit of CPU time. */
static const int fatal_signals[] = {SIGINT,  SIGTERM, SIGHUP,  SIGQUIT,   SIGPIPE, SIGALRM,
                                    SIGUSR1, SIGUSR2, SIGXCPU, SIGVTALRM, SIGPROF, SIGIO};
enum { FATAL_SIGNALS = sizeof fatal_signals / sizeof fatal_signals[0] };

/* The outputs are in place and what was to be said of them is said. */
static volatile sig_atomic_t settled;

static void remove_and_exit(int signal_number)
{
    if (settled) {
        return; /* too late: the status is that of what happened */
    }
    if (progress_takes_signal(signal_number)) {
        return;
    }
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

/* Creates the temporary under a name that is not in use. From the start it has no more rights than
 * `mode`. */
static int create_temporary(output *out, mode_t mode)
{
    int descriptor = -1;
    for (unsigned attempt = 0; attempt < 100 && descriptor < 0; attempt++) {
        char *name = temporary_name(out->target, attempt);
        if (name == NULL) {
            return -1;
        }
        sigset_t before = block_signals();
        descriptor = open(name, O_WRONLY | O_CREAT | O_EXCL, mode);
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

static void remove_temporary(output *out)
{
    if (temporaries[out->slot] != NULL) {
        sigset_t before = block_signals();
        (void)unlink(temporaries[out->slot]);
        free(temporaries[out->slot]);
        temporaries[out->slot] = NULL;
        unblock_signals(&before);
    }
}

static void forget_names(output *out)
{
    free(out->target);
    free(out->backup);
    out->target = out->backup = NULL;
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
    mode_t mode = exists ? about.st_mode & 0777 : 0666;
    out->replaced = exists;
    int descriptor = create_temporary(out, mode);
    if (descriptor >= 0 && exists) {
        (void)fchmod(descriptor, mode); /* what the umask took away */
    }
    return descriptor;
}

int output_open(output *out, const char *path)
{
    *out = (output){.name = output_name(path), .slot = free_slot()};
    if (!output_is_standard(path) && file_was_read(path)) {
        return fail(BAD_USAGE, out->name,
                    "is an input of this command: name another file to write");
    }
    int descriptor = open_target(out, path);
    if (descriptor < 0) {
        int status =
            fail_system(out->name, errno == ENOENT ? "cannot be written, make its folder first"
                                                   : "cannot be written");
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
        forget_names(out);
        return fail_memory(out->name);
    }
    (void)setvbuf(out->file, NULL, _IOFBF, 65536);
    return DONE;
}

/* The folder that a name is in, ending in "/."; NULL = no memory. */
static char *folder_of(const char *target)
{
    const char *slash = strrchr(target, '/');
    size_t length = slash != NULL ? (size_t)(slash - target) + 1 : 0;
    char *folder = malloc(length + 2);
    if (folder != NULL) {
        memcpy(folder, target, length);
        memcpy(folder + length, ".", 2);
    }
    return folder;
}

static bool is_same_file(const struct stat *a, const struct stat *b)
{
    return a->st_dev == b->st_dev && a->st_ino == b->st_ino;
}

/* The status of the folder that a name is in. Returns false if the system refuses it. */
static bool folder_status(const char *target, struct stat *about)
{
    char *folder = folder_of(target);
    bool found = folder != NULL && stat(folder, about) == 0;
    free(folder);
    return found;
}

static const char *last_part(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash != NULL ? slash + 1 : path;
}

static bool is_same_name(const char *a, const char *b)
{
    struct stat in_a, in_b;
    return strcmp(last_part(a), last_part(b)) == 0 && folder_status(a, &in_a) &&
           folder_status(b, &in_b) && is_same_file(&in_a, &in_b);
}

bool output_is_same(const output *a, const output *b)
{
    struct stat at_a, at_b;
    if (a->target != NULL && b->target != NULL) {
        return is_same_name(a->target, b->target) ||
               (lstat(a->target, &at_a) == 0 && lstat(b->target, &at_b) == 0 &&
                is_same_file(&at_a, &at_b));
    }
    bool both_straight = a->target == NULL && b->target == NULL;
    return both_straight && fstat(fileno(a->file), &at_a) == 0 &&
           fstat(fileno(b->file), &at_b) == 0 && !S_ISCHR(at_a.st_mode) &&
           is_same_file(&at_a, &at_b);
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

/* Gives the file that is to be replaced a second name, so that it can come back. Where the file
 * system has no links, or forbids this one, it cannot. */
static bool back_up(output *out)
{
    for (unsigned attempt = 0; attempt < 100; attempt++) {
        out->backup = temporary_name(out->target, 1000 + attempt);
        if (out->backup == NULL) {
            return false;
        }
        if (link(out->target, out->backup) == 0) {
            out->replaced = false;
            return true;
        }
        int reason = errno;
        free(out->backup);
        out->backup = NULL;
        if (reason != EEXIST) {
            break;
        }
    }
    return true;
}

/* Writes the folder of a file to the disk, so that a new name in it lasts. Some file systems cannot
 * (EINVAL), and some folders cannot be read (EACCES): that is no failure. */
static bool sync_folder(const char *target)
{
    char *folder = folder_of(target);
    if (folder == NULL) {
        return false;
    }
    int descriptor = open(folder, O_RDONLY);
    free(folder);
    if (descriptor < 0) {
        return errno == EACCES;
    }
    bool synced = fsync(descriptor) == 0 || errno == EINVAL;
    int reason = errno;
    (void)close(descriptor);
    errno = reason;
    return synced;
}

/* Puts a file in its place. Returns false if the system refused, and says why in errno. */
static bool put_in_place(output *out)
{
    if (!back_up(out)) {
        return false;
    }
    out->placed = rename(temporaries[out->slot], out->target) == 0;
    if (!out->placed) {
        return false;
    }
    free(temporaries[out->slot]);
    temporaries[out->slot] = NULL;
    return sync_folder(out->target);
}

/* Takes a file back from its place: what was there before is there again. */
static void take_back(output *out)
{
    if (out->placed && out->backup != NULL) {
        (void)rename(out->backup, out->target);
    } else if (out->placed && !out->replaced) {
        (void)unlink(out->target);
    } else if (out->backup != NULL) {
        (void)unlink(out->backup);
    }
    if (out->placed) {
        (void)sync_folder(out->target);
    }
    out->placed = false;
}

/* Returns true if a signal that ends the command has come while they waited. One that is ignored
 * waits, too, but ends nothing. */
static bool is_signal_waiting(void)
{
    sigset_t waiting;
    struct sigaction action;
    (void)sigpending(&waiting);
    for (int i = 0; i < FATAL_SIGNALS; i++) {
        if (sigismember(&waiting, fatal_signals[i]) == 1 &&
            sigaction(fatal_signals[i], NULL, &action) == 0 && action.sa_handler != SIG_IGN) {
            return true;
        }
    }
    return false;
}

int output_commit(output *outs, size_t count)
{
    int status = DONE;
    for (size_t i = 0; i < count; i++) {
        int closed = close_output(&outs[i]);
        status = status == DONE ? closed : status;
    }
    for (size_t i = 0; i < count && status == DONE; i++) {
        if (outs[i].target != NULL) {
            (void)block_signals();
            status = put_in_place(&outs[i]) ? DONE : fail_system(outs[i].name, "cannot be written");
        }
    }
    if (status == DONE && is_signal_waiting()) {
        status = NO_RESOURCE; /* output_settle takes the files back, and the signal comes then */
    }
    return status;
}

void output_settle(output *outs, size_t count, bool keep, bool last)
{
    for (size_t i = 0; i < count; i++) {
        if (outs[i].file != NULL) {
            (void)fclose(outs[i].file);
            outs[i].file = NULL;
        }
        if (!keep) {
            take_back(&outs[i]);
        } else if (outs[i].backup != NULL) {
            (void)unlink(outs[i].backup);
        }
        remove_temporary(&outs[i]);
        forget_names(&outs[i]);
    }
    settled = keep && last;
    const sigset_t fatal = fatal_set();
    (void)sigprocmask(SIG_UNBLOCK, &fatal, NULL);
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
