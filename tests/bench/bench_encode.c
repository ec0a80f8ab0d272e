/* Speed of cost + encode in memory beside memcpy of the same bytes: one core, medians of many runs,
 * both in turn. Prints a JSON list. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "bench.h"

enum { RUNS = 101 };

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *times)
{
    qsort(times, RUNS, sizeof *times, ascending);
    return times[RUNS / 2];
}

/* A pair of random grey pictures: the time does not depend on what they show. */
static void bench(uint32_t width, uint32_t height, uint32_t labels, qs_encoding encoding)
{
    size_t across = (size_t)width + labels - 1, pixels = across * height;
    uint8_t *left = memory(pixels), *right = memory(pixels);
    for (size_t i = 0; i < pixels; i++) {
        left[i] = (uint8_t)(rand() >> 8);
        right[i] = (uint8_t)(rand() >> 8);
    }
    qs_stereo stereo = {.left = {left, across, height, across},
                        .right = {right, across, height, across},
                        .disparity_max = (int32_t)labels - 1,
                        .scale = 1,
                        .weight = 20};
    size_t matcher_size = qs_stereo_workspace(&stereo);
    void *matcher = memory(matcher_size);
    qs_problem problem;
    demand(qs_stereo_problem(&stereo, matcher, matcher_size, &problem));
    size_t workspace_size = qs_encode_workspace(&problem);
    void *workspace = memory(workspace_size);
    qs_encode_options options = {.encoding = encoding};
    uint64_t size;
    demand(qs_encode(&problem, &options, NULL, workspace, workspace_size, &size));
    qs_buffer buffer = {memory((size_t)size), (size_t)size, 0};
    qs_sink sink = qs_buffer_sink(&buffer);
    uint8_t *copy = memory((size_t)size);
    double encode_times[RUNS], copy_times[RUNS];
    for (int run = 0; run < RUNS; run++) {
        buffer.size = 0;
        double begin = seconds();
        demand(qs_encode(&problem, &options, &sink, workspace, workspace_size, NULL));
        double middle = seconds();
        memcpy(copy, buffer.bytes, (size_t)size);
        __asm__ volatile("" : : "r"(copy) : "memory");
        copy_times[run] = seconds() - middle;
        encode_times[run] = middle - begin;
    }
    double encode = median(encode_times), plain = median(copy_times);
    printf("{\"width\": %u, \"height\": %u, \"labels\": %u, \"encoding\": \"%s\", "
           "\"bytes\": %llu, \"seconds\": %.9f, \"memcpy_seconds\": %.9f}",
           width, height, labels, encoding == QS_ONE_HOT ? "one-hot" : "one-hot-sparse",
           (unsigned long long)size, encode, plain);
    free(copy);
    free(buffer.bytes);
    free(workspace);
    free(matcher);
    free(right);
    free(left);
}

int main(void)
{
    static const struct {
        uint32_t width, height, labels;
        qs_encoding encoding;
    } shapes[] = {{177, 177, 16, QS_ONE_HOT},
                  {177, 177, 16, QS_ONE_HOT_SPARSE},
                  {369, 288, 16, QS_ONE_HOT_SPARSE},
                  {415, 383, 20, QS_ONE_HOT_SPARSE},
                  {1920, 1080, 64, QS_ONE_HOT_SPARSE}};
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        fputs(i == 0 ? "[" : ",\n", stdout);
        bench(shapes[i].width, shapes[i].height, shapes[i].labels, shapes[i].encoding);
    }
    puts("]");
    return 0;
}
