#include "fields/flow_file.h"

#include <math.h>
#include <string.h>

#include "arrays/little_endian.h"
#include "arrays/npy.h"
#include "pictures/netpbm.h"
#include "pictures/picture_library.h"
#include "pictures/picture_read.h"
#include "pictures/picture_write.h"
#include "text/fail.h"

enum { FLO_HEAD = 12, FLO_VECTOR = 8 };

/* Of KITTI's pictures. */
enum { KITTI_ZERO = 1 << 15, KITTI_UNITS = 64 };

/* Middlebury's files say "unknown" by anything larger. */
static const float flo_unknown = 1e9F;

int flow_take(const char *name, uint32_t width, uint32_t height, budget *limit, flow_field *taken)
{
    uint64_t pixels = (uint64_t)width * height;
    *taken =
        (flow_field){width, height, budget_take(limit, name, bytes_product(pixels, FLO_VECTOR))};
    return taken->vectors != NULL ? DONE : NO_RESOURCE;
}

static int read_flo(const char *name, const file_bytes *file, budget *limit, flow_field *read)
{
    if (file->size < FLO_HEAD) {
        return fail(BAD_INPUT, name, "is a .flo that is cut short");
    }
    uint32_t width = load_u32(file->bytes + 4), height = load_u32(file->bytes + 8);
    if (width == 0 || height == 0 || width > INT32_MAX || height > INT32_MAX ||
        (uint64_t)width * height != (file->size - FLO_HEAD) / FLO_VECTOR ||
        (file->size - FLO_HEAD) % FLO_VECTOR != 0) {
        return fail(BAD_INPUT, name,
                    "is a .flo of %lu x %lu pixels, but has %zu bytes: it is damaged or cut short",
                    (unsigned long)width, (unsigned long)height, file->size);
    }
    TRY(flow_take(name, width, height, limit, read));
    for (size_t i = 0; i < (size_t)width * height; i++) {
        float dx = load_float(file->bytes + FLO_HEAD + FLO_VECTOR * i),
              dy = load_float(file->bytes + FLO_HEAD + FLO_VECTOR * i + 4);
        bool known = fabsf(dx) <= flo_unknown && fabsf(dy) <= flo_unknown;
        read->vectors[2 * i] = known ? dx : NAN;
        read->vectors[2 * i + 1] = known ? dy : NAN;
    }
    return DONE;
}

static int take_kitti(const char *name, const picture *from, budget *limit, flow_field *read)
{
    if (from->channels != 3 || from->maxval != 65535) {
        return fail(BAD_INPUT, name,
                    "is no field of displacements: give a .flo, or a PNG of KITTI's kind with 3 "
                    "channels of 16 bits");
    }
    TRY(flow_take(name, (uint32_t)from->width, (uint32_t)from->height, limit, read));
    for (size_t i = 0; i < from->width * from->height; i++) {
        const uint16_t *sample = from->samples + 3 * i;
        for (size_t c = 0; c < 2; c++) {
            read->vectors[2 * i + c] =
                sample[2] == 0 ? NAN : (float)(sample[c] - KITTI_ZERO) / KITTI_UNITS;
        }
    }
    return DONE;
}

static int read_kitti(const char *path, const file_bytes *file, budget *limit, flow_field *read)
{
    picture from;
    TRY(picture_decode(path, file, limit, &from));
    int status = take_kitti(input_name(path), &from, limit, read);
    picture_free(&from);
    return status;
}

/* A number of the array; infinite ones are unknown. */
static float number_at(const npy_array *array, uint64_t at)
{
    float value = (float)npy_float(array, at);
    return isfinite(value) ? value : NAN;
}

static int read_array(const char *path, budget *limit, flow_field *read)
{
    npy_array array;
    char shape[NPY_TEXT];
    TRY(npy_open(path, limit, &array));
    npy_shape_write(&array, shape);
    if (array.kind != NPY_FLOAT || array.dimensions != 3 || array.shape[2] != 2 ||
        array.shape[0] > INT32_MAX || array.shape[1] > INT32_MAX) {
        return fail(BAD_INPUT, array.name,
                    "has the shape %s: a field is height x width x 2, (dx, dy), of floats", shape);
    }
    TRY(flow_take(array.name, (uint32_t)array.shape[1], (uint32_t)array.shape[0], limit, read));
    for (uint64_t i = 0; i < array.count; i += 2) {
        float dx = number_at(&array, i), dy = number_at(&array, i + 1);
        bool known = !isnan(dx) && !isnan(dy);
        read->vectors[i] = known ? dx : NAN;
        read->vectors[i + 1] = known ? dy : NAN;
    }
    return DONE;
}

int flow_read(const char *path, budget *limit, flow_field *read)
{
    file_bytes file;
    if (path_ends(path, ".npy")) {
        return read_array(path, limit, read);
    }
    TRY(file_read(path, limit, &file));
    bool flo = file.size >= 4 && memcmp(file.bytes, "PIEH", 4) == 0;
    return flo ? read_flo(input_name(path), &file, limit, read)
               : read_kitti(path, &file, limit, read);
}

int flow_format_read(const char *path, bool *png)
{
    *png = path_ends(path, ".png");
    if (*png && !picture_library_writes_png()) {
        return fail_usage("-o %s: this build writes only .flo; for .png build qstereo with OpenCV "
                          "(make OPENCV=1)",
                          path);
    }
    if (!*png && !output_is_straight(path) && !path_ends(path, ".flo")) {
        return fail_usage("-o %s: the name of a field ends in .flo or .png", path);
    }
    return DONE;
}

static void write_flo(const flow_field *written, output *to)
{
    uint8_t bytes[FLO_HEAD] = {'P', 'I', 'E', 'H'};
    store_u32(bytes + 4, written->width);
    store_u32(bytes + 8, written->height);
    (void)output_write(to, bytes, FLO_HEAD);
    for (size_t i = 0; i < (size_t)written->width * written->height; i++) {
        const float *vector = written->vectors + 2 * i;
        bool known = !isnan(vector[0]);
        store_float(bytes, known ? vector[0] : 1e10F);
        store_float(bytes + 4, known ? vector[1] : 1e10F);
        (void)output_write(to, bytes, FLO_VECTOR);
    }
}

/* Returns false if a displacement is beyond what the picture holds. */
static bool hold_kitti(const flow_field *from, uint16_t *samples)
{
    for (size_t i = 0; i < (size_t)from->width * from->height; i++, samples += 3) {
        const float *vector = from->vectors + 2 * i;
        if (isnan(vector[0])) {
            memset(samples, 0, 3 * sizeof *samples);
            continue;
        }
        for (size_t c = 0; c < 2; c++) {
            float held = roundf(vector[c] * KITTI_UNITS) + KITTI_ZERO;
            if (held < 0 || held > 65535) {
                return false;
            }
            samples[c] = (uint16_t)held;
        }
        samples[2] = 1;
    }
    return true;
}

static int write_kitti(const flow_field *written, output *to)
{
    picture made = {written->width, written->height, 3, 65535, NULL};
    if (!picture_allocate(&made)) {
        return fail_memory(to->name);
    }
    int status = hold_kitti(written, made.samples)
                     ? picture_write(&made, true, to)
                     : fail(BAD_INPUT, to->name,
                            "a displacement is beyond 512 pixels, the most of this format: write "
                            "a .flo");
    picture_free(&made);
    return status;
}

int flow_write(const flow_field *written, bool png, output *to)
{
    if (png) {
        return write_kitti(written, to);
    }
    write_flo(written, to);
    return DONE;
}
