/* Caustics on diffuse surfaces, L S+ D: what bidirectional path tracing seldom finds from one point, and of
 * lights without extent never. Irradiance is the density of photons (Jensen 1996, cache/photons), by the k
 * nearest and Epanechnikov's kernel (Silverman 1986),
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
#include "cache/photons/photon_tree.h"
#include "cache/shading_cache/renderers.h"

/* NEIGHBOURS: k + 1. Where none of the first photons ends in a caustic no more are sent. */
enum { NEIGHBOURS = 201, STORED = 120000, EMITTED = 1 << 22, FIRST_CHUNKS = 64 };

/* Photons are looked for so far, as a share of the diagonal of the scene's central region; where fewer are
 * found than wanted, light is faint. */
static const double farthest = 0.02;
/* Distances off the tangent plane count four times; normals as far apart as 45 degrees are of one surface. */
static const double flatness = 0.25, least_cosine = 0.7;
/* Quotients of cosines beyond that are facets seen from the side. */
static const double steepest = 4.0;

typedef struct renderer {
    sl_renderer_settings settings;
    sl_photon_tree *tree;      /* NULL: no caustics */
} renderer;

static sl_status trace(const sl_renderer_settings *s, sl_photon_list **list, sl_error *error) {
    const sl_photon_options options = {.stored = STORED,
                                       .emitted_at_most = EMITTED,
                                       .store = SL_STORE_CAUSTIC,
                                       .polished = SL_POLISHED,
                                       .seed = s->seed,
                                       .threads = s->threads};
    sl_counters uncounted = {{0}};
    bool done;
    sl_status status = sl_photons_trace(s->scene, *s->tracer, &options, FIRST_CHUNKS, list, &done, &uncounted,
                                        error);
    if (status == SL_OK && !done && (*list)->count > 0)
        status = sl_photons_trace(s->scene, *s->tracer, &options, SIZE_MAX, list, &done, &uncounted, error);
    return status;
}

static sl_status make_map(void *state, sl_error *error) {
    renderer *r = state;
    sl_photon_tree_destroy(r->tree);
    r->tree = NULL;
    sl_photon_list *list = NULL;
    sl_status status = trace(&r->settings, &list, error);
    if (status == SL_OK && list->count > 0)
        return sl_photon_tree_create(list, r->settings.threads, &r->tree, error);
    sl_photon_list_destroy(list);
    return status;
}

/* ---- at a point ------------------------------------------------------------------------------ */

/* Returns what a photon counts for on a surface shaded with this normal. */
static double cosine_quotient(const sl_lit_point *p, const sl_photon *photon) {
    sl_vec3 to_light = sl_octahedral_decode(photon->direction);
    double shading = (double)sl_dot(p->normal, to_light),
           geometric = (double)sl_dot(p->geometric_normal, to_light);
    return shading > 0.0 && geometric > 0.0 ? fmin(shading / geometric, steepest) : 0.0;
}

static void render_point(const void *state, const sl_sample_request *request, unsigned worker,
                         sl_sample *sample, sl_counters *counters) {
    (void)worker;
    const renderer *r = state;
    const sl_lit_point *p = &request->point;
    if (!r->tree || !sl_request_wants_irradiance(request)) return;
    uint32_t place[NEIGHBOURS];
    double distance[NEIGHBOURS];
    uint64_t keys[3 * NEIGHBOURS + 2 * SL_PHOTON_BUCKET];
    double radius = farthest * (double)sl_scene_central_diagonal(r->settings.scene);
    const sl_photon_query query = {.centre = p->position,
                                   .normal = p->geometric_normal,
                                   .flatness = flatness,
                                   .radius = radius,
                                   .minimum = 1e-6 * radius, /* all in one place */
                                   .cos_acceptance = least_cosine,
                                   .neighbours = NEIGHBOURS};
    sl_gathered_photons near = {.place = place, .distance = distance, .keys = keys};
    sl_photon_tree_gather(r->tree, &query, &near);
    sl_count(counters, SL_COUNT_PHOTONS_GATHERED, near.count);
    double squared = near.radius * near.radius, sum[3] = {0.0}, squares = 0.0;
    for (size_t i = 0; i < near.count; i++) {
        const sl_photon *photon = &sl_photon_tree_list(r->tree)->photon[place[i]];
        double weight =
            2.0 * fmax(1.0 - distance[i] / squared, 0.0) / (SL_PI * squared) * cosine_quotient(p, photon);
        double mean = 0.0;
        for (int c = 0; c < 3; c++) {
            sum[c] += weight * (double)photon->flux[c];
            mean += weight * (double)photon->flux[c] / 3.0;
        }
        squares += mean * mean;
    }
    sample->irradiance = sl_sum_over(sum, 1.0);
    sample->variance = (float)squares; /* photons arrive independently */
}

/* ---- the renderer ---------------------------------------------------------------------------- */

static void destroy(void *state) {
    renderer *r = state;
    if (!r) return;
    sl_photon_tree_destroy(r->tree);
    sl_free(r);
}

/* A search among photons is worth a few. */
static double rays(const void *state) {
    (void)state;
    return 8.0;
}

sl_status sl_caustic_renderer(const sl_renderer_settings *settings, sl_sample_renderer *out,
                              sl_error *error) {
    *out = (sl_sample_renderer){
        .render = render_point, .edit = make_map, .destroy = destroy, .rays = rays};
    renderer *r = sl_allocate(1, sizeof *r);
    if (!r) return sl_fail_memory(error, "a sample renderer");
    r->settings = *settings;
    sl_status status = make_map(r, error);
    if (status == SL_OK) out->state = r;
    else destroy(r);
    return status;
}
