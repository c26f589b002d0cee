/* Things in the order of a code, such as their place along the Morton curve (morton.h). */
#pragma once

#include <stddef.h>
#include <stdint.h>

typedef struct sl_coded {
    uint64_t code;
    uint32_t item;
} sl_coded;

/* Sorts by code, then by item, in place. */
void sl_sort_coded(sl_coded *list, size_t count);
