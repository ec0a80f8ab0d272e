/* Removes the noise from a small picture.
 *
 *     denoise_grid
 *
 * A labelling problem need not come from a stereo pair. Here each pixel of a picture is a site, and
 * the four grey levels 0 to 3 are its labels. A label costs 4 for each level that it is away from
 * the grey level that the pixel has; and two neighbours cost 3 for each level that they are apart,
 * at most 6. So a lone wrong pixel is put right, and an edge of an object stays. */
#include <qstereo.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 16, HEIGHT = 8, SITES = WIDTH * HEIGHT, LABELS = 4 };

static const char *const noisy[HEIGHT] = {
    "0000003333330000", "0100003333310000", "0000003033330020", "0000003333330000",
    "1111111112111111", "1111311111111111", "1111111111112222", "1110111111112222",
};

static void check(qs_status status)
{
    if (status != QS_OK) {
        fprintf(stderr, "denoise_grid: %s\n", qs_status_text(status));
        exit(3);
    }
}

static void *need(size_t size)
{
    void *memory = malloc(size);
    if (memory == NULL) {
        fputs("not enough memory\n", stderr);
        exit(4);
    }
    return memory;
}

/* costs[site * LABELS + label] */
static void fill_costs(int32_t costs[SITES * LABELS])
{
    for (int site = 0; site < SITES; site++) {
        int grey = noisy[site / WIDTH][site % WIDTH] - '0';
        for (int label = 0; label < LABELS; label++) {
            costs[site * LABELS + label] = 4 * abs(label - grey);
        }
    }
}

int main(void)
{
    static int32_t costs[SITES * LABELS];
    fill_costs(costs);
    const qs_problem problem = {
        .labels = LABELS,
        .scale = 1, /* costs are whole numbers as they are */
        .weight = 3,
        .pairwise = {.smoothness = QS_TRUNCATED_LINEAR, .truncation = 2},
        .grid = {.width = WIDTH, .height = HEIGHT},
        .costs = costs,
    };
    qs_model model;
    size_t size = qs_model_of_problem_workspace(&problem);
    void *model_memory = need(size);
    check(qs_model_of_problem(&problem, model_memory, size, &model, NULL));

    /* Expansion moves from labelling to labelling. The usual start: each site's cheapest label. */
    uint16_t labelling[SITES];
    qs_solution solution;
    qs_model_winner(&model, labelling);
    int64_t before = qs_model_energy(&model, labelling);
    size = qs_expansion_workspace(&model);
    void *memory = need(size);
    check(qs_expansion(&model, NULL, memory, size, labelling, &solution));

    for (int y = 0; y < HEIGHT; y++) {
        printf("%s  ", noisy[y]);
        for (int x = 0; x < WIDTH; x++) {
            putchar('0' + labelling[y * WIDTH + x]);
        }
        putchar('\n');
    }
    printf("energy before %lld, after %lld\n", (long long)before, (long long)solution.energy);
    free(memory);
    free(model_memory);
    return 0;
}
