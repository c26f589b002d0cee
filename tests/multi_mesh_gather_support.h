/* What tests of coarse meshes and gathers share. */
#ifndef TESTS_MULTI_MESH_GATHER_SUPPORT_H
#define TESTS_MULTI_MESH_GATHER_SUPPORT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/math.h"
#include "base/memory.h"
#include "cache/multi_mesh/gather.h"
#include "trace_scenes.h"

/* Faces that share the scene's own vertices, each side for itself: no welding by position, which is topology.c's task. */
static inline sl_topology *plain_topology(const sl_scene *scene) {
    sl_topology *t = sl_allocate(1, sizeof *t);
    assert_non_null(t);
    t->scene = scene;
    t->face_count = 2 * scene->triangle_count;
    t->site_count = 2 * scene->vertex_count;
    t->degenerate = sl_allocate(scene->triangle_count, 1);
    t->solid = sl_allocate(scene->triangle_count, 1);
    uint32_t(*ends)[2] = sl_allocate(3 * t->face_count, sizeof *ends);
    for (int k = 0; k < 3; k++) {
        t->site[k] = sl_allocate(t->face_count, sizeof *t->site[k]);
        t->edge[k] = sl_allocate(t->face_count, sizeof *t->edge[k]);
        for (uint32_t f = 0; f < t->face_count; f++) t->site[k][f] = 2 * scene->vertex[k][f / 2] + f % 2;
    }
    for (uint32_t f = 0; f < t->face_count; f++) {
        for (int k = 0; k < 3; k++) {
            uint32_t a = t->site[(k + 1) % 3][f], b = t->site[(k + 2) % 3][f], low = a < b ? a : b, high = a < b ? b : a;
            size_t e = 0;
            while (e < t->edge_count && (ends[e][0] != low || ends[e][1] != high)) e++;
            if (e == t->edge_count) {
                ends[e][0] = low;
                ends[e][1] = high;
                t->edge_count++;
            }
            t->edge[k][f] = (uint32_t)e;
        }
    }
    sl_free(ends);
    return t;
}

static inline void plain_topology_destroy(sl_topology *t) {
    for (int k = 0; k < 3; k++) {
        sl_free(t->site[k]);
        sl_free(t->edge[k]);
    }
    sl_free(t->degenerate);
    sl_free(t->solid);
    sl_free(t);
}

/* A scene with all that a gather needs. */
typedef struct gathering {
    sl_scene *scene;
    sl_topology *topology;
    sl_raster *raster;
    sl_coarse *coarse;
    sl_mesh_gather *gather;
    sl_mesh_gather_scratch *scratch;
    sl_counters counters;
} gathering;

static inline sl_mesh_gather_settings usual_settings(void) {
    return (sl_mesh_gather_settings){.size = 128, .reduced = 16, .fov = (float)(160.0 / 180.0 * SL_PI)};
}

/* Takes the scene over. */
static inline gathering gathering_of(sl_scene *scene, float edge, int depth, const sl_mesh_gather_settings *settings) {
    gathering g = {.scene = scene, .topology = plain_topology(scene)};
    sl_coarse_settings coarse = {edge, depth};
    assert_int_equal(sl_raster_create(scene, 1, &g.raster, NULL), SL_OK);
    assert_int_equal(sl_coarse_create(scene, g.topology, &coarse, &g.coarse, NULL), SL_OK);
    assert_int_equal(sl_mesh_gather_create(scene, g.raster, g.coarse, settings, &g.gather, NULL), SL_OK);
    assert_int_equal(sl_mesh_gather_scratch_create(g.gather, &g.scratch, NULL), SL_OK);
    return g;
}

static inline void gathering_destroy(gathering *g) {
    sl_mesh_gather_scratch_destroy(g->scratch);
    sl_mesh_gather_destroy(g->gather);
    sl_coarse_destroy(g->coarse);
    sl_raster_destroy(g->raster);
    plain_topology_destroy(g->topology);
    sl_scene_destroy(g->scene);
}

static inline void set_all(gathering *g, sl_rgb value) {
    for (size_t v = 0; v < sl_coarse_vertex_count(g->coarse); v++) sl_coarse_set(g->coarse, v, value);
    sl_coarse_finish(g->coarse, 1);
}

/* A point in free space. */
static inline sl_mesh_point free_point(sl_vec3 position, sl_vec3 normal) {
    return (sl_mesh_point){position, normal, normal, SL_NO_INDEX, SL_NO_INDEX};
}

/* A point of a face. */
static inline sl_mesh_point face_point(const sl_scene *scene, uint32_t face, float w1, float w2) {
    sl_vec3 a = sl_scene_position(scene, scene->vertex[0][face / 2]), b = sl_scene_position(scene, scene->vertex[1][face / 2]);
    sl_vec3 c = sl_scene_position(scene, scene->vertex[2][face / 2]);
    sl_vec3 normal = sl_scale(sl_scene_geometric_normal(scene, face / 2), face % 2 ? -1.0f : 1.0f);
    return (sl_mesh_point){sl_mad(sl_mad(a, w1, sl_sub(b, a)), w2, sl_sub(c, a)), normal, normal, face / 2, face};
}

static inline sl_rgb take(gathering *g, const sl_mesh_point *point) { return sl_mesh_gather_take(g->gather, point, g->scratch, &g->counters); }

#endif
