/* A test program of its own that includes this has another sl_allocate(): it fails when told to, and knows what is held. */
#ifndef SL_TESTS_FAILING_MEMORY_H
#define SL_TESTS_FAILING_MEMORY_H

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

static long allocations_left = -1; /* until one fails, then all do; -1: none fails */
static long blocks_held;

void *sl_allocate(size_t count, size_t size) {
    if (allocations_left == 0) return NULL;
    if (allocations_left > 0) allocations_left--;
    size_t bytes = (count * size + 64) / 64 * 64;
    void *block = aligned_alloc(64, bytes);
    assert_non_null(block);
    blocks_held++;
    return memset(block, 0, bytes);
}

void *sl_allocate_unset(size_t count, size_t size) { return sl_allocate(count, size); }

void sl_free(void *block) {
    if (block != NULL) blocks_held--;
    free(block);
}

#endif
