/* The hardware's geometry: triangles that lie together, with bounds around them (clusters.c made them). */
#pragma once

#include "raster/raster.h"

enum {
    SL_CLUSTER_TRIANGLES = 128,
    SL_CLUSTER_VERTICES = 3 * SL_CLUSTER_TRIANGLES,
    SL_LANES = 16 /* pixels (or vertices, triangles, clusters) done together: a block */
};

struct sl_raster {
    const sl_scene *scene; /* NULL for a mesh alone */
    sl_raster_mesh mesh;
    sl_isa isa;
    bool masked; /* some triangle has an alpha mask */
    const sl_raster_observer *observer; /* or NULL */

    size_t cluster_count;
    /* Bounds: box and sphere share a centre. Arrays are padded to whole groups of SL_LANES. */
    float *centre_x, *centre_y, *centre_z, *half_x, *half_y, *half_z, *radius;
    uint32_t *first_triangle, *triangles, *first_vertex, *vertices; /* cluster_count each */

    /* Positions, welded within a cluster by their bits; every cluster starts at a multiple of SL_LANES. */
    float *vertex_x, *vertex_y, *vertex_z;
    /* cluster-local vertex of each corner, in cluster order; a group of padding at the end */
    uint16_t *corner[3];
    uint32_t *triangle;      /* the scene's index of each */
    uint8_t *triangle_masked;
    uint32_t *cluster_of_triangle; /* by the scene's index */
    size_t memory_bytes;
    double extent; /* sum of the clusters' radii when they were made (move.c) */
    struct sl_spares *spares; /* buffers between passes (spare.c); NULL where no pass over tiles runs */
};

static inline sl_vec3 sl_mesh_position(const sl_raster_mesh *m, uint32_t vertex) {
    return sl_v3(m->x[vertex], m->y[vertex], m->z[vertex]);
}

/* Bounds around vertices (clusters.c). */
void sl_bound_cluster(sl_raster *raster, size_t cluster, const float *x, const float *y, const float *z,
                      size_t count);
