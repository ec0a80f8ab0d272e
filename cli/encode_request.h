/* The command line of encode: its options, and what they ask for. */
#ifndef ENCODE_REQUEST_H
#define ENCODE_REQUEST_H

#include "coding.h"
#include "pair.h"
#include "reducing.h"

typedef struct encode_request {
    const char *output;
    bool json;
    pair pair;
    budget limit;
    qs_recode_options options; /* the encoding is never the default one */
    bool reduce;
    reducing how;
} encode_request;

/* What coefficients grow with. */
#define ENCODE_WEIGHTS "--lambda, --penalty, --gap or --truncation"

/* Reads the arguments, or answers --help. Returns whether the command is to go on; else *status is
 * its exit status. */
bool encode_request_read(int argc, char **argv, encode_request *asked, int *status);

#endif
