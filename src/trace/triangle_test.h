/* Our own ray-triangle test decides what is hit, after Woop, Benthin and Wald, "Watertight Ray/Triangle
 * Intersection" (2013).
 *
 * The triangle's corners are sheared so that the ray runs along an axis. What is left is a question in the
 * plane: does the triangle hold the origin? The sheared corners are floats, the same for every triangle that
 * shares the corner; the three edge functions are differences of two products of floats, taken in double,
 * where the products are exact. So their signs are the signs of the exact edge functions: neighbours see a
 * shared edge from opposite sides with opposite signs, and a ray that meets a closed mesh at an edge or a
 * corner hits at least one triangle there. The distance is a convex combination of the corners' distances, so
 * the hit lies in the triangle's own box however thin the sliver is.
 *
 * Embree only proposes candidates. The best hit is kept here, by ray number. */
#pragma once

#include "base/isa.h"
#include "trace/trace.h"

/* Sixteen rays made ready for the test, and the best hit of each. Distances are in units of the direction.
 * Axis 3 of a ray is the dominant one of its direction, axes 1 and 2 follow it in cyclic order. */
typedef struct sl_ray_state {
    _Alignas(64) float origin_1[SL_PACKET], origin_2[SL_PACKET], origin_3[SL_PACKET];
    /* across the ray: (x1 + shear_1 x3, x2 + shear_2 x3), x relative to the origin */
    float shear_1[SL_PACKET], shear_2[SL_PACKET];
    double per_distance[SL_PACKET]; /* 1 over the direction's dominant component */
    /* distance by which the origin was moved towards a far-away scene, else 0 */
    double start[SL_PACKET];
    float near[SL_PACKET];
    float best_t[SL_PACKET], best_w1[SL_PACKET], best_w2[SL_PACKET];
    uint32_t best_triangle[SL_PACKET], skip[SL_PACKET];
    uint32_t with_axis[3];          /* bit i of entry k: ray i's dominant axis is k */
} sl_ray_state;

typedef struct sl_triangle_corners {
    float p[3][3]; /* by axis, then corner */
} sl_triangle_corners;

/* Candidate hits: entry i belongs to ray id[i]. */
typedef struct sl_candidates {
    float t[SL_PACKET], w1[SL_PACKET], w2[SL_PACKET];
} sl_candidates;

/* Tests the rays id[i] of state for which valid[i] is not 0, i < n <= 16. Bit i of the result: ray id[i]
 * meets the triangle, at candidates->t[i], whatever near, far and best hit are. A ray's bits do not depend on
 * its company. */
SL_KERNELS(uint32_t, sl_triangle_test,
           (const sl_ray_state *state, const sl_triangle_corners *corners, const int *valid,
            const unsigned *id, unsigned n, sl_candidates *candidates));

/* Sets origins, shears and dominant axes of sixteen rays, whose directions are finite and not 0. The dominant
 * component is what the others are divided by, so that a shear's entries are at most 1. */
SL_KERNELS(void, sl_ray_frames, (sl_ray_state *state, const sl_ray16 *rays));
