#include "scene/obj_check.h"

#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "scene/file.h"

/* Vertices, texture coordinates, normals: how many there are, and the largest index that a face names, with its line.
 * Faces may name what comes later in the file, so positive indices are judged at the end. */
typedef struct kind {
    const char *name;
    unsigned long count, largest, largest_line;
} kind;

typedef struct checker {
    const char *path, *at, *end;
    unsigned long line;
    kind kinds[3];
    sl_model *model;
    sl_error *error;
} checker;

static bool is_blank(char c) { return c == ' ' || c == '\t'; }
static bool is_line_end(char c) { return c == '\n' || c == '\r'; }
static bool is_digit(char c) { return c >= '0' && c <= '9'; }

static char peek(const checker *c) { return c->at < c->end ? *c->at : '\n'; }

/* Blanks, and line ends that a backslash continues. */
static void skip_blanks(checker *c) {
    for (;;) {
        if (c->at < c->end && is_blank(*c->at)) {
            c->at++;
        } else if (c->at + 1 < c->end && c->at[0] == '\\' && is_line_end(c->at[1])) {
            c->at += c->at + 2 < c->end && c->at[1] == '\r' && c->at[2] == '\n' ? 3 : 2;
            c->line++;
        } else {
            return;
        }
    }
}

static void skip_line(checker *c) {
    while (c->at < c->end && !is_line_end(*c->at)) {
        if (*c->at == '\\') {
            skip_blanks(c);
            if (c->at < c->end && *c->at == '\\') c->at++;
        } else {
            c->at++;
        }
    }
    if (c->at >= c->end) return;
    c->at += c->at + 1 < c->end && c->at[0] == '\r' && c->at[1] == '\n' ? 2 : 1;
    c->line++;
}

static bool at_end_of_statement(const checker *c) { return is_line_end(peek(c)) || peek(c) == '#'; }

/* The word at hand, for messages. */
static int word_length(const checker *c) {
    int length = 0;
    while (c->at + length < c->end && !is_blank(c->at[length]) && !is_line_end(c->at[length]) && length < 40) length++;
    return length;
}

/* ---- numbers --------------------------------------------------------------------------------------------------------- */

/* nan and inf in any of their spellings pass: triangles that use them are dropped later, with a warning. */
static bool skip_nonfinite(checker *c) {
    if (peek(c) != 'n' && peek(c) != 'N' && peek(c) != 'i' && peek(c) != 'I') return false;
    c->at += word_length(c);
    return true;
}

static bool skip_number(checker *c) {
    if (peek(c) == '+' || peek(c) == '-') c->at++;
    if (skip_nonfinite(c)) return true;
    const char *start = c->at;
    while (is_digit(peek(c))) c->at++;
    bool digits = c->at > start;
    if (peek(c) == '.' || peek(c) == ',') {
        const char *point = c->at++;
        while (is_digit(peek(c))) c->at++;
        digits |= c->at > point + 1;
    }
    if (digits && (peek(c) == 'e' || peek(c) == 'E')) {
        c->at++;
        if (peek(c) == '+' || peek(c) == '-') c->at++;
        if (!is_digit(peek(c))) return false;
        while (is_digit(peek(c))) c->at++;
    } else if (digits && peek(c) == '#') {
        c->at += word_length(c); /* 1.#INF, 1.#QNAN: infinite and NaN as an old C library printed them */
    }
    return digits && (is_blank(peek(c)) || at_end_of_statement(c) || peek(c) == '\\');
}

static sl_status check_numbers(checker *c, int wanted, kind *of) {
    for (int i = 0; i < wanted; i++) {
        skip_blanks(c);
        checker before = *c;
        if (!skip_number(c)) {
            return sl_fail(c->error, SL_ERROR_INPUT, "%s:%lu: expected %d numbers for a %s, got '%.*s'", c->path, c->line, wanted,
                           of->name, word_length(&before), before.at);
        }
    }
    of->count++;
    return SL_OK;
}

/* ---- faces -------------------------------------------------------------------------------------------------------------- */

static sl_status check_index(checker *c, kind *of) {
    bool negative = peek(c) == '-';
    checker before = *c;
    if (negative || peek(c) == '+') c->at++;
    unsigned long value = 0;
    const char *start = c->at;
    for (; is_digit(peek(c)); c->at++) {
        if (value < 1000000000000ul) value = 10 * value + (unsigned long)(*c->at - '0');
    }
    if (c->at == start) {
        return sl_fail(c->error, SL_ERROR_INPUT, "%s:%lu: expected a %s index, got '%.*s'", c->path, c->line, of->name, word_length(&before),
                       before.at);
    }
    if (value == 0 || (negative && value > of->count)) {
        return sl_fail(c->error, SL_ERROR_INPUT, "%s:%lu: %s index %s%lu is out of range: expected 1 or more, or -1 to -%lu", c->path,
                       c->line, of->name, negative ? "-" : "", value, of->count);
    }
    if (!negative && value > of->largest) {
        of->largest = value;
        of->largest_line = c->line;
    }
    return SL_OK;
}

/* v, v/vt, v//vn or v/vt/vn */
static sl_status check_corner(checker *c) {
    sl_status status = check_index(c, &c->kinds[0]);
    for (int i = 1; i < 3 && status == SL_OK && peek(c) == '/'; i++) {
        c->at++;
        bool empty = peek(c) == '/' || is_blank(peek(c)) || is_line_end(peek(c));
        if (!empty) status = check_index(c, &c->kinds[i]);
    }
    if (status != SL_OK || is_blank(peek(c)) || at_end_of_statement(c) || peek(c) == '\\') return status;
    return sl_fail(c->error, SL_ERROR_INPUT, "%s:%lu: expected face corners like 1, 1/2, 1//3 or 1/2/3, got '%.*s'", c->path, c->line,
                   word_length(c), c->at);
}

static sl_status check_face(checker *c) {
    sl_status status = SL_OK;
    for (skip_blanks(c); status == SL_OK && !at_end_of_statement(c); skip_blanks(c)) status = check_corner(c);
    if (status != SL_OK || peek(c) != '#') return status;
    /* The importer takes the comment for a corner. */
    return sl_fail(c->error, SL_ERROR_INPUT, "%s:%lu: expected no comment behind a face: put it on a line of its own", c->path, c->line);
}

/* ---- lines ---------------------------------------------------------------------------------------------------------------- */

static sl_status check_library(checker *c) {
    skip_blanks(c);
    const char *start = c->at, *stop = start;
    while (stop < c->end && !is_line_end(*stop)) stop++;
    while (stop > start && is_blank(stop[-1])) stop--;
    char name[512];
    if (stop == start || (size_t)(stop - start) >= sizeof name) return SL_OK;
    memcpy(name, start, (size_t)(stop - start));
    name[stop - start] = 0;
    char *path = sl_file_beside(c->path, name);
    if (!path) return sl_fail_memory(c->error, "a file name");
    if (!sl_file_exists(path)) {
        sl_model_warn(c->model, "%s:%lu: material library '%s' does not exist; its materials are grey", c->path, c->line, name);
    }
    sl_free(path);
    return SL_OK;
}

static bool starts_with(checker *c, const char *word) {
    size_t length = strlen(word);
    if ((size_t)(c->end - c->at) <= length || memcmp(c->at, word, length) != 0 || !is_blank(c->at[length])) return false;
    c->at += length;
    return true;
}

static sl_status check_line(checker *c) {
    while (is_blank(peek(c))) c->at++;
    if (starts_with(c, "v")) return check_numbers(c, 3, &c->kinds[0]);
    if (starts_with(c, "vt")) return check_numbers(c, 1, &c->kinds[1]);
    if (starts_with(c, "vn")) return check_numbers(c, 3, &c->kinds[2]);
    if (starts_with(c, "f")) return check_face(c);
    if (starts_with(c, "mtllib")) return check_library(c);
    return SL_OK;
}

static sl_status check_largest(const checker *c) {
    for (int i = 0; i < 3; i++) {
        const kind *k = &c->kinds[i];
        if (k->largest <= k->count) continue;
        return sl_fail(c->error, SL_ERROR_INPUT, "%s:%lu: %s index %lu is out of range: the file has %lu", c->path, k->largest_line,
                       k->name, k->largest, k->count);
    }
    return SL_OK;
}

static bool is_utf16(const unsigned char *data, size_t size) {
    return size >= 2 && ((data[0] == 0xff && data[1] == 0xfe) || (data[0] == 0xfe && data[1] == 0xff));
}

sl_status sl_obj_check(const char *path, sl_model *model, sl_error *error) {
    char *data;
    size_t size;
    sl_status status = sl_file_read(path, &data, &size, error);
    if (status != SL_OK) return status;
    checker c = {path, data, data + size, 1,
                 {{"vertex", 0, 0, 0}, {"texture coordinate", 0, 0, 0}, {"normal", 0, 0, 0}}, model, error};
    /* The importer turns UTF-16 into UTF-8 first; such a file is left to it. */
    if (!is_utf16((const unsigned char *)data, size)) {
        while (status == SL_OK && c.at < c.end) {
            status = check_line(&c);
            if (status == SL_OK) skip_line(&c);
        }
        if (status == SL_OK) status = check_largest(&c);
    }
    sl_free(data);
    return status;
}
