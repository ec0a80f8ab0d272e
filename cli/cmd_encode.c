#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "describe.h"
#include "encode_request.h"
#include "messages.h"
#include "output.h"
#include "picture.h"

/* Reads a picture as grey; its pixels are to be freed. */
static int read_grey(const char *path, qs_image *image, uint8_t **pixels)
{
    picture colour;
    int status = picture_read(path, &colour);
    if (status != DONE) {
        return status;
    }
    *pixels = picture_grey(&colour);
    *image = (qs_image){*pixels, colour.width, colour.height, colour.width};
    picture_free(&colour);
    return *pixels != NULL ? DONE : fail_memory(input_name(path));
}

/* Why the library refused the geometry, or would: the user can mend what is named. */
static int check_geometry(const encode_request *asked)
{
    const qs_stereo *stereo = &asked->stereo;
    const qs_image *left = &stereo->left, *right = &stereo->right;
    size_t end = asked->whole ? left->width : (size_t)stereo->x + stereo->width;
    if (left->width != right->width || left->height != right->height) {
        return fail(BAD_INPUT, input_name(asked->right),
                    "is %zu x %zu pixels, but %s is %zu x %zu: a pair has one size", right->width, right->height,
                    input_name(asked->left), left->width, left->height);
    }
    if (end > left->width || (!asked->whole && (size_t)stereo->y + stereo->height > left->height)) {
        return fail(BAD_INPUT, input_name(asked->left),
                    "is %zu x %zu pixels: --roi %lu,%lu,%lu,%lu does not lie inside", left->width, left->height,
                    (unsigned long)stereo->x, (unsigned long)stereo->y, (unsigned long)stereo->width,
                    (unsigned long)stereo->height);
    }
    if (end <= stereo->disparity_max) {
        return fail(
            BAD_INPUT, input_name(asked->left),
            "%s ends at column %zu, too narrow for disparity %lu: no pixel would have all of its matches inside the "
            "right picture; lower --disparity%s",
            asked->whole ? "the picture" : "--roi", end - 1, (unsigned long)stereo->disparity_max,
            asked->whole ? "" : " or move --roi to the right");
    }
    return DONE;
}

static int fail_encode(const encode_request *asked, qs_status status)
{
    const char *name = input_name(asked->left);
    if (status == QS_E_LIMIT) {
        return fail(BAD_INPUT, name, "sites x labels is over %u variables: choose a smaller --roi or --disparity",
                    QS_VARIABLES_MAX);
    }
    if (status == QS_E_OVERFLOW) {
        return fail(BAD_INPUT, name,
                    "the coefficients overflow (their sum is above 2^53): choose a smaller --lambda, "
                    "--penalty, --gap or --truncation");
    }
    return fail_status(name, status);
}

/* Where the file's bytes go: to the output, and to memory too where they are to be described. */
typedef struct destination {
    output out;
    bool keep;
    file_bytes kept;
    size_t capacity;
} destination;

static bool keep_bytes(destination *to, const void *bytes, size_t size)
{
    if (to->capacity - to->kept.size < size) {
        size_t larger = (to->capacity + size) * 2;
        uint8_t *moved = realloc(to->kept.bytes, larger);
        if (moved == NULL) {
            return false;
        }
        to->kept.bytes = moved;
        to->capacity = larger;
    }
    memcpy(to->kept.bytes + to->kept.size, bytes, size);
    to->kept.size += size;
    return true;
}

static bool write_bytes(void *context, const void *bytes, size_t size)
{
    destination *to = context;
    if (to->keep && !keep_bytes(to, bytes, size)) {
        to->out.error = ENOMEM;
        return false;
    }
    return output_write(&to->out, bytes, size);
}

static void print_summary(const encode_request *asked, const qs_problem *problem, uint64_t size)
{
    uint32_t sites = qs_problem_sites(problem);
    uint32_t left = asked->whole ? 0 : asked->stereo.x;
    printf("%s: %" PRIu32 " sites x %" PRIu32 " labels = %" PRIu64 " variables, %" PRIu64 " bytes\n", asked->output,
           sites, problem->labels, (uint64_t)sites * problem->labels, size);
    if (problem->frame.x > left) {
        printf("%" PRIu32 " columns on the left are no sites: a match would fall outside %s\n", problem->frame.x - left,
               asked->right);
    }
}

/* Prints what was asked for, from the bytes as they were written. */
static int describe_kept(const encode_request *asked, destination *to)
{
    const budget no_limit = {UINT64_MAX, 0};
    problem_file written;
    int status = problem_take(asked->output, to->kept, &no_limit, &written);
    to->kept = (file_bytes){NULL, 0};
    if (status != DONE) {
        return status;
    }
    describe_problem_json(&written);
    file_free(&written.file);
    return DONE;
}

static int write_problem(const encode_request *asked, const qs_problem *problem, void *workspace, size_t workspace_size)
{
    destination to = {.keep = asked->json};
    qs_sink sink = {write_bytes, &to};
    uint64_t size = 0;
    int status = output_open(&to.out, asked->output);
    if (status != DONE) {
        return status;
    }
    qs_status encoded = qs_encode(problem, &asked->options, &sink, workspace, workspace_size, &size);
    if (encoded != QS_OK && encoded != QS_E_IO) {
        status = fail_encode(asked, encoded);
    } else if (encoded == QS_OK && asked->json) {
        status = describe_kept(asked, &to);
    } else if (encoded == QS_OK && !output_is_standard(asked->output)) {
        print_summary(asked, problem, size);
    }
    free(to.kept.bytes);
    if (status != DONE) {
        output_abandon(&to.out);
        return status;
    }
    return output_commit(&to.out, 1); /* which reports refused bytes */
}

static int encode_problem(const encode_request *asked, const qs_problem *problem)
{
    size_t size = qs_encode_workspace(problem);
    void *workspace = malloc(size > 0 ? size : 1);
    if (workspace == NULL) {
        return fail_memory(NULL);
    }
    int status = write_problem(asked, problem, workspace, size);
    free(workspace);
    return status;
}

static int encode_pair(const encode_request *asked)
{
    qs_problem problem;
    size_t size = qs_stereo_workspace(&asked->stereo);
    void *workspace = malloc(size > 0 ? size : 1);
    if (workspace == NULL) {
        return fail_memory(NULL);
    }
    qs_status made = qs_stereo_problem(&asked->stereo, workspace, size, &problem);
    int status;
    if (made == QS_OK) {
        problem.pairwise = asked->pairwise;
        status = encode_problem(asked, &problem);
    } else {
        status = fail_encode(asked, made);
    }
    free(workspace);
    return status;
}

int cmd_encode(int argc, char **argv)
{
    encode_request asked;
    uint8_t *left = NULL, *right = NULL;
    int status;
    if (!encode_request_read(argc, argv, &asked, &status)) {
        return status;
    }
    status = read_grey(asked.left, &asked.stereo.left, &left);
    if (status == DONE) {
        status = read_grey(asked.right, &asked.stereo.right, &right);
    }
    if (status == DONE) {
        status = check_geometry(&asked);
    }
    if (status == DONE) {
        status = encode_pair(&asked);
    }
    free(left);
    free(right);
    return status;
}
