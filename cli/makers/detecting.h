/* Detection: from a file of boxes to the labelling problem of which ones to keep. */
#ifndef DETECTING_H
#define DETECTING_H

#include "made.h"
#include "makers/boxes.h"

typedef struct detecting {
    const char *path;
    box_file file;
} detecting;

extern const maker detecting_maker; /* it has no options */

#endif
