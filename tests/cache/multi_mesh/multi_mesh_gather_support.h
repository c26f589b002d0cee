/* Shared by tests of coarse meshes and gathers. */
#pragma once

#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/multi_mesh/coarse.h"
#include "trace_scenes.h"

/* A scene with all that a gather needs. */
typedef struct gathering {
    sl_scene *scene;
    sl_primitives *primitives;
    sl_raster *raster;
    sl_coarse *coarse;
    sl_gather *gather;
    sl_gather_scratch *scratch;
    sl_counters counters;
} gathering;

static inline sl_gather_settings usual_settings(void) {
    return (sl_gather_settings){.kind = SL_GATHER_PLANE,
                                .size = 128,
                                .plane_fov = (float)(160.0 / 180.0 * SL_PI),
                                .border = SL_BORDER_LC04};
}

/* Takes the scene over. */
static inline gathering gathering_of(sl_scene *scene, float edge, int depth,
                                     const sl_gather_settings *settings) {
    gathering g = {.scene = scene};
    assert_int_equal(sl_raster_create(scene, 1, &g.raster, NULL), SL_OK);
    assert_int_equal(sl_primitives_of_triangles(scene, &g.primitives, NULL), SL_OK);
    assert_int_equal(sl_coarse_create(scene, g.primitives, edge, depth, &g.coarse, NULL), SL_OK);
    const sl_lattice_colours colours = {g.coarse->face, g.coarse->colour};
    sl_gather_settings coloured = *settings;
    coloured.colours = &colours;
    assert_int_equal(sl_gather_create(scene, g.raster, NULL, &coloured, 1, &g.gather, NULL), SL_OK);
    assert_int_equal(sl_gather_scratch_create(g.gather, &g.scratch, NULL), SL_OK);
    return g;
}

static inline void gathering_destroy(gathering *g) {
    sl_gather_scratch_destroy(g->scratch);
    sl_gather_destroy(g->gather);
    sl_coarse_destroy(g->coarse);
    sl_raster_destroy(g->raster);
    sl_primitives_destroy(g->primitives);
    sl_scene_destroy(g->scene);
}

static inline void set_all(gathering *g, sl_rgb value) {
    for (size_t v = 0; v < g->coarse->vertex_count; v++) sl_coarse_set(g->coarse, v, value);
    sl_coarse_finish(g->coarse, 1);
}

/* With the usual settings, all surfaces of one value. Takes the mesh. */
static inline gathering even_gathering(trace_mesh *mesh, float edge, int depth, float value) {
    sl_gather_settings settings = usual_settings();
    gathering g = gathering_of(trace_mesh_build(mesh), edge, depth, &settings);
    set_all(&g, sl_grey(value));
    return g;
}

/* A point in free space. */
static inline sl_mesh_point free_point(sl_vec3 position, sl_vec3 normal) {
    return (sl_mesh_point){{position, normal, normal, SL_NO_INDEX}, SL_NO_INDEX};
}

/* A point of a face. */
static inline sl_mesh_point face_point(const sl_scene *scene, uint32_t face, float w1, float w2) {
    sl_vec3 a = sl_scene_position(scene, scene->vertex[0][face / 2]),
            b = sl_scene_position(scene, scene->vertex[1][face / 2]);
    sl_vec3 c = sl_scene_position(scene, scene->vertex[2][face / 2]);
    sl_vec3 normal = sl_scale(sl_scene_geometric_normal(scene, face / 2), face % 2 ? -1.0f : 1.0f);
    sl_vec3 position = sl_mad(sl_mad(a, w1, sl_sub(b, a)), w2, sl_sub(c, a));
    return (sl_mesh_point){{position, normal, normal, face / 2}, face};
}

/* Returns what bounces off at a point of a face, as gathers look it up: after sl_coarse_finish(). */
static inline sl_rgb coarse_colour(const sl_coarse *c, uint32_t face, float w1, float w2) {
    float a, b, value[3];
    int at = c->face[face].first + sl_lattice_locate(w1, w2, c->face[face].rows, &a, &b);
    const float *colour = c->colour + (size_t)at * SL_LATTICE_FLOATS;
    for (int k = 0; k < 3; k++) value[k] = colour[k] + a * colour[3 + k] + b * colour[6 + k];
    return (sl_rgb){value[0], value[1], value[2]};
}

static inline sl_rgb take(gathering *g, const sl_mesh_point *point) {
    return sl_coarse_gather(g->scene, g->gather, point, g->scratch, &g->counters);
}
