/* From two grey pictures to a disparity map.
 *
 *     pictures_to_map LEFT.pgm RIGHT.pgm MAP.pgm DISPARITIES
 *
 * The pictures are a rectified stereo pair: what is at (x, y) in the left one is at (x - d, y) in
 * the right one. d is its disparity; near things have a large one. DISPARITIES is the number of
 * disparities to choose from: 0, 1, ..., DISPARITIES - 1. The map has 8 grey levels for each pixel
 * of disparity. 0 in it means "no value": there the match may lie outside the right picture. */
#include <qstereo.h>
#include <stdio.h>
#include <stdlib.h>

/* The library allocates nothing. It says how much memory it needs, and the caller brings it. */
static void *need(void *memory, size_t size)
{
    memory = realloc(memory, size);
    if (memory == NULL) {
        fputs("not enough memory\n", stderr);
        exit(4);
    }
    return memory;
}

/* Whatever can fail returns a status. */
static void check(qs_status status)
{
    if (status != QS_OK) {
        fprintf(stderr, "pictures_to_map: %s\n", qs_status_text(status));
        exit(3);
    }
}

/* The whole way. `map` has the size of the left picture. Two workspaces are enough: `first` is for
 * the problem, and after that for the solver. `second` holds the model while it is solved. */
static qs_solution match(qs_image left, qs_image right, uint32_t disparities, int32_t *map)
{
    qs_stereo stereo = {.left = left, .right = right, .disparity_max = (int32_t)disparities - 1};
    stereo.scale = 1; /* costs are whole grey levels */
    stereo.weight = 20; /* what two neighbours of different disparity cost: the smoothness */
    qs_problem problem;
    qs_model model;
    qs_labels labels;
    qs_solution solution;
    size_t size = qs_stereo_workspace(&stereo);
    void *first = need(NULL, size), *second;
    check(qs_stereo_problem(&stereo, first, size, &problem));
    size = qs_model_of_problem_workspace(&problem);
    second = need(NULL, size);
    check(qs_model_of_problem(&problem, second, size, &model, &labels));
    size = qs_best_workspace(&model);
    first = need(first, size);
    uint16_t *labelling = need(NULL, model.sites * sizeof *labelling);
    check(qs_best(&model, NULL, first, size, labelling, &solution));
    check(qs_map_of_labelling(&labels, labelling, map));
    free(labelling);
    free(second);
    free(first);
    return solution;
}

/* A picture as P5 with 255 grey levels and no comments, for the sake of a short example. */
static qs_image read_pgm(const char *path)
{
    qs_image image = {0};
    FILE *file = fopen(path, "rb");
    if (file == NULL || fscanf(file, "P5 %zu %zu 255", &image.width, &image.height) != 2 ||
        fgetc(file) == EOF || image.width > 65535 || image.height > 65535) {
        fprintf(stderr, "%s: cannot be read as a binary PGM with 255 grey levels\n", path);
        exit(3);
    }
    size_t size = image.width * image.height;
    uint8_t *pixels = need(NULL, size);
    if (fread(pixels, 1, size, file) != size) {
        fprintf(stderr, "%s: ends too early\n", path);
        exit(3);
    }
    fclose(file);
    image.pixels = pixels;
    image.stride = image.width;
    return image;
}

static void write_pgm(const char *path, const int32_t *map, size_t width, size_t height)
{
    enum { SCALE = 8 };
    FILE *file = fopen(path, "wb");
    if (file == NULL) {
        fprintf(stderr, "%s: cannot be written\n", path);
        exit(4);
    }
    fprintf(file, "P5\n%zu %zu\n255\n", width, height);
    for (size_t i = 0; i < width * height; i++) {
        bool none = map[i] == QS_NO_DISPARITY;
        fputc(none ? 0 : (int)qs_disparity_hold((uint32_t)map[i], SCALE), file);
    }
    if (fclose(file) != 0) {
        fprintf(stderr, "%s: cannot be written\n", path);
        exit(4);
    }
}

int main(int argc, char **argv)
{
    int disparities = argc == 5 ? atoi(argv[4]) : 0;
    if (disparities < 1 || disparities > 32) {
        fputs("usage: pictures_to_map LEFT.pgm RIGHT.pgm MAP.pgm DISPARITIES (1 to 32)\n", stderr);
        return 2;
    }
    qs_image left = read_pgm(argv[1]), right = read_pgm(argv[2]);
    int32_t *map = need(NULL, left.width * left.height * sizeof *map);
    qs_solution solution = match(left, right, (uint32_t)disparities, map);
    write_pgm(argv[3], map, left.width, left.height);
    printf("energy %lld, lower bound %lld\n", (long long)solution.energy,
           (long long)solution.lower_bound);
    free(map);
    free((void *)left.pixels);
    free((void *)right.pixels);
    return 0;
}
