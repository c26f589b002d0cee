#include "base/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = 64 };

void *sl_allocate(size_t count, size_t size) {
    if (size && count > (SIZE_MAX - ALIGNMENT) / size) return NULL;
    size_t bytes = count * size;
    size_t rounded = (bytes + ALIGNMENT) / ALIGNMENT * ALIGNMENT; /* at least one line, so that count 0 is a valid block */
    void *block = aligned_alloc(ALIGNMENT, rounded);
    if (block) memset(block, 0, rounded);
    return block;
}

void sl_free(void *block) { free(block); }
