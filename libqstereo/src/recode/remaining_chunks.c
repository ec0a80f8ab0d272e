#include "../base/bytes.h"
#include "../base/minmax.h"
#include "../files/qcf_layout.h"
#include "../qubo/sites.h"
#include "remaining.h"

/* ---- kept ---- */

/* Bytes of a site's label; 0 = every site is undecided and has all labels. */
static unsigned fixed_bytes(const qs_remaining *rest)
{
    if (rest->counts.whole && rest->counts.undecided == rest->counts.sites) {
        return 0;
    }
    return rest->model->labels <= UINT8_MAX ? 1 : 2;
}

static void put_set(qs_writer *writer, const qs_remaining *rest, uint32_t site)
{
    const uint16_t *label = rest->label + rest->start[site],
                   *end = rest->label + rest->start[site + 1];
    for (uint32_t at = 0; at < rest->model->labels; at += 8) {
        unsigned byte = 0;
        for (; label < end && *label < at + 8; label++) {
            byte |= 1u << (*label - at);
        }
        qs_put_unsigned(writer, byte, 1);
    }
}

static void put_kept(qs_writer *writer, const void *context)
{
    const qs_remaining *rest = context;
    unsigned bytes = fixed_bytes(rest);
    qs_put_u32(writer, (uint32_t)rest->counts.sites);
    qs_put_u32(writer, bytes);
    if (bytes == 0) {
        return;
    }
    for (uint32_t p = 0; p < rest->model->sites; p++) {
        if (!qs_is_masked(rest->model->mask, p)) {
            uint32_t mark = rest->number[p] == QS_NO_SITE ? rest->fixed[p] : UINT16_MAX;
            qs_put_unsigned(writer, mark, bytes);
        }
    }
    for (uint32_t site = 0; site < rest->counts.undecided; site++) {
        put_set(writer, rest, site);
    }
}

void qs_put_kept(qs_writer *writer, const qs_remaining *rest)
{
    uint64_t bytes = fixed_bytes(rest),
             sets = bytes > 0 ? rest->counts.undecided * qs_bit_bytes(rest->model->labels) : 0;
    qs_put_chunk(writer, "kept", QS_KEPT_HEAD + rest->counts.sites * bytes + sets, put_kept, rest);
}

/* ---- trnc ---- */

static unsigned trimmed_bytes(const qs_remaining *rest)
{
    uint32_t largest = 0;
    for (uint64_t i = 0; i < rest->counts.labels; i++) {
        largest = qs_max_u32(largest, rest->trimmed[i]);
    }
    return qs_bytes_of(largest);
}

static void put_trnc(qs_writer *writer, const void *context)
{
    const qs_remaining *rest = context;
    unsigned bytes = trimmed_bytes(rest);
    qs_put_u32(writer, bytes);
    qs_put_u32(writer, 0);
    for (uint64_t i = 0; i < rest->counts.labels; i++) {
        qs_put_unsigned(writer, rest->trimmed[i], bytes);
    }
}

void qs_put_trnc(qs_writer *writer, const qs_remaining *rest)
{
    uint64_t numbers = rest->counts.labels * trimmed_bytes(rest);
    qs_put_chunk(writer, "trnc", QS_TRNC_HEAD + numbers, put_trnc, rest);
}
