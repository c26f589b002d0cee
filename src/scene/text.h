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

#endif
