/* The film of the reference path tracers: where its rays leave, places of samples in its pixels, and sums. */
#pragma once

#include "base/choices.h"
#include "scene/scene.h"

/* Where the rays of a film leave: tangents of half its fields of view. */
typedef struct sl_path_lens {
    int width, height;
    float tan_x, tan_y;
} sl_path_lens;

/* A place on the film, in pixels from its upper left corner; and seen from the eye, at distance 1. */
typedef struct sl_path_place {
    float x, y;
} sl_path_place;
typedef struct sl_path_tangents {
    float x, y;
} sl_path_tangents;

sl_path_lens sl_path_lens_of(const sl_scene *scene, int width, int height);
sl_path_tangents sl_path_lens_tangents(const sl_path_lens *lens, sl_path_place place);
sl_vec3 sl_path_lens_direction(const sl_scene *scene, sl_path_tangents tangents);

/* Pixel filters by the places of samples: where the filter weighs more, more of them lie, and all of them
 * weigh the same (Ernst, Stamminger, Greiner, "Filter Importance Sampling", 2006). */
enum { SL_FILTER_STEPS = 128 };

typedef struct sl_pixel_shape {
    sl_pixel_filter filter;
    float radius; /* of its support, in pixels; 0.5 of a box, 0 of a centre */
    /* Blackman-Harris: the inverse of its integral, offsets from the centre */
    float offset[SL_FILTER_STEPS + 1];
} sl_pixel_shape;

/* radius: of Blackman-Harris alone. */
sl_pixel_shape sl_pixel_shape_of(sl_pixel_filter filter, double radius);
/* Turns point, two numbers in [0,1), into a place from the pixel's corner on, which may lie in others. */
void sl_pixel_shape_place(const sl_pixel_shape *shape, float point[2]);

/* Sums: even and odd samples apart, two independent pictures whose difference is the noise. */
enum { SL_HALVES = 2 };

typedef struct sl_halves {
    size_t pixels;
    double *sums[SL_HALVES]; /* R, G, B planes */
    uint64_t samples[SL_HALVES];
} sl_halves;

sl_status sl_halves_create(sl_halves *halves, size_t pixels, sl_error *error);
void sl_halves_release(sl_halves *halves);
size_t sl_halves_memory_bytes(const sl_halves *halves);
static inline void sl_halves_add(const sl_halves *h, unsigned half, size_t pixel, sl_rgb light) {
    double *sums = h->sums[half];
    sums[pixel] += (double)light.r;
    sums[h->pixels + pixel] += (double)light.g;
    sums[2 * h->pixels + pixel] += (double)light.b;
}
/* R, G, B planes, each may be NULL; half -1: of all samples. */
void sl_halves_mean(const sl_halves *halves, int half, float *r, float *g, float *b);
