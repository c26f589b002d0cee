/* A look at an EXR's header before the library has it: sizes that cannot be make it ask for memory that nobody has, and a damaged file
 * must not pass for want of memory. */
#include "image/formats.h"

#include <string.h>

typedef struct attribute {
    const char *name, *type;
    const uint8_t *data;
    size_t size;
} attribute;

static uint32_t little_endian(const uint8_t *b) { return (uint32_t)b[3] << 24 | (uint32_t)b[2] << 16 | (uint32_t)b[1] << 8 | b[0]; }

/* A string that ends within the file; moves *at behind it. */
static const char *take_text(const sl_bytes *bytes, size_t *at) {
    const char *text = (const char *)bytes->data + *at;
    const void *end = *at < bytes->size ? memchr(text, 0, bytes->size - *at) : NULL;
    if (!end) return NULL;
    *at += (size_t)((const char *)end - text) + 1;
    return text;
}

/* Name, type, size, data. False where they go beyond the file's end. */
static bool take_attribute(const sl_bytes *bytes, size_t *at, attribute *a) {
    a->name = take_text(bytes, at);
    a->type = a->name ? take_text(bytes, at) : NULL;
    if (!a->type || bytes->size - *at < 4) return false;
    a->size = little_endian(bytes->data + *at);
    *at += 4;
    if (a->size > bytes->size - *at) return false;
    a->data = bytes->data + *at;
    *at += a->size;
    return true;
}

/* Corners that are the wrong way round, or further apart than any picture is wide. */
static bool is_no_window(const attribute *a) {
    const int64_t widest = 1 << 24;
    if (strcmp(a->type, "box2i") != 0 || a->size != 16) return false;
    for (size_t axis = 0; axis < 2; axis++) {
        int64_t low = (int32_t)little_endian(a->data + 4 * axis), high = (int32_t)little_endian(a->data + 8 + 4 * axis);
        if (high < low || high - low >= widest) return true;
    }
    return false;
}

bool sl_exr_header_is_sound(const sl_bytes *bytes) {
    enum { MAGIC_AND_VERSION = 8 };
    for (size_t at = MAGIC_AND_VERSION; at < bytes->size && bytes->data[at];) {
        attribute a;
        if (!take_attribute(bytes, &at, &a)) return false;
        bool window = strcmp(a.name, "dataWindow") == 0 || strcmp(a.name, "displayWindow") == 0;
        if (window && is_no_window(&a)) return false;
    }
    return true;
}
