/* Visibility carried from blocks of pixels to pixels: the loops over lanes, in visibility_kernels.c. */
#ifndef SL_CACHE_DIRECT_RADIANCE_SIGHT_KERNELS_H
#define SL_CACHE_DIRECT_RADIANCE_SIGHT_KERNELS_H

#include "cache/direct_radiance/receiver_tiles.h"

/* The four blocks around each of a tile's pixels, and what those of them that fit say about 32 photons, a bit each. */
enum { SL_SIGHT_BLOCKS = 4 };
typedef struct sl_tile_sight {
    _Alignas(64) int32_t block[SL_SIGHT_BLOCKS][SL_TILE_PIXELS];
    uint32_t fits[SL_SIGHT_BLOCKS][SL_TILE_PIXELS]; /* all bits, or none */
    uint32_t seen[SL_TILE_PIXELS], unsure[SL_TILE_PIXELS];
} sl_tile_sight;

/* Of the pixels that stand for blocks: position, geometric normal, shading normal. */
enum { SL_BLOCK_PLANES = 9 };
typedef struct sl_block_planes {
    float *value[SL_BLOCK_PLANES];
} sl_block_planes;

typedef void sl_sight_fit_kernel(const sl_receiver_tile *tile, const sl_block_planes *planes, const float *reach_squared,
                                 float offset_squared, sl_tile_sight *around);
/* Of a word of every block's answers. A block knows of the photons that would send light to its pixel. */
typedef void sl_sight_agree_kernel(size_t count, const uint32_t *known, const uint32_t *seen, size_t words, size_t word,
                                   sl_tile_sight *around);
/* 1, 0, or -1 for unsure, by one bit; 0 where weight is. */
typedef void sl_sight_tell_kernel(size_t count, const sl_tile_sight *around, unsigned bit, const float *weight, float *visible);

typedef struct sl_sight_kernels {
    sl_sight_fit_kernel *fit;
    sl_sight_agree_kernel *agree;
    sl_sight_tell_kernel *tell;
} sl_sight_kernels;

#define SL_DECLARE_SIGHT_KERNELS(isa)           \
    sl_sight_fit_kernel sl_sight_fit_##isa;     \
    sl_sight_agree_kernel sl_sight_agree_##isa; \
    sl_sight_tell_kernel sl_sight_tell_##isa

SL_DECLARE_SIGHT_KERNELS(baseline);
SL_DECLARE_SIGHT_KERNELS(avx2);
SL_DECLARE_SIGHT_KERNELS(avx512);

static inline sl_sight_kernels sl_sight_kernels_for(sl_isa isa) {
#ifndef SL_BASELINE_ONLY
    if (isa == SL_ISA_AVX512) return (sl_sight_kernels){sl_sight_fit_avx512, sl_sight_agree_avx512, sl_sight_tell_avx512};
    if (isa == SL_ISA_AVX2) return (sl_sight_kernels){sl_sight_fit_avx2, sl_sight_agree_avx2, sl_sight_tell_avx2};
#endif
    (void)isa;
    return (sl_sight_kernels){sl_sight_fit_baseline, sl_sight_agree_baseline, sl_sight_tell_baseline};
}

#endif
