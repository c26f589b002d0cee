/* Visibility carried from blocks of pixels to pixels: the loops over lanes, in visibility_kernels.c. */
#ifndef SL_CACHE_DIRECT_RADIANCE_SIGHT_KERNELS_H
#define SL_CACHE_DIRECT_RADIANCE_SIGHT_KERNELS_H

#include "cache/direct_radiance/receiver_tiles.h"

/* What a tile's receivers see of 32 photons, a bit each, and the four blocks around each of its pixels. */
enum { SL_SIGHT_PHOTONS = 32, SL_SIGHT_BLOCKS = 4 };
typedef struct sl_tile_sight {
    _Alignas(64) uint32_t wanted[SL_TILE_PIXELS];   /* light would arrive */
    uint32_t seen[SL_TILE_PIXELS], unsure[SL_TILE_PIXELS];
    int32_t block[SL_SIGHT_BLOCKS][SL_TILE_PIXELS];
    uint32_t fits[SL_SIGHT_BLOCKS][SL_TILE_PIXELS]; /* all bits, or none */
} sl_tile_sight;

/* Of the pixels that stand for blocks: position, geometric normal, shading normal. */
enum { SL_BLOCK_PLANES = 9 };
typedef struct sl_block_planes {
    float *value[SL_BLOCK_PLANES];
} sl_block_planes;

typedef void sl_sight_fit_kernel(const sl_receiver_tile *tile, const sl_block_planes *planes, const float *reach_squared,
                                 float offset_squared, sl_tile_sight *around);
/* Of a word of every block's answers: seen is what the blocks that fit and know agree on, unsure the rest. A block knows of the
 * photons that would send light to its pixel. */
typedef void sl_sight_agree_kernel(size_t count, const uint32_t *known, const uint32_t *seen, size_t words, size_t word,
                                   sl_tile_sight *around);
/* wanted: adds the bit of a photon where its weight is more than 0. */
typedef void sl_sight_want_kernel(size_t count, unsigned bit, const float *weight, sl_tile_sight *around);
/* 1 or 0, by one bit. */
typedef void sl_sight_tell_kernel(size_t count, const sl_tile_sight *around, unsigned bit, float *visible);

typedef struct sl_sight_kernels {
    sl_sight_fit_kernel *fit;
    sl_sight_agree_kernel *agree;
    sl_sight_want_kernel *want;
    sl_sight_tell_kernel *tell;
} sl_sight_kernels;

SL_KERNEL_VARIANTS(sl_sight_fit_kernel, sl_sight_fit);
SL_KERNEL_VARIANTS(sl_sight_agree_kernel, sl_sight_agree);
SL_KERNEL_VARIANTS(sl_sight_want_kernel, sl_sight_want);
SL_KERNEL_VARIANTS(sl_sight_tell_kernel, sl_sight_tell);

static inline sl_sight_kernels sl_sight_kernels_for(sl_isa isa) {
    return (sl_sight_kernels){
        SL_KERNEL_OF(isa, sl_sight_fit), SL_KERNEL_OF(isa, sl_sight_agree),
        SL_KERNEL_OF(isa, sl_sight_want), SL_KERNEL_OF(isa, sl_sight_tell)};
}

#endif
