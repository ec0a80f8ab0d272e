#include "pictures/planes.h"

#include "pictures/picture_read.h"
#include "text/fail.h"

static uint8_t to_8_bits(uint16_t sample, uint32_t maxval)
{
    return (uint8_t)(maxval == 255 ? sample : (sample * 255u + maxval / 2) / maxval);
}

static size_t samples_of(const picture *of)
{
    return of->width * of->height * of->channels;
}

/* Checks what a picture can be, and takes memory for its bytes. */
static int take_bytes(const char *path, const picture *from, budget *limit, colours *to)
{
    if (from->width > INT32_MAX || from->height > INT32_MAX) {
        return fail(BAD_INPUT, input_name(path), "has more than 2^31 - 1 columns or rows");
    }
    *to = (colours){budget_take(limit, input_name(path), samples_of(from)), (uint32_t)from->width,
                    (uint32_t)from->height, from->channels};
    return to->pixels != NULL ? DONE : NO_RESOURCE;
}

int picture_open(const char *path, budget *limit, picture *read)
{
    budget work = budget_inside(limit);
    file_bytes file;
    int status = file_read(path, &work, &file);
    if (status == DONE) {
        status = picture_decode(path, &file, &work, read);
    }
    budget_free(&work);
    return status;
}

int colours_read(const char *path, budget *limit, colours *read)
{
    picture from;
    TRY(picture_open(path, limit, &from));
    int status = take_bytes(path, &from, limit, read);
    for (size_t i = 0; status == DONE && i < samples_of(&from); i++) {
        read->pixels[i] = to_8_bits(from.samples[i], from.maxval);
    }
    picture_free(&from);
    return status;
}

int grey_read(const char *path, budget *limit, qs_image *read)
{
    return picture_read_grey(path, 0, limit, read);
}

/* Checks that a picture is grey, and has at most 8 bits. */
static int check_plain(const char *path, const picture *from)
{
    for (size_t i = 0; from->channels == 3 && i < samples_of(from); i += 3) {
        const uint16_t *rgb = from->samples + i;
        if (rgb[0] != rgb[1] || rgb[1] != rgb[2]) {
            return fail(BAD_INPUT, input_name(path),
                        "is a picture in colours: convert it to grey, or give its channels one by "
                        "one");
        }
    }
    return from->maxval <= UINT8_MAX
               ? DONE
               : fail(BAD_INPUT, input_name(path),
                      "has %lu greys above black: convert it to 8 bits, whose 256 greys are the "
                      "labels",
                      (unsigned long)from->maxval);
}

int plain_grey_read(const char *path, budget *limit, qs_image *read)
{
    picture from;
    TRY(picture_open(path, limit, &from));
    int status = check_plain(path, &from);
    if (status != DONE) {
        picture_free(&from);
        return status;
    }
    return picture_take_grey(path, 0, limit, &from, read);
}

static int copy_numbers(const char *path, const picture *from, colours *to)
{
    for (size_t i = 0; i < samples_of(from); i++) {
        if (from->samples[i] > UINT8_MAX) {
            return fail(BAD_INPUT, input_name(path),
                        "pixel (%zu, %zu) holds %u: such a picture holds numbers up to 255",
                        i % from->width, i / from->width, from->samples[i]);
        }
        to->pixels[i] = (uint8_t)from->samples[i];
    }
    return DONE;
}

static int read_numbers(const char *path, const picture *from, budget *limit, colours *to)
{
    if (from->channels != 1) {
        return fail(BAD_INPUT, input_name(path),
                    "is a picture in colours: give a grey one, with one number per pixel");
    }
    TRY(take_bytes(path, from, limit, to));
    return copy_numbers(path, from, to);
}

int numbers_picture_read(const char *path, budget *limit, qs_image *read)
{
    picture from;
    colours to = {0};
    TRY(picture_open(path, limit, &from));
    int status = read_numbers(path, &from, limit, &to);
    picture_free(&from);
    if (status == DONE) {
        *read = (qs_image){to.pixels, to.width, to.height, to.width};
    }
    return status;
}

int same_size_check(const char *name, size_t width, size_t height, const char *as_name,
                    size_t as_width, size_t as_height)
{
    if (width == as_width && height == as_height) {
        return DONE;
    }
    return fail(BAD_INPUT, input_name(name),
                "is %zu x %zu pixels, but %s is %zu x %zu: both need the same size", width, height,
                input_name(as_name), as_width, as_height);
}
