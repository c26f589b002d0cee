/* Rays. Embree (3 or 4, behind trace/embree.h) builds the hierarchy and walks it; our own test decides what
 * is hit: edge functions whose signs are exact (watertight), distances that stay inside the triangle, lower
 * triangle index on a tie. So hits are the same bits on every instruction set and in every packet shape. */
#pragma once

#include "scene/scene.h"

typedef struct sl_tracer sl_tracer;

/* The scene must outlive it. embree_config: as rtcNewDevice takes it ("isa=sse2"), or NULL; threads for the
 * build. */
sl_status sl_tracer_create(const sl_scene *scene, unsigned threads, const char *embree_config,
                           sl_tracer **tracer, sl_error *error);
/* The same where copies of meshes (copies.h) share a hierarchy that saves so many triangles, or more. */
sl_status sl_tracer_create_sharing(const sl_scene *scene, unsigned threads, const char *embree_config,
                                   size_t worth, sl_tracer **tracer, sl_error *error);
void sl_tracer_destroy(sl_tracer *tracer);
size_t sl_tracer_memory_bytes(const sl_tracer *tracer);
/* The most that one takes while it is made. */
double sl_tracer_memory_need(const sl_scene *scene);

enum { SL_PACKET = 16 };

typedef struct sl_ray16 {
    _Alignas(64) float origin_x[SL_PACKET], origin_y[SL_PACKET], origin_z[SL_PACKET];
    /* any length > 0; distances are in its units */
    float direction_x[SL_PACKET], direction_y[SL_PACKET], direction_z[SL_PACKET];
    float near[SL_PACKET], far[SL_PACKET]; /* a hit counts for near < t < far; far may be infinite */
    uint32_t skip[SL_PACKET]; /* a triangle that is not hit (the ray's own), or SL_NO_INDEX */
} sl_ray16;

static inline void sl_ray16_set(sl_ray16 *rays, unsigned i, sl_vec3 origin, sl_vec3 direction, float near,
                                float far, uint32_t skip) {
    rays->origin_x[i] = origin.x, rays->origin_y[i] = origin.y, rays->origin_z[i] = origin.z;
    rays->direction_x[i] = direction.x, rays->direction_y[i] = direction.y,
    rays->direction_z[i] = direction.z;
    rays->near[i] = near;
    rays->far[i] = far;
    rays->skip[i] = skip;
}

/* A shadow ray from a surface to a light `to_light` away, or far away in that direction. It starts `offset`
 * off the surface and aims at the light itself from there, so that a near light's own surface cannot come
 * between; its end stops short of the light: beside it, the ray could end behind. */
static inline void sl_ray16_set_shadow(sl_ray16 *rays, unsigned i, sl_vec3 position, sl_vec3 geometric_normal,
                                       float offset, sl_vec3 to_light, bool far_away, uint32_t skip) {
    sl_vec3 shift = sl_scale(geometric_normal, offset);
    sl_ray16_set(rays, i, sl_add(position, shift), far_away ? to_light : sl_sub(to_light, shift), 0.0f,
                 far_away ? INFINITY : 1.0f - 1e-4f, skip);
}

typedef struct sl_hit16 {
    _Alignas(64) float t[SL_PACKET];
    float w1[SL_PACKET], w2[SL_PACKET]; /* barycentric weights of corners 1 and 2 */
    uint32_t triangle[SL_PACKET];       /* SL_NO_INDEX: nothing */
} sl_hit16;

enum { SL_REFLECTIONS_MAX = 16 }; /* what two facing mirrors still show after that is black */

/* Closest hits of rays [0, count), count <= 16. Alpha masks are tested. coherent: a hint only, the bits are
 * the same. */
void sl_trace(const sl_tracer *tracer, const sl_ray16 *rays, unsigned count, bool coherent, sl_hit16 *hits,
              sl_counters *counters);
/* Bit i set: something lies between near and far of ray i. */
uint32_t sl_trace_occluded(const sl_tracer *tracer, const sl_ray16 *rays, unsigned count, bool coherent,
                           sl_counters *counters);

/* ---- light, shared by the path tracer and the methods that trace ---- */

/* A distribution over the scene's emitters, lights and environment, chosen in proportion to power. */
typedef struct sl_light_sampler sl_light_sampler;
sl_status sl_light_sampler_create(const sl_scene *scene, sl_light_sampler **sampler, sl_error *error);
/* Of those lights alone that light surfaces in this transport. Entries are numbered as ever. */
sl_status sl_light_sampler_create_for(const sl_scene *scene, const sl_transport *transport,
                                      sl_light_sampler **sampler, sl_error *error);
void sl_light_sampler_destroy(sl_light_sampler *sampler);

typedef struct sl_light_sample {
    sl_vec3 to_light;    /* unit */
    float distance;      /* infinite for directional lights and the environment */
    sl_rgb radiance; /* radiance over pdf-in-solid-angle for lights with extent; for delta lights irradiance
                        on a facing plane over the probability. So E += radiance * max(0, n . to_light) where
                        unoccluded. */
    float pdf;           /* solid angle, selection included; 0: a delta light, not hit by chance */
    float chance;        /* of the selection alone */
    uint32_t triangle;   /* the emitter's triangle, or SL_NO_INDEX */
    uint32_t entry;      /* of the sampler: emitters come first, then lights, then the environment */
} sl_light_sample;

/* One sample from two numbers in [0,1). False: contributes nothing. Only emitters' fronts shine (unless
 * two-sided). u1 chooses the light, and what is left of it, stretched to [0,1), serves for the
 * point. Two numbers that are well spread together (a Sobol' pair) stay so on every light. */
bool sl_light_sampler_sample_2d(const sl_light_sampler *sampler, sl_vec3 p, float u1, float u2,
                                sl_light_sample *sample);
/* Many emitters, of which a few lie near: lets sl_light_sampler_sample_at() choose among them by what each
 * can matter at the point (light_tree.h) instead of by power alone. How often any emitter is chosen, instead
 * of a light or the environment, stays. */
sl_status sl_light_sampler_plant_tree(sl_light_sampler *sampler, sl_error *error);
/* The same from three numbers. normal: of the receiver, unit; it decides chances alone, and without a tree
 * nothing. */
bool sl_light_sampler_sample_at(const sl_light_sampler *sampler, sl_vec3 p, sl_vec3 normal, float select,
                                float u1, float u2, sl_light_sample *sample);
/* Solid-angle pdf with which the sampler would have made the direction that hit this emitter (or the
 * environment: triangle SL_NO_INDEX) from p. */
float sl_light_sampler_pdf(const sl_light_sampler *sampler, sl_vec3 p, sl_vec3 direction, uint32_t triangle,
                           float distance);

/* For those who follow light from where it starts (emission.h): the entry that the number u in [0,1) chooses,
 * of which there is one at least; the same, u left stretched to [0,1) again, false where nothing shines; the
 * probability that an entry is chosen; and the luminance, W, of all (0: there is no light). */
uint32_t sl_light_sampler_entry(const sl_light_sampler *sampler, double u);
bool sl_light_sampler_choose(const sl_light_sampler *sampler, float *u, uint32_t *entry);
double sl_light_sampler_chance(const sl_light_sampler *sampler, uint32_t entry);
double sl_light_sampler_power(const sl_light_sampler *sampler);

/* ---- the reference path tracers ---- */

typedef struct sl_path_tracer sl_path_tracer;

typedef struct sl_path_settings {
    int width, height;
    unsigned threads;
    uint64_t seed;
    sl_transport transport; /* filter must be BOX or CENTRE */
    /* the same light paths are found from either end, and those that only light can find (caustics of lights
     * without extent): bidirectional/bidirectional.h */
    bool bidirectional;
} sl_path_settings;

sl_status sl_path_tracer_create(const sl_scene *scene, const sl_tracer *tracer,
                                const sl_path_settings *settings, sl_path_tracer **path, sl_error *error);
void sl_path_tracer_destroy(sl_path_tracer *path);
/* One more sample for every pixel, sample number `sample` (0, 1, 2, ...). */
sl_status sl_path_tracer_sample(sl_path_tracer *path, uint64_t sample, sl_counters *counters,
                                sl_error *error);
/* Means so far: R, G, B planes of width*height, row 0 at the top, each may be NULL. Half 0 and 1: the even
 * and odd samples alone, two independent pictures whose difference is the noise; -1: all. */
void sl_path_tracer_mean(const sl_path_tracer *path, int half, float *r, float *g, float *b);
size_t sl_path_tracer_memory_bytes(const sl_path_tracer *path);
