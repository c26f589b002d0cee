/* Shared by the light octree's tests: octrees of scenes, and lights of voxels made by hand. */
#pragma once

#include "raster_support.h"

#include <math.h>

#include "base/math.h"
#include "cache/light_octree/shade.h"
#include "cache/light_octree/octree.h"
#include "trace_scenes.h"

/* A sphere in the middle of a root of 2 x 2 x 2, in two corners of which lies an outlier. */
static inline sl_scene *sphere_in_a_root(unsigned rings, float radius) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t low = trace_mesh_vertex(&mesh, -1, -1, -1), high = trace_mesh_vertex(&mesh, 1, 1, 1);
    trace_mesh_triangle(&mesh, low, trace_mesh_vertex(&mesh, -0.999f, -1, -1),
                        trace_mesh_vertex(&mesh, -1, -0.999f, -1), 0);
    trace_mesh_triangle(&mesh, high, trace_mesh_vertex(&mesh, 0.999f, 1, 1),
                        trace_mesh_vertex(&mesh, 1, 0.999f, 1), 0);
    trace_mesh_sphere(&mesh, sl_v3(0, 0, 0), radius, rings, 0.0f, false, trace_mesh_diffuse(&mesh, 0.5f));
    return trace_mesh_build(&mesh);
}

static inline sl_octree *octree_of(const sl_scene *scene, int depth, unsigned threads) {
    sl_octree *octree = NULL;
    sl_error error;
    sl_octree_root root = sl_octree_root_of_all(scene);
    if (sl_octree_create(scene, &root, depth, 0.0, threads, &octree, &error) != SL_OK)
        fail_msg("%s", error.message);
    return octree;
}

/* The number of the leaf with that Morton code, or SL_NO_INDEX; and of that which holds a point. */
static inline uint32_t leaf_of(const sl_octree *octree, uint64_t morton) {
    size_t leaf = sl_octree_lower_bound(octree, 0, octree->leaf_count, morton);
    return leaf < octree->leaf_count && octree->leaf[leaf].morton == morton ? (uint32_t)leaf : SL_NO_INDEX;
}

static inline uint32_t leaf_at(const sl_octree *octree, sl_vec3 p) {
    return leaf_of(octree, sl_octree_morton_at(octree, p));
}

static inline sl_light_octree_settings plain_options(int lights) {
    return (sl_light_octree_settings){
        .neighbours = 50, .radius = 1.0, .flatness = 0.25, .acceptance = SL_PI / 3.0, .lights = lights,
        .whole_voxels = true};
}

/* All dark, without photons. */
static inline sl_voxel_lights *lights_of(const sl_scene *scene, const sl_octree *octree,
                                         const sl_light_octree_settings *options) {
    sl_voxel_lights *lights = NULL;
    sl_error error;
    if (sl_voxel_lights_create(scene, octree, NULL, options, 1, &lights, &error) != SL_OK)
        fail_msg("%s", error.message);
    return lights;
}

static inline sl_voxel_lights *whole_voxels(const sl_scene *scene, const sl_octree *octree, int lights) {
    const sl_light_octree_settings options = plain_options(lights);
    return lights_of(scene, octree, &options);
}

static inline void assert_same_lights(const sl_voxel_lights *a, const sl_voxel_lights *b) {
    assert_memory_equal(a->light, b->light, a->set_count * (size_t)a->texels * sizeof *a->light);
    assert_memory_equal(a->set, b->set, a->set_count * sizeof *a->set);
}

static inline sl_voxel_texture *texture_of(const sl_octree *octree, const sl_voxel_lights *lights) {
    sl_voxel_texture *texture = NULL;
    sl_error error;
    if (sl_voxel_texture_create(octree, lights, &texture, &error) != SL_OK)
        fail_msg("%s", error.message);
    return texture;
}

/* Destroys a scene and all that was made of it; texture may be NULL. */
static inline void destroy_octree(sl_scene *scene, sl_octree *octree, sl_voxel_lights *lights,
                                  sl_voxel_texture *texture) {
    sl_voxel_texture_destroy(texture);
    sl_voxel_lights_destroy(lights);
    sl_octree_destroy(octree);
    sl_scene_destroy(scene);
}

/* Descends to a point: the place of its leaf's first texel, or SIZE_MAX. */
static inline size_t find_at(const sl_voxel_texture *t, sl_vec3d p, uint64_t *fetches) {
    double cells = (double)(1u << t->depth) / t->edge;
    const int32_t cell[3] = {(int32_t)floor((p.x - t->origin.x) * cells),
                             (int32_t)floor((p.y - t->origin.y) * cells),
                             (int32_t)floor((p.z - t->origin.z) * cells)};
    return sl_voxel_texture_find(t, cell, fetches);
}

static inline void set_light(sl_voxel_lights *lights, size_t set, int which, sl_vec3d direction, float r,
                             float g, float b) {
    lights->light[set * (size_t)lights->texels + (size_t)which] =
        (sl_directional_light){{r, g, b}, sl_direction_pack(direction)};
    if (lights->set[set].lights <= which) lights->set[set].lights = (uint8_t)(which + 1);
}

/* Points in a list, and what they send to the eye, three floats each. */
typedef struct listed_points {
    const sl_octree_point *point;
    float *rgb;
} listed_points;

static inline bool find_listed(const void *context, size_t i, sl_octree_point *point) {
    *point = ((const listed_points *)context)->point[i];
    return true;
}

static inline void put_listed(void *context, size_t i, const float rgb[3]) {
    memcpy(((listed_points *)context)->rgb + 3 * i, rgb, 3 * sizeof *rgb);
}

static inline sl_counters shade_listed(const sl_octree_shading *shading, const sl_octree_point *point,
                                       size_t count, unsigned threads, float *rgb) {
    listed_points list = {point, rgb};
    const sl_octree_points points = {count, find_listed, put_listed, &list};
    sl_counters counters = {{0}};
    assert_int_equal(sl_octree_shade(shading, &points, threads, &counters, NULL), SL_OK);
    return counters;
}

/* Irradiance of a surface point, and what it counts. */
static inline sl_counters shade_point(const sl_octree_shading *shading, sl_vec3 at, sl_vec3 normal,
                                      float rgb[3]) {
    sl_octree_point p = {.position = at, .normal = normal, .view = normal, .diffuse = sl_grey((float)SL_PI)};
    return shade_listed(shading, &p, 1, 1, rgb);
}

/* A point of a triangle. */
static inline sl_vec3 random_on(const sl_scene *scene, uint64_t key, uint64_t index, uint32_t *triangle) {
    *triangle = sl_random_bits(key, 3 * index) % (uint32_t)scene->triangle_count;
    float a = sl_random_unit(key, 3 * index + 1), b = sl_random_unit(key, 3 * index + 2);
    if (a + b > 1.0f) {
        a = 1.0f - a;
        b = 1.0f - b;
    }
    sl_vec3 p0 = sl_scene_position(scene, scene->vertex[0][*triangle]),
            p1 = sl_scene_position(scene, scene->vertex[1][*triangle]),
            p2 = sl_scene_position(scene, scene->vertex[2][*triangle]);
    return sl_add(sl_add(sl_scale(p0, 1.0f - a - b), sl_scale(p1, a)), sl_scale(p2, b));
}
