/* The promises of a PLY file's header. */
#include <stdio.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/values.h"
#include "image/formats.h"
#include "import/assimp.h"
#include "scene/file.h"

enum { LONGEST_LINE = 1024 };

/* One line of the header without its end; false where the file ends first or the line cannot be one of a
 * header. */
static bool next_line(const char **at, const char *end, char line[LONGEST_LINE]) {
    size_t length = 0;
    while (*at + length < end && (*at)[length] != '\n' && (*at)[length] != '\r') length++;
    if (*at + length >= end || length >= LONGEST_LINE || memchr(*at, 0, length)) return false;
    memcpy(line, *at, length);
    line[length] = 0;
    *at += length;
    *at += end - *at >= 2 && (*at)[0] == '\r' && (*at)[1] == '\n' ? 2 : 1;
    return true;
}

/* In a text file every value takes a digit and a blank; in a binary one its type's size, which is a byte at
 * least, and a list at least its length. */
static double least_bytes(const char *line, bool ascii) {
    char type[32] = "";
    if (sscanf(line, "property list %31s", type) != 1) sscanf(line, "property %31s", type);
    if (ascii || strstr(type, "short") || strstr(type, "16")) return 2.0;
    if (strcmp(type, "double") == 0 || strstr(type, "64")) return 8.0;
    return strstr(type, "int8") || strstr(type, "char") ? 1.0 : 4.0;
}

/* Walks the header up to its end; false where it has none. *smallest: bytes that all elements need. */
static bool read_header(const char **at, const char *end, unsigned long *number, double *smallest) {
    char line[LONGEST_LINE], name[64];
    double elements = 0.0;
    bool ascii = false;
    for (*smallest = 0.0; next_line(at, end, line); ++*number) {
        if (strcmp(line, "end_header") == 0) return true;
        if (sscanf(line, "format %63s", name) == 1) ascii = strcmp(name, "ascii") == 0;
        if (sscanf(line, "element %63s %lf", name, &elements) == 2 && !(elements >= 0.0)) return false;
        if (strncmp(line, "property", 8) == 0) *smallest += elements * least_bytes(line, ascii);
    }
    return false;
}

static bool begins_with_line(const sl_bytes *bytes, const char *word) {
    const size_t length = strlen(word);
    return bytes->size > length && memcmp(bytes->data, word, length) == 0 &&
           (bytes->data[length] == '\n' || bytes->data[length] == '\r');
}

static sl_status check(const sl_bytes *bytes, sl_error *error) {
    const char *at = (const char *)bytes->data, *end = at + bytes->size;
    unsigned long line = 1;
    double smallest;
    if (!begins_with_line(bytes, "ply"))
        return sl_fail(error, SL_ERROR_INPUT, "%s:1: expected a PLY file, which begins with 'ply'",
                       bytes->path);
    if (!read_header(&at, end, &line, &smallest))
        return sl_fail(error, SL_ERROR_INPUT, "%s:%lu: expected a PLY header that ends with 'end_header'",
                       bytes->path, line);
    const double left = (double)(end - at) + 1.0; /* the last value may end with the file */
    if (smallest <= left) return SL_OK;
    return sl_fail(error, SL_ERROR_INPUT,
                   "%s: expected at least %.0f bytes after the header, which announces that much, got %.0f",
                   bytes->path, smallest, left - 1.0);
}

sl_status sl_ply_check(const char *path, sl_error *error) {
    sl_bytes bytes;
    sl_status status = sl_bytes_read(path, SL_FILE_BYTES, &bytes, error);
    if (status != SL_OK) return status;
    if (sl_ends_with(path, ".ply") || begins_with_line(&bytes, "ply")) status = check(&bytes, error);
    sl_free(bytes.data);
    return status;
}
