/* PNG through libpng, which reports errors by longjmp(): everything that must survive the jump lives in a
 * struct that the caller of setjmp() owns. */
#include "image/formats.h"

#include "base/error.h"
#include "base/memory.h"

#include <png.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct png_work {
    png_structp png;
    png_infop info;
    char reason[200];
    bool starved; /* there was not enough memory for something */
    /* reading */
    const sl_bytes *bytes;
    size_t position;
    png_uint_32 width, height;
    bool has_alpha;
    uint8_t *rgba;
    png_bytep *rows;
    /* writing */
    const uint8_t *texels;
    int channels;
    const sl_png_entry *texts;
    size_t text_count;
    sl_output_file *file;
    sl_status status;
    sl_error *error;
} png_work;

static void on_error(png_structp png, png_const_charp message) {
    png_work *work = png_get_error_ptr(png);
    snprintf(work->reason, sizeof work->reason, "%s", message);
    png_longjmp(png, 1);
}

/* libpng goes on, or says that the file is damaged, where it finds no memory. */
static png_voidp allocate(png_structp png, png_alloc_size_t size) {
    png_work *work = png_get_mem_ptr(png);
    void *block = malloc(size);
    if (!block) work->starved = true;
    return block;
}

static void release(png_structp png, png_voidp block) {
    (void)png;
    free(block);
}

static void on_warning(png_structp png, png_const_charp message) {
    (void)png; /* a library does not print */
    (void)message;
}

/* ---- reading --------------------------------------------------------------------------------- */

bool sl_png_recognise(const sl_bytes *bytes) {
    return bytes->size >= 8 && png_sig_cmp(bytes->data, 0, 8) == 0;
}

static void read_bytes(png_structp png, png_bytep to, size_t count) {
    png_work *work = png_get_io_ptr(png);
    if (count > work->bytes->size - work->position) png_error(png, "the file is cut short");
    memcpy(to, work->bytes->data + work->position, count);
    work->position += count;
}

/* Asks for 8-bit R, G, B, A, whatever the file holds. */
static void ask_for_rgba(png_work *work) {
    png_structp png = work->png;
    int type = png_get_color_type(png, work->info);
    bool transparent_colour = png_get_valid(png, work->info, PNG_INFO_tRNS) != 0;
    work->has_alpha = (type & PNG_COLOR_MASK_ALPHA) != 0 || transparent_colour;
    png_set_expand(png);
    png_set_scale_16(png);
    if (!(type & PNG_COLOR_MASK_COLOR)) png_set_gray_to_rgb(png);
    if (!work->has_alpha) png_set_add_alpha(png, 255, PNG_FILLER_AFTER);
    png_set_interlace_handling(png);
    png_read_update_info(png, work->info);
}

static bool decode_rows(png_work *work, sl_error *error) {
    png_structp png = work->png;
    if (setjmp(png_jmpbuf(png))) return false;
    png_set_user_limits(png, 1 << 24, 1 << 24); /* absurd sizes are refused below, by the file's own length */
    png_set_read_fn(png, work, read_bytes);
    png_read_info(png, work->info);
    work->width = png_get_image_width(png, work->info);
    work->height = png_get_image_height(png, work->info);
    /* Deflate packs at most 1032 to 1, and a byte holds eight pixels of one bit. */
    work->status = sl_check_claimed_size(work->bytes, work->width, work->height, 1, 8 * 1032, error);
    if (work->status != SL_OK) return false;
    ask_for_rgba(work);
    if (png_get_rowbytes(png, work->info) != 4 * (size_t)work->width) png_error(png, "unexpected row size");
    work->rgba = sl_allocate((size_t)work->width * work->height, 4);
    work->rows = sl_allocate(work->height, sizeof *work->rows);
    if (!work->rgba || !work->rows) {
        work->status = sl_fail_memory(error, work->bytes->path);
        return false;
    }
    for (png_uint_32 y = 0; y < work->height; y++) work->rows[y] = work->rgba + 4 * (size_t)work->width * y;
    png_read_image(png, work->rows);
    png_read_end(png, NULL);
    return true;
}

sl_status sl_png_decode(const sl_bytes *bytes, int *width, int *height, bool *has_alpha, uint8_t **rgba,
                        sl_error *error) {
    *rgba = NULL;
    png_work work = {.bytes = bytes, .status = SL_OK};
    work.png = png_create_read_struct_2(PNG_LIBPNG_VER_STRING, &work, on_error, on_warning, &work, allocate,
                                        release);
    work.info = work.png ? png_create_info_struct(work.png) : NULL;
    bool done = false;
    if (work.info) done = decode_rows(&work, error);
    if (!work.info || work.starved) {
        work.status = sl_fail_memory(error, bytes->path);
        done = false;
    }
    if (!done && work.status == SL_OK)
        work.status = sl_fail(error, SL_ERROR_INPUT, "%s: damaged PNG: %s", bytes->path, work.reason);
    png_destroy_read_struct(&work.png, &work.info, NULL);
    sl_free(work.rows);
    if (done) {
        *width = (int)work.width;
        *height = (int)work.height;
        *has_alpha = work.has_alpha;
        *rgba = work.rgba;
    } else {
        sl_free(work.rgba);
    }
    return work.status;
}

static uint32_t big_endian(const uint8_t *b) {
    return (uint32_t)b[0] << 24 | (uint32_t)b[1] << 16 | (uint32_t)b[2] << 8 | b[3];
}

/* A chunk is its length, its type, its data and a checksum; a tEXt's data are the key, a zero and the value.
 */
bool sl_png_text(const sl_bytes *bytes, const char *key, char *value, size_t size) {
    enum { SIGNATURE = 8, AROUND = 12 };
    const size_t key_bytes = strlen(key) + 1;
    size_t length;
    for (size_t at = SIGNATURE; bytes->size >= AROUND && at <= bytes->size - AROUND; at += length + AROUND) {
        const uint8_t *chunk = bytes->data + at, *data = chunk + 8;
        length = big_endian(chunk);
        if (length > bytes->size - AROUND - at) return false;
        if (memcmp(chunk + 4, "tEXt", 4) != 0 || length < key_bytes || memcmp(data, key, key_bytes) != 0)
            continue;
        snprintf(value, size, "%.*s", (int)(length - key_bytes < size ? length - key_bytes : size),
                 (const char *)data + key_bytes);
        return true;
    }
    return false;
}

/* ---- writing --------------------------------------------------------------------------------- */

static void write_bytes(png_structp png, png_bytep from, size_t count) {
    png_work *work = png_get_io_ptr(png);
    work->status = sl_output_write(work->file, from, count, work->error);
    if (work->status != SL_OK) png_error(png, "the file cannot be written");
}

static void flush_nothing(png_structp png) { (void)png; }

static void add_texts(png_work *work) {
    for (size_t i = 0; i < work->text_count; i++) {
        char key[80], value[80]; /* the library's type is not const */
        snprintf(key, sizeof key, "%s", work->texts[i].key);
        snprintf(value, sizeof value, "%s", work->texts[i].value);
        const png_text text = {.compression = PNG_TEXT_COMPRESSION_NONE, .key = key, .text = value};
        png_set_text(work->png, work->info, &text, 1); /* copied */
    }
}

static bool encode_rows(png_work *work) {
    png_structp png = work->png;
    if (setjmp(png_jmpbuf(png))) return false;
    png_set_write_fn(png, work, write_bytes, flush_nothing);
    png_set_IHDR(png, work->info, work->width, work->height, 8,
                 work->channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, work->info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_set_compression_level(png, 6); /* said, so that the bytes do not change with the library's defaults */
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
    add_texts(work);
    png_write_info(png, work->info);
    for (png_uint_32 y = 0; y < work->height; y++)
        png_write_row(png, work->texels + (size_t)work->channels * work->width * y);
    png_write_end(png, work->info);
    return true;
}

sl_status sl_png_write(int width, int height, int channels, const uint8_t *texels, const sl_png_entry *texts,
                       size_t count, sl_output_file *file, sl_error *error) {
    png_work work = {
        .texels = texels, .texts = texts, .text_count = count, .file = file, .status = SL_OK, .error = error};
    work.channels = channels;
    work.width = (png_uint_32)width;
    work.height = (png_uint_32)height;
    work.png = png_create_write_struct_2(PNG_LIBPNG_VER_STRING, &work, on_error, on_warning, &work, allocate,
                                         release);
    work.info = work.png ? png_create_info_struct(work.png) : NULL;
    bool done = work.info && encode_rows(&work);
    if (work.status == SL_OK && (!work.info || work.starved)) {
        work.status = sl_fail_memory(error, file->name);
    } else if (!done && work.status == SL_OK) {
        work.status = sl_fail(error, SL_ERROR_OUTPUT, "cannot write %s: %s", file->name, work.reason);
    }
    png_destroy_write_struct(&work.png, &work.info);
    return work.status;
}

sl_status sl_png_file(const char *path, int width, int height, int channels, const uint8_t *texels,
                      const sl_png_entry *texts, size_t count, sl_error *error) {
    sl_output_file file;
    sl_status status = sl_output_open(&file, path, error);
    if (status != SL_OK) return status;
    status = sl_png_write(width, height, channels, texels, texts, count, &file, error);
    return sl_output_close(&file, status, error);
}
