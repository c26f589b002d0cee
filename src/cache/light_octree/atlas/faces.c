/* Faces that share an edge. Along it those that run opposite ways are glued, each to the flattest; all else
 * is a border. */
#include "cache/light_octree/atlas/parts.h"

#include "base/error.h"
#include "base/memory.h"
#include "scene/edges.h"

/* Below this height over its longest edge a face's normal is noise. */
#define SLIVER 1e-4
/* Faces that fold back on each other as sharply as this are two sides of a sheet, and never in one chart. */
#define FOLD (-0.9)
/* ---- edges ---- */

/* Glues a half-edge to the one that goes on from it most evenly, of those at the same place that follow. */
static void glue(sl_atlas_faces *f, const sl_half_edges *edges, size_t first, size_t end) {
    enum { MOST = 64 }; /* of a fan of more pages some stay open */
    const sl_half_edge e = sl_half_edge_at(edges, first);
    double best = FOLD;
    uint32_t found = SL_NO_INDEX;
    for (size_t k = first + 1; k < end && k < first + MOST; k++) {
        const sl_half_edge other = sl_half_edge_at(edges, k);
        const double flatness = sl_dotd(f->normal[e.index / 3], f->normal[other.index / 3]);
        if (other.upwards == e.upwards || f->opposite[other.index] != SL_NO_INDEX || !(flatness > best))
            continue;
        best = flatness;
        found = other.index;
    }
    if (found == SL_NO_INDEX) return;
    f->opposite[e.index] = found;
    f->opposite[found] = e.index;
}

static void glue_all(sl_atlas_faces *f, const sl_half_edges *edges) {
    for (size_t h = 0; h < edges->count; h++) f->opposite[h] = SL_NO_INDEX;
    for (size_t i = 0, end; i < edges->count; i = end) {
        end = sl_half_edges_of_one(edges, i);
        for (size_t k = i; k < end; k++) {
            if (f->opposite[edges->index[k]] == SL_NO_INDEX) glue(f, edges, k, end);
        }
    }
}

/* ---- faces ---- */

static void measure(sl_atlas_faces *f, uint32_t face) {
    sl_vec3d p[3];
    double longest = 0.0;
    for (size_t k = 0; k < 3; k++) p[k] = sl_atlas_corner(f, 3 * (size_t)face + k);
    for (size_t k = 0; k < 3; k++) {
        double length = sl_lengthd(sl_subd(p[(k + 1) % 3], p[k]));
        if (length > longest) longest = length;
    }
    sl_vec3d n = sl_crossd(sl_subd(p[1], p[0]), sl_subd(p[2], p[0]));
    double twice = sl_lengthd(n);
    f->area[face] = 0.5 * twice;
    f->normal[face] = twice > SLIVER * longest * longest ? sl_scaled(n, 1.0 / twice) : sl_v3d(0.0, 0.0, 0.0);
}

sl_status sl_atlas_faces_create(const sl_scene *scene, sl_atlas_faces *f, sl_error *error) {
    size_t count = scene->triangle_count;
    *f = (sl_atlas_faces){.scene = scene, .count = count};
    f->opposite = sl_allocate(3 * count, sizeof *f->opposite);
    f->normal = sl_allocate(count, sizeof *f->normal);
    f->area = sl_allocate(count, sizeof *f->area);
    sl_half_edges edges;
    const bool good = sl_half_edges_list(scene, &edges) && f->opposite && f->normal && f->area;
    if (good) {
        for (uint32_t face = 0; face < count; face++) measure(f, face);
        glue_all(f, &edges);
    }
    sl_half_edges_release(&edges);
    if (good) return SL_OK;
    sl_atlas_faces_release(f);
    return sl_fail_memory(error, "an atlas's faces");
}

void sl_atlas_faces_release(sl_atlas_faces *f) {
    SL_FREE_ALL(f->opposite, f->normal, f->area);
    *f = (sl_atlas_faces){0};
}
