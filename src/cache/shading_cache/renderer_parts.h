/* Between the sample renderers: batches, the point that is lit, well-spread numbers, and the environment's
 * direct light. */
#ifndef SL_SHADING_CACHE_RENDERER_PARTS_H
#define SL_SHADING_CACHE_RENDERER_PARTS_H

#include "cache/light/light_sample.h"
#include "cache/shading_cache/renderers.h"
#include "trace/bsdf.h"

/* ---- batches (renderers.c) ------------------------------------------------------------------- */

/* One request; worker < threads chooses scratch memory alone. */
typedef void sl_render_point(const void *state, const sl_sample_request *request, unsigned worker,
                             sl_sample *sample, sl_counters *counters);
void sl_render_each(sl_render_point *render, const void *state, size_t count,
                    const sl_sample_request *requests, unsigned threads, sl_sample *samples,
                    sl_counters *counters);
/* Position and normals are finite, and normals have a length. */
bool sl_request_is_sound(const sl_sample_request *request);
/* What is asked for: irradiance of materials that have a diffuse part, and of points without a material;
 * radiance of glossy lobes and of mirrors. */
bool sl_request_wants_irradiance(const sl_sample_request *request);
bool sl_request_wants_lobe(const sl_sample_request *request);
bool sl_request_wants_mirror(const sl_sample_request *request);
/* The lobe alone, ks = 1, seen from the eye; false where the eye is behind the surface. */
bool sl_request_lobe(const sl_sample_request *request, sl_bsdf *lobe);

/* ---- well-spread numbers (area_points.c) ----------------------------------------------------- */

/* Halton's points in bases 2 and 3. Digits are shifted by a fixed number each, which keeps what makes the
 * points even; different keys give points that have nothing to do with each other, the same key the same ones
 * for everybody. */
enum { SL_HALTON_DIGITS = 20 };
typedef struct sl_halton {
    uint32_t shift_2;                      /* by bit */
    uint8_t shift_3[SL_HALTON_DIGITS];     /* 0 to 2 */
    /* what the shifts of digits from k on add to a number that has none there */
    double rest_3[SL_HALTON_DIGITS + 1];
} sl_halton;
sl_halton sl_halton_make(uint64_t key);
void sl_halton_point(const sl_halton *halton, uint32_t index, double point[2]);

/* ---- points of area lights (area_points.c) --------------------------------------------------- */

typedef struct sl_area_light {
    const sl_sampled_light *light;
    sl_halton halton;
    sl_light_surface surface;
    sl_vec3d *normal;          /* by triangle, unit, of the shining side */
} sl_area_light;
sl_status sl_area_light_make(const sl_scene *scene, const sl_sampled_light *light, uint64_t key,
                             sl_area_light *area, sl_error *error);
void sl_area_light_release(sl_area_light *area);

typedef struct sl_area_point {
    sl_vec3d position, normal;
    uint32_t triangle;         /* of the scene */
    bool shines;               /* false: a hole of its alpha mask */
} sl_area_point;
sl_area_point sl_area_light_point(const sl_scene *scene, const sl_area_light *area, uint32_t index);

/* ---- the environment (sky_light.c) ----------------------------------------------------------- */

/* Direct light of the environment at a point, by `samples` directions drawn from the cosine (and the lobe)
 * and as many from the environment. Added to the sample; its variance too. */
void sl_sky_light(const sl_scene *scene, const sl_tracer *tracer, uint64_t seed, uint32_t samples,
                  const sl_sample_request *request, sl_sample *sample, sl_counters *counters);

#endif
