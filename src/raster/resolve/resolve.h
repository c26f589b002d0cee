/* Resolution: from the triangle that a pixel shows to what it shows there.
 *
 * A list of pixels is worked through in blocks. Neighbours mostly show the same triangle, so a block is cut
 * into runs of pixels with the same one:
 *
 *     runs         where the index changes                                       (resolve_kernels.c)
 *     fetch        each run's corners                                            (resolve.c)
 *     weights      edge lines, a run in each lane; then e_0, e_1, e_2 of a run's pixels, a pixel in each
 * lane; then weights, a pixel in each lane again, whatever the runs   (resolve_kernels.c) interpolate  any
 * attribute of the corners, by those weights                (resolve_kernels.c) surfaces     positions, sides
 * and normals, as surface_rules.h decides      (resolve_kernels.c) albedo       materials and their textures
 * (albedo_kernels.c)
 *
 * A run's lanes are written whole, over the first pixels of the next run, which is written after it; so short
 * runs need no masks and no scalar ends. Blocks and runs only say what is computed together: a pixel's values
 * depend on the view, the pixel and the triangle alone. */
#pragma once

#include "raster/pipeline.h"
#include "raster/textures/mip.h"

enum {
    SL_RESOLVE_PIXELS = 512,
    SL_RESOLVE_RUNS = 64,
    SL_RESOLVE_ROOM = SL_RESOLVE_PIXELS + SL_LANES /* a run's lanes may reach beyond the block's end */
};

/* A number, or a vector, at each of the corners of each run's triangle. */
typedef float sl_run_corners[3][SL_RESOLVE_RUNS];
typedef struct sl_run_vectors {
    sl_run_corners x, y, z;
} sl_run_vectors;
/* A vector at each pixel. */
typedef struct sl_vector_planes {
    float x[SL_RESOLVE_ROOM], y[SL_RESOLVE_ROOM], z[SL_RESOLVE_ROOM];
} sl_vector_planes;

typedef struct sl_resolve_block {
    uint32_t count, runs;
    uint32_t first;        /* the pixels are first, first + 1, ..., or those of the list */
    const uint32_t *pixel, *id;
    uint32_t start[SL_RESOLVE_RUNS + 2]; /* run r is [start[r], start[r + 1]) */
    uint32_t vertex[3][SL_RESOLVE_RUNS]; /* of the corners; SL_NO_INDEX on the background */
    /* in: what the caller will read by vertex, later_bytes each, or NULL: brought near while weights are
     * found */
    const char *later;
    size_t later_bytes;
    sl_run_vectors corner; /* positions */
    float w1[SL_RESOLVE_ROOM], w2[SL_RESOLVE_ROOM]; /* out: weights of corners 1 and 2; 0 on the background */
    /* Within the kernel, by run: edge lines (barycentrics.h). */
    double a0[SL_RESOLVE_RUNS], b0[SL_RESOLVE_RUNS], c0[SL_RESOLVE_RUNS], a1[SL_RESOLVE_RUNS],
        b1[SL_RESOLVE_RUNS];
    double c1[SL_RESOLVE_RUNS], a2[SL_RESOLVE_RUNS], b2[SL_RESOLVE_RUNS], c2[SL_RESOLVE_RUNS];
    double origin_x[SL_RESOLVE_RUNS], origin_y[SL_RESOLVE_RUNS];
    /* By pixel. */
    double column[SL_RESOLVE_ROOM], row[SL_RESOLVE_ROOM];
    double e0[SL_RESOLVE_ROOM], e1[SL_RESOLVE_ROOM], e2[SL_RESOLVE_ROOM];
    uint8_t outside[SL_RESOLVE_ROOM]; /* 1: the pixel lies outside its triangle */
} sl_resolve_block;

/* Surface points of a block. */
typedef struct sl_surface_block {
    bool facets; /* every triangle of the block has one normal at all its corners */
    sl_run_vectors corner_normal;
    float face_x[SL_RESOLVE_RUNS], face_y[SL_RESOLVE_RUNS], face_z[SL_RESOLVE_RUNS]; /* geometric normals */
    sl_vector_planes position, normal, geometric; /* out */
} sl_surface_block;

/* Materials of a block: kd, black on the background, and the texture that it is multiplied by, or NULL. */
typedef struct sl_albedo_block {
    float red[SL_RESOLVE_RUNS], green[SL_RESOLVE_RUNS], blue[SL_RESOLVE_RUNS];
    const sl_texture *texture[SL_RESOLVE_RUNS];
    const sl_mip *mip[SL_RESOLVE_RUNS]; /* NULL: the texture is looked up as it is */
    sl_run_corners u, v; /* where there is a texture */
} sl_albedo_block;

/* The kernels, in the order in which they are called; all variants give the same bits. */
/* Finds the runs of a block of at most `count` pixels. */
SL_KERNELS(void, sl_resolve_runs, (sl_resolve_block *block, size_t count));
SL_KERNELS(void, sl_resolve_weights, (sl_resolve_block *block, const sl_pass_view *view));
/* Values given at the corners, at every pixel; and indices given for each run. */
SL_KERNELS(void, sl_resolve_interpolate,
           (const sl_resolve_block *block, const sl_run_corners value, float *out));
SL_KERNELS(void, sl_resolve_spread_index,
           (const sl_resolve_block *block, const uint32_t *value, uint32_t *out));
SL_KERNELS(void, sl_resolve_surfaces,
           (const sl_resolve_block *block, const sl_pass_view *view, sl_surface_block *surfaces));
SL_KERNELS(void, sl_resolve_albedo,
           (const sl_resolve_block *block, const sl_albedo_block *materials, sl_vector_planes *out));

/* Takes the next block from `count` pixels (pixel NULL: first, first + 1, ...) with their ids, and finds
 * their weights. Returns how many pixels it took: 0 when count is 0. The block must have been cleared once.
 */
size_t sl_resolve_next(const sl_raster *raster, const sl_pass_view *view, size_t count, size_t first,
                       const uint32_t *pixel, const uint32_t *id, sl_resolve_block *block);
/* A run's triangle. */
static inline uint32_t sl_run_triangle(const sl_resolve_block *block, uint32_t run) {
    return block->id[block->start[run]];
}
/* kd times texture of a block's pixels, of a raster with a scene. */
void sl_resolve_diffuse(const sl_raster *raster, const sl_pass_view *view, const sl_resolve_block *block,
                        sl_vector_planes *diffuse);
/* Pixels of a block that show a triangle. */
uint64_t sl_resolve_shaded(const sl_resolve_block *block);
