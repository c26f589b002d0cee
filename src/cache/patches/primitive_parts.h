/* Between primitives.c, primitive_points.c and primitive_edges.c. */
#pragma once

#include "cache/patches/primitives.h"

/* Do shading normals agree so far that shading at them is one? Within 1e-4. */
bool sl_same_normal(sl_vec3 a, sl_vec3 b);

static inline int sl_primitive_corners(const sl_primitives *p, uint32_t primitive) {
    return p->kind[primitive] == SL_PRIMITIVE_TRIANGLE ? 3 : 4;
}

/* (u, v) of edge `edge` at t, from corner `edge` (t = 0) to the next (t = SL_PATCH_DYADIC). */
void sl_edge_point(int corners, int edge, uint32_t t, uint32_t *u, uint32_t *v);
/* Returns the edge on which (u, v) lies, and t there; corners are on the edge that begins with them. -1:
 * inside. */
int sl_edge_at(int corners, uint32_t u, uint32_t v, uint32_t *t);

/* From t on an edge (4 primitive + edge) to the way that its ring agrees on, and back. */
static inline uint32_t sl_edge_along(const sl_primitives *p, uint32_t code, uint32_t t) {
    return p->edge_kind[code] & SL_EDGE_BACKWARDS ? SL_PATCH_DYADIC - t : t;
}

/* Finds which edges and corners are one. */
sl_status sl_primitives_join(sl_primitives *primitives, sl_error *error);
