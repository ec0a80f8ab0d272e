/* The variables of one undecided site in a sample. */
#ifndef QS_SITE_CODE_H
#define QS_SITE_CODE_H

#include "../qubo/sites.h"

/* Which of its labels left the site has, counted from 0; site->count where what stands there is no
 * label. */
uint32_t qs_site_read(const qs_site *site, const uint8_t *bits);

/* Gives it the label with `rank` labels left below it. */
void qs_site_write(const qs_site *site, uint32_t rank, uint8_t *bits);

/* How many labels left are below this one. */
uint32_t qs_site_rank(const qs_site *site, uint32_t label);

/* The reverse. */
uint32_t qs_site_label_at(const qs_site *site, uint32_t rank);

#endif
