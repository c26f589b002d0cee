/* Triangles in index order, for passes that blend. Clusters as clusters.c makes them would mix the order up, and take longer to make than
 * to draw once; here they are 128 triangles in a row, and nothing is kept of them but their bounds. Whoever draws one gathers its corners
 * anew, none shared. */
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "raster/fragments/add.h"

enum { CLUSTERS_A_TASK = 64 };

static size_t clusters_of(const sl_raster_mesh *mesh) {
    return (mesh->triangle_count + SL_CLUSTER_TRIANGLES - 1) / SL_CLUSTER_TRIANGLES;
}

static void bound_some(void *context, size_t index, unsigned worker) {
    sl_raster *bounds = context;
    sl_one_cluster one;
    (void)worker;
    sl_one_cluster_make(bounds, &one);
    for (size_t c = index * CLUSTERS_A_TASK; c < bounds->cluster_count && c < (index + 1) * CLUSTERS_A_TASK; c++) {
        sl_one_cluster_fetch(&one, (uint32_t)c);
        sl_bound_cluster(bounds, c, one.x, one.y, one.z, 3 * (size_t)one.triangles);
    }
}

sl_status sl_in_order_bounds(const sl_raster *raster, unsigned threads, sl_raster **bounds, sl_error *error) {
    sl_raster *r = sl_allocate(1, sizeof *r);
    bool ok = r != NULL;
    *bounds = NULL;
    if (ok) {
        *r = (sl_raster){.mesh = raster->mesh, .kernels = raster->kernels, .cluster_count = clusters_of(&raster->mesh)};
        ok = sl_bounds_allocate(r, r->cluster_count);
    }
    if (!ok) {
        sl_raster_destroy(r);
        return sl_fail_memory(error, "clusters in order");
    }
    sl_parallel_for(threads, (r->cluster_count + CLUSTERS_A_TASK - 1) / CLUSTERS_A_TASK, bound_some, r);
    *bounds = r;
    return SL_OK;
}

void sl_one_cluster_make(const sl_raster *raster, sl_one_cluster *one) {
    one->raster = (sl_raster){.mesh = raster->mesh, .kernels = raster->kernels, .cluster_count = 1,
                              .first_triangle = &one->first_triangle, .triangles = &one->triangles,
                              .first_vertex = &one->first_vertex, .vertices = &one->vertices, .triangle = one->triangle,
                              .vertex_x = one->x, .vertex_y = one->y, .vertex_z = one->z,
                              .corner = {one->corner[0], one->corner[1], one->corner[2]}};
    one->first_triangle = one->first_vertex = 0;
    for (uint32_t t = 0; t < SL_CLUSTER_TRIANGLES + SL_LANES; t++) {
        for (uint32_t k = 0; k < 3; k++) one->corner[k][t] = (uint16_t)(t < SL_CLUSTER_TRIANGLES ? 3 * t + k : 0);
    }
    for (uint32_t i = 0; i < SL_CLUSTER_VERTICES; i++) one->x[i] = one->y[i] = one->z[i] = 0.0f; /* whole groups are transformed */
}

void sl_one_cluster_fetch(sl_one_cluster *one, uint32_t cluster) {
    const sl_raster_mesh *mesh = &one->raster.mesh;
    const size_t first = (size_t)cluster * SL_CLUSTER_TRIANGLES, left = mesh->triangle_count - first;
    one->triangles = left < SL_CLUSTER_TRIANGLES ? (uint32_t)left : SL_CLUSTER_TRIANGLES;
    one->vertices = 3 * one->triangles;
    for (uint32_t t = 0; t < one->triangles; t++) {
        one->triangle[t] = (uint32_t)first + t;
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t vertex = mesh->vertex[k][first + t];
            one->x[3 * t + k] = mesh->x[vertex];
            one->y[3 * t + k] = mesh->y[vertex];
            one->z[3 * t + k] = mesh->z[vertex];
        }
    }
}
