/* Encodes a problem that is never in memory as a whole.
 *
 *     streaming_encoder WIDTH HEIGHT > PROBLEM.qcf
 *
 * The costs of a grid may be made row by row while the file is being written, and the file leaves
 * by a callback as it is made. So the memory that this needs is that of one row, and a sensor can
 * be encoded on the device that reads it.
 *
 * The "sensor" here shows three bands, one above the other, that are to be told apart by their
 * brightness: each pixel gets one of three labels. */
#include <qstereo.h>
#include <stdio.h>
#include <stdlib.h>

enum { LABELS = 3 };

typedef struct sensor {
    uint32_t width, height;
} sensor;

/* Brightness 0 to 255 of a pixel: the band's, and some noise. */
static int brightness(const sensor *s, uint32_t x, uint32_t y)
{
    uint32_t noise = (x * 2654435761u ^ y * 2246822519u) >> 27; /* 0 to 31 */
    return (int)(40 + 80 * (y * LABELS / s->height) + noise);
}

/* The costs of a row, in bytes: how far the brightness is from that of each band. The least of each
 * pixel goes into `least`, and only what is above it into `costs`. */
static void make_row(void *context, uint32_t row, void *costs, int32_t *least)
{
    const sensor *s = context;
    uint8_t *out = costs;
    for (uint32_t x = 0; x < s->width; x++, out += LABELS) {
        int cost[LABELS];
        least[x] = 255;
        for (int label = 0; label < LABELS; label++) {
            cost[label] = abs(brightness(s, x, row) - (56 + 80 * label));
            least[x] = cost[label] < least[x] ? cost[label] : least[x];
        }
        for (int label = 0; label < LABELS; label++) {
            out[label] = (uint8_t)(cost[label] - least[x]);
        }
    }
}

static bool write_to_stdout(void *context, const void *bytes, size_t size)
{
    (void)context;
    return fwrite(bytes, 1, size, stdout) == size;
}

int main(int argc, char **argv)
{
    int width = argc == 3 ? atoi(argv[1]) : 0, height = argc == 3 ? atoi(argv[2]) : 0;
    if (width < 1 || width > 20000 || height < 1 || height > 20000) {
        fputs("usage: streaming_encoder WIDTH HEIGHT > PROBLEM.qcf (1 to 20000)\n", stderr);
        return 2;
    }
    sensor s = {(uint32_t)width, (uint32_t)height};
    const qs_problem problem = {
        .labels = LABELS,
        .scale = 1,
        .weight = 30,
        .pairwise = {.smoothness = QS_POTTS},
        .grid = {.width = s.width, .height = s.height},
        .source = {.row = make_row, .context = &s, .bytes = 1},
    };
    const qs_encode_options options = {.encoding = QS_ONE_HOT_SPARSE};
    const qs_sink sink = {write_to_stdout, NULL};
    size_t size = qs_encode_workspace(&problem);
    void *memory = malloc(size);
    uint64_t written;
    qs_status status =
        memory ? qs_encode(&problem, &options, &sink, memory, size, &written) : QS_E_WORKSPACE;
    free(memory);
    if (status != QS_OK || fflush(stdout) != 0) {
        fprintf(stderr, "streaming_encoder: %s\n", qs_status_text(status ? status : QS_E_IO));
        return 4;
    }
    fprintf(stderr, "%llu bytes written, %zu bytes of workspace\n", (unsigned long long)written,
            size);
    return 0;
}
