/* The faces of all meshes: corners that they share (sites.c), edges (edges.c). */
#include <math.h>

#include "base/error.h"
#include "base/memory.h"
#include "cache/patches/topology_parts.h"

/* Triangles of no area to speak of; NaN has none. */
static void find_degenerate(sl_topology *topology) {
    const sl_scene *scene = topology->scene;
    double least = 1e-12 * (double)scene->scale * (double)scene->scale;
    for (size_t t = 0; t < scene->triangle_count; t++) {
        sl_vec3d a = sl_to_double(sl_scene_position(scene, scene->vertex[0][t]));
        sl_vec3d b = sl_to_double(sl_scene_position(scene, scene->vertex[1][t]));
        sl_vec3d c = sl_to_double(sl_scene_position(scene, scene->vertex[2][t]));
        double area = 0.5 * sl_lengthd(sl_crossd(sl_subd(b, a), sl_subd(c, a)));
        topology->degenerate[t] = !(area >= least && area > 0.0 && area <= DBL_MAX);
    }
}

static bool allocate_faces(sl_topology *topology) {
    size_t triangles = topology->scene->triangle_count;
    topology->degenerate = sl_allocate(triangles, 1);
    bool good = topology->degenerate != NULL;
    for (int c = 0; c < 3; c++) {
        topology->site[c] = sl_allocate(topology->face_count, sizeof(uint32_t));
        topology->edge[c] = sl_allocate(topology->face_count, sizeof(uint32_t));
        good = good && topology->site[c] != NULL && topology->edge[c] != NULL;
    }
    return good;
}

static sl_status make_parts(sl_topology *topology, bool by_exponent, sl_error *error) {
    if (!allocate_faces(topology)) return sl_fail_memory(error, "faces");
    find_degenerate(topology);
    sl_status status = sl_sites_make(topology, by_exponent, error);
    if (status == SL_OK) status = sl_edges_make(topology, error);
    return status == SL_OK ? sl_solids_find(topology->scene, &topology->solids, error) : status;
}

sl_status sl_topology_create(const sl_scene *scene, bool by_exponent, sl_topology **topology,
                             sl_error *error) {
    *topology = NULL;
    /* Corners of faces, 6 a triangle, are counted in 32 bits. */
    if (scene->triangle_count > UINT32_MAX / 8)
        return sl_fail(error, SL_ERROR_RESOURCES, "too many triangles for meshes: %zu",
                       scene->triangle_count);
    sl_topology *t = sl_allocate(1, sizeof *t);
    if (t == NULL) return sl_fail_memory(error, "faces");
    t->scene = scene;
    t->face_count = 2 * scene->triangle_count;
    sl_status status = make_parts(t, by_exponent, error);
    if (status == SL_OK) *topology = t;
    else sl_topology_destroy(t);
    return status;
}

void sl_topology_destroy(sl_topology *topology) {
    if (topology == NULL) return;
    for (int c = 0; c < 3; c++) {
        sl_free(topology->site[c]);
        sl_free(topology->edge[c]);
    }
    sl_free(topology->site_position);
    sl_free(topology->site_normal);
    sl_free(topology->site_face);
    sl_free(topology->site_shared);
    sl_free(topology->degenerate);
    sl_solids_destroy(topology->solids);
    sl_free(topology->edge_start);
    sl_free(topology->edge_face);
    sl_free(topology->edge_low);
    sl_free(topology->edge_high);
    sl_free(topology);
}

size_t sl_topology_memory_bytes(const sl_topology *topology) {
    size_t word = sizeof(uint32_t), triangles = topology->scene->triangle_count;
    size_t faces = topology->face_count * (6 + 3) * word; /* sites, edges, faces by edge */
    size_t sites = topology->site_count * (2 * sizeof(sl_vec3) + 2 * word + 1);
    size_t edges = topology->edge_count * 2 * word;
    return sizeof *topology + faces + sites + edges + triangles;
}
