/* Morton codes: the bits of three coordinates interleaved, so that what is near in space is near in order. */
#pragma once

#include <stdint.h>

/* Spreads the low 21 bits, two zeros between each. */
static inline uint64_t sl_morton_spread(uint64_t v) {
    v &= 0x1fffffu;
    v = (v | v << 32) & 0x1f00000000ffffu;
    v = (v | v << 16) & 0x1f0000ff0000ffu;
    v = (v | v << 8) & 0x100f00f00f00f00fu;
    v = (v | v << 4) & 0x10c30c30c30c30c3u;
    return (v | v << 2) & 0x1249249249249249u;
}

static inline uint64_t sl_morton_code(uint64_t x, uint64_t y, uint64_t z) {
    return sl_morton_spread(x) | sl_morton_spread(y) << 1 | sl_morton_spread(z) << 2;
}

/* Undoes the spread. */
static inline uint32_t sl_morton_gather(uint64_t v) {
    v &= 0x1249249249249249u;
    v = (v | v >> 2) & 0x10c30c30c30c30c3u;
    v = (v | v >> 4) & 0x100f00f00f00f00fu;
    v = (v | v >> 8) & 0x1f0000ff0000ffu;
    v = (v | v >> 16) & 0x1f00000000ffffu;
    return (uint32_t)((v | v >> 32) & 0x1fffffu);
}

static inline void sl_morton_decode(uint64_t code, uint32_t cell[3]) {
    for (int axis = 0; axis < 3; axis++) cell[axis] = sl_morton_gather(code >> axis);
}
