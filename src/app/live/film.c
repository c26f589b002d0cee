#include "app/live/film.h"

#include "app/same_file.h"
#include "base/error.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool is_stream(const char *output) {
    return strcmp(output, "-") == 0 || sl_name_ends_with(output, ".y4m");
}

sl_status sl_film_check(const char *output, double frames_per_second, sl_error *error) {
    if (!output) return SL_OK;
    if (is_stream(output)) {
        if (!(frames_per_second > 0.0))
            return sl_fail(error, SL_ERROR_USAGE,
                        "--output: a stream has a rate: expected --fps above 0 for '%s'", output);
        return strcmp(output, "-") == 0 ? SL_OK : sl_output_check(output, error);
    }
    if (sl_name_ends_with(output, ".png") && sl_frame_pattern_is_good(output)) {
        char first[4096];
        sl_frame_name(output, 0, first, sizeof first);
        return sl_output_check(first, error);
    }
    return sl_fail(error, SL_ERROR_USAGE,
                "--output: expected frame-%%04d.png, a name that ends with .y4m, or - for a stream; got '%s'",
                output);
}

static sl_status cannot_write(const sl_film *film, sl_error *error) {
    return sl_fail(error, SL_ERROR_OUTPUT, "cannot write %.600s: %.100s", film->output, strerror(errno));
}

static sl_status put(sl_film *film, const void *bytes, size_t count, sl_error *error) {
    if (!film->to_stdout) return sl_output_write(&film->file, bytes, count, error);
    return fwrite(bytes, 1, count, stdout) == count ? SL_OK : cannot_write(film, error);
}

sl_status sl_film_open(sl_film *film, const char *output, int width, int height, double frames_per_second,
                       sl_error *error) {
    *film = (sl_film){.output = output, .width = width, .height = height};
    size_t bytes = 3 * (size_t)width * (size_t)height;
    film->rgb = malloc(bytes);
    film->yuv = malloc(bytes);
    if (!film->rgb || !film->yuv)
        return sl_fail(error, SL_ERROR_RESOURCES, "not enough memory for %s", "a frame");
    if (!output || !is_stream(output)) return SL_OK;
    char header[80];
    long rate = (long)(1000.0 * frames_per_second + 0.5);
    film->streams = true;
    film->to_stdout = strcmp(output, "-") == 0;
    if (!film->to_stdout) {
        sl_status status = sl_output_open(&film->file, output, error);
        if (status != SL_OK) return status;
        film->opened = true;
    }
    snprintf(header, sizeof header, "YUV4MPEG2 W%d H%d F%ld:1000 Ip A1:1 C444\n", width, height,
             rate > 0 ? rate : 1);
    return put(film, header, strlen(header), error);
}

/* Rec. 601 in 16 to 235, which players take such streams for; a plane each, nothing left out. */
static void to_yuv(const uint8_t *rgb, size_t pixels, uint8_t *yuv) {
    for (size_t i = 0; i < pixels; i++) {
        int r = rgb[3 * i], g = rgb[3 * i + 1], b = rgb[3 * i + 2];
        yuv[i] = (uint8_t)((66 * r + 129 * g + 25 * b + 128 + 16 * 256) / 256);
        yuv[pixels + i] = (uint8_t)((-38 * r - 74 * g + 112 * b + 128 + 128 * 256) / 256);
        yuv[2 * pixels + i] = (uint8_t)((112 * r - 94 * g - 18 * b + 128 + 128 * 256) / 256);
    }
}

static sl_status write_picture(const sl_film *film, const sl_image *frame, sl_tone tone, sl_error *error) {
    char name[4096];
    sl_frame_name(film->output, film->written, name, sizeof name);
    return sl_image_write_png(frame, name, tone, error);
}

static sl_status write_stream(sl_film *film, uint64_t times, sl_error *error) {
    size_t pixels = (size_t)film->width * (size_t)film->height;
    to_yuv(film->rgb, pixels, film->yuv);
    sl_status status = SL_OK;
    for (uint64_t k = 0; status == SL_OK && k < times; k++) {
        status = put(film, "FRAME\n", 6, error);
        if (status == SL_OK) status = put(film, film->yuv, 3 * pixels, error);
    }
    return status == SL_OK && film->to_stdout && fflush(stdout) != 0 ? cannot_write(film, error) : status;
}

sl_status sl_film_write(sl_film *film, const sl_image *frame, sl_tone *tone, bool keep, uint64_t times,
                        sl_error *error) {
    if (!film->output) return SL_OK;
    sl_tone used = *tone;
    sl_status status = SL_OK;
    if (film->streams || used.automatic) status = sl_image_srgb(frame, &used, film->rgb, error);
    if (status == SL_OK)
        status = film->streams ? write_stream(film, times, error) : write_picture(film, frame, used, error);
    if (status != SL_OK) return status;
    if (keep) *tone = used;
    film->written += film->streams ? times : 1;
    return SL_OK;
}

sl_status sl_film_close(sl_film *film, bool well, sl_error *error) {
    free(film->rgb);
    free(film->yuv);
    if (!film->opened) return SL_OK;
    if (well) return sl_output_commit(&film->file, error);
    sl_output_discard(&film->file);
    return SL_OK;
}
