/* Clusters: at most 128 triangles that lie close together, with a box and a sphere around them, so that a
 * view can reject them whole.
 *
 * Triangles are sorted by size class, then by the Morton code of their box's centre, then by index; the
 * sorted list is cut where Morton codes differ in their highest bit (Lauterbach et al. 2009, "Fast BVH
 * construction on GPUs") until a piece fits. Large triangles are kept apart: one wall among the books on a
 * shelf would make the shelf's box as large as the room. */
#include <math.h>
#include <string.h>

#include "base/code_sort.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/morton.h"
#include "raster/pipeline.h"

enum { MORTON_BITS = 20, HASH_SLOTS = 1024 };

/* ---- order ---- */

/* Around all vertices of triangles that are finite. */
typedef struct {
    double low[3], diagonal;
} box;

static box box_of(const sl_raster_mesh *m) {
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY},
           squared = 0.0;
    const float *axis[3] = {m->x, m->y, m->z};
    for (int c = 0; c < 3; c++) {
        for (size_t t = 0; t < m->triangle_count; t++) {
            for (int k = 0; k < 3; k++) {
                double p = (double)axis[k][m->vertex[c][t]];
                if (!(fabs(p) < 1e30)) continue;
                low[k] = p < low[k] ? p : low[k];
                high[k] = p > high[k] ? p : high[k];
            }
        }
    }
    for (int k = 0; k < 3; k++) squared += high[k] > low[k] ? (high[k] - low[k]) * (high[k] - low[k]) : 0.0;
    return (box){{low[0], low[1], low[2]}, squared > 0.0 ? sqrt(squared) : 1.0};
}

static uint64_t quantize(double value, double low, double scale) {
    double q = (value - low) * scale;
    if (!(q > 0.0)) return 0; /* also NaN */
    double last = (double)((1 << MORTON_BITS) - 1);
    return (uint64_t)(q < last ? q : last);
}

/* The size class in the top bits, the Morton code below. */
static uint64_t triangle_code(const sl_raster_mesh *m, const box *b, uint32_t t) {
    double low[3], high[3];
    for (int c = 0; c < 3; c++) {
        uint32_t i = m->vertex[c][t];
        double p[3] = {(double)m->x[i], (double)m->y[i], (double)m->z[i]};
        for (int k = 0; k < 3; k++) {
            low[k] = c == 0 || p[k] < low[k] ? p[k] : low[k];
            high[k] = c == 0 || p[k] > high[k] ? p[k] : high[k];
        }
    }
    double scale = (double)(1 << MORTON_BITS) / b->diagonal, extent = 0.0;
    uint64_t code = 0;
    for (int k = 0; k < 3; k++) {
        code |= sl_morton_spread(quantize(0.5 * (low[k] + high[k]), b->low[k], scale)) << k;
        if (high[k] - low[k] > extent) extent = high[k] - low[k];
    }
    uint64_t class = extent > b->diagonal / 6.0 ? 0 : extent > b->diagonal / 24.0 ? 1 : 2;
    return class << 60 | code;
}

/* First index in (first, last) whose code has the highest bit in which the ends differ; the middle if they do
 * not. */
static size_t split_position(const sl_coded *t, size_t first, size_t last) {
    uint64_t difference = t[first].code ^ t[last - 1].code;
    if (!difference) return first + (last - first) / 2;
    uint64_t bit = (uint64_t)1 << (63 - __builtin_clzll(difference));
    size_t low = first, high = last - 1; /* bit clear at low, set at high */
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (t[middle].code & bit) high = middle;
        else low = middle;
    }
    return high;
}

/* ---- one cluster ---- */

typedef struct {
    sl_raster *raster;
    const sl_coded *sorted;
    size_t clusters, vertices; /* so far */
    bool fill;                 /* false: only count */
} builder;

typedef struct {
    uint32_t bits[SL_CLUSTER_VERTICES][3];
    uint16_t slot[HASH_SLOTS]; /* number + 1 */
    uint16_t count;
} welder;

static uint16_t weld(welder *w, const float p[3]) {
    uint32_t bits[3];
    memcpy(bits, p, sizeof bits);
    uint32_t hash = bits[0] * 0x9e3779b1u ^ bits[1] * 0x85ebca77u ^ bits[2] * 0xc2b2ae3du;
    for (uint32_t at = hash >> 22;; at = (at + 1) % HASH_SLOTS) {
        if (!w->slot[at]) {
            memcpy(w->bits[w->count], bits, sizeof bits);
            w->slot[at] = ++w->count;
            return (uint16_t)(w->count - 1);
        }
        uint16_t found = (uint16_t)(w->slot[at] - 1);
        if (memcmp(w->bits[found], bits, sizeof bits) == 0) return found;
    }
}

/* Box and sphere around the vertices, about one centre; rounded outwards. */
void sl_bound_cluster(sl_raster *r, size_t cluster, const float *x, const float *y, const float *z,
                      size_t count) {
    const float *axis[3] = {x, y, z};
    float *centre[3] = {r->centre_x, r->centre_y, r->centre_z}, *half[3] = {r->half_x, r->half_y, r->half_z};
    double c[3];
    for (int k = 0; k < 3; k++) {
        float low = axis[k][0], high = axis[k][0];
        for (size_t i = 1; i < count; i++) {
            low = axis[k][i] < low ? axis[k][i] : low;
            high = axis[k][i] > high ? axis[k][i] : high;
        }
        float middle = (float)(0.5 * ((double)low + (double)high));
        double reach = fmax((double)high - (double)middle, (double)middle - (double)low);
        centre[k][cluster] = middle;
        half[k][cluster] = (float)(reach * (1.0 + 1e-6));
        c[k] = (double)middle;
    }
    double radius_squared = 0.0;
    for (size_t i = 0; i < count; i++) {
        sl_vec3d d = sl_v3d((double)axis[0][i] - c[0], (double)axis[1][i] - c[1], (double)axis[2][i] - c[2]);
        double squared = sl_dotd(d, d); /* no fmax(): gcc 12 for Arm fails at it in a loop over floats */
        if (squared > radius_squared) radius_squared = squared;
    }
    r->radius[cluster] = (float)(sqrt(radius_squared) * (1.0 + 1e-6));
}

static void fill_cluster(builder *b, size_t first, size_t count, welder *w) {
    sl_raster *r = b->raster;
    const sl_raster_mesh *m = &r->mesh;
    for (size_t i = first; i < first + count; i++) {
        uint32_t t = b->sorted[i].item;
        for (int c = 0; c < 3; c++) {
            uint32_t v = m->vertex[c][t];
            uint16_t local = weld(w, (const float[3]){m->x[v], m->y[v], m->z[v]});
            if (!b->fill) continue;
            r->corner[c][i] = local;
            r->vertex_x[b->vertices + local] = m->x[v];
            r->vertex_y[b->vertices + local] = m->y[v];
            r->vertex_z[b->vertices + local] = m->z[v];
        }
        if (!b->fill) continue;
        r->triangle[i] = t;
        r->cluster_of_triangle[t] = (uint32_t)b->clusters;
        r->triangle_masked[i] = r->scene && sl_scene_has_alpha(r->scene, t);
        r->masked |= r->triangle_masked[i];
    }
}

static void add_cluster(builder *b, size_t first, size_t count) {
    sl_raster *r = b->raster;
    welder w = {.count = 0};
    fill_cluster(b, first, count, &w);
    if (b->fill) {
        r->first_triangle[b->clusters] = (uint32_t)first;
        r->triangles[b->clusters] = (uint32_t)count;
        r->first_vertex[b->clusters] = (uint32_t)b->vertices;
        r->vertices[b->clusters] = w.count;
        sl_bound_cluster(r, b->clusters, r->vertex_x + b->vertices, r->vertex_y + b->vertices,
                         r->vertex_z + b->vertices, w.count);
        r->extent += (double)r->radius[b->clusters];
    }
    b->clusters++;
    b->vertices += (size_t)(w.count + SL_LANES - 1) / SL_LANES * SL_LANES;
}

static void split(builder *b, size_t first, size_t last) {
    if (last - first <= SL_CLUSTER_TRIANGLES) {
        add_cluster(b, first, last - first);
        return;
    }
    size_t middle = split_position(b->sorted, first, last);
    split(b, first, middle);
    split(b, middle, last);
}

/* ---- the whole ---- */

static void *claim(sl_raster *r, bool *ok, size_t count, size_t size) {
    void *block = sl_allocate(count, size);
    if (!block) *ok = false;
    r->memory_bytes += count * size;
    return block;
}

static size_t padded_to_lanes(size_t count) { return (count + SL_LANES - 1) / SL_LANES * SL_LANES; }

static bool allocate_bounds(sl_raster *r, size_t clusters) {
    bool ok = true;
    float **bounds[7] = {&r->centre_x, &r->centre_y, &r->centre_z, &r->half_x,
                         &r->half_y,   &r->half_z,   &r->radius};
    for (int k = 0; k < 7; k++) *bounds[k] = claim(r, &ok, padded_to_lanes(clusters), sizeof(float));
    return ok;
}

static bool allocate_clusters(sl_raster *r, size_t clusters, size_t vertices) {
    bool ok = allocate_bounds(r, clusters);
    size_t padded = padded_to_lanes(clusters), triangles = r->mesh.triangle_count;
    uint32_t **ranges[4] = {&r->first_triangle, &r->triangles, &r->first_vertex, &r->vertices};
    for (int k = 0; k < 4; k++) *ranges[k] = claim(r, &ok, padded, sizeof(uint32_t));
    float **positions[3] = {&r->vertex_x, &r->vertex_y, &r->vertex_z};
    for (int k = 0; k < 3; k++) *positions[k] = claim(r, &ok, vertices, sizeof(float));
    for (int k = 0; k < 3; k++) r->corner[k] = claim(r, &ok, triangles + SL_LANES, sizeof(uint16_t));
    r->triangle = claim(r, &ok, triangles, sizeof(uint32_t));
    r->triangle_masked = claim(r, &ok, triangles, 1);
    r->cluster_of_triangle = claim(r, &ok, triangles, sizeof(uint32_t));
    return ok;
}

static void put_in_order(const sl_raster *r, sl_coded *list) {
    const size_t count = r->mesh.triangle_count;
    const box around = box_of(&r->mesh);
    for (size_t t = 0; t < count; t++)
        list[t] = (sl_coded){triangle_code(&r->mesh, &around, (uint32_t)t), (uint32_t)t};
    sl_sort_coded(list, count);
}

static bool build(sl_raster *r, const sl_coded *sorted) {
    size_t count = r->mesh.triangle_count;
    builder counting = {.raster = r, .sorted = sorted, .fill = false};
    if (count) split(&counting, 0, count);
    if (!allocate_clusters(r, counting.clusters, counting.vertices)) return false;
    builder filling = {.raster = r, .sorted = sorted, .fill = true};
    if (count) split(&filling, 0, count);
    r->cluster_count = filling.clusters;
    return true;
}

static sl_status create(const sl_scene *scene, const sl_raster_mesh *mesh, sl_raster **raster,
                        sl_error *error) {
    *raster = NULL;
    sl_raster *r = sl_allocate(1, sizeof *r);
    sl_coded *sorted = sl_allocate_unset(mesh->triangle_count, sizeof *sorted);
    bool ok = r && sorted;
    if (ok) {
        *r = (sl_raster){.scene = scene,
                         .mesh = *mesh,
                         .isa = sl_isa_best(),
                         .memory_bytes = sizeof *r,
                         .observer = scene ? scene->observer : NULL,
                         .spares = sl_spares_create()};
        put_in_order(r, sorted);
        ok = r->spares && build(r, sorted);
    }
    sl_free(sorted);
    if (!ok) {
        sl_raster_destroy(r);
        return sl_fail_memory(error, "the rasterizer's clusters");
    }
    *raster = r;
    return SL_OK;
}

sl_status sl_raster_create(const sl_scene *scene, unsigned threads, sl_raster **raster, sl_error *error) {
    (void)threads; /* the build is a few linear passes */
    sl_raster_mesh mesh = {scene->vertex_count, scene->triangle_count,
                           scene->position_x,   scene->position_y,
                           scene->position_z,   {scene->vertex[0], scene->vertex[1], scene->vertex[2]}};
    return create(scene, &mesh, raster, error);
}

sl_status sl_raster_create_mesh(const sl_raster_mesh *mesh, unsigned threads, sl_raster **raster,
                                sl_error *error) {
    (void)threads;
    return create(NULL, mesh, raster, error);
}


void sl_raster_destroy(sl_raster *r) {
    if (!r) return;
    float *bounds[10] = {r->centre_x, r->centre_y, r->centre_z, r->half_x,   r->half_y,
                         r->half_z,   r->radius,   r->vertex_x, r->vertex_y, r->vertex_z};
    for (int k = 0; k < 10; k++) sl_free(bounds[k]);
    uint32_t *ranges[5] = {r->first_triangle, r->triangles, r->first_vertex, r->vertices, r->triangle};
    for (int k = 0; k < 5; k++) sl_free(ranges[k]);
    for (int k = 0; k < 3; k++) sl_free(r->corner[k]);
    sl_free(r->triangle_masked);
    sl_free(r->cluster_of_triangle);
    sl_spares_destroy(r->spares);
    sl_free(r);
}

size_t sl_raster_cluster_count(const sl_raster *raster) { return raster->cluster_count; }
size_t sl_raster_memory_bytes(const sl_raster *raster) { return raster->memory_bytes; }

/* A sorted list of triangles, until the clusters stand: 41 to 43 bytes a triangle, of which 25 to 27 stay. */
double sl_raster_memory_need(size_t triangles) { return 1e6 + 46.0 * (double)triangles; }
double sl_raster_memory_kept(size_t triangles) { return 1e6 + 30.0 * (double)triangles; }
