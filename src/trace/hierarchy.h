/* What the tracer is made of: Embree's hierarchy, and where the triangles are that it proposes. Objects that
 * are copies of one mesh share a hierarchy (copies.h); all other triangles lie in one of their own. */
#pragma once

#include <stdatomic.h>

#include "trace/copies.h"
#include "trace/ray_setup.h"
#include "trace/trace.h"
#include "trace/triangle_test.h"

/* Small, so that those of one leaf lie in few cache lines. */
typedef struct sl_placed_triangle {
    sl_triangle_corners corners;
    uint32_t index; /* in the scene */
} sl_placed_triangle;

/* A user geometry of Embree's, a primitive a triangle: those of the scene that are placed, or those of a mesh
 * with copies, by their numbers in it. */
typedef struct sl_traced_part {
    const sl_tracer *tracer;
    size_t count;
    sl_placed_triangle *placed;
    uint32_t *order;
    uint32_t first;  /* of the mesh */
    float inflation; /* of boxes */
    RTCScene scene;  /* of the mesh */
} sl_traced_part;

struct sl_tracer {
    const sl_scene *scene;
    RTCDevice device;
    RTCScene hierarchy;
    sl_traced_part plain;
    sl_copies copies;
    sl_traced_part *meshes;
    bool any_alpha;
    float unit;      /* Embree's unit of length over ours, a power of two; 1 but for astronomical scenes */
    float inflation;
    sl_vec3d centre;
    double diagonal;
    sl_isa isa;
    sl_ray_setup setup;
    atomic_llong embree_bytes;
};

void sl_intersect_callback(const struct RTCIntersectFunctionNArguments *arguments);
void sl_occluded_callback(const struct RTCOccludedFunctionNArguments *arguments);

/* Origins beyond this are far from the scene. */
static inline double sl_tracer_far_squared(const sl_tracer *tracer) {
    return 4.0 * tracer->diagonal * tracer->diagonal;
}

static inline void sl_scene_corners(const sl_scene *s, uint32_t triangle, sl_triangle_corners *c) {
    for (int k = 0; k < 3; k++) {
        const sl_vec3 p = sl_scene_position(s, s->vertex[k][triangle]);
        c->p[0][k] = p.x;
        c->p[1][k] = p.y;
        c->p[2][k] = p.z;
    }
}
