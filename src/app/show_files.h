/* The frames of a show as files: numbered PNGs, or one stream that players take (YUV4MPEG2, uncompressed). */
#pragma once

#include "image/output_file.h"

typedef struct sl_show_files {
    /* frame-%04d.png, show.y4m, or - for a stream to standard output; NULL: nothing is written */
    const char *output;
    int width, height;
    uint64_t written;
    bool streams;         /* else pictures */
    bool to_stdout;
    bool opened;          /* file is: of a stream that goes elsewhere */
    sl_output_file file;
    uint8_t *rgb, *yuv;
} sl_show_files;

/* Checks what it could be, before anything else is done: SL_ERROR_USAGE. */
sl_status sl_show_files_check(const char *output, double frames_per_second, sl_error *error);
sl_status sl_show_files_open(sl_show_files *files, const char *output, int width, int height,
                             double frames_per_second, sl_error *error);
/* Writes a frame, that many times in a row (once in pictures). An automatic exposure is fixed where keep says
 * so. */
sl_status sl_show_files_write(sl_show_files *files, const sl_image *frame, sl_tone *tone, bool keep,
                              uint64_t times, sl_error *error);
/* Lets what went well so far appear under its name; else nothing does. */
sl_status sl_show_files_close(sl_show_files *files, bool well, sl_error *error);
