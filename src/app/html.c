#include "app/html.h"

#include "image/formats.h"
#include "image/output_file.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

void sl_put_escaped(FILE *out, const char *text) { sl_put_escaped_part(out, text, strlen(text)); }

void sl_put_escaped_part(FILE *out, const char *text, size_t length) {
    for (const char *end = text + length; text < end; text++) {
        switch (*text) {
        case '&': fputs("&amp;", out); break;
        case '<': fputs("&lt;", out); break;
        case '>': fputs("&gt;", out); break;
        case '"': fputs("&quot;", out); break;
        default: fputc((unsigned char)*text < 32 ? ' ' : *text, out);
        }
    }
}

char *sl_base_64(const void *data, size_t count) {
    const unsigned char *bytes = data;
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char *text = malloc(4 * ((count + 2) / 3) + 1), *out = text;
    if (!text) return NULL;
    for (size_t i = 0; i < count; i += 3) {
        uint32_t three = (uint32_t)bytes[i] << 16;
        if (i + 1 < count) three |= (uint32_t)bytes[i + 1] << 8;
        if (i + 2 < count) three |= bytes[i + 2];
        for (size_t k = 0; k < 4; k++) *out++ = i + k > count ? '=' : digits[(three >> (18 - 6 * k)) & 63];
    }
    *out = '\0';
    return text;
}

char *sl_picture_text(const sl_image *image, bool tone) {
    sl_tone curve = {tone ? SL_TONE_REINHARD : SL_TONE_CLIP, 0.0f, tone};
    uint8_t *rgb = malloc(3 * (size_t)image->width * (size_t)image->height);
    sl_output_file png;
    sl_output_open_memory(&png);
    char *text = NULL;
    if (rgb && sl_image_srgb(image, &curve, rgb, NULL) == SL_OK &&
        sl_png_write(image->width, image->height, rgb, NULL, 0, &png, NULL) == SL_OK)
        text = sl_base_64(png.memory, png.size);
    sl_output_discard(&png);
    free(rgb);
    return text;
}

sl_status sl_text_write(const char *path, const char *text, size_t size, sl_error *error) {
    sl_output_file file;
    sl_status status = sl_output_open(&file, path, error);
    if (status != SL_OK) return status;
    status = sl_output_write(&file, text, size, error);
    if (status == SL_OK) return sl_output_commit(&file, error);
    sl_output_discard(&file);
    return status;
}
