/* Colours that are known on all surfaces, as those of multi-mesh caching's coarse mesh: a gather sees them
 * and adds them up on the hardware, times a weight texture; nothing is lit, and emitters are black (their
 * light is direct light), but the environment is not.
 *
 *   known_colours.c           one gather, and an environment that is a picture
 *   known_colours_kernels.c   a picture's pixels: colours between the vertices of a lattice, times weights
 */
#pragma once

#include "base/isa.h"
#include "raster/textures/textures.h"

/* Colours on faces: face 2 t is the front of triangle t, 2 t + 1 its back, and two more are the background.
 * Each is cut into n^2 small triangles, n rows of them, which are numbered from `first`. */
typedef struct sl_face_lattice {
    int32_t first, rows;
} sl_face_lattice;
/* of a small triangle: colour at its corner 0, differences of those at corners 1 and 2 */
enum { SL_LATTICE_FLOATS = 9 };
typedef struct sl_lattice_colours {
    const sl_face_lattice *face;
    const float *colour;
} sl_lattice_colours;

/* Returns the number of the small triangle, in n rows of a face, in which the point with weights w1, w2 of
 * the face's corners 1 and 2 lies; and the weights of its own. Row j holds 2 (n - j) - 1 of them. */
static inline int sl_lattice_locate(float w1, float w2, int n, float *a, float *b) {
    float u = w1 * (float)n, v = w2 * (float)n;
    int j = (int)v;
    j = j < n - 1 ? j : n - 1;
    int last = n - 1 - j, i = (int)u;
    i = i < last ? i : last;
    float x = u - (float)i, y = v - (float)j;
    int on_head = (x + y > 1.0f) & (i < last);
    *a = on_head ? 1.0f - x : x;
    *b = on_head ? 1.0f - y : y;
    return j * (2 * n - j) + 2 * i + on_head;
}

/* Returns the frame of the picture over a point: z its normal. */
sl_frame sl_known_colours_frame(sl_vec3 normal);

/* ---- between the parts ---- */

/* A picture: the pixel in column i and row j looks along x[i] frame.x + y[j width] frame.y + frame.z. */
typedef struct sl_colour_pixels {
    int width, height;
    const uint32_t *id;            /* SL_NO_INDEX: background */
    const float *w1, *w2;          /* where in its triangle: sl_raster_barycentrics() */
    const float *x, *y;
    sl_frame frame;
    sl_vec3 eye;
    sl_vec3 horizon;               /* geometric normal: what lies below its plane is black */
    const sl_scene *scene;
    sl_lattice_colours lattice;
    const float *weight;
    float *radiance[3];            /* planes: the picture */
    float *weighted[3];            /* ... times weights */
} sl_colour_pixels;

SL_KERNELS(void, sl_colour_pixels_shade, (const sl_colour_pixels *pixels));

/* Leaves NULL where there is no environment, or a constant one, which is a face. pixel: the widest one's
 * angle. */
sl_status sl_gather_sky_create(const sl_environment *environment, double pixel, sl_texture_image **sky,
                               sl_error *error);
size_t sl_gather_sky_memory_bytes(const sl_texture_image *sky);
