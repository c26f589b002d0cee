/* Photons strewn by hand, and lights of voxels made from them. */
#pragma once

#include "light_octree_support.h"

#include "base/memory.h"

/* ---- photons ---- */

static inline sl_photon_list *new_list(size_t room) {
    sl_photon_list *list = sl_allocate(1, sizeof *list);
    assert_non_null(list);
    list->photon = sl_allocate(room, sizeof *list->photon);
    assert_non_null(list->photon);
    list->emitted = 1;
    return list;
}

static inline void strew(sl_photon_list *list, sl_vec3 at, sl_vec3 direction, sl_vec3 normal, float flux) {
    list->photon[list->count++] = (sl_photon){{at.x, at.y, at.z},
                                              {flux, 0.5f * flux, 0.25f * flux},
                                              sl_octahedral_encode(direction),
                                              sl_octahedral_encode(normal),
                                              1};
}

/* About a normal, by the cosine law: an even sky. */
static inline sl_vec3 cosine_about(sl_vec3 normal, uint64_t key, uint64_t i) {
    float s = sl_random_unit(key, 2 * i), sine, cosine, r = sqrtf(s);
    sl_sincos_turnf(sl_random_unit(key, 2 * i + 1), &sine, &cosine);
    sl_frame frame = sl_frame_from_normal(normal);
    return sl_frame_to_world(&frame, sl_v3(r * cosine, r * sine, sqrtf(1.0f - s)));
}

/* Irradiance e (red) on a parallelogram's side that `normal` is on. */
static inline void strew_evenly(sl_photon_list *list, size_t count, sl_vec3 corner, sl_vec3 a, sl_vec3 b,
                                sl_vec3 normal, float e, uint64_t seed) {
    uint64_t key = sl_random_key(seed, 0), more = sl_random_key(seed, 1);
    float area = sl_length(sl_cross(a, b));
    for (uint64_t i = 0; i < count; i++) {
        sl_vec3 at = sl_mad(sl_mad(corner, sl_random_unit(key, 2 * i), a), sl_random_unit(key, 2 * i + 1), b);
        strew(list, at, cosine_about(normal, more, i), normal, e * area / (float)count);
    }
}

typedef struct lit {
    sl_octree *octree;
    sl_photon_tree *tree;
    sl_voxel_lights *lights;
    sl_counters counters;
} lit;

static inline lit light_up(const sl_scene *scene, int depth, sl_photon_list *list,
                           const sl_light_octree_settings *options, unsigned threads) {
    lit l = {.octree = octree_of(scene, depth, 1)};
    sl_error error;
    if (sl_photon_tree_create(list, 1, &l.tree, &error) != SL_OK) fail_msg("%s", error.message);
    if (sl_voxel_lights_create(scene, l.octree, l.tree, options, threads, &l.lights, &error) !=
        SL_OK)
        fail_msg("%s", error.message);
    sl_voxel_lights_compute(l.lights, 0, l.octree->leaf_count, threads, &l.counters);
    return l;
}

static inline void end_lit(lit *l) {
    sl_voxel_lights_destroy(l->lights);
    sl_photon_tree_destroy(l->tree);
    sl_octree_destroy(l->octree);
}

/* sum c (n . d)+ of a set's lights, red. */
static inline double irradiance_on(const sl_voxel_lights *lights, size_t set, sl_vec3 normal) {
    double sum = 0.0;
    for (int j = 0; j < lights->texels; j++) {
        const sl_directional_light *light = &lights->light[set * (size_t)lights->texels + (size_t)j];
        double cosine = (double)sl_dot(normal, sl_direction_unpack(light->packed));
        sum += cosine > 0.0 ? cosine * (double)light->color[0] : 0.0;
    }
    return sum;
}

static inline void add_quad(float *xyz, size_t at, sl_vec3 corner, sl_vec3 a, sl_vec3 b) {
    sl_vec3 p[4] = {corner, sl_add(corner, a), sl_add(sl_add(corner, a), b), sl_add(corner, b)};
    const int order[6] = {0, 1, 2, 0, 2, 3};
    for (int k = 0; k < 6; k++) memcpy(&xyz[9 * at + 3 * (size_t)k], &p[order[k]], sizeof *p);
}

/* A floor of 4 x 4, facing up. */
static inline sl_scene *floor_of_four(void) {
    float xyz[18];
    add_quad(xyz, 0, sl_v3(0, 0, 0), sl_v3(0, 0, 4), sl_v3(4, 0, 0));
    return scene_of_triangles(xyz, 2);
}

/* Photons of irradiance e on it. */
static inline sl_photon_list *even_floor(size_t count, float e, uint64_t seed) {
    sl_photon_list *list = new_list(count);
    strew_evenly(list, count, sl_v3(0, 0, 0), sl_v3(0, 0, 4), sl_v3(4, 0, 0), sl_v3(0, 1, 0), e, seed);
    return list;
}
