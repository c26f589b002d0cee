#include "scene/lines.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/print.h"
#include "image/formats.h"
#include "scene/file.h"

enum { MOST_DECIMALS = 15 /* of a fraction; more are passed over */, MOST_EXPONENT = 1000 };

static bool is_blank(char c) { return c == ' ' || c == '\t'; }
static bool is_end(char c) { return c == '\n' || c == '\r'; }
static bool is_digit(char c) { return c >= '0' && c <= '9'; }

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

/* ---- values in any line ------------------------------------------------------------------------------ */

bool sl_lines_more(sl_lines *l) {
    while (l->rest && sl_is_line_end(l->rest)) l->rest = sl_lines_next(l);
    return l->rest;
}

sl_status sl_lines_decimal(sl_lines *l, const char *expected, double *value) {
    if (!sl_lines_more(l)) return sl_lines_fail(l, expected, NULL);
    const size_t length = strcspn(l->rest, " \t#");
    char *end;
    *value = strtod(l->rest, &end);
    /* neither hexadecimal nor "inf" nor "nan" */
    const bool decimal = strspn(l->rest, "+-.0123456789eE") >= length && end == l->rest + length;
    if (!decimal || !isfinite(*value)) return sl_lines_fail(l, expected, l->rest);
    l->rest = skip_blanks(end);
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

/* ---- words ------------------------------------------------------------------------------------------ */

char *sl_word_end(char *at) { return at + strcspn(at, " \t"); }
char *sl_word_after(char *at) { return skip_blanks(sl_word_end(at)); }
bool sl_word_is(const char *at, const char *word) {
    return strcspn(at, " \t") == strlen(word) && strncasecmp(at, word, strlen(word)) == 0;
}
bool sl_is_line_end(const char *at) { return !*at || *at == '#'; }

/* ---- numbers ---------------------------------------------------------------------------------------- */

static bool ends_number(const char *at) { return is_blank(*at) || sl_is_line_end(at); }

/* Reads digits as a whole number, the first so many of them. */
static double digits(char **at, int most, int *count) {
    double value = 0.0;
    for (*count = 0; is_digit(**at); ++*at) {
        if (*count < most) value = 10.0 * value + (**at - '0'), ++*count;
    }
    return value;
}

static double power_of_ten(int exponent) {
    double power = 1.0;
    for (int i = 0; i < (exponent < 0 ? -exponent : exponent); i++) power *= 10.0;
    return exponent < 0 ? 1.0 / power : power;
}

static char *read_exponent(char *at, float *value) {
    int count;
    const bool negative = *at == '-';
    at += *at == '-' || *at == '+';
    const int exponent = (int)fmin(digits(&at, MOST_DECIMALS, &count), MOST_EXPONENT);
    *value *= (float)power_of_ten(negative ? -exponent : exponent);
    if (isnan(*value)) *value = 0.0f; /* 0 times infinity */
    return count ? at : NULL;
}

/* Reads nan and inf, with any ending. */
static char *read_nonfinite(char *at, float *value) {
    const bool infinite = strncasecmp(at, "inf", 3) == 0;
    if (!infinite && strncasecmp(at, "nan", 3) != 0) return NULL;
    *value = infinite ? INFINITY : NAN;
    return sl_word_after(at);
}

char *sl_read_number(char *at, float *value) {
    const bool negative = *at == '-';
    int whole, decimals = 0;
    at += *at == '-' || *at == '+';
    char *end = read_nonfinite(at, value);
    if (end) return end;
    *value = (float)digits(&at, INT32_MAX, &whole);
    if (*at == '.' || *at == ',') {
        at++;
        const double fraction = digits(&at, MOST_DECIMALS, &decimals);
        *value += (float)(fraction / power_of_ten(decimals));
    }
    if (whole + decimals == 0) return NULL;
    if (*at == 'e' || *at == 'E') at = read_exponent(at + 1, value);
    if (negative) *value = -*value;
    return at && ends_number(at) ? skip_blanks(at) : NULL;
}

__attribute__((format(printf, 3, 4))) static bool reads_back(float value, char text[SL_NUMBER_ROOM],
                                                             const char *format, ...) {
    float read = 0.0f;
    va_list arguments;
    va_start(arguments, format);
    sl_print_list(text, SL_NUMBER_ROOM, format, arguments);
    va_end(arguments);
    return sl_read_number(text, &read) && memcmp(&read, &value, sizeof value) == 0;
}

/* Tries as few digits as will do; then all of them; then, for what fractions cannot hold, a number of some
 * size times a power of ten as reading rounds it. */
const char *sl_write_number(float value, char text[SL_NUMBER_ROOM]) {
    const double exact = (double)value;
    for (int digits = 6; digits <= 9; digits++) {
        if (reads_back(value, text, "%.*g", digits, exact)) return text;
    }
    if (reads_back(value, text, "%.0f", exact) || reads_back(value, text, "%.15f", exact)) return text;
    for (int k = 1; k <= 52; k++) {
        const float power = (float)power_of_ten(-k);
        float whole = power > 0.0f ? (float)(exact / (double)power) : 0.0f;
        if (!(fabsf(whole) >= 1.0f && fabsf(whole) < 1e7f)) continue;
        whole = nextafterf(nextafterf(whole, -INFINITY), -INFINITY);
        for (int i = 0; i < 5; i++, whole = nextafterf(whole, INFINITY)) {
            if (reads_back(value, text, "%.9fe-%d", (double)whole, k)) return text;
        }
    }
    return text;
}
