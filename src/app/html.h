/* What the writers of pages share: text and pictures inside one file that fetches nothing. */
#ifndef SL_APP_HTML_H
#define SL_APP_HTML_H

#include "softlux.h"

#include <stddef.h>
#include <stdio.h>

/* Text as HTML and SVG have it. */
void sl_put_escaped(FILE *out, const char *text);
void sl_put_escaped_part(FILE *out, const char *text, size_t length);
/* Bytes in base 64, which the caller frees; NULL: no memory. */
char *sl_base_64(const void *bytes, size_t count);
/* As PNG in base 64, which the caller frees; NULL: no memory. tone: of radiance; else values as they are. */
char *sl_picture_text(const sl_image *image, bool tone);
/* Writes a text file that appears whole or not at all. */
sl_status sl_text_write(const char *path, const char *text, size_t size, sl_error *error);

#endif
