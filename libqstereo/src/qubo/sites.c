#include "sites.h"

#include "../base/bits.h"

bool qs_site_next(qs_site *site)
{
    const qs_labels *l = site->labels;
    if (site->next == l->sites) {
        return false;
    }
    uint32_t at = site->next++, each = (uint32_t)qs_bit_bytes(l->labels);
    site->is_undecided = true;
    site->set = NULL;
    site->count = l->labels;
    site->variable = site->next_variable;
    if (l->fixed_bytes > 0) {
        site->fixed = qs_fixed_at(l, at);
        site->is_undecided = site->fixed == qs_undecided_mark(l);
        site->count = 1;
    }
    if (!site->is_undecided) {
        return true;
    }
    site->number = site->next_number++;
    if (l->fixed_bytes > 0) {
        site->set = l->sets + (size_t)site->number * each;
        site->count = 0;
        for (uint32_t byte = 0; byte < each; byte++) {
            site->count += qs_byte_count(site->set[byte]);
        }
    }
    site->next_variable += qs_encoding_site_variables(l->encoding, site->count);
    return true;
}
