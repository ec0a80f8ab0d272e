/* Numbers of the command line, and JSON: the first byte says which. */
#include <string.h>

#include "fuzz.h"
#include "text/json.h"
#include "text/numbers.h"

static void read_decimal(const char *text)
{
    fraction read;
    char written[DECIMAL_SIZE];
    if (decimal_read(text, INT64_MAX, DECIMAL_DENOMINATOR_MAX, &read) == DECIMAL_OK) {
        fraction again;
        PROMISE(read.denominator >= 1 && read.denominator <= DECIMAL_DENOMINATOR_MAX);
        decimal_write((int64_t)read.numerator, read.denominator, written);
        decimal_status status = decimal_read(written, INT64_MAX, DECIMAL_DENOMINATOR_MAX, &again);
        PROMISE(status == DECIMAL_OK && again.numerator == read.numerator &&
                again.denominator == read.denominator);
    }
}

static void read_numbers(const char *text)
{
    uint32_t numbers[4];
    uint64_t number;
    double threshold;
    int64_t microseconds;
    numbers_read(text, ',', numbers, 4);
    numbers_read(text, ':', numbers, 2);
    if (number64_read("--n", text, 5, 70, &number) == 0) {
        PROMISE(number >= 5 && number <= 70);
    }
    if (threshold_read("--t", text, &threshold) == 0) {
        PROMISE(threshold >= 0);
    }
    if (seconds_read("--s", text, &microseconds) == 0) {
        PROMISE(microseconds >= 0);
    }
}

static void told(void *context, const char *name, size_t size, double number)
{
    (void)name;
    (void)number;
    *(size_t *)context += size;
}

static void read_json(const char *text, size_t size)
{
    double number;
    size_t names = 0;
    if (json_is_object(text, size)) {
        json_find_number(text, size, "seconds", &number);
        json_each_number(text, size, "p", told, &names);
        PROMISE(names <= size);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size == 0) {
        return 0;
    }
    char *text = malloc(size);
    memcpy(text, data + 1, size - 1);
    text[size - 1] = '\0';
    switch (data[0] % 3) {
    case 0: read_decimal(text); break;
    case 1: read_numbers(text); break;
    default: read_json((const char *)data + 1, size - 1);
    }
    free(text);
    return 0;
}
