/* Faces that share an edge. Along an edge of two faces that run opposite ways these are glued; where more
 * meet, the flattest such pairs; all else is a border. */
#include "cache/light_octree/atlas/parts.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "scene/edges.h"

/* Below this height over its longest edge a face's normal is noise. */
#define SLIVER 1e-4
/* Faces that fold back on each other as sharply as this are two sides of a sheet, and never in one chart. */
#define FOLD (-0.9)

/* ---- edges ---- */

/* Glues the flattest pair of faces at an edge that run opposite ways, then the flattest of the rest. */
static void glue_flattest(sl_atlas_faces *f, const sl_half_edge *e, size_t count) {
    enum { MOST = 64 }; /* a fan of more pages than this stays open */
    for (bool glued = count <= MOST; glued;) {
        double best = FOLD;
        uint32_t left = SL_NO_INDEX, right = SL_NO_INDEX;
        for (size_t i = 0; i < count; i++)
            for (size_t j = i + 1; j < count; j++) {
                uint32_t a = e[i].index, b = e[j].index;
                if (f->opposite[a] != SL_NO_INDEX || f->opposite[b] != SL_NO_INDEX ||
                    e[i].upwards == e[j].upwards)
                    continue;
                double flatness = sl_dotd(f->normal[a / 3], f->normal[b / 3]);
                if (flatness > best) best = flatness, left = a, right = b;
            }
        glued = left != SL_NO_INDEX;
        if (glued) f->opposite[left] = right, f->opposite[right] = left;
    }
}

static void glue_all(sl_atlas_faces *f, const sl_half_edge *edges) {
    const size_t count = 3 * f->count;
    for (size_t h = 0; h < count; h++) f->opposite[h] = SL_NO_INDEX;
    for (size_t i = 0, end; i < count; i = end) {
        end = sl_half_edges_of_one(edges, i, count);
        if (end - i > 1) glue_flattest(f, edges + i, end - i);
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
    f->point = sl_allocate(3 * count, sizeof *f->point);
    f->opposite = sl_allocate(3 * count, sizeof *f->opposite);
    f->normal = sl_allocate(count, sizeof *f->normal);
    f->area = sl_allocate(count, sizeof *f->area);
    uint32_t *places = sl_scene_places(scene);
    sl_half_edge *edges = places ? sl_scene_half_edges(scene, places) : NULL;
    const bool good = f->point && f->opposite && f->normal && f->area && edges;
    if (good) {
        for (size_t c = 0; c < 3 * count; c++) f->point[c] = places[scene->vertex[c % 3][c / 3]];
        for (uint32_t face = 0; face < count; face++) measure(f, face);
        glue_all(f, edges);
    }
    sl_free(places);
    sl_free(edges);
    if (good) return SL_OK;
    sl_atlas_faces_release(f);
    return sl_fail_memory(error, "an atlas's faces");
}

void sl_atlas_faces_release(sl_atlas_faces *f) {
    sl_free(f->point);
    sl_free(f->opposite);
    sl_free(f->normal);
    sl_free(f->area);
    *f = (sl_atlas_faces){0};
}
