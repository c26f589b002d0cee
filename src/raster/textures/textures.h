/* The hardware's texture units: 2D textures with MIP maps, cube maps, 3D textures, and the pass that applies a
 * scene's textures.
 *
 *     texels ── sl_texture_image_build() ── MIP chain ──┬── sl_texture_sample()        one lookup: the plain form
 *                                                       └── sl_texture_sample_many()   many at once: the same bits, vectorised
 *     scene ── sl_texture_set_create() ── sl_raster_textured(id plane) ── colour planes
 *
 * Texels are four floats (RGBA) side by side: a filter reads four texels at unrelated places, and so it reads four
 * cache lines instead of sixteen. Missing channels are 0, missing alpha 1, as in OpenGL. Row 0 is at the bottom, t =
 * 0 its lower edge; texel i of n has its centre at (i + 1/2) / n.
 *
 * Accuracy: positions and weights are worked out in double, filtering too, and a result is rounded to float once. So
 * it is within half a unit in the last place of exact filtering of the given floats, whatever the texture's size.
 *
 * Coordinates may be anything. Where they are not finite, or (with repetition) beyond 2^30, where floats have no
 * fraction anyway, a repeated coordinate counts as 0, and a clamped one as the nearest edge (NaN: the lower). */
#ifndef SL_RASTER_TEXTURES_H
#define SL_RASTER_TEXTURES_H

#include "raster/fragments/pbuffer.h"
#include "raster/raster.h"

typedef enum sl_wrap { SL_WRAP_REPEAT, SL_WRAP_CLAMP /* to the edge texel */ } sl_wrap;
/* Which level a lookup reads: the finest; the nearest to its level of detail; the two around it, blended. */
typedef enum sl_mip { SL_MIP_NONE, SL_MIP_NEAREST, SL_MIP_LINEAR } sl_mip;

/* OpenGL's filters: GL_NEAREST is {false, SL_MIP_NONE}, bilinear GL_LINEAR {true, SL_MIP_NONE}, trilinear
 * GL_LINEAR_MIPMAP_LINEAR {true, SL_MIP_LINEAR}, and so on. */
typedef struct sl_sampler {
    sl_wrap wrap_s, wrap_t, wrap_r;
    bool linear; /* between texels; or the one that the point lies in */
    sl_mip mip;
} sl_sampler;

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

/* Texels all 0; the caller writes those of level 0, then calls sl_texture_image_build() if it asked for a MIP map. */
sl_status sl_texture_image_create(int width, int height, bool mip, sl_texture_image **image, sl_error *error);
void sl_texture_image_destroy(sl_texture_image *image);
/* Level l+1 has half the size of level l, rounded down (OpenGL 4.5, section 8.14.3), and is the exact mean over each
 * of its texels' areas: 2x2 texels, or 3 in a direction whose size is odd, those shared by two weighted by their
 * share. So the mean of every level is the mean of the picture. */
void sl_texture_image_build(sl_texture_image *image, unsigned threads);
/* With MIP map: of an 8-bit sRGB texture, decoded before anything is averaged (alpha is linear); of a pbuffer of
 * floats, whose levels are means of its pixels (means of positions, normals and radiance, in Direct Radiance
 * Mapping). */
sl_status sl_texture_image_of_texture(const sl_texture *texture, unsigned threads, sl_texture_image **image, sl_error *error);
sl_status sl_texture_image_of_pbuffer(const sl_pbuffer *pbuffer, unsigned threads, sl_texture_image **image, sl_error *error);

/* One texel as it is (GLSL's texelFetch); x, y and level are clamped to what there is. */
const float *sl_texture_fetch(const sl_texture_image *image, int level, int x, int y);
/* One lookup at level of detail `lod` (0: the finest; ignored with SL_MIP_NONE; NaN counts as 0). */
void sl_texture_sample(const sl_texture_image *image, sl_sampler sampler, float s, float t, float lod, float rgba[4]);
/* `count` lookups; lod NULL: 0. plane[c][n] is channel c of lookup n; NULL planes are not wanted. */
void sl_texture_sample_many(const sl_texture_image *image, sl_sampler sampler, size_t count, const float *s, const float *t,
                            const float *lod, float *const plane[4]);
/* Level of detail of a footprint with derivatives of s and t by window x and y: log2 of the longer of its axes, in
 * texels of the finest level (OpenGL 4.5, section 8.14.1). Below 0: the texture is magnified. -63 where the footprint
 * is a point, or NaN. */
float sl_texture_lod(int width, int height, double ds_dx, double dt_dx, double ds_dy, double dt_dy);

/* ---- cube maps ---- */

/* Faces as sl_cube_face_frame() has them (OpenGL 4.5, table 8.19), row 0 at t = 0. Every face of every level has a
 * border of one texel with the neighbouring faces' texels, and at its corners the mean of the three that meet there:
 * so a bilinear lookup reads one face alone, and is continuous over edges and corners (GL_TEXTURE_CUBE_MAP_SEAMLESS). */
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
/* The finest level's face, of a pbuffer of floats of size x size. */
void sl_cube_map_set_face(sl_cube_map *cube, int face, const sl_pbuffer *pbuffer);
/* MIP chain and borders, when the finest level's six faces are written. */
void sl_cube_map_build(sl_cube_map *cube, unsigned threads);
/* One lookup by direction, which need not be unit. Wrapping does not matter. A NaN component counts as 0, an infinite
 * one as the largest float; the direction 0 is that of the middle of face +x. */
void sl_cube_map_sample(const sl_cube_map *cube, sl_sampler sampler, sl_vec3 direction, float lod, float rgba[4]);
void sl_cube_map_sample_many(const sl_cube_map *cube, sl_sampler sampler, size_t count, const float *x, const float *y,
                             const float *z, const float *lod, float *const plane[4]);
/* Level of detail of a direction with its derivatives by window x and y (OpenGL 4.5, section 8.14.1, on the
 * direction's face). */
float sl_cube_map_lod(const sl_cube_map *cube, sl_vec3 direction, sl_vec3 d_dx, sl_vec3 d_dy);

/* ---- 3D textures ---- */

typedef enum sl_volume_format {
    SL_VOLUME_RGBA32F,
    SL_VOLUME_RGBA8  /* unsigned, normalised: byte b is b / 255; also plain storage of 24-bit addresses and marks */
} sl_volume_format;

typedef struct sl_volume {
    int width, height, depth;
    sl_volume_format format;
    float *texels;   /* RGBA32F: 4 floats each, x fastest, then y, then z */
    uint8_t *bytes;  /* RGBA8: 4 bytes each */
    const sl_texture_kernels *kernels;
} sl_volume;

/* Texels all 0, to be written by the caller at any time. 1 to 16384 each way, less than 2^31 texels. */
sl_status sl_volume_create(int width, int height, int depth, sl_volume_format format, sl_volume **volume, sl_error *error);
void sl_volume_destroy(sl_volume *volume);
/* The four bytes of an RGBA8 texel, red lowest, exactly as stored: x | y | z are clamped to what there is. */
uint32_t sl_volume_fetch(const sl_volume *volume, int x, int y, int z);
void sl_volume_fetch_many(const sl_volume *volume, size_t count, const int32_t *x, const int32_t *y, const int32_t *z,
                          uint32_t *bytes);
/* The bytes of the texel in which the point lies: a descent's step. */
uint32_t sl_volume_nearest(const sl_volume *volume, sl_sampler sampler, float s, float t, float r);
void sl_volume_nearest_many(const sl_volume *volume, sl_sampler sampler, size_t count, const float *s, const float *t,
                            const float *r, uint32_t *bytes);
/* Nearest or trilinear, of either format, as numbers. */
void sl_volume_sample(const sl_volume *volume, sl_sampler sampler, float s, float t, float r, float rgba[4]);
void sl_volume_sample_many(const sl_volume *volume, sl_sampler sampler, size_t count, const float *s, const float *t,
                           const float *r, float *const plane[4]);

/* ---- the textured pass ---- */

/* A scene's textures with MIP maps, decoded to linear colour: built once for a scene. 16 bytes a texel, a third more
 * for the MIP map; only textures that a material's colour uses. */
typedef struct sl_texture_set sl_texture_set;
sl_status sl_texture_set_create(const sl_scene *scene, unsigned threads, sl_texture_set **set, sl_error *error);
void sl_texture_set_destroy(sl_texture_set *set);
/* NULL where no material's colour uses that texture. */
const sl_texture_image *sl_texture_set_image(const sl_texture_set *set, uint32_t texture);
size_t sl_texture_set_memory_bytes(const sl_texture_set *set);

typedef enum sl_lod_rule {
    /* The derivatives of the perspective-correct interpolation at the pixel itself. */
    SL_LOD_EXACT,
    /* Differences inside each quad of 2x2 pixels, one level of detail a quad, as graphics hardware and OSMesa do:
     * coarser, and wrong where the footprint changes fast; for comparison with them. */
    SL_LOD_DIFFERENCES
} sl_lod_rule;

typedef struct sl_textured_pass {
    const sl_texture_set *set;      /* the materials' own textures; or */
    const sl_texture_image *single; /* one for all triangles, materials aside (an atlas); used if not NULL */
    const float *coordinates;       /* s and t of corners 0, 1, 2: 6 floats a triangle; NULL: the scene's */
    sl_sampler sampler;
    sl_lod_rule lod_rule;
    float lod_bias;
} sl_textured_pass;

/* Caller-owned planes of the view's size, NULL: not wanted. */
typedef struct sl_textured_planes {
    float *color[4];    /* kd times texture and the texture's alpha (1 without); with `single` its filtered texels alone */
    float *specular[3]; /* ks, which no texture changes */
    float *s, *t, *lod; /* perspective-correct coordinates, and level of detail before clamping to the levels there are */
} sl_textured_planes;

/* Shades the pixels of an id plane of that view; background is 0. A mesh without scene has neither materials nor
 * coordinates of its own: then `single` and `coordinates` are wanted. */
void sl_raster_textured(const sl_raster *raster, const sl_view *view, unsigned threads, const uint32_t *id,
                        const sl_textured_pass *pass, const sl_textured_planes *out, sl_counters *counters);

#endif
