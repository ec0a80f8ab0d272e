/* Changes files of the container as libFuzzer does, then mends their checksums. */
#include "fuzz.h"

#include <string.h>

#include "../../libqstereo/src/base/bytes.h"
#include "../../libqstereo/src/files/crc32c.h"

enum { HEADER = 64, FRAME = 20 };

/* A chunk that is longer than the file ends with it. */
static void mend_chunks(uint8_t *file, size_t size, uint32_t *chunks)
{
    *chunks = 0;
    for (size_t at = HEADER; size - at >= FRAME; ++*chunks) {
        uint64_t length = qs_load_u64(file + at + 8), left = size - at - FRAME;
        if (length > left) {
            length = left;
            qs_store_u64(file + at + 8, length);
        }
        size_t covered = 16 + (size_t)length;
        qs_store_u32(file + at + covered, qs_crc32c_portable(0, file + at, covered));
        at += covered + 4;
    }
}

size_t fuzz_mend(uint8_t *file, size_t size)
{
    uint32_t chunks;
    if (size < HEADER) {
        return size;
    }
    mend_chunks(file, size, &chunks);
    qs_store_u32(file + 8, 1);
    qs_store_u32(file + 12, chunks);
    qs_store_u64(file + 16, size);
    qs_store_u32(file + 60, qs_crc32c_portable(0, file, 60));
    return size;
}

#ifdef FUZZ_CONTAINER

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t most);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed);

/* Changes the payload of one chunk, or the fields of the header; the rest moves with it. */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed)
{
    uint8_t part[512];
    size_t starts[32], count = 0;
    if (size < HEADER || seed % 16 == 0) {
        return LLVMFuzzerMutate(data, size, most);
    }
    starts[count++] = 24;
    for (size_t at = HEADER; size - at >= FRAME && count < 32;) {
        uint64_t length = qs_load_u64(data + at + 8);
        if (length > size - at - FRAME) {
            break;
        }
        starts[count++] = at + 16;
        at += FRAME + (size_t)length;
    }
    size_t from = starts[seed / 16 % count],
           length = from == 24 ? 36 : (size_t)qs_load_u64(data + from - 8);
    length = length < sizeof part ? length : sizeof part;
    memcpy(part, data + from, length);
    size_t room = from == 24 ? 36 : most - size + length;
    if (room == 0) {
        return size;
    }
    size_t changed = LLVMFuzzerMutate(part, length, room < sizeof part ? room : sizeof part);
    changed = from == 24 ? length : changed;
    memmove(data + from + changed, data + from + length, size - from - length);
    memcpy(data + from, part, changed);
    if (from != 24) {
        qs_store_u64(data + from - 8, qs_load_u64(data + from - 8) - length + changed);
    }
    return fuzz_mend(data, size - length + changed);
}

#endif
