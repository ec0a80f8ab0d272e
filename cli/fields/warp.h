/* A picture drawn where a field of displacements leads. */
#ifndef WARP_H
#define WARP_H

#include "fields/flow_file.h"
#include "qstereo.h"

/* warped(x) = moving(x + d(x)), interpolated bilinearly and rounded; beyond its border the moving
 * picture continues with the pixels of the border. All have one size; `warped` has its pixels
 * without gaps. */
void warp(const qs_image *moving, const flow_field *field, uint8_t *warped);

#endif
