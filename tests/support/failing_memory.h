/* A test program of its own that includes this has another sl_allocate(): it fails when told to, and knows
 * what is held. */
#pragma once

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

static long allocations_left = -1; /* until one fails, then all do; -1: none fails */
static long blocks_held;

void *sl_allocate(size_t count, size_t size) {
    if (allocations_left == 0) {
        errno = ENOMEM;
        return NULL;
    }
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

bool sl_memory_has_ended(void) { return allocations_left == 0; }

/* Calls something with room for 0, 1, 2 ... allocations until it succeeds; how often it failed. Each time it
 * says that memory ended, and holds no more than before, unless it is of those that keep what they did until
 * then. after_failure (or NULL) looks at what is left, with all memory there is. */
typedef sl_status attempt(void *context);
typedef void look(void *context);
static inline long until_it_succeeds(attempt *call, void *context, bool keeps, look *after_failure) {
    for (long room = 0;; room++) {
        long held = blocks_held;
        allocations_left = room;
        sl_status status = call(context);
        allocations_left = -1;
        if (status == SL_OK) return room;
        assert_int_equal(status, SL_ERROR_RESOURCES);
        if (!keeps) assert_int_equal(blocks_held, held);
        if (after_failure) after_failure(context);
    }
}
