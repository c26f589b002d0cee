#include "scene/obj_check.h"

#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "scene/file.h"
#include "scene/mtl_text.h"
#include "scene/obj_materials.h"

enum { LONGEST_NUMBER = 4000 /* the importer takes longer ones for two */ };

/* Vertices, texture coordinates, normals: the numbers each may have, how many there are, and the largest
 * index that a face names, with its line. Faces may name what comes later in the file, so positive indices
 * are judged at the end. */
typedef struct kind {
    const char *word, *name, *lengths;
    unsigned allowed; /* bit n: n numbers */
    unsigned long count, largest, largest_line;
} kind;

typedef struct checker {
    const char *path, *at, *end;
    unsigned long line;
    kind kinds[3];
    bool coloured, faced; /* a vertex has a colour, a face is there */
    sl_model *model;
    sl_text *plain;
    sl_obj_materials *materials;
    sl_error *error;
    unsigned long short_faces, first_short; /* faces of fewer than three corners, and the line of the first */
} checker;

static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\f' || c == '\v'; }
static bool is_line_end(char c) { return c == '\n' || c == '\r'; }
static bool is_digit(char c) { return c >= '0' && c <= '9'; }

static char peek(const checker *c) { return c->at < c->end ? *c->at : '\n'; }

static void skip_line_end(checker *c) {
    c->at += c->at + 1 < c->end && c->at[0] == '\r' && c->at[1] == '\n' ? 2 : 1;
    c->line++;
}

/* A line end behind a backslash is none. */
static bool skip_continuation(checker *c) {
    if (c->at + 1 >= c->end || c->at[0] != '\\' || !is_line_end(c->at[1])) return false;
    c->at++;
    skip_line_end(c);
    return true;
}

static void skip_blanks(checker *c) {
    for (;;) {
        if (c->at < c->end && is_blank(*c->at)) c->at++;
        else if (!skip_continuation(c)) return;
    }
}

/* A comment ends where its line does, whatever stands before the end: a path of Windows may. */
static void skip_line(checker *c) {
    while (c->at < c->end && !is_line_end(*c->at)) c->at++;
    if (c->at < c->end) skip_line_end(c);
}

static bool at_end_of_statement(const checker *c) { return is_line_end(peek(c)) || peek(c) == '#'; }

/* The word at hand, for messages. */
static int word_length(const checker *c) {
    int length = 0;
    while (c->at + length < c->end && !is_blank(c->at[length]) && !is_line_end(c->at[length]) && length < 40)
        length++;
    return length;
}

/* ---- numbers --------------------------------------------------------------------------------- */

static bool begins_with_letters(const char *at, const char *end, const char *letters) {
    for (; *letters; at++, letters++) {
        if (at >= end || (*at | 0x20) != *letters) return false;
    }
    return true;
}

/* nan and inf with any ending pass: triangles that use them are dropped later, with a warning. */
static bool skip_nonfinite(checker *c) {
    if (!begins_with_letters(c->at, c->end, "nan") && !begins_with_letters(c->at, c->end, "inf"))
        return false;
    while (c->at < c->end && !is_blank(*c->at) && !is_line_end(*c->at)) c->at++;
    return true;
}

/* 1.#INF, 1.#QNAN: infinite and NaN as an old C library printed them; any other # begins a comment. */
static bool is_old_nonfinite(const char *at, const char *end) {
    return begins_with_letters(at, end, "#in") || begins_with_letters(at, end, "#qnan") ||
           begins_with_letters(at, end, "#snan");
}

static bool skip_number(checker *c) {
    const char *start = c->at, *end = sl_text_number_end(c->at, c->end);
    if (peek(c) == '+' || peek(c) == '-') c->at++;
    if (skip_nonfinite(c)) return true;
    if (!end) return false;
    c->at = end;
    if (end[-1] == '.' && is_old_nonfinite(c->at, c->end)) c->at += word_length(c);
    return c->at - start < LONGEST_NUMBER && (is_blank(peek(c)) || at_end_of_statement(c) || peek(c) == '\\');
}

/* The importer does not count what begins with a point, and reads 1.#INF as 1. */
static void add_number(checker *c, const char *from) {
    sl_text_add(c->plain, " ", 1);
    if (memchr(from, '#', (size_t)(c->at - from))) {
        sl_text_add(c->plain, "nan", 3);
        return;
    }
    if (*from == '+' || *from == '-') sl_text_add(c->plain, from++, 1);
    if (*from == '.' || *from == ',') sl_text_add(c->plain, "0", 1);
    sl_text_add(c->plain, from, (size_t)(c->at - from));
}

static bool is_zero(const char *at, const char *end) {
    for (; at < end && *at != 'e' && *at != 'E'; at++) {
        if (*at != '0' && *at != '.' && *at != ',' && *at != '+' && *at != '-') return false;
    }
    return true;
}

/* Colours are for nothing here, and the importer refuses files that have them for some vertices alone. */
static void leave_out_colour(checker *c, size_t end_of_position) {
    c->plain->size = end_of_position;
    if (!c->coloured) sl_model_warn(c->model, "%s: vertex colours are not used", c->path);
    c->coloured = true;
}

static sl_status check_numbers(checker *c, kind *of) {
    unsigned count = 0;
    size_t end_of_third = 0;
    bool ends_in_zero = false;
    sl_text_add(c->plain, of->word, strlen(of->word));
    for (skip_blanks(c); !at_end_of_statement(c); skip_blanks(c)) {
        checker before = *c;
        if (!skip_number(c)) {
            return sl_fail(c->error, SL_ERROR_INPUT, "%s:%lu: expected %s numbers for a %s, got '%.*s'",
                           c->path, c->line, of->lengths, of->name, word_length(&before), before.at);
        }
        ends_in_zero = is_zero(before.at, c->at);
        add_number(c, before.at);
        if (++count == 3) end_of_third = c->plain->size;
    }
    if (count > 7 || !(of->allowed >> count & 1)) {
        return sl_fail(c->error, SL_ERROR_INPUT, "%s:%lu: expected %s numbers for a %s, got %u", c->path,
                       c->line, of->lengths, of->name, count);
    }
    if (count == 4 && ends_in_zero) {
        return sl_fail(c->error, SL_ERROR_INPUT,
                       "%s:%lu: expected the fourth number of a %s to be other than 0: it divides", c->path,
                       c->line, of->name);
    }
    if (count == 6) leave_out_colour(c, end_of_third);
    /* the second may be left out, for a texture of one dimension */
    if (count == 1) sl_text_add(c->plain, " 0", 2);
    of->count++;
    return SL_OK;
}

/* ---- faces ----------------------------------------------------------------------------------- */

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
        return sl_fail(c->error, SL_ERROR_INPUT, "%s:%lu: expected a %s index, got '%.*s'", c->path, c->line,
                       of->name, word_length(&before), before.at);
    }
    if (value == 0 || (negative && value > of->count)) {
        return sl_fail(c->error, SL_ERROR_INPUT,
                       "%s:%lu: %s index %s%lu is out of range: expected 1 or more, or -1 to -%lu", c->path,
                       c->line, of->name, negative ? "-" : "", value, of->count);
    }
    if (!negative && value > of->largest) {
        of->largest = value;
        of->largest_line = c->line;
    }
    for (; *start == '0'; start++) {} /* the importer would read on behind as many digits as the value has */
    if (negative) sl_text_add(c->plain, "-", 1);
    sl_text_add(c->plain, start, (size_t)(c->at - start));
    return SL_OK;
}

/* v, v/vt, v//vn or v/vt/vn; of: bit 1 for a vt, bit 2 for a vn */
static sl_status check_corner(checker *c, unsigned *of) {
    *of = 0;
    sl_text_add(c->plain, " ", 1);
    sl_status status = check_index(c, &c->kinds[0]);
    size_t slashes = 0;
    for (int i = 1; i < 3 && status == SL_OK && peek(c) == '/'; i++) {
        c->at++;
        slashes++;
        if (peek(c) == '/' || peek(c) == '\\' || is_blank(peek(c)) || at_end_of_statement(c)) continue;
        sl_text_add(c->plain, "//", slashes);
        slashes = 0;
        status = check_index(c, &c->kinds[i]);
        *of |= 1u << i;
    }
    if (status != SL_OK || is_blank(peek(c)) || at_end_of_statement(c) || peek(c) == '\\') return status;
    return sl_fail(c->error, SL_ERROR_INPUT,
                   "%s:%lu: expected face corners like 1, 1/2, 1//3 or 1/2/3, got '%.*s'", c->path, c->line,
                   word_length(c), c->at);
}

/* The importer would give what a corner does not have to the corner before it. */
static sl_status check_corners(checker *c) {
    unsigned first = 0, other;
    sl_status status = SL_OK;
    unsigned long line = c->line;
    int i = 0;
    c->faced = true;
    sl_text_add(c->plain, "f", 1);
    for (; skip_blanks(c), status == SL_OK && !at_end_of_statement(c); i++) {
        status = check_corner(c, i == 0 ? &first : &other);
        if (i == 0 || status != SL_OK || other == first) continue;
        status = sl_fail(c->error, SL_ERROR_INPUT,
                         "%s:%lu: expected face corners that all have the same, as in 1/1 2/2 3/3: corner %d "
                         "has other indices than the first",
                         c->path, c->line, i + 1);
    }
    if (i >= 3) return status;
    if (c->short_faces++ == 0) c->first_short = line;
    return status;
}

/* Lines and points are not drawn, and the importer stumbles over a line of one point: they are checked alone.
 */
static sl_status check_undrawn(checker *c) {
    size_t before = c->plain->size;
    sl_status status = SL_OK;
    unsigned of;
    for (skip_blanks(c); status == SL_OK && !at_end_of_statement(c); skip_blanks(c))
        status = check_corner(c, &of);
    c->plain->size = before;
    return status;
}

/* ---- lines ----------------------------------------------------------------------------------- */

static bool starts_with(checker *c, const char *word) {
    size_t length = strlen(word);
    if ((size_t)(c->end - c->at) <= length || memcmp(c->at, word, length) != 0 ||
        !(is_blank(c->at[length]) || c->at[length] == '\\'))
        return false;
    c->at += length;
    return true;
}

/* Other statements stay as they are, on one line: names may have a # in them. */
static void copy_statement(checker *c) {
    while (c->at < c->end && !is_line_end(*c->at)) {
        if (skip_continuation(c)) continue;
        char byte = *c->at++;
        sl_text_add(c->plain, byte == '\f' ? " " : &byte, 1); /* the importer takes it for a line end */
    }
    sl_text_trim(c->plain);
}

static sl_status check_library(checker *c) {
    unsigned long line = c->line;
    size_t before = c->plain->size;
    skip_blanks(c);
    copy_statement(c);
    if (c->plain->size == before) return SL_OK;
    sl_status status =
        sl_obj_materials_read(c->materials, line, c->plain->data + before, c->plain->size - before, c->error);
    c->plain->size = before;
    return status;
}

/* Without a name the importer would look for one in the next line. */
static void copy_use(checker *c) {
    unsigned long line = c->line;
    sl_text_add(c->plain, "usemtl ", 7);
    size_t start = c->plain->size;
    skip_blanks(c);
    copy_statement(c);
    if (c->plain->size > start)
        sl_obj_materials_use(c->materials, line, c->plain->data + start, c->plain->size - start);
    else sl_text_add(c->plain, " " SL_NAMELESS_MATERIAL, strlen(" " SL_NAMELESS_MATERIAL));
}

/* The importer takes any word that begins like v, f, l or p for it, and skips what is between cstype and end,
 * vertices too. */
static bool is_left_out(checker *c) { return memchr("#vflp", peek(c), 5) || starts_with(c, "cstype"); }

static sl_status check_statement(checker *c) {
    for (int i = 0; i < 3; i++) {
        if (starts_with(c, c->kinds[i].word)) return check_numbers(c, &c->kinds[i]);
    }
    /* fo is an old name of the same */
    if (starts_with(c, "f") || starts_with(c, "fo")) return check_corners(c);
    if (starts_with(c, "l") || starts_with(c, "p")) return check_undrawn(c);
    if (starts_with(c, "mtllib")) return check_library(c);
    if (starts_with(c, "usemtl")) copy_use(c);
    else if (!is_left_out(c)) copy_statement(c);
    return SL_OK;
}

static sl_status check_line(checker *c) {
    skip_blanks(c);
    sl_status status = check_statement(c);
    sl_text_add(c->plain, "\n", 1);
    skip_line(c);
    return status;
}

static sl_status check_largest(const checker *c) {
    for (int i = 0; i < 3; i++) {
        const kind *k = &c->kinds[i];
        if (k->largest <= k->count) continue;
        return sl_fail(c->error, SL_ERROR_INPUT, "%s:%lu: %s index %lu is out of range: the file has %lu",
                       c->path, k->largest_line, k->name, k->largest, k->count);
    }
    return SL_OK;
}

static void warn_of_short_faces(const checker *c) {
    if (c->short_faces == 1)
        sl_model_warn(c->model, "%s:%lu: a face of fewer than three corners is not drawn", c->path,
                      c->first_short);
    else if (c->short_faces)
        sl_model_warn(c->model, "%s:%lu: this face and %lu more of fewer than three corners are not drawn",
                      c->path, c->first_short, c->short_faces - 1);
}

static sl_status conclude(checker *c) {
    sl_status status = check_largest(c);
    if (status != SL_OK) return status;
    warn_of_short_faces(c);
    return sl_obj_materials_conclude(c->materials, c->error);
}

/* Libraries come first, and after them the importer's own material: it would give the last one that it has
 * read of to the faces before the first usemtl, and that of the first usemtl where there is no library. */
static void put_libraries_first(checker *c) {
    if (!c->faced) c->plain->size = 0; /* it would make points of the vertices, and not find their normals */
    sl_text *libraries = &c->materials->libraries;
    sl_text_add(libraries, "usemtl " SL_NAMELESS_MATERIAL "\n", strlen("usemtl " SL_NAMELESS_MATERIAL "\n"));
    sl_text_prepend(c->plain, libraries);
}

sl_status sl_obj_check(const char *path, sl_model *model, sl_text *plain, sl_text *libraries,
                       sl_error *error) {
    *plain = *libraries = (sl_text){0};
    char *data;
    size_t size;
    sl_status status = sl_file_read(path, &data, &size, error);
    if (status != SL_OK) return status;
    sl_obj_materials materials = {.path = path, .model = model, .texts = libraries};
    checker c = {path,
                 data,
                 data + size,
                 1,
                 {{"v", "vertex", "3, 4 or 6", 1 << 3 | 1 << 4 | 1 << 6, 0, 0, 0},
                  {"vt", "texture coordinate", "1, 2 or 3", 1 << 1 | 1 << 2 | 1 << 3, 0, 0, 0},
                  {"vn", "normal", "3", 1 << 3, 0, 0, 0}},
                 .model = model,
                 .plain = plain,
                 .materials = &materials,
                 .error = error};
    c.at += sl_text_mark_bytes(data, size);
    /* The importer turns UTF-16 into UTF-8 first; such a file is left to it. */
    if (!sl_text_is_utf16(data, size)) {
        sl_text_reserve(plain, size + 64);
        status = sl_text_refuse_zeros(data, size, path, error);
        while (status == SL_OK && c.at < c.end) status = check_line(&c);
        if (status == SL_OK) status = conclude(&c);
        if (size) put_libraries_first(&c); /* an empty file stays one, and is refused */
        if (status == SL_OK) status = sl_text_check(plain, path, error);
    }
    sl_free(data);
    sl_obj_materials_release(&materials);
    if (status != SL_OK) sl_text_release(plain);
    if (status != SL_OK) sl_text_release(libraries);
    return status;
}
