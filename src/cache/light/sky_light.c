/* The environment's direct light: directions from the cosine (and from the glossy lobe) and from the
 * environment itself, put together by the balance heuristic (Veach and Guibas 1995), E = sum over all
 * directions of L V cos / p with p the sum of n_j p_j over the ways of drawing. A sky of one colour needs no
 * directions of its own. */
#include <math.h>

#include "base/math.h"
#include "cache/light/light_sample.h"

typedef enum way { BY_COSINE, BY_SKY, BY_LOBE, WAYS } way;

typedef struct sky_point {
    const sl_scene *scene;
    const sl_tracer *tracer;
    const sl_lit_point *point;
    const sl_bsdf *lobe;
    sl_counters *counters;
    sl_vec3 origin;
    sl_bsdf cosine;
    double samples[WAYS];      /* n_j */
} sky_point;

typedef struct sums {
    double irradiance[3], lobe[3];
    double mean, squares;      /* of the irradiance's channel mean, a sample */
} sums;

typedef struct packet {
    sl_ray16 rays;
    sl_rgb irradiance[SL_PACKET], lobe[SL_PACKET];
    unsigned count;
} packet;

static void trace(const sky_point *at, packet *p, sums *s) {
    uint32_t hidden = p->count ? sl_trace_occluded(at->tracer, &p->rays, p->count, false, at->counters) : 0;
    for (unsigned i = 0; i < p->count; i++) {
        if (hidden >> i & 1) continue;
        const double e[3] = {(double)p->irradiance[i].r, (double)p->irradiance[i].g,
                             (double)p->irradiance[i].b};
        const double l[3] = {(double)p->lobe[i].r, (double)p->lobe[i].g, (double)p->lobe[i].b};
        for (int c = 0; c < 3; c++) {
            s->irradiance[c] += e[c];
            s->lobe[c] += l[c];
        }
        double mean = (e[0] + e[1] + e[2]) / 3.0;
        s->mean += mean;
        s->squares += mean * mean;
    }
    p->count = 0;
}

static bool draw(const sky_point *at, way how, const float u[2], sl_vec3 *direction) {
    sl_rgb radiance;
    float pdf;
    if (how == BY_COSINE) return sl_bsdf_sample(&at->cosine, 0.0f, u[0], u[1], direction);
    if (how == BY_LOBE) return sl_bsdf_sample(at->lobe, 0.0f, u[0], u[1], direction);
    *direction = sl_environment_sample(&at->scene->environment, u[0], u[1], &radiance, &pdf);
    return pdf > 0.0f;
}

static void add_direction(const sky_point *at, sl_vec3 d, packet *p, sums *s) {
    const sl_lit_point *point = at->point;
    double cosine = (double)sl_dot(d, point->normal);
    if (!(cosine > 0.0) || !(sl_dot(d, point->geometric_normal) > 0.0f)) return;
    double density = at->samples[BY_COSINE] * cosine / SL_PI;
    if (at->samples[BY_SKY] > 0.0)
        density += at->samples[BY_SKY] * (double)sl_environment_pdf(&at->scene->environment, d);
    if (at->lobe) density += at->samples[BY_LOBE] * (double)sl_bsdf_pdf(at->lobe, d);
    sl_rgb radiance = sl_environment_radiance(&at->scene->environment, d);
    if (!(density > 0.0) || sl_rgb_is_black(radiance)) return;
    unsigned i = p->count++;
    p->irradiance[i] = sl_rgb_scale(radiance, (float)(cosine / density));
    p->lobe[i] = at->lobe ? sl_rgb_mul(p->irradiance[i], sl_bsdf_value(at->lobe, d, SL_LOBE_GLOSSY))
                          : sl_grey(0.0f);
    sl_ray16_set(&p->rays, i, at->origin, d, 0.0f, INFINITY, point->triangle);
    if (p->count == SL_PACKET) trace(at, p, s);
}

static sl_rgb colour_of(const double c[3]) { return (sl_rgb){(float)c[0], (float)c[1], (float)c[2]}; }

/* Adds one way's directions; its numbers are independent of the others'. */
static void add_way(const sky_point *at, way how, const sl_light_numbers *numbers, uint32_t each, sums *s) {
    packet p = {.count = 0};
    for (uint32_t i = 0; i < each; i++) {
        float u[3];
        sl_vec3 direction;
        sl_sequence_point(numbers->sequence, numbers->key, (uint32_t)how, numbers->first + i, u);
        if (draw(at, how, u, &direction)) add_direction(at, direction, &p, s);
    }
    trace(at, &p, s);
}

sl_sky_light sl_sky_light_at(const sl_scene *scene, const sl_tracer *tracer, const sl_lit_point *point,
                             bool irradiance, const sl_bsdf *lobe, const sl_light_numbers *numbers,
                             sl_counters *counters) {
    const sl_environment *sky = &scene->environment;
    sl_sky_light light = {.variance = 0.0};
    if (!sky->present || numbers->count == 0) return light;
    sky_point at = {.scene = scene, .tracer = tracer, .point = point, .lobe = lobe, .counters = counters};
    at.origin = sl_surface_lift_anywhere(scene, point->position, point->geometric_normal);
    at.cosine = (sl_bsdf){
        .diffuse = sl_grey(1.0f), .normal = point->normal, .geometric_normal = point->geometric_normal};
    sl_bsdf_turn(&at.cosine, point->normal, SL_LOBE_DIFFUSE);
    uint32_t each = sky->width > 0 || lobe ? (numbers->count + 1) / 2 : numbers->count;
    at.samples[BY_COSINE] = irradiance ? (double)each : 0.0;
    at.samples[BY_SKY] = sky->width > 0 ? (double)each : 0.0;
    at.samples[BY_LOBE] = lobe ? (double)each : 0.0;
    double n = (double)each;
    for (int how = 0; how < WAYS; how++) {
        sums s = {.mean = 0.0};
        if (!(at.samples[how] > 0.0)) continue;
        add_way(&at, (way)how, numbers, each, &s);
        light.irradiance = sl_rgb_add(light.irradiance, colour_of(s.irradiance));
        light.lobe = sl_rgb_add(light.lobe, colour_of(s.lobe));
        if (each > 1) light.variance += fmax(s.squares - s.mean * s.mean / n, 0.0) * n / (n - 1.0);
    }
    return light;
}
