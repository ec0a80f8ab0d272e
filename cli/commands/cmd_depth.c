#include <inttypes.h>
#include <stdio.h>

#include "camera/depth.h"
#include "command.h"
#include "pictures/disparity_map.h"
#include "pictures/picture_write.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/names.h"
#include "text/numbers.h"
#include "text/plain.h"

enum { OUTPUT, CALIBRATION, UNIT, COLOR, SCALE, NO_VALUE, JSON, MEMORY_LIMIT };

static const option options[] = {
    [OUTPUT] = {"output", 'o', true, "OUT", NULL,
                "depths in mm to write, a .png or .pgm of 16 bits, or a point cloud, a .ply; - is "
                "standard output, as PGM"},
    [CALIBRATION] = CALIBRATION_OPTION(true, CALIBRATION_FILES),
    [UNIT] = {"unit", 0, false, "NAME", "mm", "the calibration's unit of length: m, cm or mm"},
    [COLOR] = {"color", 0, false, "PICTURE", NULL,
               "the rectified left picture: gives the points of a .ply their colours"},
    [SCALE] = {"scale", 0, false, "S", "8", "a .png or .pgm MAP holds disparity x S"},
    [NO_VALUE] = {"no-value", 0, false, "V", NULL, "in MAP " NO_VALUE_HELP},
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

typedef struct request {
    const char *path; /* of the output */
    bool cloud, png;
    map_form form;
    const char *colour; /* NULL = none */
    double unit;
} request;

static int read_request(const job *at, request *asked)
{
    int millimetres;
    asked->path = at->values[OUTPUT];
    asked->cloud = path_ends(asked->path, ".ply");
    asked->colour = at->values[COLOR];
    if (!asked->cloud && !path_ends(asked->path, ".png") && !path_ends(asked->path, ".pgm") &&
        !output_is_straight(asked->path)) {
        return fail_usage("-o %s: the name ends in .png or .pgm for depths, in .ply for points",
                          asked->path);
    }
    if (!asked->cloud) {
        TRY(picture_format_read(asked->path, &asked->png));
    }
    if (asked->colour != NULL && !asked->cloud) {
        return fail_usage("--color goes with points: name a .ply with -o");
    }
    TRY(name_read(&unit_names, at->values[UNIT], "", &millimetres));
    asked->unit = millimetres / 1000.0;
    return map_form_read("--scale", at->values[SCALE], "--no-value", at->values[NO_VALUE],
                         &asked->form);
}

/* A baseline that hardly any pair of cameras has tells that the unit is another one. */
static void hint_unit(const job *at, const calibration *by, const depth_source *from)
{
    double metres = from->by.baseline * from->unit;
    if (metres < 0.002 || metres > 20) {
        warn(by->name, "its baseline of %g is %g m with --unit %s: is that its unit?",
             from->by.baseline, metres, at->values[UNIT]);
    }
}

static void print_result(const job *at, const request *asked, const depth_range *found)
{
    if (at->json) {
        json_begin();
        json_name("output", asked->path);
        json_count("points", found->points);
        json_count("left_out", found->left_out);
        json_real("nearest", found->nearest);
        json_real("farthest", found->farthest);
        json_end();
        return;
    }
    printf("%s: %" PRIu64 " point%s, %.3f m to %.3f m away; %" PRIu64 " pixel%s left out\n",
           plain(asked->path), found->points, plural(found->points), found->nearest,
           found->farthest, found->left_out, plural(found->left_out));
}

static int write_cloud(const request *asked, const depth_source *from, const depth_range *found,
                       budget *limit, output *to)
{
    colours picked;
    if (asked->colour != NULL) {
        TRY(colours_read(asked->colour, limit, &picked));
        TRY(same_size_check(asked->colour, picked.width, picked.height, "the map", from->map.width,
                            from->map.height));
    }
    cloud_write(from, found->points, asked->colour != NULL ? &picked : NULL, to);
    return DONE;
}

static int write_depths(const request *asked, const depth_source *from, const depth_range *found,
                        output *to)
{
    if (found->farthest >= DEPTH_PICTURE_MOST + 0.0005) {
        warn(asked->path,
             "16 bits of millimetres end at %g m: farther pixels have no value (a .ply has all)",
             DEPTH_PICTURE_MOST);
    }
    return depth_picture_write(from, asked->png, to);
}

static int run_depth(job *at)
{
    const char *name = at->given->operands[0];
    request asked = {0};
    calibration by;
    depth_source from;
    output *to;
    TRY(read_request(at, &asked));
    TRY(calibration_read(at, CALIBRATION, &at->limit, &by));
    TRY(map_read(name, &asked.form, &at->limit, &from.map));
    TRY(calibration_complete(&by, input_name(name), from.map.width, from.map.height));
    from.by = calibration_geometry(&by);
    from.unit = asked.unit;
    hint_unit(at, &by, &from);
    depth_range found = depth_range_of(&from);
    TRY(job_open_output(at, asked.path, &to));
    TRY(asked.cloud ? write_cloud(&asked, &from, &found, &at->limit, to)
                    : write_depths(&asked, &from, &found, to));
    TRY(job_commit(at));
    if (!output_is_standard(asked.path)) {
        print_result(at, &asked, &found);
    }
    return DONE;
}

const command cmd_depth = {
    .line =
        {
            .name = "depth",
            .operands = {"MAP"},
            .about =
                "Turns the disparity map of a rectified pair into depths or points. A disparity d "
                "is a depth of f B / (d + doffs), with the focal length f, the baseline B and the "
                "offset doffs of the rectified cameras, from the same calibration that the "
                "pictures were rectified with. A picture of depths holds whole millimetres along "
                "the optical axis, 0 where there is none. A cloud holds metres: x to the right, "
                "y down, z forward. Pixels without a disparity, and those at infinity, are left "
                "out.\n",
            OPTIONS(options),
            .examples =
                "  qstereo depth disparity.pfm --calibration stereo.yml -o depth.png\n"
                "  qstereo depth disparity.pfm --calibration stereo.yml --unit m -o cloud.ply \\\n"
                "      --color left2.png\n"
                "  qstereo depth disp0.pfm --calibration calib.txt -o cloud.ply --color im0.png\n",
        },
    .summary = "turn a disparity map into depths in millimetres or a point cloud",
    .run = run_depth,
};
