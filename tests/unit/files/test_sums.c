/* The sums over bytes that both formats have: CRC-32C and SHA-256. */
#include "slow.h"

#include "files/crc32c.h"

/* The check value of the CRC catalogues; the instruction beside the tables; the tables beside the
 * definition. */
static void crc(void **unused)
{
    (void)unused;
    assert_int_equal(qs_crc32c_portable(0, (const uint8_t *)"123456789", 9), 0xe3069283);
    static uint8_t text[4000];
    uint64_t state = 3;
    for (size_t i = 0; i < sizeof text; i++) {
        text[i] = (uint8_t)tiny_random(&state, 256);
    }
    qs_crc *fastest = qs_crc32c_fastest();
    uint32_t slow = UINT32_MAX;
    for (size_t i = 0; i < sizeof text; i++) {
        assert_int_equal(qs_crc32c_portable(0, text, i), ~slow);
        assert_int_equal(fastest(0, text, i), ~slow);
        assert_int_equal(fastest(qs_crc32c_portable(0, text, i / 3), text + i / 3, i - i / 3),
                         ~slow);
        slow ^= text[i];
        for (int bit = 0; bit < 8; bit++) {
            slow = slow >> 1 ^ (slow & 1 ? 0x82f63b78u : 0);
        }
    }
}

/* FIPS 180-4's examples, and lengths round the block's end. */
static void digest(void **unused)
{
    (void)unused;
    static const struct {
        const char *text;
        size_t size;
        uint8_t first[4];
    } cases[] = {
        {"", 0, {0xe3, 0xb0, 0xc4, 0x42}},
        {"abc", 3, {0xba, 0x78, 0x16, 0xbf}},
        {"abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq", 56, {0x24, 0x8d, 0x6a, 0x61}},
        {"aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa", 55, {0x9f, 0x43, 0x90, 0xf8}},
        {"aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa",
         64,
         {0xff, 0xe0, 0x54, 0xfe}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        uint8_t got[QS_DIGEST_SIZE];
        qs_digest(cases[i].text, cases[i].size, got);
        assert_memory_equal(got, cases[i].first, 4);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(crc),
        cmocka_unit_test(digest),
    };
    return cmocka_run_group_tests_name("sums", tests, NULL, NULL);
}
