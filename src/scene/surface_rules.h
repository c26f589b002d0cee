/* The arithmetic of a surface point: how attributes are interpolated, which side is seen, which way normals
 * point. One home for sl_scene_surface(), one point at a time, and for the rasterizer's lanes, which
 * therefore agree to the bit. */
#ifndef SL_SCENE_SURFACE_RULES_H
#define SL_SCENE_SURFACE_RULES_H

#include "base/vec.h"

/* Perspective plays no part: the weights are those of the point on the triangle itself. to_1 and to_2 are the
 * differences of the other two corners' values from the first corner's. */
static inline float sl_interpolate(float first, float to_1, float to_2, float w1, float w2) {
    return first + w1 * to_1 + w2 * to_2;
}

/* 1 where the counter-clockwise side is seen, and edge on; -1 where the other side is. */
static inline float sl_side_seen(sl_vec3 geometric, sl_vec3 to_viewer) {
    return sl_dot(geometric, to_viewer) < 0.0f ? -1.0f : 1.0f;
}

/* The unit shading normal along an interpolated one, in the hemisphere of the geometric normal; that one
 * itself where there is none, or one at right angles: then neither side is right. Turning the geometric
 * normal turns the result. */
static inline sl_vec3 sl_shading_normal(sl_vec3 interpolated, sl_vec3 geometric) {
    sl_vec3 normal = sl_normalize_or(interpolated, geometric);
    float agreement = sl_dot(normal, geometric), turn = agreement < 0.0f ? -1.0f : 1.0f;
    return sl_v3(agreement != 0.0f ? turn * normal.x : geometric.x,
                 agreement != 0.0f ? turn * normal.y : geometric.y,
                 agreement != 0.0f ? turn * normal.z : geometric.z);
}

#endif
