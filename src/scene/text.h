/* Text that grows at its end: copies of files, spelled as the importer reads them right. */
#ifndef SL_SCENE_TEXT_H
#define SL_SCENE_TEXT_H

#include "softlux.h"

/* Zeroed: empty. */
typedef struct sl_text {
    char *data;
    size_t size, capacity;
    bool starved; /* something could not be added for want of memory */
} sl_text;

/* Room for that many bytes; adding more makes more, at a cost in proportion to the whole. */
void sl_text_reserve(sl_text *text, size_t capacity);
void sl_text_add(sl_text *text, const char *from, size_t size);
void sl_text_prepend(sl_text *text, const sl_text *first); /* which is not empty */
/* Takes the blanks from its end. */
void sl_text_trim(sl_text *text);
/* Fails where something could not be added, or it has become longer than a file may be. */
sl_status sl_text_check(const sl_text *text, const char *path, sl_error *error);
void sl_text_release(sl_text *text);

/* Whether a file begins as UTF-16 does. */
bool sl_text_is_utf16(const char *data, size_t size);
/* The bytes of the mark with which a file in UTF-8 may begin: 3 or 0. */
size_t sl_text_mark_bytes(const char *data, size_t size);
/* An input error with its line, where a byte is zero: the importer takes that for a line's end, or the
 * file's. */
sl_status sl_text_refuse_zeros(const char *data, size_t size, const char *path, sl_error *error);
/* Past a decimal number, its sign included; NULL where there is none, or the importer would read another:
 * whole parts and exponents beyond 64 bits are 0 to it. */
const char *sl_text_number_end(const char *at, const char *end);

#endif
