/* Arrays that grow by a quarter: room for one more without holding much more than is used. */
#ifndef SL_MULTI_MESH_GROW_H
#define SL_MULTI_MESH_GROW_H

#include <string.h>

#include "base/memory.h"

/* A block of at least `capacity` elements with the first `used` of *block in it, in place of *block. False: memory ended, nothing has changed. */
static inline bool sl_regrow(void **block, size_t used, size_t capacity, size_t size) {
    void *larger = sl_allocate_unset(capacity, size);
    if (larger == NULL) return false;
    if (used > 0) memcpy(larger, *block, used * size);
    sl_free(*block);
    *block = larger;
    return true;
}

static inline size_t sl_grown_capacity(size_t capacity, size_t needed) {
    size_t grown = capacity + capacity / 4;
    return grown > needed ? grown : needed;
}

#endif
