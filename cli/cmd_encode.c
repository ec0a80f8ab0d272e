#include <errno.h>
#include <inttypes.h>
#include <stdio.h>

#include "describe.h"
#include "encode_request.h"
#include "messages.h"
#include "output.h"

/* Where the file's bytes go: to the output, and to memory too where they are to be described. */
typedef struct destination {
    output out;
    bool keep;
    growing_file kept;
} destination;

static bool write_bytes(void *context, const void *bytes, size_t size)
{
    destination *to = context;
    if (to->keep && !growing_append(&to->kept, bytes, size)) {
        to->out.error = ENOMEM;
        return false;
    }
    return output_write(&to->out, bytes, size);
}

static void print_summary(const encode_request *asked, const qs_problem *problem, uint64_t size)
{
    uint32_t sites = qs_problem_sites(problem);
    uint32_t left = asked->pair.whole ? 0 : asked->pair.stereo.x;
    printf("%s: %" PRIu32 " sites x %" PRIu32 " labels = %" PRIu64 " variables, %" PRIu64 " bytes\n", asked->output,
           sites, problem->labels, (uint64_t)sites * problem->labels, size);
    if (problem->frame.x > left) {
        printf("%" PRIu32 " columns on the left are no sites: a match would fall outside %s\n", problem->frame.x - left,
               asked->pair.right);
    }
}

/* Prints what was asked for, from the bytes as they were written. */
static int describe_kept(const encode_request *asked, destination *to)
{
    const budget no_limit = {UINT64_MAX, 0};
    problem_file written;
    int status = problem_take(asked->output, to->kept.file, &no_limit, &written);
    to->kept.file = (file_bytes){NULL, 0};
    if (status != DONE) {
        return status;
    }
    describe_problem_json(&written);
    file_free(&written.file);
    return DONE;
}

static int write_problem(const encode_request *asked, const qs_problem *problem)
{
    destination to = {.keep = asked->json};
    qs_sink sink = {write_bytes, &to};
    uint64_t size = 0;
    int status = output_open(&to.out, asked->output);
    if (status != DONE) {
        return status;
    }
    status = pair_encode(&asked->pair, problem, &asked->options, &sink, &size);
    bool whole = status == DONE && to.out.error == 0;
    if (whole && asked->json) {
        status = describe_kept(asked, &to);
    } else if (whole && !output_is_standard(asked->output)) {
        print_summary(asked, problem, size);
    }
    file_free(&to.kept.file);
    if (status != DONE) {
        output_abandon(&to.out);
        return status;
    }
    return output_commit(&to.out, 1); /* which reports refused bytes */
}

int cmd_encode(int argc, char **argv)
{
    encode_request asked;
    qs_problem problem;
    int status;
    if (!encode_request_read(argc, argv, &asked, &status)) {
        return status;
    }
    status = pair_open(&asked.pair, &problem);
    if (status == DONE) {
        status = write_problem(&asked, &problem);
    }
    pair_close(&asked.pair);
    return status;
}
