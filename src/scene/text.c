#include "scene/text.h"

#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "scene/file.h"

enum {
    MOST_DIGITS = 19 /* of a whole number that the importer is sure to hold: beyond 64 bits it reads 0 */
};

void sl_text_reserve(sl_text *text, size_t capacity) {
    if (capacity <= text->capacity || text->starved) return;
    text->starved = !sl_regrow(&text->data, text->size, capacity, 1);
    if (!text->starved) text->capacity = capacity;
}

void sl_text_add(sl_text *text, const char *from, size_t size) {
    if (size > text->capacity - text->size)
        sl_text_reserve(text, text->size + size + text->capacity / 2 + 256);
    if (text->starved || size == 0) return;
    memcpy(text->data + text->size, from, size);
    text->size += size;
}

void sl_text_prepend(sl_text *text, const sl_text *first) {
    size_t size = text->size;
    sl_text_add(text, first->data, first->size);
    text->starved |= first->starved;
    if (text->starved) return;
    memmove(text->data + first->size, text->data, size);
    memcpy(text->data, first->data, first->size);
}

void sl_text_trim(sl_text *text) {
    while (text->size && (text->data[text->size - 1] == ' ' || text->data[text->size - 1] == '\t'))
        text->size--;
}

sl_status sl_text_check(const sl_text *text, const char *path, sl_error *error) {
    return text->starved ? sl_fail_memory(error, path) : sl_file_check_size(path, text->size, error);
}

void sl_text_release(sl_text *text) {
    sl_free(text->data);
    *text = (sl_text){0};
}

static bool is_digit(const char *at, const char *end) { return at < end && *at >= '0' && *at <= '9'; }

static const char *digits_end(const char *at, const char *end) {
    while (is_digit(at, end)) at++;
    return at;
}

/* Past a whole number, if the importer can hold it. */
static const char *whole_end(const char *at, const char *end) {
    while (at < end && *at == '0') at++;
    const char *stop = digits_end(at, end);
    return stop - at <= MOST_DIGITS ? stop : NULL;
}

const char *sl_text_number_end(const char *at, const char *end) {
    if (at < end && (*at == '+' || *at == '-')) at++;
    const char *stop = whole_end(at, end);
    if (!stop) return NULL;
    bool digits = stop > at;
    if (stop < end && (*stop == '.' || *stop == ',')) {
        const char *fraction = stop + 1;
        stop = digits_end(fraction, end);
        digits |= stop > fraction;
    }
    if (!digits) return NULL;
    if (stop == end || (*stop != 'e' && *stop != 'E')) return stop;
    stop++;
    if (stop < end && (*stop == '+' || *stop == '-')) stop++;
    return is_digit(stop, end) ? whole_end(stop, end) : NULL;
}

sl_status sl_text_refuse_zeros(const char *data, size_t size, const char *path, sl_error *error) {
    const char *zero = size ? memchr(data, 0, size) : NULL;
    unsigned long line = 1;
    if (!zero) return SL_OK;
    for (const char *at = data; at < zero; at++) line += *at == '\n' || (*at == '\r' && at[1] != '\n');
    return sl_fail(error, SL_ERROR_INPUT, "%s:%lu: expected text, got a byte that is zero", path, line);
}

size_t sl_text_mark_bytes(const char *data, size_t size) {
    return size >= 3 && memcmp(data, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
}

bool sl_text_is_utf16(const char *data, size_t size) {
    return size >= 2 && (memcmp(data, "\xff\xfe", 2) == 0 || memcmp(data, "\xfe\xff", 2) == 0);
}
