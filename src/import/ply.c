#include <stdio.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "image/formats.h"
#include "import/assimp.h"
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

static bool begins_with_line(const char *data, size_t size, const char *word) {
    size_t length = strlen(word);
    return size > length && memcmp(data, word, length) == 0 && (data[length] == '\n' || data[length] == '\r');
}

sl_status sl_ply_check(const char *path, sl_error *error) {
    sl_bytes bytes;
    sl_status status = sl_bytes_read(path, SL_FILE_BYTES, &bytes, error);
    if (status != SL_OK) return status;
    const char *data = (const char *)bytes.data;
    header h = {.path = path, .line = 1, .error = error};
    if (sl_file_has_extension(path, ".ply") || begins_with_line(data, bytes.size, "ply"))
        status = check(&h, data, bytes.size);
    sl_free(bytes.data);
    return status;
}
