/* The command line of encode: its options, and what they ask for. */
#ifndef ENCODE_REQUEST_H
#define ENCODE_REQUEST_H

#include "pair.h"

typedef struct encode_request {
    const char *output;
    bool json;
    pair pair;
    qs_encode_options options;
} encode_request;

/* Reads the arguments, or answers --help. Returns whether the command is to go on; else *status is its exit status. */
bool encode_request_read(int argc, char **argv, encode_request *asked, int *status);

#endif
