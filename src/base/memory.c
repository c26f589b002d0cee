#include "base/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = 64 };

static void *allocate(size_t count, size_t size, size_t *rounded) {
    if (size && count > (SIZE_MAX - ALIGNMENT) / size) return NULL;
    /* at least one line, so that count 0 is a valid block */
    *rounded = (count * size + ALIGNMENT) / ALIGNMENT * ALIGNMENT;
    return aligned_alloc(ALIGNMENT, *rounded);
}

void *sl_allocate(size_t count, size_t size) {
    size_t rounded;
    void *block = allocate(count, size, &rounded);
    if (block) memset(block, 0, rounded);
    return block;
}

void *sl_allocate_unset(size_t count, size_t size) {
    size_t rounded;
    return allocate(count, size, &rounded);
}

bool sl_memory_has_ended(void) {
    enum { SMALL = 1 << 16 };
    void *block = sl_allocate_unset(SMALL, 1);
    sl_free(block);
    return !block;
}

void sl_free(void *block) { free(block); }
