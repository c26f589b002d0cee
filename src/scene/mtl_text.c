#include "scene/mtl_text.h"

#include <string.h>

#include "base/memory.h"
#include "scene/file.h"

static bool is_blank(char c) { return c == ' ' || c == '\t'; }
static bool is_line_end(char c) { return c == '\n' || c == '\r'; }

static bool is_colour(const char *at, const char *end) {
    return end - at > 3 && (at[0] == 'K' || at[0] == 'k') && strchr("adse", at[1]) && at[1] && is_blank(at[2]);
}

static bool begins_number(char c) { return (c >= '0' && c <= '9') || c == '.' || c == ',' || c == '+' || c == '-'; }

/* Of a colour of one number green and blue are as red; the importer makes them 0. */
static void add_colour(sl_text *plain, const char *at, const char *end) {
    const char *from = at + 2;
    while (from < end && is_blank(*from)) from++;
    const char *to = from, *behind;
    while (to < end && !is_blank(*to) && *to != '#') to++;
    for (behind = to; behind < end && is_blank(*behind);) behind++;
    bool single = from < to && begins_number(*from) && (behind == end || *behind == '#');
    sl_text_add(plain, at, (size_t)((single ? to : end) - at));
    for (int i = 0; i < 2 && single; i++) {
        sl_text_add(plain, " ", 1);
        sl_text_add(plain, from, (size_t)(to - from));
    }
}

static void add_line(sl_text *plain, const char *at, const char *end) {
    while (at < end && is_blank(*at)) at++;
    while (at < end && is_blank(end[-1])) end--;
    if (is_colour(at, end)) add_colour(plain, at, end);
    else sl_text_add(plain, at, (size_t)(end - at));
    sl_text_add(plain, "\n", 1);
}

sl_status sl_mtl_text_read(const char *path, sl_text *plain, sl_error *error) {
    *plain = (sl_text){0};
    char *data;
    size_t size;
    sl_status status = sl_file_read(path, &data, &size, error);
    if (status != SL_OK) return status;
    for (const char *at = data, *end = data + size, *stop; at < end && !sl_text_is_utf16(data, size); at = stop + (stop < end)) {
        for (stop = at; stop < end && !is_line_end(*stop);) stop++;
        add_line(plain, at, stop);
    }
    sl_free(data);
    status = sl_text_check(plain, path, error);
    if (status != SL_OK) sl_text_release(plain);
    return status;
}
