/* Arrays that grow. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

/* `block` is the address of a pointer to elements of any type, which may be NULL if `used` is 0. In place of
 * what it points to comes a block of `capacity` elements, at least `used`: the first `used` as they were, the
 * others zero. False: there was no memory for it, and nothing has changed. */
bool sl_regrow(void *block, size_t used, size_t capacity, size_t size);
/* Returns a copy of an array in a block of its own; NULL where there was no memory. */
void *sl_copy_of(const void *array, size_t count, size_t size);
/* Makes room for one more behind `count` of them, growing twofold. False: there was no memory. */
bool sl_make_room(void *block, size_t count, size_t *room, size_t size);
/* A quarter more, or what is needed if that is more still: room for one more without holding much more than
 * is used. */
size_t sl_grown_capacity(size_t capacity, size_t needed);
