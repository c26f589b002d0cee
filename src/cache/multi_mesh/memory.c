/* What multi-mesh caching takes, and where refinement ends if memory does. */
#include "cache/frame/budget.h"
#include "cache/multi_mesh/multi_mesh_internal.h"

#include <stdio.h>

/* IDs 4, three Gouraud planes 36, materials 28, the pixels by face 16, the picture 84. For each triangle three meshes have a root (its node, its corners and edges, what
 * they are on the screen), there is the topology, and a coarse mesh. Refinement has no use for less than a thousand leaves. */
enum { A_PIXEL = 176, OF_GLOSS = 24, A_TRIANGLE = 760, A_COARSE = 320, AN_IRRADIANCE = 120, LEAVES_LEAST = 1000, A_LEAF = 200, A_CELL = 160 };

/* The coarse mesh has edges of its own: pieces of the surface, as large as the scene's box six times over. */
static double coarse_bytes(const sl_scene *scene, const sl_settings *settings) {
    const double edge = sl_multi_mesh_coarse_edge(scene, settings), d = (double)scene->diagonal;
    double pieces = 4.0 * 6.0 * d * d / (edge * edge), finest = (double)scene->triangle_count;
    for (int i = 0; i < settings->multi_mesh.coarse_depth; i++) finest *= 4.0;
    return 2.0 * (pieces < finest ? pieces : finest) * A_COARSE; /* as many again where light differs */
}

sl_memory_need sl_multi_mesh_need(const sl_scene *scene, const sl_settings *settings) {
    const sl_multi_mesh_plan plan = sl_multi_mesh_plan_make(scene, settings);
    const double triangles = (double)scene->triangle_count, n = settings->gather_size, l = settings->multi_mesh.light_size;
    const double lights = sl_need_lights(scene);
    double caches = triangles * A_TRIANGLE + (plan.coarse ? coarse_bytes(scene, settings) : 0.0) + LEAVES_LEAST * A_LEAF;
    caches += sl_need_of_threads(settings, A_CELL * (n * n + l * l)) + lights * 2000.0 + 3e6;
    return (sl_memory_need){.hierarchies = plan.lights ? sl_tracer_memory_need(scene->triangle_count) + sl_raster_memory_kept(scene->triangle_count)
                                                       : sl_raster_memory_need(scene->triangle_count),
                            .caches = caches,
                            .picture = sl_need_of_pixels(settings, A_PIXEL + (plan.specular_seen ? OF_GLOSS : 0))};
}

const sl_concession sl_multi_mesh_concessions[] = {{"pixels a side of a gather", offsetof(sl_settings, gather_size), SL_CONCEDE_INT, 16.0},
                                                   {"levels of the coarse mesh", offsetof(sl_settings, multi_mesh.coarse_depth), SL_CONCEDE_LEVEL, 1.0},
                                                   {NULL, 0, SL_CONCEDE_INT, 0.0}};

static double mesh_bytes(const sl_multi_mesh_state *s) {
    double bytes = s->irradiance ? (double)sl_irradiance_meshes_bytes(s->irradiance) : 0.0;
    for (int i = 0; i < SL_COMPONENTS; i++)
        if (s->part[i]) bytes += (double)sl_displayed_memory_bytes(s->part[i]);
    return bytes;
}

bool sl_multi_mesh_is_full(sl_multi_mesh_state *s) {
    if (!s->settings.memory_bytes || s->full) return s->full;
    double bytes = mesh_bytes(s);
    if (!s->bytes_of_roots) s->bytes_of_roots = (size_t)bytes;
    s->full = 2.0 * (bytes - (double)s->bytes_of_roots) > (double)s->settings.memory_bytes; /* arrays are there twice while they grow */
    size_t leaves = 0;
    for (int i = 0; i < SL_COMPONENTS; i++) leaves += s->part[i] ? s->part[i]->mesh->leaf_count : 0;
    if (s->full) snprintf(s->filled, sizeof s->filled, "meshes end at %zu leaves", leaves);
    return s->full;
}

const char *sl_multi_mesh_filled(const void *state) {
    const sl_multi_mesh_state *s = state;
    return s->full ? s->filled : NULL;
}
