/* The work of encode, whatever the problem: from what a maker made to a .qcf. */
#ifndef ENCODING_MADE_H
#define ENCODING_MADE_H

#include "command.h"
#include "encoding_choice.h"
#include "made.h"
#include "reducing.h"

/* The options that every problem has come first, then those of its maker. */
enum {
    ENCODE_OUTPUT,
    ENCODE_PROBLEM,
    ENCODE_ENCODING,
    ENCODE_CODING,
    ENCODE_REDUCE = ENCODE_CODING + CODING_OPTIONS,
    ENCODE_REDUCING,
    ENCODE_JSON = ENCODE_REDUCING + REDUCING_OPTIONS,
    ENCODE_MEMORY_LIMIT,
    ENCODE_MAKER
};

#define ENCODE_OPTION_ROWS                                                                         \
    [ENCODE_OUTPUT] = {"output", 'o',  true,                                                       \
                       "FILE",   NULL, "QUBO file (.qcf) to write, - is standard output"},         \
    [ENCODE_PROBLEM] =                                                                             \
        {"problem",                                                                                \
         0,                                                                                        \
         false,                                                                                    \
         "NAME",                                                                                   \
         "stereo",                                                                                 \
         "stereo, label, restore, segment, flow, register, detect or uai; its own operands and "   \
         "options are in qstereo encode --problem NAME --help"},                                   \
    [ENCODE_ENCODING] = {"encoding",                                                               \
                         0,                                                                        \
                         false,                                                                    \
                         "NAME",                                                                   \
                         NULL,                                                                     \
                         "how labels become bits: one-hot, one-hot-sparse, domain-wall, "          \
                         "multiway-cut, st-cut or st-cut-arcs (default one-hot-sparse for potts, " \
                         "else one-hot)"},                                                         \
    [ENCODE_CODING] = CODING_OPTION_ROWS(" (default local)", " (default 1)", ""),                  \
    [ENCODE_REDUCE] = {"reduce",                                                                   \
                       0,                                                                          \
                       false,                                                                      \
                       NULL,                                                                       \
                       NULL,                                                                       \
                       "leave out labels that are proven to be in no optimum, as reduce does"},    \
    [ENCODE_REDUCING] = REDUCING_OPTION_ROWS,                                                      \
    [ENCODE_JSON] = {"json", 0, false, NULL, NULL, "print what info --json prints of the file"},   \
    [ENCODE_MEMORY_LIMIT] = MEMORY_LIMIT_OPTION

/* Makes the problem and writes it. Returns an exit status. */
int encode_made(job *at, const maker *by);

#endif
