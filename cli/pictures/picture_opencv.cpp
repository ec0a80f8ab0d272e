// The picture library: OpenCV's imgcodecs behind picture_library.h.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "pictures/picture_library.h"

const char *picture_library_name()
{
    return "OpenCV " CV_VERSION;
}

bool picture_library_writes_png()
{
    return true;
}

// Standard error leads nowhere while this exists: the decoders print messages of their own, but the
// command prints one message.
class Silence
{
  public:
    Silence() : kept(dup(STDERR_FILENO))
    {
        const int nowhere = open("/dev/null", O_WRONLY);
        if (kept >= 0 && nowhere >= 0) {
            dup2(nowhere, STDERR_FILENO);
        }
        if (nowhere >= 0) {
            close(nowhere);
        }
    }
    ~Silence()
    {
        if (kept >= 0) {
            dup2(kept, STDERR_FILENO);
            close(kept);
        }
    }
    Silence(const Silence &) = delete;
    Silence &operator=(const Silence &) = delete;

  private:
    const int kept;
};

// Returns true for a JPEG without its end marker. The decoder would take a file that is cut short
// for a whole one and fill it up with grey.
static bool is_cut_jpeg(const file_bytes *file)
{
    const uint8_t *bytes = file->bytes;
    size_t at = 2;
    if (file->size < 3 || std::memcmp(bytes, "\xff\xd8\xff", 3) != 0) {
        return false;
    }
    while (at + 2 <= file->size) {
        const uint8_t marker = bytes[at + 1];
        if (bytes[at] == 0xFF && marker == 0xD9) {
            return false;
        }
        if (bytes[at] != 0xFF || marker == 0x00 || marker == 0xFF ||
            (marker >= 0xD0 && marker <= 0xD7)) {
            at++; // within coded samples
        } else if (at + 4 <= file->size) {
            at += 2 + (static_cast<size_t>(bytes[at + 2]) << 8 | bytes[at + 3]);
        } else {
            break;
        }
    }
    return true;
}

// OpenCV has B first. With two channels the second one is alpha, with four the fourth one.
template <typename Sample> static void copy_samples(const cv::Mat &from, picture *to)
{
    uint16_t *at = to->samples;
    const int channels = from.channels();
    for (int y = 0; y < from.rows; y++) {
        const Sample *pixel = from.ptr<Sample>(y);
        for (int x = 0; x < from.cols; x++, pixel += channels) {
            for (unsigned c = 0; c < to->channels; c++) {
                *at++ = pixel[to->channels - 1 - c];
            }
        }
    }
}

static picture_status copy_picture(const cv::Mat &from, picture *to, char *reason)
{
    if (from.empty() || (from.depth() != CV_8U && from.depth() != CV_16U) || from.channels() > 4) {
        std::snprintf(reason, REASON_SIZE, "%s",
                      from.empty() ? "is not a picture that can be read (PNG, JPEG, TIFF, BMP, "
                                     "WebP or Netpbm), or a damaged one"
                                   : "is a picture of another kind than 8 or 16 bits, grey or RGB");
        return PICTURE_BAD;
    }
    to->width = static_cast<size_t>(from.cols);
    to->height = static_cast<size_t>(from.rows);
    to->channels = from.channels() < 3 ? 1 : 3;
    to->maxval = from.depth() == CV_8U ? 255 : 65535;
    if (!picture_allocate(to)) {
        return PICTURE_NO_MEMORY;
    }
    if (from.depth() == CV_8U) {
        copy_samples<uint8_t>(from, to);
    } else {
        copy_samples<uint16_t>(from, to);
    }
    return PICTURE_OK;
}

static picture_status copy_floats(const cv::Mat &from, float_picture *to, char *reason)
{
    if (from.empty() || from.channels() != 1) {
        std::snprintf(reason, REASON_SIZE, "%s",
                      from.empty() ? "is not a TIFF that can be read, or a damaged one"
                                   : "has more than one value per pixel");
        return PICTURE_BAD;
    }
    to->width = static_cast<size_t>(from.cols);
    to->height = static_cast<size_t>(from.rows);
    to->whole = from.depth() != CV_32F && from.depth() != CV_64F;
    to->values = static_cast<float *>(std::malloc(from.total() * sizeof *to->values));
    if (to->values == nullptr) {
        return PICTURE_NO_MEMORY;
    }
    cv::Mat values(from.rows, from.cols, CV_32F, to->values);
    from.convertTo(values, CV_32F);
    return PICTURE_OK;
}

template <typename Picture>
static picture_status decode(const file_bytes *file, Picture *decoded, char *reason,
                             picture_status (*copy)(const cv::Mat &, Picture *, char *))
{
    try {
        const Silence silence;
        const cv::_InputArray bytes(file->bytes, static_cast<int>(file->size));
        return copy(cv::imdecode(bytes, cv::IMREAD_UNCHANGED), decoded, reason);
    } catch (const std::bad_alloc &) {
        return PICTURE_NO_MEMORY;
    } catch (const cv::Exception &refused) {
        std::snprintf(reason, REASON_SIZE, "cannot be read: %s", refused.err.c_str());
        return PICTURE_BAD;
    }
}

picture_status picture_library_decode(const file_bytes *file, picture *decoded,
                                      char reason[REASON_SIZE])
{
    if (is_cut_jpeg(file)) {
        std::snprintf(reason, REASON_SIZE, "is a JPEG that is cut short: its end is missing");
        return PICTURE_BAD;
    }
    return decode(file, decoded, reason, copy_picture);
}

picture_status picture_library_decode_floats(const file_bytes *file, float_picture *decoded,
                                             char reason[REASON_SIZE])
{
    return decode(file, decoded, reason, copy_floats);
}

static std::vector<uint8_t> to_png(const picture *encoded)
{
    const int depth = encoded->maxval > 255 ? CV_16U : CV_8U;
    cv::Mat samples(static_cast<int>(encoded->height), static_cast<int>(encoded->width),
                    CV_MAKETYPE(CV_16U, static_cast<int>(encoded->channels)));
    std::vector<uint8_t> png;
    for (int y = 0; y < samples.rows; y++) {
        const size_t row = encoded->width * encoded->channels;
        uint16_t *to = samples.ptr<uint16_t>(y);
        for (size_t i = 0; i < row; i++) {
            // B first again: the position is mirrored within the pixel.
            const size_t c = i % encoded->channels;
            to[i - c + encoded->channels - 1 - c] =
                encoded->samples[static_cast<size_t>(y) * row + i];
        }
    }
    samples.convertTo(samples, depth);
    cv::imencode(".png", samples, png);
    return png;
}

picture_status picture_library_encode_png(const picture *encoded, file_bytes *file)
{
    try {
        const std::vector<uint8_t> png = to_png(encoded);
        file->bytes = static_cast<uint8_t *>(std::malloc(png.size()));
        file->size = png.size();
        if (file->bytes == nullptr) {
            return PICTURE_NO_MEMORY;
        }
        std::memcpy(file->bytes, png.data(), png.size());
        return PICTURE_OK;
    } catch (const std::exception &) {
        return PICTURE_NO_MEMORY;
    }
}
