/* Arrays out of blocks of sl_allocate(), which tests replace by one that fails: so they are a file of their
 * own. */
#include "base/grow.h"

#include <string.h>

#include "base/memory.h"

void *sl_allocate_planes(size_t stride, size_t planes, float **const plane[]) {
    float *block = sl_allocate(stride, planes * sizeof *block);
    for (size_t i = 0; i < planes && block; i++) *plane[i] = block + i * stride;
    return block;
}

void sl_free_all(void *const blocks[], size_t count) {
    for (size_t i = 0; i < count; i++) sl_free(blocks[i]);
}

void *sl_copy_of(const void *array, size_t count, size_t size) {
    void *copy = sl_allocate_unset(count, size);
    if (copy && count) memcpy(copy, array, count * size);
    return copy;
}

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
