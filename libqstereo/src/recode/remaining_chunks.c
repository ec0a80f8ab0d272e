#include "../base/bytes.h"
#include "../base/minmax.h"
#include "../files/qcf_layout.h"
#include "../qubo/sites.h"
#include "remaining.h"

/* Bytes of a label or of its number among those left to its site. */
static unsigned label_bytes(const qs_remaining *rest)
{
    return rest->model->labels <= UINT8_MAX ? 1 : 2;
}

/* ---- kept ---- */

/* Bytes of a site's label; 0 = every site is undecided and has all labels. */
static unsigned fixed_bytes(const qs_remaining *rest)
{
    if (rest->counts.whole && rest->counts.undecided == rest->counts.sites) {
        return 0;
    }
    return label_bytes(rest);
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

/* ---- best ---- */

/* The number of a label among those left to an undecided site; that of all = it is not left. */
static uint32_t number_of(const qs_remaining *rest, uint32_t site, uint16_t label)
{
    uint32_t size = qs_remaining_size(rest, site), j = 0;
    while (j < size && rest->label[rest->start[site] + j] != label) {
        j++;
    }
    return j;
}

bool qs_remaining_has(const qs_remaining *rest, const uint16_t *labelling)
{
    const uint16_t *label = labelling;
    bool has = true;
    for (uint32_t p = 0; p < rest->model->sites && has; p++) {
        if (qs_is_masked(rest->model->mask, p)) {
            continue;
        }
        bool fixed = rest->number[p] == QS_NO_SITE;
        uint32_t site = fixed ? 0 : (uint32_t)rest->number[p];
        has = fixed ? rest->fixed[p] == *label
                    : number_of(rest, site, *label) < qs_remaining_size(rest, site);
        label++;
    }
    return has;
}

typedef struct known_best {
    const qs_remaining *rest;
    const uint16_t *labelling;
    int64_t lower_bound;
} known_best;

static void put_best(qs_writer *writer, const void *context)
{
    const known_best *known = context;
    const qs_remaining *rest = known->rest;
    const uint16_t *label = known->labelling;
    unsigned bytes = label_bytes(rest);
    qs_put_u64(writer, (uint64_t)known->lower_bound);
    qs_put_u32(writer, bytes);
    qs_put_u32(writer, 0);
    for (uint32_t p = 0; p < rest->model->sites; p++) {
        if (rest->number[p] != QS_NO_SITE) {
            qs_put_unsigned(writer, number_of(rest, (uint32_t)rest->number[p], *label), bytes);
        }
        label += !qs_is_masked(rest->model->mask, p);
    }
}

void qs_put_best(qs_writer *writer, const qs_remaining *rest, const uint16_t *best,
                 int64_t lower_bound)
{
    const known_best known = {rest, best, lower_bound};
    uint64_t length = QS_KNOWN_HEAD + rest->counts.undecided * label_bytes(rest);
    qs_put_chunk(writer, "best", length, put_best, &known);
}
