/* What the example needs of the machine: files and messages by semihosting, and measurements. */
#ifndef MACHINE_H
#define MACHINE_H

#include <stdbool.h>
#include <stddef.h>

/* A file of the emulator's folder, emptied; below 0 = it cannot be made. */
int machine_create(const char *name);
bool machine_write(int file, const void *bytes, size_t size);
void machine_close(int file);

void machine_say(const char *text);
void machine_say_number(size_t number);

/* Fills the free stack with a pattern; later the bytes that have lost it are those that were used
 * from the caller's frame on. */
void machine_paint_stack(void);
size_t machine_stack_used(void);

/* Bytes of code and constants of the library and of all that it calls. */
size_t machine_library_size(void);

#endif
