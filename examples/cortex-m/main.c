/* Turns stereo pairs into QUBO files on a Cortex-M4 without an operating system.
 *
 * `make check-cortex-m` runs it in an emulator. Files and messages go through semihosting; on a
 * board `send` would feed a serial line or a memory card, and nothing else changes. The program
 * prints how much code and memory the encoder took, and fails where that is more than promised. */
#include <qstereo.h>

#include "machine.h"

enum {
    CODE_MAX = 12 * 1024, /* bytes of code and constants: the library, libgcc, mem* */
    RAM_MAX = 2 * 1024, /* bytes of workspaces and stack, the pictures apart */
    WIDTH = 64,
    HEIGHT = 48,
    LABELS = 8
};

typedef struct job {
    const char *name; /* of the file to write */
    qs_stereo stereo;
    qs_encode_options options;
} job;

/* The paper's example, samples/paper. */
static const uint8_t paper_left[12] = {0, 0, 100, 100, 0, 0, 0, 100, 0, 0, 100, 100};
static const uint8_t paper_right[12] = {0, 50, 100, 100, 0, 0, 50, 100, 0, 50, 100, 100};

static uint8_t left[WIDTH * HEIGHT], right[WIDTH * HEIGHT];
static uint32_t workspace[320]; /* the rest of RAM_MAX is stack */
static size_t workspace_used;

/* A pattern without meaning: each row of the left picture is the right one's, moved by 0 to 7. */
static void draw(void)
{
    uint32_t state = 1;
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        state = state * 1664525u + 1013904223u;
        right[i] = (uint8_t)(state >> 24);
    }
    for (uint32_t y = 0; y < HEIGHT; y++) {
        for (uint32_t x = 0; x < WIDTH; x++) {
            uint32_t moved = y % LABELS;
            left[y * WIDTH + x] = right[y * WIDTH + (x < moved ? 0 : x - moved)];
        }
    }
}

static bool send(void *file, const void *bytes, size_t size)
{
    return machine_write(*(int *)file, bytes, size);
}

static qs_status encode(const job *todo)
{
    int file = machine_create(todo->name);
    qs_sink sink = {send, &file};
    qs_problem problem;
    size_t first = qs_stereo_workspace(&todo->stereo);
    first = (first + 7) / 8 * 8;
    if (first > sizeof workspace) {
        return QS_E_WORKSPACE;
    }
    qs_status status = qs_stereo_problem(&todo->stereo, workspace, first, &problem);
    if (status == QS_OK) {
        size_t second = qs_encode_workspace(&problem);
        workspace_used = first + second > workspace_used ? first + second : workspace_used;
        status = qs_encode(&problem, &todo->options, &sink, (char *)workspace + first,
                           sizeof workspace - first, NULL);
    }
    machine_close(file);
    return status;
}

static qs_image picture(const uint8_t *pixels, size_t width, size_t height)
{
    return (qs_image){pixels, width, height, width};
}

static bool encode_paper(void)
{
    job paper = {.name = "paper.qcf",
                 .stereo = {.left = picture(paper_left, 4, 3),
                            .right = picture(paper_right, 4, 3),
                            .disparity_max = 1,
                            .scale = 1,
                            .weight = 10},
                 .options = {.encoding = QS_ONE_HOT, .penalty = QS_PENALTY_GIVEN, .alpha = 200}};
    return encode(&paper) == QS_OK;
}

static bool encode_pattern(void)
{
    job pattern = {.name = "pattern.qcf",
                   .stereo = {.left = picture(left, WIDTH, HEIGHT),
                              .right = picture(right, WIDTH, HEIGHT),
                              .disparity_max = LABELS - 1,
                              .scale = 1,
                              .weight = 20}};
    return encode(&pattern) == QS_OK;
}

static bool within(const char *what, size_t bytes, size_t most)
{
    machine_say(what);
    machine_say_number(bytes);
    machine_say(" bytes of ");
    machine_say_number(most);
    machine_say("\n");
    return bytes <= most;
}

int main(void)
{
    draw();
    machine_paint_stack();
    bool written = encode_paper() && encode_pattern();
    size_t stack = machine_stack_used();
    bool small = within("code and constants: ", machine_library_size(), CODE_MAX);
    machine_say("workspaces: ");
    machine_say_number(workspace_used);
    machine_say(" bytes, stack: ");
    machine_say_number(stack);
    machine_say(" bytes\n");
    small &= within("RAM beside the pictures: ", workspace_used + stack, RAM_MAX);
    return written && small ? 0 : 1;
}
