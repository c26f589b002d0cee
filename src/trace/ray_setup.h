/* Rays made ready for Embree and for the triangle test, sixteen at a time. Nearly all rays are usual: their
 * numbers are finite, their directions of about unit length, their origins not far from the scene. tracer.c
 * makes usual rays of the others, one by one. */
#pragma once

#include "trace/embree.h"
#include "trace/triangle_test.h"

/* Across the ray a hit is decided within about 3 * 2^-24 of its distance, which a ray's start near the scene
 * bounds by 2.5 diagonals. Near ties differ by the rounding of distances, far below this. */
#define SL_FAR_SLACK 1e-4

/* Directions whose largest component lies between these are usual. */
#define SL_SHORTEST 0x1p-20f
#define SL_LONGEST 0x1p20f

/* The same of all rays. */
typedef struct sl_ray_setup {
    sl_vec3d centre;     /* of the scene */
    double far_squared;  /* origins beyond it are moved nearer */
    double unit;         /* Embree's unit of length over ours */
} sl_ray_setup;

/* Finds which of the first `count` are usual: -1, else 0. Returns how many. */
SL_KERNELS(unsigned, sl_rays_usual,
           (const sl_ray_setup *setup, const sl_ray16 *rays, unsigned count, int *valid));
/* Makes sixteen usual rays, whose `start` is known, ready: all of the state but the frames
 * (sl_ray_frames). */
SL_KERNELS(void, sl_rays_ready,
           (const sl_ray_setup *setup, const sl_ray16 *rays, sl_ray_state *state, struct RTCRay16 *ready));
