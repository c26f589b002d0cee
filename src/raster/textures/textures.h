/* The hardware's texture units: 2D textures and cube maps with MIP maps, read linearly between texels and
 * between levels; and 3D textures of bytes, read a texel at a time.
 *
 *     texels ── sl_texture_image_build() ── MIP chain ──┬── sl_texture_sample()       one lookup: the plain
 * form └── sl_texture_sample_many()  many, vectorised: the same bits
 *
 * Texels are four floats (RGBA) side by side: a filter reads four texels at unrelated places, and so it reads
 * four cache lines instead of sixteen. Row 0 is at the bottom, t = 0 its lower edge; texel i of n has its
 * centre at (i + 1/2) / n. Beyond the edge the edge's texels go on.
 *
 * Accuracy: positions and weights are worked out in double, filtering too, and a result is rounded to float
 * once. So it is within half a unit in the last place of exact filtering of the given floats, whatever the
 * texture's size.
 *
 * Coordinates may be anything: infinite ones count as the nearest edge, NaN as the lower. */
#ifndef SL_RASTER_TEXTURES_H
#define SL_RASTER_TEXTURES_H

#include "raster/raster.h"

enum {
    SL_TEXTURE_LEVELS = 15, /* 16384 ... 1 */
    SL_TEXTURE_SIZE_MAX = 16384,
    SL_TEXTURE_BLOCK = 64   /* lookups done together */
};

typedef struct sl_texture_kernels sl_texture_kernels;

/* ---- 2D textures ---- */

typedef struct sl_texture_image {
    int levels;                                           /* 1: without MIP map */
    int width[SL_TEXTURE_LEVELS], height[SL_TEXTURE_LEVELS];
    int32_t first[SL_TEXTURE_LEVELS];                     /* of each level's texels */
    float *texels;                                        /* 4 floats each */
    const sl_texture_kernels *kernels;
} sl_texture_image;

/* Texels all 0; the caller writes those of level 0, then calls sl_texture_image_build() if it asked for a MIP
 * map. */
sl_status sl_texture_image_create(int width, int height, bool mip, sl_texture_image **image, sl_error *error);
void sl_texture_image_destroy(sl_texture_image *image);
/* Level l+1 has half the size of level l, rounded down (OpenGL 4.5, section 8.14.3), and is the exact mean
 * over each of its texels' areas: 2x2 texels, or 3 in a direction whose size is odd, those shared by two
 * weighted by their share. So the mean of every level is the mean of the picture. */
void sl_texture_image_build(sl_texture_image *image, unsigned threads);

/* `count` lookups at level of detail `lod` (0 and below: the finest; NaN counts as 0; NULL: 0). plane[c][n]
 * is channel c of lookup n; NULL planes are not wanted. */
void sl_texture_sample_many(const sl_texture_image *image, size_t count, const float *s, const float *t,
                            const float *lod, float *const plane[4]);

/* ---- cube maps ---- */

/* Faces as sl_cube_face_frame() has them (OpenGL 4.5, table 8.19), row 0 at t = 0. Every face of every level
 * has a border of one texel with the neighbouring faces' texels, and at its corners the mean of the three
 * that meet there: so a bilinear lookup reads one face alone, and is continuous over edges and corners
 * (GL_TEXTURE_CUBE_MAP_SEAMLESS). */
typedef struct sl_cube_map {
    int size, levels;
    int level_size[SL_TEXTURE_LEVELS];   /* without border */
    int32_t first[SL_TEXTURE_LEVELS];    /* 6 (size + 2)^2 texels a level */
    float *texels;
    const sl_texture_kernels *kernels;
} sl_cube_map;

sl_status sl_cube_map_create(int size, bool mip, sl_cube_map **cube, sl_error *error);
void sl_cube_map_destroy(sl_cube_map *cube);
/* A texel to be written or read; x and y from 0 to size - 1 of the level, or -1 and size for the border. */
float *sl_cube_map_texel(const sl_cube_map *cube, int level, int face, int x, int y);
/* MIP chain and borders, when the finest level's six faces are written. */
void sl_cube_map_build(sl_cube_map *cube, unsigned threads);
/* The same by direction, which need not be unit. A NaN component counts as 0, an infinite one as the largest
 * float; the direction 0 is that of the middle of face +x. */
void sl_cube_map_sample_many(const sl_cube_map *cube, size_t count, const float *x, const float *y,
                             const float *z, const float *lod, float *const plane[4]);

/* ---- 3D textures ---- */

/* Texels of four bytes, x fastest, then y, then z: 24-bit addresses and marks. */
typedef struct sl_volume {
    int width, height, depth;
    uint8_t *bytes;
} sl_volume;

/* Texels all 0, to be written by the caller at any time. 1 to 16384 each way, less than 2^31 texels. */
sl_status sl_volume_create(int width, int height, int depth, sl_volume **volume, sl_error *error);
void sl_volume_destroy(sl_volume *volume);
/* The four bytes of a texel, red lowest, exactly as stored: x | y | z are clamped to what there is. */
uint32_t sl_volume_fetch(const sl_volume *volume, int x, int y, int z);

/* ---- between the files of this folder ---- */

/* Halving a picture of RGBA texels by exact means (mip_chain.c). */
static inline int sl_half_size(int n) { return n > 1 ? n / 2 : 1; }
/* Levels of a size: 1 + floor(log2(n)). */
int sl_mip_levels(int width, int height);
/* Rows start `stride` texels apart. */
void sl_mip_halve(const float *from, int width, int height, size_t from_stride, float *to, size_t to_stride,
                  unsigned threads);

/* The vectorised lookups (texture_kernels.c), in blocks of up to SL_TEXTURE_BLOCK. */
struct sl_texture_kernels {
    void (*texture)(const sl_texture_image *image, size_t count, const float *s, const float *t,
                    const float *lod, float *const plane[4]);
    void (*cube)(const sl_cube_map *cube, size_t count, const float *x, const float *y, const float *z,
                 const float *lod, float *const plane[4]);
};

const sl_texture_kernels *sl_texture_kernels_best(void);

#endif
