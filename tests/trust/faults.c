/* A library to preload (LD_PRELOAD) that lets one call of a program fail: x86-64 Linux.
 *
 * FAULT=NAME:K[:ERRNO]  the K-th call of NAME fails: write, close, rename, fsync or malloc. Counted
 *                       are the closes of what was open for writing, and as malloc all of malloc,
 *                       calloc and realloc. K = 0: none fails
 *                       ERRNO below 0: the process sends itself signal -ERRNO before the call
 * FAULT_COUNT=FILE      at the end the number of calls that were counted is written there
 *
 * System calls are caught by seccomp, so that those inside the C library are seen too. Threads may
 * come; processes that the program starts would be killed. */
#define _GNU_SOURCE

#include <errno.h>
#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

/* The one place whose system calls are let through. */
extern const char straight_start[], straight_end[];
__asm__(".text\n"
        "straight_start:\n"
        "straight: mov %rdi, %rax; mov %rsi, %rdi; mov %rdx, %rsi; mov %rcx, %rdx\n"
        "mov %r8, %r10; mov %r9, %r8; xor %r9, %r9; syscall; ret\n"
        "straight_end:\n");
long straight(long number, long a, long b, long c, long d, long e);

static const struct {
    const char *name;
    long numbers[3];
} calls[] = {
    {"write", {SYS_write, SYS_writev, SYS_pwrite64}},
    {"close", {SYS_close, SYS_close, SYS_close}},
    {"rename", {SYS_rename, SYS_renameat, SYS_renameat2}},
    {"fsync", {SYS_fsync, SYS_fdatasync, SYS_fsync}},
};

static unsigned long fails_at, counted;
static int reason = ENOSPC;
static bool armed_memory;

static bool is_due(void)
{
    return __atomic_add_fetch(&counted, 1, __ATOMIC_RELAXED) == fails_at;
}

static void caught(int signal_number, siginfo_t *about, void *context)
{
    greg_t *r = ((ucontext_t *)context)->uc_mcontext.gregs;
    (void)signal_number;
    bool counts = true;
    if (about->si_syscall == SYS_close) {
        long flags = straight(SYS_fcntl, r[REG_RDI], F_GETFL, 0, 0, 0);
        counts = flags >= 0 && (flags & O_ACCMODE) != O_RDONLY;
    }
    bool due = counts && is_due();
    if (due && reason < 0) {
        kill(getpid(), -reason);
        due = false;
    }
    if (due && about->si_syscall != SYS_close) {
        r[REG_RAX] = -reason;
        return;
    }
    /* As on Linux, a close that fails closes the file nevertheless. */
    long result =
        straight(about->si_syscall, r[REG_RDI], r[REG_RSI], r[REG_RDX], r[REG_R10], r[REG_R8]);
    r[REG_RAX] = due ? -reason : result;
}

static void catch_calls(const long numbers[3])
{
    uintptr_t from = (uintptr_t)straight_start, to = (uintptr_t)straight_end;
    struct sock_filter filter[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (uint32_t)numbers[0], 3, 0),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (uint32_t)numbers[1], 2, 0),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (uint32_t)numbers[2], 1, 0),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, instruction_pointer)),
        BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, (uint32_t)from, 0, 2),
        BPF_JUMP(BPF_JMP | BPF_JGT | BPF_K, (uint32_t)to, 1, 0),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP),
    };
    struct sock_fprog program = {sizeof filter / sizeof *filter, filter};
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_sigaction = caught;
    action.sa_flags = SA_SIGINFO | SA_NODEFER;
    if (sigaction(SIGSYS, &action, NULL) != 0 || prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 ||
        prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) != 0) {
        abort();
    }
}

void faults_begin(void);
void faults_end(void);

__attribute__((constructor)) void faults_begin(void)
{
    char *fault = getenv("FAULT"), *at = fault ? strchr(fault, ':') : NULL;
    if (!at) {
        return;
    }
    fails_at = strtoul(at + 1, &at, 10);
    reason = *at == ':' ? atoi(at + 1) : ENOSPC;
    for (size_t i = 0; i < sizeof calls / sizeof *calls; i++) {
        if (strncmp(fault, calls[i].name, strlen(calls[i].name)) == 0) {
            catch_calls(calls[i].numbers);
        }
    }
    armed_memory = strncmp(fault, "malloc:", 7) == 0;
}

__attribute__((destructor)) void faults_end(void)
{
    const char *path = getenv("FAULT_COUNT");
    char digits[24];
    size_t at = sizeof digits;
    unsigned long left = counted;
    if (!path) {
        return;
    }
    do {
        digits[--at] = (char)('0' + left % 10);
        left /= 10;
    } while (left > 0);
    long file = straight(SYS_openat, AT_FDCWD, (long)path, O_WRONLY | O_CREAT | O_TRUNC, 0666, 0);
    straight(SYS_write, file, (long)(digits + at), (long)(sizeof digits - at), 0, 0);
    straight(SYS_close, file, 0, 0, 0, 0);
}

/* ---- Memory: the C library's own functions under the names that it keeps for this. ---- */

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *old, size_t size);

static bool refused(void)
{
    bool due = armed_memory && is_due();
    if (due) {
        errno = ENOMEM;
    }
    return due;
}

void *malloc(size_t size)
{
    return refused() ? NULL : __libc_malloc(size);
}

void *calloc(size_t count, size_t size)
{
    return refused() ? NULL : __libc_calloc(count, size);
}

void *realloc(void *old, size_t size)
{
    return refused() ? NULL : __libc_realloc(old, size);
}
