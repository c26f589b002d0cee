#include "base/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/grow.h"

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

void *sl_allocate_planes(size_t stride, size_t planes, float **const plane[]) {
    float *block = sl_allocate(stride, planes * sizeof *block);
    for (size_t i = 0; i < planes && block; i++) *plane[i] = block + i * stride;
    return block;
}

void sl_free(void *block) { free(block); }

/* ---- arrays that grow ---- */

bool sl_regrow(void *block, size_t used, size_t capacity, size_t size) {
    char *old, *larger = sl_allocate_unset(capacity, size);
    if (!larger) return false;
    memcpy(&old, block, sizeof old);
    if (used) memcpy(larger, old, used * size);
    memset(larger + used * size, 0, (capacity - used) * size);
    sl_free(old);
    memcpy(block, &larger, sizeof larger); /* a pointer to another type is not one to void */
    return true;
}

bool sl_make_room(void *block, size_t count, size_t *room, size_t size) {
    const size_t more = 2 * *room + 8;
    if (count < *room) return true;
    if (!sl_regrow(block, count, more, size)) return false;
    *room = more;
    return true;
}

size_t sl_grown_capacity(size_t capacity, size_t needed) {
    size_t grown = capacity + capacity / 4;
    return grown > needed ? grown : needed;
}
