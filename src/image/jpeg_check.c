/* Checks what stb_image 2.27 trusts in a JPEG: a table of Huffman codes that lists more codes than there are
 * makes it write beyond its own. So the file's segments are walked before it is decoded (ITU T.81,
 * annex B). */
#include "image/formats.h"

enum { HUFFMAN_TABLES = 0xc4, END_OF_IMAGE = 0xd9 };

/* Markers without a segment: restarts, the start of the image, and TEM. */
static bool stands_alone(uint8_t marker) { return marker == 1 || (marker >= 0xd0 && marker <= 0xd8); }

/* A segment may hold several tables: a byte of class and number, 16 counts of codes by length, then the
 * codes' values. */
static bool huffman_tables_are_sound(const uint8_t *segment, size_t size) {
    while (size > 0) {
        if (size < 17) return false;
        size_t codes = 0, space = 0;
        for (size_t length = 1; length <= 16; length++) {
            codes += segment[length];
            space += (size_t)segment[length] << (16 - length); /* in codes of 16 bits */
        }
        if (codes > 256 || space > 65536 || size < 17 + codes) return false;
        segment += 17 + codes;
        size -= 17 + codes;
    }
    return true;
}

/* The position behind the next marker at or after `position`, or 0 where there is none. In a scan's data 0xff
 * is followed by 0; elsewhere that would be junk, which decoders skip alike. */
static size_t next_marker(const sl_bytes *bytes, size_t position, uint8_t *marker) {
    for (; position + 1 < bytes->size; position++) {
        uint8_t second = bytes->data[position + 1];
        if (bytes->data[position] != 0xff || second == 0 || second == 0xff) continue;
        *marker = second;
        return position + 2;
    }
    return 0;
}

bool sl_jpeg_tables_are_sound(const sl_bytes *bytes) {
    uint8_t marker;
    size_t position = 0;
    while ((position = next_marker(bytes, position, &marker)) != 0) {
        if (marker == END_OF_IMAGE) return true; /* decoders stop here too */
        if (stands_alone(marker)) continue;
        if (bytes->size - position < 2) return false;
        size_t length = (size_t)bytes->data[position] << 8 | bytes->data[position + 1]; /* counts itself */
        if (length < 2 || length > bytes->size - position) return false;
        if (marker == HUFFMAN_TABLES && !huffman_tables_are_sound(bytes->data + position + 2, length - 2))
            return false;
        position += length;
    }
    return true;
}
