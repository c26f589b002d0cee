#include "scene/text.h"

#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "scene/file.h"

void sl_text_reserve(sl_text *text, size_t capacity) {
    if (capacity <= text->capacity || text->starved) return;
    char *data = sl_allocate_unset(capacity, 1);
    text->starved = !data;
    if (!data) return;
    if (text->size) memcpy(data, text->data, text->size);
    sl_free(text->data);
    text->data = data;
    text->capacity = capacity;
}

void sl_text_add(sl_text *text, const char *from, size_t size) {
    if (size > text->capacity - text->size) sl_text_reserve(text, text->size + size + text->capacity / 2 + 256);
    if (text->starved || size == 0) return;
    memcpy(text->data + text->size, from, size);
    text->size += size;
}

void sl_text_prepend(sl_text *text, const sl_text *first) {
    size_t size = text->size;
    sl_text_add(text, first->data, first->size);
    text->starved |= first->starved;
    if (text->starved) return;
    memmove(text->data + first->size, text->data, size);
    memcpy(text->data, first->data, first->size);
}

void sl_text_trim(sl_text *text) {
    while (text->size && (text->data[text->size - 1] == ' ' || text->data[text->size - 1] == '\t')) text->size--;
}

sl_status sl_text_check(const sl_text *text, const char *path, sl_error *error) {
    return text->starved ? sl_fail_memory(error, path) : sl_file_check_size(path, text->size, error);
}

void sl_text_release(sl_text *text) {
    sl_free(text->data);
    *text = (sl_text){0};
}

bool sl_text_is_utf16(const char *data, size_t size) {
    return size >= 2 && (memcmp(data, "\xff\xfe", 2) == 0 || memcmp(data, "\xfe\xff", 2) == 0);
}
