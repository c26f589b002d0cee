#include "app/serve/mail.h"

#include "image/formats.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef SL_HAVE_JPEG
#include <jpeglib.h>
#endif

enum { QUALITY = 88 };

static void put(uint8_t *at, uint64_t value, int bytes) {
    for (int i = 0; i < bytes; i++) at[i] = (uint8_t)(value >> (8 * i));
}

static sl_packet *packet_of(const sl_frame_told *told, int width, int height, int format, const uint8_t *file,
                            size_t size) {
    sl_packet *p = malloc(sizeof *p + SL_PACKET_ROOM + SL_FRAME_HEADER + size);
    if (!p) return NULL;
    *p = (sl_packet){.slot = told->kind == SL_FRAME_PASS ? SL_FRAME_KINDS + (int)told->index % 62
                                                         : (int)told->kind,
                     .frame = told->frame,
                     .size = SL_FRAME_HEADER + size};
    uint8_t *at = p->bytes + SL_PACKET_ROOM;
    memcpy(at, "SLFR", 4);
    put(at + 4, told->kind, 1);
    put(at + 5, (uint64_t)format, 1);
    put(at + 6, told->index, 2);
    put(at + 8, told->frame, 4);
    put(at + 12, (uint64_t)width, 2);
    put(at + 14, (uint64_t)height, 2);
    put(at + 16, told->event, 8);
    memcpy(at + SL_FRAME_HEADER, file, size);
    return p;
}

static sl_packet *packet_of_png(const sl_frame_told *told, int width, int height, const uint8_t *rgb) {
    sl_output_file png;
    sl_output_open_memory(&png);
    sl_packet *p = NULL;
    if (sl_png_write(width, height, 3, rgb, NULL, 0, &png, NULL) == SL_OK)
        p = packet_of(told, width, height, 1, png.memory, png.size);
    sl_output_discard(&png);
    return p;
}

#ifdef SL_HAVE_JPEG
/* Without memory libjpeg ends the program: of the few hundred kilobytes that it takes. */
static sl_packet *packet_of_jpeg(const sl_frame_told *told, int width, int height, const uint8_t *rgb) {
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr errors;
    unsigned char *file = NULL;
    unsigned long size = 0;
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    jpeg_mem_dest(&jpeg, &file, &size);
    jpeg.image_width = (JDIMENSION)width, jpeg.image_height = (JDIMENSION)height;
    jpeg.input_components = 3, jpeg.in_color_space = JCS_RGB;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, QUALITY, TRUE);
    jpeg.dct_method = JDCT_FASTEST;
    jpeg_start_compress(&jpeg, TRUE);
    while (jpeg.next_scanline < jpeg.image_height) {
        JSAMPROW row = (JSAMPROW)(rgb + (size_t)jpeg.next_scanline * 3 * (size_t)width);
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    sl_packet *p = packet_of(told, width, height, 0, file, size);
    free(file);
    return p;
}
#else
static sl_packet *packet_of_jpeg(const sl_frame_told *told, int width, int height, const uint8_t *rgb) {
    return packet_of_png(told, width, height, rgb);
}
#endif

sl_packet *sl_packet_picture(const sl_frame_told *told, int width, int height, const uint8_t *rgb) {
    return told->still ? packet_of_png(told, width, height, rgb) : packet_of_jpeg(told, width, height, rgb);
}
