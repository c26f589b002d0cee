/* The light that surface points send to the eye, from the octree and its lights: L_o = sum f_r c_j
 * (n . d_j)+ in each of the eight voxels around, then their trilinear mean. Points that share their eight
 * voxels are shaded together: the octree is descended once for all of them, and the loop over their lights is
 * arithmetic alone. */
#ifndef SL_CACHE_LIGHT_OCTREE_SHADE_H
#define SL_CACHE_LIGHT_OCTREE_SHADE_H

#include "cache/light_octree/shade_kernels.h"
#include "cache/light_octree/voxel_texture.h"
#include "raster/raster.h"

typedef struct sl_octree_shading {
    const sl_voxel_texture *texture;
    sl_voxel_filter filter;
    bool keep_void_dark;  /* empty voxels count as black: the paper's holes */
    bool facing;          /* voxels weigh by the cosine between their normal and the point's, against leaks */
} sl_octree_shading;

/* A surface point; normal unit, shading, turned to the viewer (not finite, or 0: such a point gets 0).
 * Diffuse pi: the irradiance comes out. Specular 0: the view is not looked at. */
typedef struct sl_octree_point {
    sl_vec3 position, normal;
    sl_vec3 view;                /* unit, towards the viewer */
    sl_rgb diffuse, specular;
    float exponent;              /* modified Phong */
} sl_octree_point;

enum { SL_OCTREE_BATCH = 4096 };
typedef struct sl_octree_scratch sl_octree_scratch; /* one for each worker */
sl_status sl_octree_scratch_create(sl_octree_scratch **scratch, sl_error *error);
void sl_octree_scratch_destroy(sl_octree_scratch *scratch);

/* Radiance (or irradiance) of any number of points, written to r, g, b. Each point's is a function of that
 * point alone. */
void sl_octree_shade(const sl_octree_shading *shading, const sl_octree_point *point, size_t count,
                     sl_octree_scratch *scratch, float *r, float *g, float *b, sl_counters *counters);

/* A whole G-buffer seen from an eye (but for pixels that mirrors show), in tiles; planes as the G-buffer's,
 * background and mirrors 0. Fails for want of memory alone. */
sl_status sl_octree_shade_gbuffer(const sl_octree_shading *shading, const sl_scene *scene,
                                  const sl_gbuffer *gbuffer, sl_vec3 eye, unsigned threads, float *r,
                                  float *g, float *b, sl_counters *counters, sl_error *error);

/* ---- one pixel as the shader has it, before the loop over lights: for those who tell what made it ---- */

typedef struct sl_octree_pixel {
    sl_shade_block block;      /* the pixel, SL_SHADE_LANES times */
    sl_shade_cells cells;      /* its eight voxels, or the nearest alone */
    int32_t cell[3];           /* the first of them */
    bool glossy;
    sl_octree_point point;
} sl_octree_pixel;

/* Of a pixel that shows a surface which is no mirror. False where that gets no light. */
bool sl_octree_pixel_cells(const sl_octree_shading *shading, const sl_scene *scene, const sl_gbuffer *gbuffer,
                           sl_vec3 eye, size_t pixel, sl_octree_pixel *out);

#endif
