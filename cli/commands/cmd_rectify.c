#include <stdio.h>

#include "camera/rectifier.h"
#include "command.h"
#include "pictures/picture_library.h"
#include "pictures/picture_write.h"
#include "pictures/planes.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/plain.h"

enum { OUTPUT, CALIBRATION, JSON, MEMORY_LIMIT };

static const option options[] = {
    [OUTPUT] = {"output", 'o', true, "LEFT2 RIGHT2", NULL,
                "the two pictures to write: .png, .pgm or .ppm", true},
    [CALIBRATION] = CALIBRATION_OPTION(true, CALIBRATION_FILES),
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

/* The two pictures that are written. */
typedef struct written_pair {
    const char *paths[2];
    output *files[2];
} written_pair;

static int check_path(const char *path)
{
    bool png = path_ends(path, ".png");
    if (png && !picture_library_writes_png()) {
        return fail_usage("-o %s: this build writes only .pgm and .ppm; for .png build qstereo "
                          "with OpenCV (make OPENCV=1)",
                          path);
    }
    return png || path_ends(path, ".pgm") || path_ends(path, ".ppm")
               ? DONE
               : fail_usage("-o %s: the name of a picture ends in .png, .pgm or .ppm", path);
}

static int read_outputs(const job *at, written_pair *asked)
{
    size_t next = 0;
    const char *path = options_next(at->given, OUTPUT, &next);
    /* If -o is given more than once, the last one counts. */
    do {
        asked->paths[0] = path;
        asked->paths[1] = options_next(at->given, OUTPUT, &next);
        path = options_next(at->given, OUTPUT, &next);
    } while (path != NULL);
    TRY(check_path(asked->paths[0]));
    return check_path(asked->paths[1]);
}

static int write_rectified(const picture *made, const char *path, output *to)
{
    bool coloured = made->channels == 3;
    if (path_ends(path, coloured ? ".pgm" : ".ppm")) {
        return fail(BAD_INPUT, path, "the picture is %s: name a %s",
                    coloured ? "in colours" : "grey", coloured ? ".ppm" : ".pgm");
    }
    return picture_write(made, path_ends(path, ".png"), to);
}

static int rectify_one(const rectifier *by, unsigned side, const picture *from, const char *name,
                       const written_pair *asked)
{
    picture made;
    TRY(rectifier_apply(by, side, from, input_name(name), &made));
    int status = write_rectified(&made, asked->paths[side], asked->files[side]);
    picture_free(&made);
    return status;
}

static void print_result(const job *at, const written_pair *asked, const calibration *by)
{
    stereo_geometry found = calibration_geometry(by);
    if (at->json) {
        json_begin();
        json_name("left", asked->paths[0]);
        json_name("right", asked->paths[1]);
        json_count("width", by->width);
        json_count("height", by->height);
        json_real("focal_length", found.focal);
        json_real("baseline", found.baseline);
        json_real("disparity_offset", found.offset);
        json_end();
        return;
    }
    printf("%s, %s: %lu x %lu pixels, focal length %.2f pixels, baseline %g\n",
           plain(asked->paths[0]), plain(asked->paths[1]), (unsigned long)by->width,
           (unsigned long)by->height, found.focal, found.baseline);
}

/* What the picture in work and its rectified one take beside the tables. */
static int check_memory(const job *at, const char *name, const picture *first)
{
    return budget_need(&at->limit, name, bytes_product(picture_bytes(first), 4));
}

static int rectify_both(job *at, calibration *by, const picture *first, const written_pair *asked)
{
    const char *const *names = at->given->operands;
    rectifier made;
    picture second;
    TRY(calibration_complete(by, input_name(names[0]), first->width, first->height));
    TRY(check_memory(at, input_name(names[0]), first));
    TRY(rectifier_make(by, &at->limit, &made));
    TRY(rectify_one(&made, 0, first, names[0], asked));
    TRY(picture_open(names[1], &at->limit, &second));
    int status = calibration_complete(by, input_name(names[1]), second.width, second.height);
    status = status == DONE ? rectify_one(&made, 1, &second, names[1], asked) : status;
    picture_free(&second);
    return status;
}

static int run_rectify(job *at)
{
    const char *left = at->given->operands[0];
    written_pair asked;
    calibration by;
    picture first;
    TRY(read_outputs(at, &asked));
    TRY(calibration_read(at, CALIBRATION, &at->limit, &by));
    if (by.is_rectified) {
        return fail(BAD_INPUT, by.name,
                    "is of pictures that are rectified already: match them as they are");
    }
    TRY(picture_open(left, &at->limit, &first));
    int status = job_open_output(at, asked.paths[0], &asked.files[0]);
    status = status == DONE ? job_open_output(at, asked.paths[1], &asked.files[1]) : status;
    status = status == DONE ? rectify_both(at, &by, &first, &asked) : status;
    picture_free(&first);
    TRY(status);
    TRY(job_commit(at));
    print_result(at, &asked, &by);
    return DONE;
}

const command cmd_rectify = {
    .line =
        {
            .name = "rectify",
            .operands = {"LEFT", "RIGHT"},
            .about =
                "Turns the pictures of two calibrated cameras into a rectified pair: without the "
                "distortion of the lenses, and with each point on the same row of both. The "
                "calibration is what OpenCV's stereoCalibrate gives, in a file of its "
                "FileStorage: the matrices K1, D1, K2, D2, R and T (or M1, D1, M2, D2, or "
                "cameraMatrix1, distCoeffs1, ...). R1, R2, P1 and P2 are taken from it, too, if it "
                "has them. Else they are found as OpenCV's stereoRectify finds them with "
                "alpha = 0: every pixel of the result lies inside of what the cameras saw.\n",
            OPTIONS(options),
            .examples = "  qstereo rectify left.png right.png --calibration stereo.yml \\\n"
                        "      -o left2.png right2.png\n"
                        "  qstereo rectify left.png right.png --calibration intrinsics.yml \\\n"
                        "      --calibration extrinsics.yml -o left2.png right2.png\n",
        },
    .summary = "turn the pictures of two calibrated cameras into a rectified pair",
    .run = run_rectify,
};
