/* Random walks from the eye, sixteen at a time, counting exactly the light paths of an sl_transport. */
#ifndef SL_TRACE_PATH_WALK_H
#define SL_TRACE_PATH_WALK_H

#include "trace/pixel_filter.h"
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
/* Sets ray i. */
void sl_path_lens_ray(const sl_scene *scene, const sl_path_lens *lens, sl_path_place place, sl_ray16 *rays,
                      unsigned i);
/* A place for pixel (x, y): where, point (key, ., index) and the transport's filter say. */
sl_path_place sl_path_place_in(const sl_path_walk *walk, int x, int y, uint64_t key, uint32_t index);
/* A sample that is not a number would spoil its pixel for good. */
sl_rgb sl_path_finite_or_black(sl_rgb radiance, sl_counters *counters);

#endif
