/* Irradiance at a point from colours that are known on all surfaces: the scene as the point sees it under 160
 * degrees, times a weight texture, summed on the hardware. (gather.h: radiance is found where it looks.)
 *
 *   mesh_gather.c           where the point looks from, the render, the sums, what lies beyond the field
 *   mesh_gather_kernels.c   a picture's pixels: colours between the vertices of a lattice, times weights
 *   gather_sky.c            ... and where they show an environment that is a picture */
#ifndef SL_CACHE_MESH_GATHER_H
#define SL_CACHE_MESH_GATHER_H

#include "base/isa.h"
#include "cache/light/light_sample.h"
#include "raster/raster.h"

/* Colours on faces: face 2 t is the front of triangle t, 2 t + 1 its back, and two more are the background.
 * Each is cut into n^2 small triangles, n rows of them, which are numbered from `first`. */
typedef struct sl_face_lattice {
    int32_t first, rows;
} sl_face_lattice;
/* of a small triangle: colour at its corner 0, differences of those at corners 1 and 2; three to spare */
enum { SL_LATTICE_FLOATS = 12 };
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

enum { SL_MESH_GATHER_LEAST = 8 }; /* pixels a side */

typedef struct sl_mesh_gather_settings {
    int size;                  /* N of N x N pixels, a power of two from SL_MESH_GATHER_LEAST on */
    float fov;                 /* radians, both ways */
} sl_mesh_gather_settings;
typedef struct sl_mesh_gather sl_mesh_gather;
/* Emitters are black in it (their light is direct light), the environment is not. Scene, raster and
 * colours must outlive it. */
sl_status sl_mesh_gather_create(const sl_scene *scene, const sl_raster *raster,
                                const sl_lattice_colours *colours, const sl_mesh_gather_settings *settings,
                                sl_mesh_gather **gather, sl_error *error);
void sl_mesh_gather_destroy(sl_mesh_gather *gather);
size_t sl_mesh_gather_memory_bytes(const sl_mesh_gather *gather);
typedef struct sl_mesh_gather_scratch sl_mesh_gather_scratch;
sl_status sl_mesh_gather_scratch_create(const sl_mesh_gather *gather, sl_mesh_gather_scratch **scratch,
                                        sl_error *error);
void sl_mesh_gather_scratch_destroy(sl_mesh_gather_scratch *scratch);
/* Returns E_i in W/m^2, a pure function of the point, a face that it lies on (SL_NO_INDEX: none) and the
 * colours. Counts SL_COUNT_INDIRECT_SAMPLES. */
sl_rgb sl_mesh_gather_take(const sl_mesh_gather *gather, const sl_lit_point *point, uint32_t face,
                           sl_mesh_gather_scratch *scratch, sl_counters *counters);
/* Gives the picture of the last one, before weights: N x N, bottom row first; for observers and tests. */
void sl_mesh_gather_picture(const sl_mesh_gather_scratch *scratch, int *size, const float *planes[3]);
/* Returns the frame of that picture: z the point's normal. */
sl_frame sl_mesh_gather_frame(sl_vec3 normal);

/* ---- between the parts ---- */

/* of a triangle: its corner 0, edges from there to corners 1 and 2; three to spare */
enum { SL_MESH_GATHER_FLOATS = 12 };

/* A picture: pixel (i, j) looks along x[i] frame.x + y[j] frame.y + frame.z. */
typedef struct sl_mesh_gather_pixels {
    int width, height;             /* width is a multiple of four */
    const uint32_t *id;            /* SL_NO_INDEX: background */
    const float *x, *y;
    sl_frame frame;
    sl_vec3 eye;
    sl_vec3 horizon;               /* geometric normal: what lies below its plane is black */
    /* by scene triangle, SL_MESH_GATHER_FLOATS each; then one more, all 0, for the background */
    const float *triangle;
    uint32_t triangle_count;
    sl_lattice_colours colours;
    const float *weight;
    float *radiance[3];            /* planes: the picture */
    float *weighted[3];            /* ... times weights */
} sl_mesh_gather_pixels;

typedef void sl_mesh_gather_kernel(const sl_mesh_gather_pixels *pixels);
SL_KERNEL_VARIANTS(sl_mesh_gather_kernel, sl_mesh_gather_shade);

static inline sl_mesh_gather_kernel *sl_mesh_gather_kernel_for(sl_isa isa) {
    return SL_KERNEL_OF(isa, sl_mesh_gather_shade);
}

typedef struct sl_gather_sky sl_gather_sky;
/* pixel: the widest one's angle. NULL with SL_OK where there is no environment, or a constant one. */
sl_status sl_gather_sky_create(const sl_environment *environment, double pixel, sl_gather_sky **sky,
                               sl_error *error);
void sl_gather_sky_destroy(sl_gather_sky *sky);
size_t sl_gather_sky_memory_bytes(const sl_gather_sky *sky);
/* Gives radiance, plain and weighted, of pixels that show nothing. */
void sl_gather_sky_add(const sl_gather_sky *sky, const sl_mesh_gather_pixels *pixels);

#endif
