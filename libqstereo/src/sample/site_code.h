/* The variables of one undecided site in a sample. A rank counts the labels left to the site from
 * 0, in rising order. */
#ifndef QS_SITE_CODE_H
#define QS_SITE_CODE_H

#include "../qubo/sites.h"

/* The rank of the label that the site has. site->count: its variables are no label. */
uint32_t qs_site_read(const qs_site *site, const uint8_t *bits);

/* Gives the site the label of a rank. */
void qs_site_write(const qs_site *site, uint32_t rank, uint8_t *bits);

/* The rank of a label: how many labels left to the site are below it. */
uint32_t qs_site_rank(const qs_site *site, uint32_t label);

/* The label of a rank. */
uint32_t qs_site_label_at(const qs_site *site, uint32_t rank);

#endif
