#include "right_side.h"

#include "text/fail.h"

/* A picture from right to left. */
static int mirror(const char *name, const qs_image *image, budget *limit, qs_image *made)
{
    uint8_t *pixels = budget_take(limit, name, image->width * image->height);
    if (pixels == NULL) {
        return NO_RESOURCE;
    }
    for (size_t y = 0; y < image->height; y++) {
        const uint8_t *from = image->pixels + y * image->stride;
        uint8_t *to = pixels + y * image->width;
        for (size_t x = 0; x < image->width; x++) {
            to[x] = from[image->width - 1 - x];
        }
    }
    *made = (qs_image){pixels, image->width, image->height, image->width};
    return DONE;
}

/* The columns of the right picture that the window's matches can lie in, seen in the mirror. */
static void mirror_window(qs_matching *of)
{
    uint32_t width = (uint32_t)of->left.width;
    if (of->width == 0) {
        return;
    }
    int64_t parts = of->parts;
    int64_t left = (int64_t)of->x - (of->disparity_max + parts - 1) / parts;
    int64_t ahead = of->disparity_min < 0 ? (parts - 1 - of->disparity_min) / parts : 0;
    int64_t right = (int64_t)of->x + of->width + ahead;
    uint32_t from = left > 0 ? (uint32_t)left : 0;
    uint32_t end = right < width ? (uint32_t)right : width;
    of->x = width - end;
    of->width = end - from;
}

int right_side_make(const pair *of, const solver *by, uint64_t iterations, bool straight,
                    budget *limit, side *right)
{
    qs_matching *mirrored = &right->stereo;
    made_problem *made = &right->made;
    qs_status status;
    *made = (made_problem){.name = input_name(of->right), .mend = "--lambda or --truncation"};
    *mirrored = of->stereo;
    TRY(mirror(made->name, &of->stereo.right, limit, &mirrored->left));
    TRY(mirror(made->name, &of->stereo.left, limit, &mirrored->right));
    mirror_window(mirrored);
    TRY(pair_problem(mirrored, made->name, limit, &made->problem, &status));
    if (status != QS_OK) {
        return made_fail(made, "choose a smaller --roi or --disparity", status);
    }
    made->problem.pairwise = of->pairwise;
    TRY(made_need(made, by, 0, limit));
    TRY(made_lay_out(made, straight && by->run_straight != NULL, limit, &right->laid));
    if (right->halved) {
        TRY(halves_begin(made->name, mirrored, &of->pairwise, limit, &right->finer));
    }
    return laid_out_need(&right->laid, by, iterations, 0, limit);
}

halves *side_halves(side *of)
{
    return of->halved ? &of->finer : NULL;
}
