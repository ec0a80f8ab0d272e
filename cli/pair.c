#include "pair.h"

#include <stdlib.h>
#include <string.h>

#include "messages.h"
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
static int check_geometry(const pair *asked)
{
    const qs_stereo *stereo = &asked->stereo;
    const qs_image *left = &stereo->left, *right = &stereo->right;
    size_t end = asked->whole ? left->width : (size_t)stereo->x + stereo->width;
    if (left->width != right->width || left->height != right->height) {
        return fail(BAD_INPUT, input_name(asked->right),
                    "is %zu x %zu pixels, but %s is %zu x %zu: a pair has one size", right->width,
                    right->height, input_name(asked->left), left->width, left->height);
    }
    if (end > left->width || (!asked->whole && (size_t)stereo->y + stereo->height > left->height)) {
        return fail(BAD_INPUT, input_name(asked->left),
                    "is %zu x %zu pixels: --roi %lu,%lu,%lu,%lu does not lie inside", left->width,
                    left->height, (unsigned long)stereo->x, (unsigned long)stereo->y,
                    (unsigned long)stereo->width, (unsigned long)stereo->height);
    }
    if (end <= stereo->disparity_max) {
        return fail(BAD_INPUT, input_name(asked->left),
                    "%s ends at column %zu, too narrow for disparity %lu: no pixel would have all "
                    "of its matches inside the "
                    "right picture; lower --disparity%s",
                    asked->whole ? "the picture" : "--roi", end - 1,
                    (unsigned long)stereo->disparity_max,
                    asked->whole ? "" : " or move --roi to the right");
    }
    return DONE;
}

static int fail_encode(const pair *asked, qs_status status)
{
    const char *name = input_name(asked->left);
    if (status == QS_E_LIMIT) {
        return fail(BAD_INPUT, name,
                    "sites x labels is over %u variables: choose a smaller --roi or --disparity",
                    QS_VARIABLES_MAX);
    }
    if (status == QS_E_OVERFLOW) {
        return fail(BAD_INPUT, name,
                    "the coefficients overflow (their sum is above 2^53): choose a smaller %s",
                    asked->weights);
    }
    return fail_status(name, status);
}

static int make_problem(pair *opened, qs_problem *problem)
{
    size_t size = qs_stereo_workspace(&opened->stereo);
    opened->workspace = malloc(size > 0 ? size : 1);
    if (opened->workspace == NULL) {
        return fail_memory(NULL);
    }
    qs_status made = qs_stereo_problem(&opened->stereo, opened->workspace, size, problem);
    if (made != QS_OK) {
        return fail_encode(opened, made);
    }
    problem->pairwise = opened->pairwise;
    return DONE;
}

int pair_open(pair *opened, qs_problem *problem)
{
    int status = read_grey(opened->left, &opened->stereo.left, &opened->left_pixels);
    if (status == DONE) {
        status = read_grey(opened->right, &opened->stereo.right, &opened->right_pixels);
    }
    if (status == DONE) {
        status = check_geometry(opened);
    }
    return status == DONE ? make_problem(opened, problem) : status;
}

void pair_close(pair *closed)
{
    free(closed->workspace);
    free(closed->left_pixels);
    free(closed->right_pixels);
}

int pair_encode(const pair *encoded, const qs_problem *problem, const qs_encode_options *options,
                const qs_sink *sink, uint64_t *size)
{
    size_t workspace_size = qs_encode_workspace(problem);
    void *workspace = malloc(workspace_size > 0 ? workspace_size : 1);
    if (workspace == NULL) {
        return fail_memory(NULL);
    }
    qs_status written = qs_encode(problem, options, sink, workspace, workspace_size, size);
    free(workspace);
    return written == QS_OK || written == QS_E_IO ? DONE : fail_encode(encoded, written);
}

int pair_hold(const pair *held, const qs_problem *problem, const qs_encode_options *options,
              budget *limit, problem_file *made)
{
    growing_file grown = growing_begin(limit->left);
    const qs_sink sink = {growing_append, &grown};
    memset(made, 0, sizeof *made);
    int status = pair_encode(held, problem, options, &sink, NULL);
    if (status != DONE) {
        file_free(&grown.file);
        return status;
    }
    status = growing_end(&grown, input_name(held->left), limit);
    return status == DONE ? problem_take(held->left, grown.file, limit, made) : status;
}
