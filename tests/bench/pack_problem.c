/* pack_problem < PROBLEM > P.qcf: a grid problem of plain numbers as a .qcf, penalty local, in
 * one-hot-sparse where that holds the pairwise cost, else in one-hot.
 *
 * PROBLEM is 32-bit integers in the machine's byte order: width, height, labels, smoothness (as in
 * qs_smoothness), truncation, weight, 1 if weights of the edges follow or 0; then the costs (height
 * x width x labels); of QS_TABLE the table (labels x labels); and, if they follow, the weights of
 * the edges to the right and then of those down (height x width each). tests/bench/mrf_problem.py
 * writes it. */
#include <stdio.h>
#include <stdlib.h>

#include <qstereo.h>

enum { WIDTH, HEIGHT, LABELS, SMOOTHNESS, TRUNCATION, WEIGHT, WEIGHTS, HEADER };

static void demand(bool good, const char *what)
{
    if (!good) {
        fprintf(stderr, "pack_problem: %s\n", what);
        exit(3);
    }
}

static int32_t *read_numbers(size_t count)
{
    int32_t *numbers = malloc(sizeof *numbers * count + 1);
    demand(numbers, "no memory");
    demand(fread(numbers, sizeof *numbers, count, stdin) == count, "the input ends too early");
    return numbers;
}

static bool write_bytes(void *context, const void *bytes, size_t size)
{
    return fwrite(bytes, 1, size, context) == size;
}

int main(void)
{
    const int32_t *header = read_numbers(HEADER);
    demand(header[WIDTH] > 0 && header[HEIGHT] > 0 && header[LABELS] > 0, "an empty problem");
    size_t labels = (size_t)header[LABELS];
    size_t cells = (size_t)header[WIDTH] * (size_t)header[HEIGHT];
    demand(labels <= QS_LABELS_MAX && cells <= QS_VARIABLES_MAX / labels, "too many variables");
    qs_problem problem = {
        .labels = (uint32_t)labels,
        .scale = 1,
        .weight = header[WEIGHT],
        .pairwise = {.smoothness = (qs_smoothness)header[SMOOTHNESS],
                     .truncation = (uint32_t)header[TRUNCATION]},
        .grid = {(uint32_t)header[WIDTH], (uint32_t)header[HEIGHT], NULL, NULL, NULL},
        .costs = read_numbers(cells * labels)};
    if (problem.pairwise.smoothness == QS_TABLE) {
        problem.pairwise.table = read_numbers(labels * labels);
    }
    if (header[WEIGHTS]) {
        problem.grid.right = read_numbers(cells);
        problem.grid.down = read_numbers(cells);
    }
    demand(getchar() == EOF, "the input goes on after its end");
    bool sparse = problem.pairwise.smoothness <= QS_TRUNCATED_LINEAR;
    const qs_encode_options options = {.encoding = sparse ? QS_ONE_HOT_SPARSE : QS_ONE_HOT};
    const qs_sink sink = {write_bytes, stdout};
    size_t size = qs_encode_workspace(&problem);
    void *workspace = malloc(size + 1);
    demand(workspace, "no memory");
    qs_status status = qs_encode(&problem, &options, &sink, workspace, size, NULL);
    demand(status == QS_OK, qs_status_text(status));
    demand(fflush(stdout) == 0, "cannot write");
    return 0;
}
