#include "camera/calibration.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "camera/rectification.h"
#include "camera/storage.h"
#include "text/fail.h"

enum { FILES_MAX = 2, NAMES_MAX = 3 };

typedef struct file_set {
    const char *names[FILES_MAX];
    storage files[FILES_MAX];
    size_t count;
} file_set;

/* Finds a matrix under any of its names, in any of the files; where says in which. */
static stored_status find_any(const file_set *in, const char *const *names, matrix *found,
                              const char **where, const char **name)
{
    for (size_t n = 0; n < NAMES_MAX && names[n] != NULL; n++) {
        for (size_t f = 0; f < in->count; f++) {
            stored_status status = storage_find(&in->files[f], names[n], found);
            if (status != NOT_STORED) {
                *where = in->names[f];
                *name = names[n];
                return status;
            }
        }
    }
    return NOT_STORED;
}

/* Reads a matrix of `rows` x `columns`. *is_there says whether there is one. */
static int read_optional(const file_set *in, const char *const *names, size_t rows, size_t columns,
                         double *values, bool *is_there)
{
    matrix found;
    const char *where = in->names[0], *name = names[0];
    stored_status status = find_any(in, names, &found, &where, &name);
    *is_there = status == STORED;
    if (status == NOT_STORED) {
        return DONE;
    }
    if (status == STORED_BADLY || found.rows * found.columns != rows * columns) {
        return fail(BAD_INPUT, where, "%s is no matrix of %zu x %zu finite numbers", name, rows,
                    columns);
    }
    memcpy(values, found.values, rows * columns * sizeof *values);
    return DONE;
}

static int read_needed(const file_set *in, const char *const *names, size_t rows, size_t columns,
                       double *values)
{
    bool is_there;
    TRY(read_optional(in, names, rows, columns, values, &is_there));
    if (is_there) {
        return DONE;
    }
    return fail(BAD_INPUT, in->names[0],
                "has no matrix %s%s%s: a calibration has K1, D1, K2, D2, R and T, as OpenCV's "
                "stereoCalibrate gives them; if they are in two files, give --calibration twice",
                names[0], names[1] != NULL ? " or " : "", names[1] != NULL ? names[1] : "");
}

/* As many coefficients as OpenCV knows: 4, 5, 8, 12 or 14. The last two of 14 tilt the sensor, and
 * 0 is no tilt. None at all is a lens without distortion. */
static int read_distortion(const file_set *in, const char *const *names, double *coefficients)
{
    matrix found;
    const char *where = in->names[0], *name = names[0];
    stored_status status = find_any(in, names, &found, &where, &name);
    if (status == NOT_STORED) {
        return read_needed(in, names, 1, 5, coefficients);
    }
    size_t count = found.rows * found.columns;
    if (status == STORED_BADLY ||
        (count != 0 && count != 4 && count != 5 && count != 8 && count != 12 && count != 14)) {
        return fail(BAD_INPUT, where, "%s is no list of 4, 5, 8, 12 or 14 finite coefficients",
                    name);
    }
    if (found.values[12] != 0 || found.values[13] != 0) {
        return fail(BAD_INPUT, where,
                    "%s has a tilted sensor, which qstereo cannot rectify: calibrate without "
                    "CALIB_TILTED_MODEL",
                    name);
    }
    memcpy(coefficients, found.values, DISTORTIONS * sizeof *coefficients);
    return DONE;
}

static int check_camera_matrix(const char *name, const char *which, const double k[9])
{
    bool is_one =
        k[0] > 0 && k[4] > 0 && k[1] == 0 && k[3] == 0 && k[6] == 0 && k[7] == 0 && k[8] == 1;
    return is_one
               ? DONE
               : fail(BAD_INPUT, name, "%s is no camera matrix: [fx 0 cx; 0 fy cy; 0 0 1]", which);
}

/* R R^T is the identity matrix, but for the digits that a file leaves out. */
static int check_rotation(const char *name, const char *which, const double r[9])
{
    for (int i = 0; i < 9; i++) {
        const double *a = &r[i / 3 * 3], *b = &r[i % 3 * 3];
        double product = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        if (fabs(product - (i / 3 == i % 3)) > 1e-3) {
            return fail(BAD_INPUT, name, "%s is no rotation: its rows are not perpendicular",
                        which);
        }
    }
    return DONE;
}

static int read_camera(const file_set *in, unsigned side, camera *read)
{
    static const char *const matrices[2][NAMES_MAX] = {{"K1", "M1", "cameraMatrix1"},
                                                       {"K2", "M2", "cameraMatrix2"}};
    static const char *const lenses[2][NAMES_MAX] = {{"D1", "distCoeffs1", NULL},
                                                     {"D2", "distCoeffs2", NULL}};
    TRY(read_needed(in, matrices[side], 3, 3, read->matrix));
    TRY(check_camera_matrix(in->names[0], matrices[side][0], read->matrix));
    return read_distortion(in, lenses[side], read->distortion);
}

/* P2 has the baseline times the focal length; both cameras have the same focal length. */
static int check_projections(const char *name, const camera both[2])
{
    const double *left = both[0].projection, *right = both[1].projection;
    bool fits = left[0] > 0 && left[5] > 0 && fabs(left[0] - right[0]) <= 1e-6 * left[0] &&
                fabs(left[5] - right[5]) <= 1e-6 * left[5] && left[1] == 0 && left[10] == 1 &&
                fabs(left[6] - right[6]) < 1e-3 && right[7] == 0;
    if (!fits) {
        return fail(BAD_INPUT, name,
                    "P1 and P2 are no projections of cameras side by side with the same focal "
                    "length and the same rows");
    }
    if (right[3] >= 0) {
        return fail(BAD_INPUT, name,
                    "P2 has its camera on the left of the other: calibrate with the left camera as "
                    "the first one");
    }
    return DONE;
}

/* R1, R2, P1 and P2: all or none. */
static int read_projections(const file_set *in, calibration *read)
{
    static const char *const rotations[2][NAMES_MAX] = {{"R1", NULL, NULL}, {"R2", NULL, NULL}};
    static const char *const projections[2][NAMES_MAX] = {{"P1", NULL, NULL}, {"P2", NULL, NULL}};
    int count = 0;
    for (int side = 0; side < 2; side++) {
        camera *to = &read->cameras[side];
        bool has_rotation, has_projection;
        TRY(read_optional(in, rotations[side], 3, 3, to->rotation, &has_rotation));
        TRY(read_optional(in, projections[side], 3, 4, to->projection, &has_projection));
        count += has_rotation + has_projection;
        if (has_rotation) {
            TRY(check_rotation(read->name, rotations[side][0], to->rotation));
        }
    }
    if (count != 0 && count != 4) {
        return fail(BAD_INPUT, read->name,
                    "has some of R1, R2, P1 and P2: give all four, or none of them");
    }
    read->has_projections = count == 4;
    return read->has_projections ? check_projections(read->name, read->cameras) : DONE;
}

static int read_pose(const file_set *in, calibration *read)
{
    static const char *const rotation[NAMES_MAX] = {"R", NULL, NULL};
    static const char *const translation[NAMES_MAX] = {"T", NULL, NULL};
    TRY(read_needed(in, rotation, 3, 3, read->rotation));
    TRY(read_needed(in, translation, 3, 1, read->translation));
    return check_rotation(read->name, "R", read->rotation);
}

/* The size of the pictures, where the files say it: under the names of OpenCV's samples. */
static int read_size(const file_set *in, calibration *read)
{
    static const char *const names[3][NAMES_MAX] = {{"image_width", NULL, NULL},
                                                    {"image_height", NULL, NULL},
                                                    {"imageSize", "image_size", "size"}};
    double size[2] = {0, 0};
    bool has_width, has_height, has_both = false;
    TRY(read_optional(in, names[0], 1, 1, &size[0], &has_width));
    TRY(read_optional(in, names[1], 1, 1, &size[1], &has_height));
    if (!has_width || !has_height) {
        TRY(read_optional(in, names[2], 1, 2, size, &has_both));
    }
    if ((has_width && has_height) || has_both) {
        if (!(size[0] >= 1 && size[0] <= INT32_MAX && size[1] >= 1 && size[1] <= INT32_MAX)) {
            return fail(BAD_INPUT, read->name, "the size of its pictures is %g x %g", size[0],
                        size[1]);
        }
        read->width = (uint32_t)size[0];
        read->height = (uint32_t)size[1];
    }
    return DONE;
}

static int read_opencv(const file_set *in, calibration *read)
{
    TRY(read_camera(in, 0, &read->cameras[0]));
    TRY(read_camera(in, 1, &read->cameras[1]));
    TRY(read_projections(in, read));
    if (!read->has_projections) {
        TRY(read_pose(in, read));
    }
    return read_size(in, read);
}

/* Finds "name=" at the beginning of a line of calib.txt. Returns how many numbers follow; 0 = it is
 * not there; MATRIX_MAX + 1 = they cannot be read. */
static size_t find_setting(const storage *in, const char *name, double values[MATRIX_MAX])
{
    size_t length = strlen(name);
    for (const char *at = in->text; at < in->end;) {
        const char *end = memchr(at, '\n', (size_t)(in->end - at));
        end = end != NULL ? end : in->end;
        if ((size_t)(end - at) > length && memcmp(at, name, length) == 0 && at[length] == '=') {
            return storage_numbers(at + length + 1, end, values);
        }
        at = end + (end < in->end);
    }
    return 0;
}

static bool read_setting(const storage *in, const char *name, size_t count,
                         double values[MATRIX_MAX])
{
    return find_setting(in, name, values) == count;
}

static bool is_middlebury(const storage *in)
{
    double values[MATRIX_MAX];
    return find_setting(in, "cam0", values) > 0;
}

static void project(const double k[9], double shift, double projection[12])
{
    for (int row = 0; row < 3; row++) {
        memcpy(projection + 4 * row, k + 3 * row, 3 * sizeof *k);
        projection[4 * row + 3] = 0;
    }
    projection[3] = shift;
}

static bool read_whole(const storage *in, const char *name, uint32_t most, uint32_t *number)
{
    double values[MATRIX_MAX];
    bool is_one = read_setting(in, name, 1, values) && values[0] >= 1 && values[0] <= most;
    *number = is_one ? (uint32_t)values[0] : 0;
    return is_one;
}

/* Middlebury's calib.txt: cam0, cam1, doffs, baseline, width, height, ndisp (Scharstein et al.,
 * GCPR 2014). Its pictures are rectified. */
static int read_middlebury(const storage *in, calibration *read)
{
    double values[MATRIX_MAX], left[MATRIX_MAX], right[MATRIX_MAX], baseline[MATRIX_MAX];
    bool fits = read_setting(in, "cam0", 9, left) && read_setting(in, "cam1", 9, right) &&
                read_setting(in, "baseline", 1, baseline) && baseline[0] > 0 &&
                read_whole(in, "width", INT32_MAX, &read->width) &&
                read_whole(in, "height", INT32_MAX, &read->height);
    if (!fits) {
        return fail(BAD_INPUT, read->name,
                    "lacks one of cam0, cam1, baseline, width and height, or has another one than "
                    "Middlebury's calib.txt");
    }
    TRY(check_camera_matrix(read->name, "cam0", left));
    TRY(check_camera_matrix(read->name, "cam1", right));
    if (read_setting(in, "doffs", 1, values)) {
        right[2] = left[2] + values[0]; /* it has more digits than the difference of the two */
    }
    project(left, 0, read->cameras[0].projection);
    project(right, -right[0] * baseline[0], read->cameras[1].projection);
    (void)read_whole(in, "ndisp", QS_LABELS_MAX, &read->labels);
    read->is_rectified = read->has_projections = true;
    return check_projections(read->name, read->cameras);
}

static int open_files(const job *at, size_t index, budget *limit, file_set *opened)
{
    size_t next = 0;
    const char *path;
    memset(opened, 0, sizeof *opened);
    while ((path = options_next(at->given, index, &next)) != NULL) {
        file_bytes file;
        if (opened->count == FILES_MAX) {
            return fail_usage("--calibration is given more than twice: a calibration is one file, "
                              "or two");
        }
        TRY(file_read(path, limit, &file));
        opened->names[opened->count] = input_name(path);
        opened->files[opened->count++] = storage_of(&file);
    }
    return DONE;
}

int calibration_read(const job *at, size_t index, budget *limit, calibration *read)
{
    file_set files;
    memset(read, 0, sizeof *read);
    TRY(open_files(at, index, limit, &files));
    read->name = files.names[0];
    for (size_t f = 0; f < files.count; f++) {
        const storage *file = &files.files[f];
        if (file->end > file->text && *file->text == '{') {
            return fail(BAD_INPUT, files.names[f],
                        "is JSON: have OpenCV's FileStorage write .yml or .xml");
        }
    }
    return is_middlebury(&files.files[0]) ? read_middlebury(&files.files[0], read)
                                          : read_opencv(&files, read);
}

int calibration_complete(calibration *of, const char *picture_name, size_t width, size_t height)
{
    if (of->width != 0 && (of->width != width || of->height != height)) {
        return fail(BAD_INPUT, picture_name,
                    "is %zu x %zu pixels, but %s is of cameras with %" PRIu32 " x %" PRIu32, width,
                    height, of->name, of->width, of->height);
    }
    of->width = (uint32_t)width;
    of->height = (uint32_t)height;
    if (of->has_projections) {
        return DONE;
    }
    TRY(rectification_find(of));
    of->has_projections = true;
    return DONE;
}

stereo_geometry calibration_geometry(const calibration *of)
{
    const double *left = of->cameras[0].projection, *right = of->cameras[1].projection;
    return (stereo_geometry){
        .focal = left[0],
        .focal_y = left[5],
        .x0 = left[2],
        .y0 = left[6],
        .offset = right[2] - left[2],
        .baseline = -right[3] / right[0],
    };
}
