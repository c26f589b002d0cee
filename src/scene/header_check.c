#include "scene/header_check.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "scene/file.h"

typedef struct header {
    const char *path;
    unsigned long line;
    bool started, vertices, faces, ascii;
    double elements;  /* of the element being described */
    double smallest;  /* bytes that all elements need at least */
    sl_error *error;
} header;

/* Bytes of a scalar type in a binary file; 0: no such type. */
static unsigned type_size(const char *type) {
    static const struct {
        const char *name;
        unsigned size;
    } types[] = {{"char", 1},  {"uchar", 1},   {"int8", 1},   {"uint8", 1},  {"short", 2}, {"ushort", 2},
                 {"int16", 2}, {"uint16", 2},  {"int", 4},    {"uint", 4},   {"int32", 4}, {"uint32", 4},
                 {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++) {
        if (strcmp(type, types[i].name) == 0) return types[i].size;
    }
    return 0;
}

static sl_status fail(const header *h, const char *what) {
    return sl_fail(h->error, SL_ERROR_INPUT, "%s:%lu: expected %s", h->path, h->line, what);
}

/* In a text file every value takes a digit and a blank; in a binary one its type's size, and a list at least
 * its length. */
static sl_status read_property(header *h, const char *line) {
    char type[32], second[32];
    if (!h->started) return fail(h, "an element before its properties");
    if (sscanf(line, "property list %31s %31s", type, second) == 2) {
        if (!type_size(type) || !type_size(second))
            return fail(h, "a property type of PLY (char ... double)");
    } else if (sscanf(line, "property %31s", type) != 1 || !type_size(type)) {
        return fail(h, "a property type of PLY (char ... double)");
    }
    h->smallest += h->elements * (h->ascii ? 2.0 : (double)type_size(type));
    return SL_OK;
}

static sl_status read_line(header *h, const char *line) {
    char name[64];
    if (sscanf(line, "format %63s", name) == 1) {
        h->ascii = strcmp(name, "ascii") == 0;
        bool known =
            h->ascii || strcmp(name, "binary_little_endian") == 0 || strcmp(name, "binary_big_endian") == 0;
        return known ? SL_OK : fail(h, "format ascii, binary_little_endian or binary_big_endian");
    }
    if (sscanf(line, "element %63s %lf", name, &h->elements) == 2) {
        bool is_vertex = strcmp(name, "vertex") == 0, is_face = strcmp(name, "face") == 0;
        if ((is_vertex && h->vertices) || (is_face && h->faces))
            return fail(h, "one element 'vertex' and one element 'face'");
        h->vertices |= is_vertex;
        h->faces |= is_face;
        h->started = true;
        return h->elements >= 0.0 && h->elements < 4e9 ? SL_OK
                                                       : fail(h, "a number of elements below 4000000000");
    }
    if (strncmp(line, "property", 8) == 0) return read_property(h, line);
    return SL_OK; /* writers add lines of their own */
}

/* One line of the header without its end; false where the file ends first or the line cannot be one of a
 * header. */
static bool next_line(const char **at, const char *end, char *line, size_t room) {
    size_t length = 0;
    while (*at + length < end && (*at)[length] != '\n' && (*at)[length] != '\r') length++;
    if (*at + length >= end || length >= room || memchr(*at, 0, length)) return false;
    memcpy(line, *at, length);
    line[length] = 0;
    *at += length;
    *at += end - *at >= 2 && (*at)[0] == '\r' && (*at)[1] == '\n' ? 2 : 1;
    return true;
}

static sl_status check(header *h, const char *data, size_t size) {
    const char *at = data, *end = data + size;
    char line[1024];
    if (!next_line(&at, end, line, sizeof line) || strcmp(line, "ply") != 0)
        return fail(h, "a PLY file, which begins with 'ply'");
    for (h->line = 2;; h->line++) {
        if (!next_line(&at, end, line, sizeof line))
            return fail(h, "a PLY header that ends with 'end_header'");
        if (strcmp(line, "end_header") == 0) break;
        sl_status status = read_line(h, line);
        if (status != SL_OK) return status;
    }
    double left = (double)(end - at) + 1.0; /* the last value may end with the file */
    if (h->smallest <= left) return SL_OK;
    return sl_fail(h->error, SL_ERROR_INPUT,
                   "%s: expected at least %.0f bytes after the header, which announces that much, got %.0f",
                   h->path, h->smallest, left - 1.0);
}

/* ---- OFF ------------------------------------------------------------------------------------- */

/* Past blanks, ends of lines and comments. */
static const char *next_word(const char *at) {
    for (at += strspn(at, " \t\r\n\f"); *at == '#'; at += strspn(at, " \t\r\n\f"))
        at += strcspn(at, "\r\n\f");
    return at;
}

/* Past the line that begins here, and past empty ones. */
static const char *line_after(const char *at) {
    at += strcspn(at, "\r\n\f");
    return at + strspn(at, "\r\n\f");
}

static unsigned long lines_between(const char *from, const char *to) {
    unsigned long lines = 0;
    for (; from < to; from++) lines += *from == '\n' || (*from == '\r' && from[1] != '\n');
    return lines;
}

/* The digits here, as the importer reads a number: no sign, no point. */
static bool read_whole(const char **at, double *number) {
    const char *from = *at;
    for (*number = 0.0; **at >= '0' && **at <= '9'; ++*at) *number = 10.0 * *number + (**at - '0');
    return *at > from;
}

static bool read_whole_of_line(const char **at, double *number) {
    *at += strspn(*at, " \t");
    return read_whole(at, number);
}

static bool read_whole_of_header(const char **at, double *number) {
    *at = next_word(*at);
    return read_whole(at, number) && strchr(" \t\r\n\f#", **at); /* or the file's end */
}

/* The importer takes the last vertex for one that there is none of. */
static bool is_face(const char *at, double vertices) {
    double corners, vertex;
    if (!read_whole_of_line(&at, &corners) || corners < 1.0 || corners > 9.0) return false;
    for (; corners > 0.0; corners--) {
        if (!read_whole_of_line(&at, &vertex) || vertex >= vertices) return false;
    }
    return true;
}

/* A line a vertex, a line a face. The importer takes one face off its count for each that does not have one
 * to nine corners, and goes on reading: below none. */
static sl_status check_off_faces(const char *path, const char *data, const char *at, double vertices,
                                 double faces, sl_error *error) {
    for (double i = 0.0; i < vertices && *at; i++) at = line_after(at);
    for (double i = 0.0; i < faces && *at; i++, at = line_after(at)) {
        if (is_face(at, vertices)) continue;
        return sl_fail(
            error, SL_ERROR_INPUT,
            "%s:%lu: expected a face: a number of corners from 1 to 9, and so many vertices below %.0f", path,
            lines_between(data, at) + 1, vertices);
    }
    return SL_OK;
}

/* Past "OFF" and the letters before it that say what a vertex has. NULL: it is not there. Without it the
 * importer would lose a first digit 4. */
static const char *after_magic(const char *at) {
    static const char *const letters[] = {"ST", "C", "N", "4", "n"};
    for (size_t i = 0; i < sizeof letters / sizeof *letters; i++) {
        size_t length = strlen(letters[i]);
        if (strncmp(at, letters[i], length) == 0) at += length;
    }
    return strncmp(at, "OFF", 3) == 0 ? at + 3 : NULL;
}

/* "OFF", then how many vertices, faces and edges there are, in one line or several; some writers have no
 * blank between. A vertex takes two bytes a coordinate ("0 0 0\n"), a face two. */
static sl_status check_off(const char *path, const char *data, size_t size, sl_error *error) {
    double dimension = 3.0, vertices, faces, edges;
    const char *begin = next_word(data), *at = after_magic(begin);
    if (!at)
        return sl_fail(error, SL_ERROR_INPUT, "%s:%lu: expected an OFF file, which begins with 'OFF'", path,
                       lines_between(data, begin) + 1);
    bool has_dimension = at - begin > 3 && at[-4] == 'n';
    if ((has_dimension && !read_whole_of_header(&at, &dimension)) || !read_whole_of_header(&at, &vertices) ||
        !read_whole_of_header(&at, &faces) || !read_whole_of_header(&at, &edges)) {
        return sl_fail(error, SL_ERROR_INPUT, "%s:%lu: expected how many vertices, faces and edges there are",
                       path, lines_between(data, at) + 1);
    }
    double smallest = 2.0 * dimension * vertices + 2.0 * faces;
    if (smallest <= (double)size) return check_off_faces(path, data, next_word(at), vertices, faces, error);
    return sl_fail(error, SL_ERROR_INPUT,
                   "%s: expected at least %.0f bytes for %.0f vertices and %.0f faces, got %zu", path,
                   smallest, vertices, faces, size);
}

static bool begins_with(const char *data, size_t size, const char *word) {
    size_t length = strlen(word);
    return size > length && memcmp(data, word, length) == 0 && (data[length] == '\n' || data[length] == '\r');
}

sl_status sl_header_check(const char *path, sl_error *error) {
    char *data;
    size_t size;
    sl_status status = sl_file_read(path, &data, &size, error);
    if (status != SL_OK) return status;
    header h = {.path = path, .line = 1, .error = error};
    if (sl_file_has_extension(path, ".ply") || begins_with(data, size, "ply")) status = check(&h, data, size);
    else if (sl_file_has_extension(path, ".off") || begins_with(data, size, "OFF"))
        status = check_off(path, data, size, error);
    sl_free(data);
    return status;
}
