/* OSMesa (llvmpipe) as the rasterizer's peer: the same passes by OpenGL 4.5, core profile, with what is fixed
 * (vertex and index buffers, programs, framebuffers) made once, one draw call a pass, and nothing but the
 * view's matrix changed in between. */
#pragma once

#include "cache/splatting/record.h"
#include "raster/raster.h"

/* Indexed triangles with shared vertices; three floats each. normal and colour may be NULL. */
typedef struct peer_mesh {
    size_t vertex_count, triangle_count;
    const float *position, *normal, *colour;
    const uint32_t *index;
} peer_mesh;

typedef struct peer_pass peer_pass;

/* threads 1: rasterizes on the calling thread (LP_NUM_THREADS=0). NULL: it runs; otherwise why it does not.
 * Before any other call, once. */
const char *peer_start(unsigned threads);
const char *peer_name(void);

/* Each is NULL where OSMesa does not run. */
/* without ids: depth alone */
peer_pass *peer_ids(const peer_mesh *mesh, const sl_view *views, size_t count, bool ids);
/* position, normal, diffuse: three RGBA32F */
peer_pass *peer_gbuffer(const peer_mesh *mesh, const sl_view *view);
peer_pass *peer_gouraud(const peer_mesh *mesh, const sl_view *view); /* colour in RGBA32F */

typedef struct peer_splat {
    sl_splat_rect rect;
    const sl_record *record;
} peer_splat;
/* (w E, w) in one RGBA32F and the count in another. */
peer_pass *peer_splats(int width, int height, const peer_splat *splats, size_t count,
                       const sl_weight_rules *rules, const sl_splat_receivers *receivers);
/* rgba: size x size; halved until final x final. final = 0: read back as it is and added up by the processor,
 * the sums being plane 1. */
peer_pass *peer_reduction(const float *rgba, int size, int final);

/* All views (one after another, each read back before the next is drawn), or one. Without reading, waits
 * until all is drawn. Additive passes add to what is there. */
void peer_run(peer_pass *pass, bool read);
void peer_run_view(peer_pass *pass, size_t view);
void peer_clear(peer_pass *pass);
/* Returns the last view's picture as read into memory: ids, colours, then depth where there is one. */
const void *peer_plane(const peer_pass *pass, int plane);
void peer_destroy(peer_pass *pass);
