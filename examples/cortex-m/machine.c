/* Start, semihosting (Arm's "Semihosting for AArch32 and AArch64") and measurements. */
#include "machine.h"

#include <stdint.h>
#include <string.h>

enum {
    SYS_OPEN = 1,
    SYS_CLOSE = 2,
    SYS_WRITE0 = 4,
    SYS_WRITE = 5,
    SYS_EXIT_EXTENDED = 0x20,
    OPEN_WRITE_BINARY = 5,
    APPLICATION_EXIT = 0x20026,
    PAINT = 0xa5
};

/* Of the linker's script. */
extern uint8_t stack_bottom[], stack_top[], bss_start[], bss_end[], library_start[], library_end[];

int main(void);
void start(void);
void fault(void);

static uint8_t *painted_from; /* where the stack was when it was painted */

static int call(int operation, const void *arguments)
{
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = arguments;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static void leave(int status)
{
    uint32_t arguments[] = {APPLICATION_EXIT, (uint32_t)status};
    call(SYS_EXIT_EXTENDED, arguments);
}

void start(void)
{
    memset(bss_start, 0, (size_t)(bss_end - bss_start));
    leave(main());
    for (;;) {
    }
}

void fault(void)
{
    machine_say("fault\n");
    leave(2);
    for (;;) {
    }
}

__attribute__((section(".vectors"), used)) static void *const vectors[16] = {
    stack_top,     (void *)start, (void *)fault, (void *)fault,
    (void *)fault, (void *)fault, (void *)fault,
};

int machine_create(const char *name)
{
    uint32_t arguments[] = {(uint32_t)name, OPEN_WRITE_BINARY, (uint32_t)strlen(name)};
    return call(SYS_OPEN, arguments);
}

bool machine_write(int file, const void *bytes, size_t size)
{
    uint32_t arguments[] = {(uint32_t)file, (uint32_t)bytes, (uint32_t)size};
    return call(SYS_WRITE, arguments) == 0;
}

void machine_close(int file)
{
    uint32_t arguments[] = {(uint32_t)file};
    call(SYS_CLOSE, arguments);
}

void machine_say(const char *text)
{
    call(SYS_WRITE0, text);
}

void machine_say_number(size_t number)
{
    char digits[12];
    char *at = digits + sizeof digits - 1;
    *at = '\0';
    do {
        *--at = (char)('0' + number % 10);
        number /= 10;
    } while (number > 0);
    machine_say(at);
}

void machine_paint_stack(void)
{
    enum { OWN_FRAME = 64 };
    painted_from = __builtin_frame_address(0);
    for (volatile uint8_t *at = stack_bottom; at < painted_from - OWN_FRAME; at++) {
        *at = PAINT;
    }
}

size_t machine_stack_used(void)
{
    const uint8_t *at = stack_bottom;
    while (at < painted_from && *at == PAINT) {
        at++;
    }
    return (size_t)(painted_from - at);
}

size_t machine_library_size(void)
{
    return (size_t)(library_end - library_start);
}
