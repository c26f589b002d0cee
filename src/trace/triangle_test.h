/* What is hit: our own ray-triangle test, after Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection" (2013).
 *
 * The triangle's corners are sheared so that the ray runs along an axis. What is left is a question in the plane: does the
 * triangle hold the origin? The sheared corners are floats, the same for every triangle that shares the corner; the
 * three edge functions are differences of two products of floats, taken in double, where the products are exact. So
 * their signs are the signs of the exact edge functions: neighbours see a shared edge from opposite sides with opposite
 * signs, and a ray that meets a closed mesh at an edge or a corner hits at least one triangle there. The distance is a
 * convex combination of the corners' distances, so the hit lies in the triangle's own box however thin the sliver is.
 *
 * Embree only proposes candidates. The best hit is kept here, by ray number. */
#ifndef SL_TRACE_TRIANGLE_TEST_H
#define SL_TRACE_TRIANGLE_TEST_H

#include "base/isa.h"
#include "trace/trace.h"

/* Sixteen rays made ready for the test, and the best hit of each. Distances `near`, `best_t` are the caller's. */
typedef struct sl_ray_state {
    _Alignas(64) float origin_x[SL_PACKET], origin_y[SL_PACKET], origin_z[SL_PACKET];
    /* Rows of the shear: coordinates across the ray are (row_x . p, row_y . p) for p relative to the origin. */
    float row_xx[SL_PACKET], row_xy[SL_PACKET], row_xz[SL_PACKET];
    float row_yx[SL_PACKET], row_yy[SL_PACKET], row_yz[SL_PACKET];
    float along_x[SL_PACKET], along_y[SL_PACKET], along_z[SL_PACKET]; /* 1 on the ray's dominant axis, else 0 */
    double per_distance[SL_PACKET]; /* 1 over the direction's dominant component */
    double start[SL_PACKET];        /* distance by which the origin was moved towards a far-away scene, else 0 */
    float near[SL_PACKET];
    float best_t[SL_PACKET], best_w1[SL_PACKET], best_w2[SL_PACKET];
    uint32_t best_triangle[SL_PACKET], skip[SL_PACKET];
} sl_ray_state;

typedef struct sl_triangle_corners {
    float x[3], y[3], z[3];
} sl_triangle_corners;

/* Candidate hits of consecutive rays. */
typedef struct sl_candidates {
    _Alignas(64) float t[SL_PACKET], w1[SL_PACKET], w2[SL_PACKET];
} sl_candidates;

/* Tests rays [first, first + count) of state. Bit i of the result: ray first + i meets the triangle's plane inside it, at
 * candidates->t[i], whatever near, far and best hit are. The bits do not depend on count. */
typedef uint32_t sl_triangle_test(const sl_ray_state *state, const sl_triangle_corners *corners, unsigned first,
                                  unsigned count, sl_candidates *candidates);

uint32_t sl_triangle_test_baseline(const sl_ray_state *, const sl_triangle_corners *, unsigned, unsigned, sl_candidates *);
uint32_t sl_triangle_test_avx2(const sl_ray_state *, const sl_triangle_corners *, unsigned, unsigned, sl_candidates *);
uint32_t sl_triangle_test_avx512(const sl_ray_state *, const sl_triangle_corners *, unsigned, unsigned, sl_candidates *);

/* Fills the shear of ray i from its origin (already in the state) and direction, whose components must be finite and not
 * all 0. */
void sl_ray_state_shear(sl_ray_state *state, unsigned i, float x, float y, float z);

#endif
