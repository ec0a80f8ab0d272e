/* A problem goes out as a QUBO file, and the samples of whoever solved it come back.
 *
 *     qcf_out_qsf_in PROBLEM.qcf                writes the problem
 *     qcf_out_qsf_in PROBLEM.qcf SAMPLES.qsf    reads the samples
 *
 * In between an annealer solves PROBLEM.qcf: qstereo-bridge sends it to D-Wave's, or solves it with
 * their software on this machine; qstereo solve does it with this library's own solvers.
 *
 * The problem is a ring of five tasks, each to be given one of three days. Neighbours on the ring
 * should not be on the same day: a table of pairwise costs says so. The first task must be on
 * day 0, and days 1 and 2 cost a little. */
#include <qstereo.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TASKS = 5, DAYS = 3, LARGEST_FILE = 1 << 20 };

static void fail(const char *what, const char *why)
{
    fprintf(stderr, "%s: %s\n", what, why);
    exit(3);
}

static void check(const char *what, qs_status status)
{
    if (status != QS_OK) {
        fail(what, qs_status_text(status));
    }
}

static void *need(size_t size)
{
    void *memory = malloc(size);
    if (memory == NULL) {
        fail("memory", "not enough");
    }
    return memory;
}

/* ---- Out. ---- */

/* The library writes through a callback. false would stop it with QS_E_IO. */
static bool write_to_file(void *context, const void *bytes, size_t size)
{
    return fwrite(bytes, 1, size, context) == size;
}

static void write_problem(const char *path)
{
    static const int32_t costs[TASKS * DAYS] = {0, 9, 9, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2};
    static const int32_t same_day[DAYS * DAYS] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const qs_edge ring[TASKS] = {{0, 1, 5}, {1, 2, 5}, {2, 3, 5}, {3, 4, 5}, {0, 4, 5}};
    const qs_problem problem = {
        .sites = TASKS,
        .labels = DAYS,
        .scale = 1,
        .pairwise = {.smoothness = QS_TABLE, .table = same_day},
        .edges = ring,
        .edge_count = TASKS,
        .costs = costs,
    };
    const qs_encode_options options = {0}; /* the encoding that suits, and the least penalties */
    FILE *file = fopen(path, "wb");
    if (file == NULL) {
        fail(path, "cannot be written");
    }
    const qs_sink sink = {write_to_file, file};
    size_t size = qs_encode_workspace(&problem);
    void *memory = need(size);
    uint64_t written;
    check(path, qs_encode(&problem, &options, &sink, memory, size, &written));
    if (fclose(file) != 0) {
        fail(path, "cannot be written");
    }
    free(memory);
    printf("%s: %llu bytes\n", path, (unsigned long long)written);
}

/* ---- In. ---- */

static uint8_t *read_file(const char *path, size_t *size)
{
    uint8_t *bytes = need(LARGEST_FILE);
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        fail(path, "cannot be read");
    }
    *size = fread(bytes, 1, LARGEST_FILE, file);
    fclose(file);
    return bytes;
}

/* A .qsf names the .qcf that it answers by its SHA-256. */
static void check_that_they_belong(const char *path, const uint8_t *problem, size_t size,
                                   const qs_samples_view *samples)
{
    uint8_t digest[QS_DIGEST_SIZE];
    qs_digest(problem, size, digest);
    if (memcmp(digest, samples->problem, sizeof digest) != 0) {
        fail(path, "these are samples of another problem");
    }
}

static void print_sample(const qs_index *index, const uint8_t *bits)
{
    uint16_t day[TASKS];
    qs_status status = qs_sample_decode(index, bits, day);
    if (status == QS_E_INFEASIBLE) { /* an annealer may miss; qs_sample_repair would mend it */
        puts("no labelling: some task has no day, or two");
        return;
    }
    check("sample", status);
    printf("energy %lld, days", (long long)qs_qubo_energy(index, bits));
    for (int task = 0; task < TASKS; task++) {
        printf(" %d", day[task]);
    }
    putchar('\n');
}

static void read_samples(const char *problem_path, const char *samples_path)
{
    size_t problem_size, samples_size;
    uint8_t *problem = read_file(problem_path, &problem_size);
    uint8_t *bytes = read_file(samples_path, &samples_size);
    qs_qubo qubo;
    qs_index index;
    qs_samples_view samples;
    check(problem_path, qs_qubo_open(problem, problem_size, LARGEST_FILE, &qubo, NULL));
    check(samples_path, qs_samples_open(bytes, samples_size, &samples, NULL));
    check_that_they_belong(samples_path, problem, problem_size, &samples);
    if (qubo.labels.sites != TASKS) {
        fail(problem_path, "is not the problem of this example");
    }
    size_t size = qs_index_workspace(&qubo);
    void *memory = need(size);
    check(problem_path, qs_index_build(&qubo, memory, size, &index));
    for (uint32_t i = 0; i < samples.count; i++) {
        print_sample(&index, qs_samples_bits(&samples, i));
    }
    free(memory);
    free(bytes);
    free(problem);
}

int main(int argc, char **argv)
{
    if (argc == 2) {
        write_problem(argv[1]);
    } else if (argc == 3) {
        read_samples(argv[1], argv[2]);
    } else {
        fputs("usage: qcf_out_qsf_in PROBLEM.qcf [SAMPLES.qsf]\n", stderr);
        return 2;
    }
    return 0;
}
