/* Reading by content, writing by name. */
#include "image/color.h"
#include "image/formats.h"
#include "image/tone.h"

#include "base/error.h"
#include "base/memory.h"
#include "base/print.h"
#include "base/values.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- bytes ----------------------------------------------------------------------------------- */

static sl_status read_descriptor(int descriptor, size_t most, sl_bytes *bytes, sl_error *error) {
    struct stat about;
    if (fstat(descriptor, &about) != 0)
        return sl_fail(error, SL_ERROR_INPUT, "%s: cannot be read: %s", bytes->path, strerror(errno));
    if (!S_ISREG(about.st_mode)) return sl_fail(error, SL_ERROR_INPUT, "%s: expected a file", bytes->path);
    const size_t size = (size_t)about.st_size;
    if (size > most)
        return sl_fail(error, SL_ERROR_INPUT, "%s: expected a file of at most %zu bytes, got %zu",
                       bytes->path, most, size);
    bytes->data = sl_allocate(size + 1, 1);
    if (!bytes->data) return sl_fail_memory(error, bytes->path);
    while (bytes->size < size) {
        ssize_t got = read(descriptor, bytes->data + bytes->size, size - bytes->size);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0)
            return sl_fail(error, SL_ERROR_INPUT, "%s: cannot be read: %s", bytes->path, strerror(errno));
        if (got == 0) break;
        bytes->size += (size_t)got;
    }
    return SL_OK;
}

sl_status sl_bytes_read(const char *path, size_t most, sl_bytes *bytes, sl_error *error) {
    *bytes = (sl_bytes){path, NULL, 0};
    int descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor < 0)
        return sl_fail(error, sl_status_of_errno(errno, SL_ERROR_INPUT), "%s: cannot be opened: %s", path,
                       strerror(errno));
    sl_status status = read_descriptor(descriptor, most, bytes, error);
    close(descriptor);
    if (status != SL_OK) {
        sl_free(bytes->data);
        bytes->data = NULL;
    }
    return status;
}

sl_status sl_check_claimed_size(const sl_bytes *bytes, int64_t width, int64_t height, int channels,
                                uint64_t expansion, sl_error *error) {
    /* Small pictures pass whatever they say: nothing is lost by trying. */
    const uint64_t small = (uint64_t)1 << 20, largest = (uint64_t)1 << 29;
    const int64_t longest = 1 << 24;
    if (width < 1 || height < 1 || width > longest || height > longest)
        return sl_fail(error, SL_ERROR_INPUT, "%s: %lld x %lld pixels is no size for a picture", bytes->path,
                       (long long)width, (long long)height);
    const uint64_t pixels = (uint64_t)width * (uint64_t)height, values = pixels * (uint64_t)channels;
    if (pixels <= largest && (values <= small || values / expansion <= bytes->size)) return SL_OK;
    return sl_fail(error, SL_ERROR_INPUT,
                   "%s: claims %lld x %lld pixels of %d channels, too many for its %zu bytes", bytes->path,
                   (long long)width, (long long)height, channels, bytes->size);
}

/* ---- 8-bit pictures -------------------------------------------------------------------------- */

sl_status sl_decode_texels(const char *path, const void *memory, size_t size, int *width, int *height,
                           bool *has_alpha, uint8_t **rgba, sl_error *error) {
    *rgba = NULL;
    sl_bytes bytes = {path, (uint8_t *)(uintptr_t)memory, size}; /* which is not written to */
    sl_status status = memory ? SL_OK : sl_bytes_read(path, SIZE_MAX - 1, &bytes, error);
    if (status == SL_OK)
        status = sl_png_recognise(&bytes) ? sl_png_decode(&bytes, width, height, has_alpha, rgba, error)
                                          : sl_stb_decode(&bytes, width, height, has_alpha, rgba, error);
    if (!memory) sl_free(bytes.data);
    return status;
}

static sl_status read_texels(const sl_bytes *bytes, sl_image **image, sl_error *error) {
    static const char *const names[4] = {"R", "G", "B", "A"};
    int width, height;
    bool has_alpha;
    uint8_t *rgba;
    sl_status status =
        sl_decode_texels(bytes->path, bytes->data, bytes->size, &width, &height, &has_alpha, &rgba, error);
    if (status != SL_OK) return status;
    status = sl_image_create(width, height, has_alpha ? 4 : 3, names, image, error);
    if (status == SL_OK) {
        size_t pixels = (size_t)width * (size_t)height;
        for (size_t i = 0; i < pixels; i++) {
            for (size_t c = 0; c < 3; c++)
                (*image)->planes[c * pixels + i] = sl_srgb_to_linear[rgba[4 * i + c]];
            if (has_alpha) (*image)->planes[3 * pixels + i] = (float)rgba[4 * i + 3] / 255.0f;
        }
    }
    sl_free(rgba);
    return status;
}

/* The tone as the picture's metadata tell it. */
static sl_status set_tone(const sl_bytes *bytes, sl_image *image, sl_error *error) {
    static const char *const keys[] = {SL_TONE_KEY, SL_TONE_EXPOSURE_KEY, SL_TONE_AUTOMATIC_KEY};
    sl_status status = sl_image_set_metadata(image, SL_TONE_KEY, "unknown", error);
    for (size_t i = 0; i < 3 && status == SL_OK; i++) {
        char value[32];
        if (sl_png_recognise(bytes) && sl_png_text(bytes, keys[i], value, sizeof value))
            status = sl_image_set_metadata(image, keys[i], value, error);
    }
    return status;
}

static sl_status read_picture(const sl_bytes *bytes, sl_image **image, sl_error *error) {
    sl_status status = read_texels(bytes, image, error);
    if (status == SL_OK) status = set_tone(bytes, *image, error);
    if (status == SL_OK) return SL_OK;
    sl_image_destroy(*image);
    *image = NULL;
    return status;
}

/* ---- images ---------------------------------------------------------------------------------- */

sl_status sl_image_decode(const sl_bytes *bytes, sl_image **image, sl_error *error) {
    *image = NULL;
    if (sl_exr_recognise(bytes)) return sl_exr_read(bytes, false, image, error);
    if (sl_pfm_recognise(bytes)) return sl_pfm_read(bytes, image, error);
    if (sl_hdr_recognise(bytes)) return sl_hdr_read(bytes, image, error);
    if (sl_png_recognise(bytes) || sl_jpeg_recognise(bytes)) return read_picture(bytes, image, error);
    return sl_fail(error, SL_ERROR_INPUT, "%s: not an EXR, PFM, Radiance HDR, PNG or JPEG picture",
                   bytes->path);
}

static sl_status read_file(const char *path, bool sky, sl_image **image, sl_error *error) {
    if (!image) return sl_fail_null(error, "a place for an image");
    *image = NULL;
    if (!path) return sl_fail_null(error, "the name of a picture's file");
    sl_bytes bytes;
    sl_status status = sl_bytes_read(path, SIZE_MAX - 1, &bytes, error);
    if (status == SL_OK)
        status = sky && sl_exr_recognise(&bytes) ? sl_exr_read(&bytes, true, image, error)
                                                 : sl_image_decode(&bytes, image, error);
    sl_free(bytes.data);
    return status;
}

sl_status sl_image_read(const char *path, sl_image **image, sl_error *error) {
    return read_file(path, false, image, error);
}

sl_status sl_sky_read(const char *path, sl_image **image, sl_error *error) {
    return read_file(path, true, image, error);
}

typedef sl_status write_function(const sl_image *image, sl_output_file *file, sl_error *error);

static sl_status write_with(write_function *write_image, const sl_image *image, const char *path,
                            sl_error *error) {
    sl_output_file file;
    sl_status status = sl_output_open(&file, path, error);
    if (status != SL_OK) return status;
    return sl_output_close(&file, write_image(image, &file, error), error);
}

sl_status sl_image_write(const sl_image *image, const char *path, sl_error *error) {
    if (!image || !path) return sl_fail_null(error, "an image and the name of a file");
    if (sl_ends_with(path, ".exr")) return write_with(sl_exr_write, image, path, error);
    if (sl_ends_with(path, ".pfm")) return write_with(sl_pfm_write, image, path, error);
    if (sl_ends_with(path, ".png"))
        return sl_image_write_png(image, path, (sl_tone){SL_TONE_CLIP, 0.0f, false}, error);
    return sl_fail(error, SL_ERROR_USAGE, "cannot write %s: the name must end in .exr, .pfm or .png", path);
}

sl_status sl_image_write_png(const sl_image *image, const char *path, sl_tone tone, sl_error *error) {
    if (!image || !path) return sl_fail_null(error, "an image and the name of a file");
    char stops[32];
    sl_print(stops, sizeof stops, "%.17g", sl_tone_stops(image, tone));
    const sl_png_entry texts[3] = {{SL_TONE_KEY, sl_tone_curve_name((size_t)tone.curve)},
                                   {SL_TONE_EXPOSURE_KEY, stops},
                                   {SL_TONE_AUTOMATIC_KEY, "true"}};
    const size_t entries = tone.automatic ? 3 : 2;
    uint8_t *rgb = sl_allocate_unset((size_t)image->width * (size_t)image->height, 3);
    if (!rgb) return sl_fail_memory(error, "a tone-mapped picture");
    sl_status status = sl_image_srgb(image, &tone, rgb, error);
    if (status == SL_OK)
        status = sl_png_file(path, image->width, image->height, 3, rgb, texts, entries, error);
    sl_free(rgb);
    return status;
}
