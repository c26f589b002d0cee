#include "scene/lines.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/print.h"
#include "image/formats.h"
#include "scene/file.h"

static bool is_blank(char c) { return c == ' ' || c == '\t'; }
static bool is_end(char c) { return c == '\n' || c == '\r'; }

static char *skip_blanks(char *at) {
    while (is_blank(*at)) at++;
    return at;
}

/* ---- lines ------------------------------------------------------------------------------------------ */

static size_t end_bytes(const char *at) { return at[0] == '\r' && at[1] == '\n' ? 2 : 1; }

static sl_status refuse_zeros(const char *text, size_t size, const char *path, sl_error *error) {
    const char *zero = text + strlen(text);
    unsigned long line = 1;
    if (zero == text + size) return SL_OK;
    for (const char *at = text; at < zero; at += is_end(*at) ? end_bytes(at) : 1) line += is_end(*at);
    return sl_fail(error, SL_ERROR_INPUT, "%s:%lu: expected text, got a byte that is zero", path, line);
}

sl_status sl_lines_open(const char *path, char **text, sl_lines *lines, sl_error *error) {
    sl_bytes bytes;
    sl_status status = sl_bytes_read(path, SL_FILE_BYTES, &bytes, error);
    if (status == SL_OK) status = refuse_zeros((char *)bytes.data, bytes.size, path, error);
    *text = (char *)bytes.data;
    if (status != SL_OK) {
        sl_free(*text);
        *text = NULL;
        return status;
    }
    char *end = *text + bytes.size, *start = *text + (strncmp(*text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0);
    *lines = (sl_lines){path, start, end, end, 1, 1, error};
    return SL_OK;
}

static char *cut_line(sl_lines *l) {
    char *start = l->at, *at = start;
    bool comment = false;
    l->line = l->next++;
    for (; *at && !is_end(*at); at++) {
        comment |= *at == '#' && (at == start || is_blank(at[-1]));
        if (*at == '\f' || *at == '\v') *at = ' ';
        if (comment || *at != '\\' || !is_end(at[1])) continue;
        const size_t bytes = 1 + end_bytes(at + 1);
        memset(at, ' ', bytes);
        at += bytes - 1;
        l->next++;
    }
    l->at = *at ? at + end_bytes(at) : l->end;
    while (at > start && is_blank(at[-1])) at--;
    *at = 0;
    return skip_blanks(start);
}

char *sl_lines_next(sl_lines *l) {
    while (l->at < l->end) {
        char *line = cut_line(l);
        if (*line) return line;
    }
    l->line = l->next;
    return NULL;
}

sl_status sl_lines_fail(const sl_lines *l, const char *expected, const char *got) {
    if (!got)
        return sl_fail(l->error, SL_ERROR_INPUT, "%s:%lu: expected %s, got the end of the file", l->path,
                       l->line, expected);
    const int length = (int)strcspn(got, " \t");
    return sl_fail(l->error, SL_ERROR_INPUT, "%s:%lu: expected %s, got '%.*s'", l->path, l->line, expected,
                   length < 40 ? length : 40, got);
}

/* ---- words ------------------------------------------------------------------------------------------ */

char *sl_word_end(char *at) { return at + strcspn(at, " \t"); }
char *sl_word_after(char *at) { return skip_blanks(sl_word_end(at)); }
bool sl_word_is(const char *at, const char *word) {
    return strcspn(at, " \t") == strlen(word) && strncasecmp(at, word, strlen(word)) == 0;
}
bool sl_is_line_end(const char *at) { return !*at || *at == '#'; }

/* ---- numbers ---------------------------------------------------------------------------------------- */

/* Reads a word that is a number; NULL where it is none, or hexadecimal. */
static char *read_double(char *at, double *value) {
    const size_t length = strcspn(at, " \t#");
    char *end;
    *value = strtod(at, &end);
    return length && end == at + length && strcspn(at, "xX") >= length ? skip_blanks(end) : NULL;
}

char *sl_read_number(char *at, float *value) {
    double number;
    char *end = read_double(at, &number);
    *value = (float)number;
    return end;
}

const char *sl_write_number(float value, char text[SL_NUMBER_ROOM]) {
    float read = 0.0f;
    for (int digits = 6; digits <= 9; digits++) {
        sl_print(text, SL_NUMBER_ROOM, "%.*g", digits, (double)value);
        if (sl_read_number(text, &read) && memcmp(&read, &value, sizeof value) == 0) break;
    }
    return text;
}

/* ---- values in any line ------------------------------------------------------------------------------ */

bool sl_lines_more(sl_lines *l) {
    while (l->rest && sl_is_line_end(l->rest)) l->rest = sl_lines_next(l);
    return l->rest;
}

sl_status sl_lines_decimal(sl_lines *l, const char *expected, double *value) {
    if (!sl_lines_more(l)) return sl_lines_fail(l, expected, NULL);
    char *end = read_double(l->rest, value);
    if (!end || !isfinite(*value)) return sl_lines_fail(l, expected, l->rest);
    l->rest = end;
    return SL_OK;
}

sl_status sl_lines_whole(sl_lines *l, const char *expected, double low, double high, uint32_t *value) {
    double number = 0.0;
    const char *word = sl_lines_more(l) ? l->rest : NULL;
    sl_status status = sl_lines_decimal(l, expected, &number);
    if (status != SL_OK) return status;
    if (!(number >= low && number <= high && number == floor(number)))
        return sl_lines_fail(l, expected, word);
    *value = (uint32_t)number;
    return SL_OK;
}
