#include "app/show_files.h"

#include "app/same_file.h"
#include "base/error.h"
#include "base/values.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool is_stream(const char *output) {
    return strcmp(output, "-") == 0 || sl_ends_with(output, ".y4m");
}

sl_status sl_show_files_check(const char *output, double frames_per_second, sl_error *error) {
    if (!output) return SL_OK;
    if (is_stream(output)) {
        if (!(frames_per_second > 0.0))
            return sl_fail(error, SL_ERROR_USAGE,
                        "--output: a stream has a rate: expected --fps above 0 for '%s'", output);
        return strcmp(output, "-") == 0 ? SL_OK : sl_output_check(output, error);
    }
    if (sl_ends_with(output, ".png") && sl_frame_pattern_is_good(output)) {
        char first[4096];
        sl_frame_name(output, 0, first, sizeof first);
        return sl_output_check(first, error);
    }
    return sl_fail(error, SL_ERROR_USAGE,
                "--output: expected frame-%%04d.png, a name that ends with .y4m, or - for a stream; got '%s'",
                output);
}

static sl_status cannot_write(const sl_show_files *files, sl_error *error) {
    return sl_fail(error, SL_ERROR_OUTPUT, "cannot write %.600s: %.100s", files->output, strerror(errno));
}

static sl_status put(sl_show_files *files, const void *bytes, size_t count, sl_error *error) {
    if (!files->to_stdout) return sl_output_write(&files->file, bytes, count, error);
    return fwrite(bytes, 1, count, stdout) == count ? SL_OK : cannot_write(files, error);
}

sl_status sl_show_files_open(sl_show_files *files, const char *output, int width, int height,
                             double frames_per_second, sl_error *error) {
    *files = (sl_show_files){.output = output, .width = width, .height = height};
    size_t bytes = 3 * (size_t)width * (size_t)height;
    files->rgb = malloc(bytes);
    files->yuv = malloc(bytes);
    if (!files->rgb || !files->yuv)
        return sl_fail(error, SL_ERROR_RESOURCES, "not enough memory for %s", "a frame");
    if (!output || !is_stream(output)) return SL_OK;
    char header[80];
    long rate = (long)(1000.0 * frames_per_second + 0.5);
    files->streams = true;
    files->to_stdout = strcmp(output, "-") == 0;
    if (!files->to_stdout) {
        sl_status status = sl_output_open(&files->file, output, error);
        if (status != SL_OK) return status;
        files->opened = true;
    }
    snprintf(header, sizeof header, "YUV4MPEG2 W%d H%d F%ld:1000 Ip A1:1 C444\n", width, height,
             rate > 0 ? rate : 1);
    return put(files, header, strlen(header), error);
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

static sl_status write_picture(const sl_show_files *files, const sl_image *frame, sl_tone tone,
                               sl_error *error) {
    char name[4096];
    sl_frame_name(files->output, files->written, name, sizeof name);
    return sl_image_write_png(frame, name, tone, error);
}

static sl_status write_stream(sl_show_files *files, uint64_t times, sl_error *error) {
    size_t pixels = (size_t)files->width * (size_t)files->height;
    to_yuv(files->rgb, pixels, files->yuv);
    sl_status status = SL_OK;
    for (uint64_t k = 0; status == SL_OK && k < times; k++) {
        status = put(files, "FRAME\n", 6, error);
        if (status == SL_OK) status = put(files, files->yuv, 3 * pixels, error);
    }
    return status == SL_OK && files->to_stdout && fflush(stdout) != 0 ? cannot_write(files, error) : status;
}

sl_status sl_show_files_write(sl_show_files *files, const sl_image *frame, sl_tone *tone, bool keep,
                              uint64_t times, sl_error *error) {
    if (!files->output) return SL_OK;
    sl_tone used = *tone;
    sl_status status = SL_OK;
    if (files->streams || used.automatic) status = sl_image_srgb(frame, &used, files->rgb, error);
    if (status == SL_OK)
        status =
            files->streams ? write_stream(files, times, error) : write_picture(files, frame, used, error);
    if (status != SL_OK) return status;
    if (keep) *tone = used;
    files->written += files->streams ? times : 1;
    return SL_OK;
}

sl_status sl_show_files_close(sl_show_files *files, bool well, sl_error *error) {
    free(files->rgb);
    free(files->yuv);
    if (!files->opened) return SL_OK;
    if (well) return sl_output_close(&files->file, SL_OK, error);
    sl_output_discard(&files->file);
    return SL_OK;
}
