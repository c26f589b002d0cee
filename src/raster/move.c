/* Moved vertices: the clusters stay as they are, their vertices are read again and their bounds follow.
 *
 * No pixel can tell clusters that were moved from clusters made anew. What is drawn is decided triangle by
 * triangle from its corners' positions, which are the same bits; the depth test is a total order; and culling
 * and occlusion leave out only what would not have been drawn, however large a cluster's box has become. Only
 * the price can tell: so where motion has scattered what was close together, clusters are made anew.
 *
 * A cluster holds vertices by position: several of the mesh's may be one of its own, as long as all of them
 * move alike. That is checked; where motion tears them apart, clusters are made anew as well. */
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "base/math.h"
#include "base/parallel.h"
#include "raster/clusters.h"

#define SL_SCATTERED 2.0 /* the clusters' radii, together, against what they were */

typedef struct motion {
    sl_raster *raster;
    atomic_bool torn; /* in some cluster vertices that were one have come apart */
} motion;

static uint32_t bits_that_differ(float a, float b) { return sl_float_bits(a) ^ sl_float_bits(b); }

/* The first corner that names one of the cluster's vertices gives its place, other vertices of the mesh must
 * agree with it. */
static void move_cluster(void *context, size_t cluster, unsigned worker) {
    (void)worker;
    motion *of = context;
    sl_raster *r = of->raster;
    const sl_raster_mesh *m = &r->mesh;
    const size_t first = r->first_triangle[cluster], end = first + r->triangles[cluster];
    float *x = r->vertex_x + r->first_vertex[cluster], *y = r->vertex_y + r->first_vertex[cluster];
    float *z = r->vertex_z + r->first_vertex[cluster];
    uint32_t source[SL_CLUSTER_VERTICES], differing = 0;
    memset(source, 0xff, sizeof source);
    for (size_t i = first; i < end; i++) {
        for (int k = 0; k < 3; k++) {
            const uint32_t v = m->vertex[k][r->triangle[i]], n = r->corner[k][i];
            if (source[n] == v) continue;
            if (source[n] == SL_NO_INDEX) x[n] = m->x[v], y[n] = m->y[v], z[n] = m->z[v];
            source[n] = v;
            differing |= bits_that_differ(m->x[v], x[n]) | bits_that_differ(m->y[v], y[n]) |
                         bits_that_differ(m->z[v], z[n]);
        }
    }
    if (differing) atomic_store(&of->torn, true);
    sl_bound_cluster(r, cluster, x, y, z, r->vertices[cluster]);
}

static bool is_scattered(const sl_raster *r) {
    double extent = 0.0;
    for (size_t c = 0; c < r->cluster_count; c++) extent += (double)r->radius[c];
    return isfinite(extent) && extent > SL_SCATTERED * r->extent;
}

/* ---- the whole ---- */

static sl_status make_anew(sl_raster *r, unsigned threads, sl_error *error) {
    sl_raster *fresh = NULL, old = *r;
    sl_status status = r->scene ? sl_raster_create(r->scene, threads, &fresh, error)
                                : sl_raster_create_mesh(&r->mesh, threads, &fresh, error);
    if (status != SL_OK) return status;
    *r = *fresh;
    *fresh = old;
    sl_raster_destroy(fresh);
    return SL_OK;
}

/* The scene has other arrays, or other triangles, than when the clusters were made. */
static bool is_another_mesh(const sl_raster *r) {
    const sl_scene *s = r->scene;
    const sl_raster_mesh *m = &r->mesh;
    return s &&
           (s->vertex_count != m->vertex_count || s->triangle_count != m->triangle_count ||
            s->position_x != m->x || s->position_y != m->y || s->position_z != m->z ||
            s->vertex[0] != m->vertex[0] || s->vertex[1] != m->vertex[1] || s->vertex[2] != m->vertex[2]);
}

sl_status sl_raster_move(sl_raster *raster, unsigned threads, sl_error *error) {
    threads = sl_thread_count(threads);
    if (is_another_mesh(raster)) return make_anew(raster, threads, error);
    motion of = {.raster = raster};
    sl_parallel_for(threads, raster->cluster_count, move_cluster, &of);
    return atomic_load(&of.torn) || is_scattered(raster) ? make_anew(raster, threads, error) : SL_OK;
}
