/* Caustics on diffuse surfaces, L S+ D: what bidirectional path tracing seldom finds from one point, and of
 * lights without extent never. Irradiance is the photons' density, by the k nearest and Epanechnikov's kernel
 * (Silverman 1986),
 *
 *     E = sum_i Phi_i 2 (1 - d_i^2 / r^2) / (pi r^2),   r the distance of the (k+1)-st,
 *
 * which, r being that of the next one, is right on the mean where light is even. Photons are measured by what
 * arrives on the geometric surface; shading normals turn that by the quotient of the cosines.
 *
 * Where this renderer is used, bidirectional_renderer.c leaves these paths out
 * (sl_shading_cache_settings.caustics); all others are its own. One map serves all sets of samples: further
 * sets do not make it better. */
#include <math.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/shading_cache/caustic_map.h"
#include "cache/shading_cache/renderer_parts.h"

/* Photons are looked for so far, as a share of the diagonal of the scene's central region; where fewer are
 * found than wanted, light is faint. */
static const double farthest = 0.02;
/* Quotients of cosines beyond that are facets seen from the side. */
static const double steepest = 4.0;

typedef struct renderer {
    sl_renderer_settings settings;
    sl_caustic_map map;
} renderer;

/* What a photon counts for on a surface shaded with this normal. */
static double cosine_quotient(const sl_root_point *p, const sl_caustic_photon *photon) {
    double shading = (double)sl_dot(p->normal, photon->to_light),
           geometric = (double)sl_dot(p->geometric_normal, photon->to_light);
    return shading > 0.0 && geometric > 0.0 ? fmin(shading / geometric, steepest) : 0.0;
}

static void render_point(const void *state, const sl_sample_request *request, unsigned worker,
                         sl_sample *sample, sl_counters *counters) {
    (void)worker;
    const renderer *r = state;
    const sl_root_point *p = &request->point;
    if (r->map.count == 0 || !sl_request_wants_irradiance(request)) return;
    sl_near_photon near[SL_CAUSTIC_NEIGHBOURS];
    double radius = farthest * (double)sl_scene_central_diagonal(r->settings.scene);
    size_t count = sl_caustic_nearest(&r->map, p->position, p->geometric_normal, radius, near);
    double squared = count == SL_CAUSTIC_NEIGHBOURS ? near[0].squared : radius * radius;
    sl_count(counters, SL_COUNT_PHOTONS_GATHERED, count);
    if (!(squared > 0.0)) squared = 1e-12 * radius * radius; /* all in one place */
    double sum[3] = {0.0}, squares = 0.0;
    for (size_t i = 0; i < count; i++) {
        const sl_caustic_photon *photon = &r->map.photon[near[i].place];
        double weight =
            2.0 * fmax(1.0 - near[i].squared / squared, 0.0) / (SL_PI * squared) * cosine_quotient(p, photon);
        sum[0] += weight * (double)photon->flux.r;
        sum[1] += weight * (double)photon->flux.g;
        sum[2] += weight * (double)photon->flux.b;
        double mean = weight * (double)sl_rgb_mean(photon->flux);
        squares += mean * mean;
    }
    sample->irradiance = (sl_rgb){(float)sum[0], (float)sum[1], (float)sum[2]};
    sample->variance = (float)squares; /* photons arrive independently */
}

static void render(const void *state, size_t count, const sl_sample_request *requests, unsigned threads,
                   sl_sample *samples, sl_counters *counters) {
    sl_render_each(render_point, state, count, requests, threads, samples, counters);
}

static sl_status edit(void *state, unsigned changes, sl_error *error) {
    renderer *r = state;
    if (!(changes & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS))) return SL_OK;
    sl_caustic_map_release(&r->map);
    return sl_caustic_map_make(&r->settings, &r->map, error);
}

static void destroy(void *state) {
    renderer *r = state;
    if (!r) return;
    sl_caustic_map_release(&r->map);
    sl_free(r);
}

sl_status sl_caustic_renderer(const sl_renderer_settings *settings, sl_sample_renderer *out,
                              sl_error *error) {
    *out = (sl_sample_renderer){.name = "caustics", .render = render, .edit = edit, .destroy = destroy};
    renderer *r = sl_allocate(1, sizeof *r);
    if (!r) return sl_fail_memory(error, "a sample renderer");
    r->settings = *settings;
    sl_status status = sl_caustic_map_make(settings, &r->map, error);
    if (status != SL_OK) {
        destroy(r);
        return status;
    }
    out->state = r;
    return SL_OK;
}
