/* Pictures one after the other in one file or pipe: binary PGM and PPM as they are, and the grey of
 * YUV4MPEG2 (.y4m), as ffmpeg and others write them. Each function that can fail returns an exit
 * status and has printed why. */
#ifndef PICTURE_STREAM_H
#define PICTURE_STREAM_H

#include <stdio.h>

#include "files.h"
#include "pictures/picture.h"

typedef struct picture_stream {
    FILE *file;
    const char *name; /* for messages */
    uint64_t count; /* pictures that were read */
    bool y4m;
    picture form; /* of the pictures of a Y4M: one channel, without samples */
    uint64_t skipped; /* bytes of colour after the grey of each of them */
} picture_stream;

/* Opens a stream; "-" is standard input. Returns DONE or NO_RESOURCE. */
int stream_open(const char *path, picture_stream *opened);

/* Reads the next picture, which picture_free frees. Its place in messages is `name`, such as
 * "standard input, frame 12". Returns DONE, with *ended if there is none, BAD_INPUT or
 * NO_RESOURCE. */
int stream_next(picture_stream *from, const char *name, const budget *limit, picture *read,
                bool *ended);

void stream_close(picture_stream *closed);

#endif
