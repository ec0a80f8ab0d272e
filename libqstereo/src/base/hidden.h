/* For a private function whose address is taken in another file. Without this mark the compiler
 * looks such an address up in a table that the linker has to make, _GLOBAL_OFFSET_TABLE_; with it
 * the library needs no such symbol. */
#ifndef QS_HIDDEN_H
#define QS_HIDDEN_H

#if defined(__GNUC__) && defined(__ELF__)
#define QS_HIDDEN __attribute__((visibility("hidden")))
#else
#define QS_HIDDEN
#endif

#endif
