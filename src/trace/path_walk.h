/* Random walks from the eye, sixteen at a time, counting exactly the light paths of an sl_transport. */
#pragma once

#include "trace/film.h"
#include "trace/walker.h"

typedef struct sl_path_walk {
    const sl_scene *scene;
    const sl_tracer *tracer;
    const sl_light_sampler *lights;
    const sl_sequence *sequence;
    sl_transport transport;
    sl_pixel_shape shape; /* of the transport's filter */
} sl_path_walk;

/* Radiance along the first count rays (near, far and skip are theirs). Ray i uses the points (key[i], .,
 * index). */
void sl_path_walk_radiance(const sl_path_walk *walk, const sl_ray16 *rays, unsigned count, bool coherent,
                           const uint64_t key[SL_PACKET], uint32_t index, sl_rgb radiance[SL_PACKET],
                           sl_counters *counters);

/* Sets ray i. */
void sl_path_lens_ray(const sl_scene *scene, const sl_path_lens *lens, sl_path_place place, sl_ray16 *rays,
                      unsigned i);
/* A place for pixel (x, y): where, point (key, ., index) and the transport's filter say. */
sl_path_place sl_path_place_in(const sl_path_walk *walk, int x, int y, uint64_t key, uint32_t index);
/* A sample that is not a number would spoil its pixel for good. */
sl_rgb sl_path_finite_or_black(sl_rgb radiance, sl_counters *counters);

/* A lamp is hundreds of times as bright as what it lights, so at its rim nearly all noise of a pixel is that
 * of how much of the lamp is in it. There walks leave out what the eye itself sees of lamps (L S* E), and
 * sixteen rays for each of them look for nothing else. */
typedef struct sl_path_lamps {
    sl_path_walk lamps, rest; /* what the eye sees of lamps; and all other light */
} sl_path_lamps;

typedef struct sl_path_lamp_view {
    sl_rgb mean;
    float low, high; /* luminance */
} sl_path_lamp_view;

sl_path_lamps sl_path_lamps_of(const sl_path_walk *walk);
/* Looks through sixteen places of the square of that side at (x, y), in pixels; with other points than the
 * walks of that key. walk: of an sl_path_lamps, for lamps. */
sl_path_lamp_view sl_path_see_lamps(const sl_path_walk *walk, const sl_path_lens *lens, int x, int y,
                                    float side, uint64_t key, uint32_t index, sl_counters *counters);
