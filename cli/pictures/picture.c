#include "pictures/picture.h"

#include <stdlib.h>

bool picture_allocate(picture *made)
{
    made->samples = NULL;
    if (made->height <= SIZE_MAX / sizeof *made->samples / made->channels / made->width) {
        made->samples = malloc(made->width * made->height * made->channels * sizeof *made->samples);
    }
    return made->samples != NULL;
}

void picture_free(picture *freed)
{
    free(freed->samples);
    freed->samples = NULL;
}
