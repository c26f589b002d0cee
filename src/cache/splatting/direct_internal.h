/* What the parts of direct light share:
 *
 *     direct.c        strips of rows, and what each pixel is
 *     direct_maps.c   by shadow maps
 *     direct_rays.c   by shadow rays
 */
#ifndef SL_CACHE_SPLATTING_DIRECT_INTERNAL_H
#define SL_CACHE_SPLATTING_DIRECT_INTERNAL_H

#include "cache/splatting/splatting.h"
#include "trace/emitter_table.h"

struct sl_direct {
    const sl_scene *scene;
    const sl_tracer *tracer;
    sl_direct_settings settings;
    sl_emitter_table emitters;
    sl_scene emitters_alone;        /* the scene without its other lights, for the sampler */
    sl_light_sampler *sampler;      /* where there are too many emitters to weigh them for every pixel; else NULL */
    bool exact;
};

/* A pixel that reflects light. */
typedef struct sl_receiver {
    sl_vec3 position, normal, geometric_normal, to_viewer;
    uint32_t triangle;
    const sl_material *material;
    float offset;          /* how far along the geometric normal rays start */
} sl_receiver;

sl_receiver sl_receiver_at(const sl_direct *direct, const sl_gbuffer *gbuffer, size_t pixel);
bool sl_pixel_reflects(const sl_gbuffer *gbuffer, const sl_scene *scene, size_t pixel);
bool sl_pixel_is_glossy(const sl_gbuffer *gbuffer, const sl_scene *scene, size_t pixel);
/* ks (n+2)/(2 pi) cos^n alpha, alpha between the light and the mirror direction of the viewer. */
sl_rgb sl_phong(const sl_receiver *at, sl_vec3 to_light);

/* Rows [row0, row1), into r, g, b. */
sl_status sl_direct_by_maps(const sl_direct *direct, const sl_gbuffer *gbuffer, int row0, int row1, float *r, float *g, float *b,
                            sl_counters *counters, sl_error *error);
sl_status sl_direct_by_rays(const sl_direct *direct, const sl_gbuffer *gbuffer, int row0, int row1, float *r, float *g, float *b,
                            sl_counters *counters, sl_error *error);

#endif
