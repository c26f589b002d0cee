/* Indirect irradiance at a point: the coarse mesh of direct diffuse light, drawn as the point sees it under
 * 160 degrees, times a weight texture, summed on the hardware.
 *
 *   coarse.c             the coarse mesh: what of it is to be sampled
 *   coarse_clusters.c    ... which corners share a sample
 *   coarse_borders.c     ... and where
 *   coarse_colours.c     ... its values times the bounce's reflectance
 *   coarse_contrast.c    ... where these tell that it is too coarse
 *   gather.c             where the point looks from, the render, the sums, what lies beyond the field of view
 *   gather_kernels.c     a picture's pixels: colours between the coarse mesh's vertices, times weights
 *   gather_sky.c         ... and where they show an environment that is a picture
 *
 * Mirrors are black in it, as are the sides of faces that reflect nothing or lie inside a solid: the paper's
 * gather follows no reflections. */
#ifndef SL_MULTI_MESH_GATHER_H
#define SL_MULTI_MESH_GATHER_H

#include "cache/patches/mesh.h"
#include "raster/raster.h"

/* The coarse mesh: every face of the scene that may be seen (not a solid's inner side, not degenerate), split
 * until its edges are short enough. A tree of values U_dd = sum E_d / pi, which the method samples through
 * the same irradiance meshes as the picture's. */
typedef struct sl_coarse_settings {
    float edge;                /* scene units: longer edges are split, */
    int depth;                 /* ... at most so often */
    /* by scene triangle: whether its edges are to be a quarter of that; NULL: none are */
    const uint8_t *finer;
} sl_coarse_settings;
typedef struct sl_coarse sl_coarse;
sl_status sl_coarse_create(const sl_scene *scene, const sl_topology *topology,
                           const sl_coarse_settings *settings, sl_coarse **coarse, sl_error *error);
void sl_coarse_destroy(sl_coarse *coarse);
size_t sl_coarse_memory_bytes(const sl_coarse *coarse);
/* Its points, to be sampled: places in faces. Vertices of faces without diffuse reflectance are not wanted.
 */
typedef struct sl_coarse_vertex {
    uint32_t face;
    uint16_t p, q;             /* weights of corners 1 and 2 in 1/SL_MESH_DYADIC */
    /* ... and of where light is asked for: on a border, a little within (coarse_borders.c) */
    uint16_t lit_p, lit_q;
    uint8_t depth;             /* of the coarse triangle */
} sl_coarse_vertex;
size_t sl_coarse_vertex_count(const sl_coarse *coarse), sl_coarse_triangle_count(const sl_coarse *coarse);
const sl_coarse_vertex *sl_coarse_vertices(const sl_coarse *coarse);
/* U_dd at vertex i; with two bounces U_dd + E_i / pi. Where it is not finite (or never set) the other
 * corners' mean stands in, triangle by triangle, and sl_coarse_get() has no number. */
void sl_coarse_set(sl_coarse *coarse, size_t vertex, sl_rgb radiosity_over_pi);
sl_rgb sl_coarse_get(const sl_coarse *coarse, size_t vertex);
/* Colours times reflectance, in the form that gathers draw: after a round of sl_coarse_set(). */
void sl_coarse_finish(sl_coarse *coarse, unsigned threads);
/* U_dd at a point of a face, between its coarse vertices. */
sl_rgb sl_coarse_value(const sl_coarse *coarse, uint32_t face, float w1, float w2);
sl_rgb sl_coarse_brightest(const sl_coarse *coarse);
/* Which scene triangles are to be finer, for sl_coarse_create() and sl_free(): where colours of neighbouring
 * coarse vertices are further apart than `noticed` (coarse_contrast.c). NULL: none are. */
sl_status sl_coarse_find_contrasts(const sl_coarse *coarse, float noticed, uint8_t **finer, sl_error *error);

enum { SL_MESH_GATHER_LEAST = 8 }; /* pixels a side */

typedef struct sl_mesh_gather_settings {
    int size;                  /* N of N x N pixels, a power of two */
    int reduced;               /* 16 */
    float fov;                 /* radians, both ways */
} sl_mesh_gather_settings;
typedef struct sl_mesh_gather sl_mesh_gather;
/* Emitters are black in it (their light is direct light), the environment is not. Scene, raster and coarse
 * mesh must outlive it. */
sl_status sl_mesh_gather_create(const sl_scene *scene, const sl_raster *raster, const sl_coarse *coarse,
                                const sl_mesh_gather_settings *settings, sl_mesh_gather **gather,
                                sl_error *error);
void sl_mesh_gather_destroy(sl_mesh_gather *gather);
size_t sl_mesh_gather_memory_bytes(const sl_mesh_gather *gather);
typedef struct sl_mesh_gather_scratch sl_mesh_gather_scratch;
sl_status sl_mesh_gather_scratch_create(const sl_mesh_gather *gather, sl_mesh_gather_scratch **scratch,
                                        sl_error *error);
void sl_mesh_gather_scratch_destroy(sl_mesh_gather_scratch *scratch);
/* E_i in W/m^2; a pure function of the point and the coarse mesh. Counts SL_COUNT_INDIRECT_SAMPLES. */
sl_rgb sl_mesh_gather_take(const sl_mesh_gather *gather, const sl_mesh_point *point,
                           sl_mesh_gather_scratch *scratch, sl_counters *counters);
/* The picture of the last one, before weights: N x N, bottom row first; for observers and tests. */
void sl_mesh_gather_picture(const sl_mesh_gather_scratch *scratch, int *size, const float *planes[3]);
/* The frame of that picture: z the point's normal. */
sl_frame sl_mesh_gather_frame(sl_vec3 normal);

#endif
