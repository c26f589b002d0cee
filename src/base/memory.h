/* Allocation with overflow checks; 64-byte aligned, zeroed. NULL on failure or overflow; count 0 gives a
 * valid block. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

void *sl_allocate(size_t count, size_t size);
/* The same, not zeroed: for what is written whole before it is read. */
void *sl_allocate_unset(size_t count, size_t size);
/* Sets *plane[i] for each of `planes` to `stride` zeros of its own. Returns the block that holds them all, to
 * be freed. */
void *sl_allocate_planes(size_t stride, size_t planes, float **const plane[]);
/* Tells whether even a small block cannot be had: for what libraries answer that do not say what they
 * lacked. */
bool sl_memory_has_ended(void);
void sl_free(void *block); /* NULL is allowed; only for blocks of sl_allocate() */
/* Frees each of the blocks, whose pointers are all read before. */
#define SL_FREE_ALL(...) \
    sl_free_all((void *[]){__VA_ARGS__}, sizeof((void *[]){__VA_ARGS__}) / sizeof(void *))
void sl_free_all(void *const blocks[], size_t count);
