/* The arithmetic of a surface point: how attributes are interpolated, which side is seen, which way normals
 * point. One home for sl_scene_surface(), one point at a time, and for the rasterizer's lanes, which
 * therefore agree to the bit. */
#pragma once

#include "scene/scene.h"

/* Perspective plays no part: the weights are those of the point on the triangle itself. to_1 and to_2 are the
 * differences of the other two corners' values from the first corner's. */
static inline float sl_interpolate(float first, float to_1, float to_2, float w1, float w2) {
    return first + w1 * to_1 + w2 * to_2;
}

/* Of what the corners of a triangle have, in an array of all vertices. */
static inline float sl_interpolate_at(const sl_scene *s, const float *values, uint32_t triangle, float w1,
                                      float w2) {
    const float first = values[s->vertex[0][triangle]];
    return sl_interpolate(first, values[s->vertex[1][triangle]] - first,
                          values[s->vertex[2][triangle]] - first, w1, w2);
}
static inline sl_vec3 sl_position_at(const sl_scene *s, uint32_t triangle, float w1, float w2) {
    return sl_v3(sl_interpolate_at(s, s->position_x, triangle, w1, w2),
                 sl_interpolate_at(s, s->position_y, triangle, w1, w2),
                 sl_interpolate_at(s, s->position_z, triangle, w1, w2));
}
static inline sl_vec3 sl_vertex_normal_at(const sl_scene *s, uint32_t triangle, float w1, float w2) {
    return sl_v3(sl_interpolate_at(s, s->normal_x, triangle, w1, w2),
                 sl_interpolate_at(s, s->normal_y, triangle, w1, w2),
                 sl_interpolate_at(s, s->normal_z, triangle, w1, w2));
}
typedef struct sl_texture_place {
    float u, v;
} sl_texture_place;
static inline sl_texture_place sl_texture_place_at(const sl_scene *s, uint32_t triangle, float w1, float w2) {
    return (sl_texture_place){sl_interpolate_at(s, s->texture_u, triangle, w1, w2),
                              sl_interpolate_at(s, s->texture_v, triangle, w1, w2)};
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
