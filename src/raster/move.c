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
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "raster/clusters.h"

enum { GROUP = 32 }; /* clusters of a task */
#define SL_SCATTERED 2.0 /* the clusters' radii, together, against what they were */

/* Which of the mesh's vertices a cluster's corners name: its triangles' part of `vertex`, three a triangle,
 * begins with one vertex for each of the cluster's own, in their order; then come the others that share a
 * place with one of those. */
struct sl_vertex_sources {
    uint32_t *vertex;
    uint16_t *local;   /* the cluster's vertex that it is */
    uint32_t *count;   /* by cluster */
    double extent;     /* sum of the clusters' radii when they were made */
    uint8_t *torn;     /* by task */
};

static double extent_of(const sl_raster *r) {
    double sum = 0.0;
    for (size_t c = 0; c < r->cluster_count; c++) sum += (double)r->radius[c];
    return sum;
}

static size_t tasks_of(const sl_raster *r) { return (r->cluster_count + GROUP - 1) / GROUP; }

/* ---- where vertices come from ---- */

typedef struct {
    uint32_t first[SL_CLUSTER_VERTICES]; /* the mesh's vertex that stands for each of the cluster's */
    /* others at the same place: a list for each, of numbers + 1 */
    uint16_t next[SL_CLUSTER_VERTICES], head[SL_CLUSTER_VERTICES];
    uint32_t other[SL_CLUSTER_VERTICES];
    uint16_t local[SL_CLUSTER_VERTICES], others;
} vertex_list;

static void note(vertex_list *list, uint16_t local, uint32_t vertex) {
    if (list->first[local] == SL_NO_INDEX) list->first[local] = vertex;
    if (list->first[local] == vertex) return;
    for (uint16_t n = list->head[local]; n; n = list->next[n - 1]) {
        if (list->other[n - 1] == vertex) return;
    }
    uint16_t n = list->others++;
    list->other[n] = vertex;
    list->local[n] = local;
    list->next[n] = list->head[local];
    list->head[local] = (uint16_t)(n + 1);
}

static void list_sources(void *context, size_t cluster, unsigned worker) {
    (void)worker;
    const sl_raster *r = context;
    struct sl_vertex_sources *s = r->sources;
    const size_t first = r->first_triangle[cluster], at = 3 * first;
    vertex_list list;
    memset(&list, 0, sizeof list);
    for (uint32_t v = 0; v < r->vertices[cluster]; v++) list.first[v] = SL_NO_INDEX;
    for (size_t i = first; i < first + r->triangles[cluster]; i++) {
        for (int k = 0; k < 3; k++) note(&list, r->corner[k][i], r->mesh.vertex[k][r->triangle[i]]);
    }
    uint32_t count = r->vertices[cluster];
    for (uint32_t v = 0; v < count; v++) {
        s->vertex[at + v] = list.first[v];
        s->local[at + v] = (uint16_t)v;
    }
    for (uint16_t n = 0; n < list.others; n++, count++) {
        s->vertex[at + count] = list.other[n];
        s->local[at + count] = list.local[n];
    }
    s->count[cluster] = count;
}

void sl_vertex_sources_destroy(struct sl_vertex_sources *s) {
    if (!s) return;
    sl_free(s->vertex);
    sl_free(s->local);
    sl_free(s->count);
    sl_free(s->torn);
    sl_free(s);
}

static bool find_sources(sl_raster *r, unsigned threads) {
    const size_t corners = 3 * r->mesh.triangle_count;
    struct sl_vertex_sources *s = sl_allocate(1, sizeof *s);
    if (!s) return false;
    *s = (struct sl_vertex_sources){
        sl_allocate(corners, sizeof *s->vertex), sl_allocate(corners, sizeof *s->local),
        sl_allocate(r->cluster_count, sizeof *s->count), extent_of(r), sl_allocate(tasks_of(r), 1)};
    if (!s->vertex || !s->local || !s->count || !s->torn) {
        sl_vertex_sources_destroy(s);
        return false;
    }
    r->sources = s;
    r->memory_bytes += sizeof *s + corners * (sizeof *s->vertex + sizeof *s->local) +
                       r->cluster_count * sizeof *s->count + tasks_of(r);
    sl_parallel_for(threads, r->cluster_count, list_sources, r);
    return true;
}

/* ---- moving ---- */

static uint32_t bits_that_differ(float a, float b) {
    uint32_t x, y;
    memcpy(&x, &a, sizeof x);
    memcpy(&y, &b, sizeof y);
    return x ^ y;
}

/* False where vertices that were one have come apart. */
static bool move_cluster(sl_raster *r, size_t cluster) {
    const struct sl_vertex_sources *s = r->sources;
    const sl_raster_mesh *m = &r->mesh;
    const size_t at = 3 * (size_t)r->first_triangle[cluster];
    const uint32_t own = r->vertices[cluster], count = s->count[cluster];
    const uint32_t *vertex = s->vertex + at;
    const uint16_t *local = s->local + at;
    float *x = r->vertex_x + r->first_vertex[cluster], *y = r->vertex_y + r->first_vertex[cluster];
    float *z = r->vertex_z + r->first_vertex[cluster];
    uint32_t differing = 0;
    for (uint32_t n = 0; n < own; n++) {
        x[n] = m->x[vertex[n]];
        y[n] = m->y[vertex[n]];
        z[n] = m->z[vertex[n]];
    }
    for (uint32_t n = own; n < count; n++) {
        const uint32_t v = vertex[n], l = local[n];
        differing |= bits_that_differ(m->x[v], x[l]) | bits_that_differ(m->y[v], y[l]) |
                     bits_that_differ(m->z[v], z[l]);
    }
    sl_bound_cluster(r, cluster, x, y, z, own);
    return differing == 0;
}

static void move_group(void *context, size_t group, unsigned worker) {
    (void)worker;
    sl_raster *r = context;
    const size_t first = group * GROUP,
                 end = first + GROUP < r->cluster_count ? first + GROUP : r->cluster_count;
    bool together = true;
    for (size_t c = first; c < end; c++) together = move_cluster(r, c) && together;
    r->sources->torn[group] = !together;
}

static bool is_torn(const sl_raster *r) {
    for (size_t g = 0; g < tasks_of(r); g++) {
        if (r->sources->torn[g]) return true;
    }
    return false;
}

static bool is_scattered(const sl_raster *r) {
    double extent = extent_of(r);
    return isfinite(extent) && extent > SL_SCATTERED * r->sources->extent;
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
    if (!raster->sources && !find_sources(raster, threads))
        return sl_fail_memory(error, "the rasterizer's moving vertices");
    sl_parallel_for(threads, tasks_of(raster), move_group, raster);
    return is_torn(raster) || is_scattered(raster) ? make_anew(raster, threads, error) : SL_OK;
}
