/* What the gather sees, lit by direct light alone: outgoing radiance L = kd / pi * E_direct of a Lambertian bounce.
 *
 * Shadow rays: every light without extent lights every hit (where there are more than eight, the sampler draws among
 * them), and emitters and environment together get one sample a hit (near emitters their closed form is used; one of many
 * emitters is chosen by what it can matter there). The numbers
 * that choose these samples are one three-dimensional Kronecker sequence over the hits of the gather (Roberts' R3), rotated
 * by the point's key, so that all hits together are spread evenly over the lights. */
#include "cache/gather/gather_internal.h"

#include "base/counters.h"
#include "base/math.h"
#include "base/random.h"

/* Radiance below this is 0 (its products would be denormal), above that it is cut (radiance-cache-splatting 8). */
#define RADIANCE_MIN 1e-30f
#define RADIANCE_MAX 1e20f

/* ---- surfaces ------------------------------------------------------------------------------------------------------- */

static float interpolate(const float *values, const uint32_t corner[3], float w1, float w2) {
    float first = values[corner[0]];
    return first + w1 * (values[corner[1]] - first) + w2 * (values[corner[2]] - first);
}

static void clear_slot(const sl_gather_hits *h, size_t k) {
    h->depth[k] = 0.0f;
    h->normal_x[k] = h->normal_y[k] = h->normal_z[k] = 0.0f;
    h->geometric_x[k] = h->geometric_y[k] = h->geometric_z[k] = 0.0f;
    h->diffuse_r[k] = h->diffuse_g[k] = h->diffuse_b[k] = 0.0f;
}

static void load_slot(const sl_gather *gather, const sl_gather_hits *h, size_t k) {
    const sl_scene *s = gather->scene;
    uint32_t triangle = h->triangle[k], corner[3] = {s->vertex[0][triangle], s->vertex[1][triangle], s->vertex[2][triangle]};
    float w1 = h->w1[k], w2 = h->w2[k];
    h->normal_x[k] = interpolate(s->normal_x, corner, w1, w2);
    h->normal_y[k] = interpolate(s->normal_y, corner, w1, w2);
    h->normal_z[k] = interpolate(s->normal_z, corner, w1, w2);
    h->geometric_x[k] = s->geometric_normal_x[triangle];
    h->geometric_y[k] = s->geometric_normal_y[triangle];
    h->geometric_z[k] = s->geometric_normal_z[triangle];
    const sl_material *material = &s->materials[s->material_index[triangle]];
    sl_rgb diffuse = material->texture == SL_NO_INDEX ? material->diffuse : sl_scene_diffuse_nearest(s, triangle, w1, w2);
    h->diffuse_r[k] = diffuse.r;
    h->diffuse_g[k] = diffuse.g;
    h->diffuse_b[k] = diffuse.b;
}

static void make_surfaces(const sl_gather_view *view) {
    const sl_gather *gather = view->gather;
    const sl_gather_hits *h = &view->scratch->hits;
    for (size_t k = 0; k < gather->tables->used; k++) {
        if (h->triangle[k] == SL_NO_INDEX) clear_slot(h, k);
        else load_slot(gather, h, k);
        h->irradiance_r[k] = h->irradiance_g[k] = h->irradiance_b[k] = 0.0f;
    }
    sl_surface_cells cells = {
        .count = gather->tables->used, .eye = view->eye, .depth = h->depth,
        .direction_x = h->direction_x, .direction_y = h->direction_y, .direction_z = h->direction_z,
        .position_x = h->position_x, .position_y = h->position_y, .position_z = h->position_z,
        .normal_x = h->normal_x, .normal_y = h->normal_y, .normal_z = h->normal_z,
        .geometric_x = h->geometric_x, .geometric_y = h->geometric_y, .geometric_z = h->geometric_z,
        .cosine = h->cosine, .back = h->back};
    gather->kernels.surfaces(&cells);
}

/* A shading normal may tilt the gather below the geometric horizon: nothing arrives from there, neither from the surface itself nor
 * from what lies behind it. */
static bool is_below_horizon(const sl_gather_view *view, size_t k) {
    const sl_gather_hits *h = &view->scratch->hits;
    return !(sl_dot(view->point->geometric_normal, sl_v3(h->direction_x[k], h->direction_y[k], h->direction_z[k])) > 0.0f);
}

static void drop_below_horizon(const sl_gather_view *view) {
    const sl_gather_hits *h = &view->scratch->hits;
    if (sl_dot(view->point->geometric_normal, view->frame.z) >= 1.0f - 1e-6f) return; /* not tilted */
    for (size_t k = 0; k < view->gather->tables->used; k++) {
        if (is_below_horizon(view, k)) h->triangle[k] = SL_NO_INDEX;
    }
}

/* ---- direct light by shadow rays ----------------------------------------------------------------------------------------- */

/* Shadow rays wait here until there are sixteen. */
typedef struct shadow_queue {
    const sl_gather_view *view;
    sl_counters *counters;
    unsigned count;
    bool coherent;
    sl_ray16 rays;
    uint32_t slot[SL_PACKET];
    sl_rgb light[SL_PACKET];
} shadow_queue;

static void flush_queue(shadow_queue *q) {
    if (q->count == 0) return;
    const sl_gather_hits *h = &q->view->scratch->hits;
    uint32_t occluded = sl_trace_occluded(q->view->gather->tracer, &q->rays, q->count, q->coherent, q->counters);
    for (unsigned i = 0; i < q->count; i++) {
        if (occluded >> i & 1u) continue;
        h->irradiance_r[q->slot[i]] += q->light[i].r;
        h->irradiance_g[q->slot[i]] += q->light[i].g;
        h->irradiance_b[q->slot[i]] += q->light[i].b;
    }
    q->count = 0;
}

/* Irradiance arrives at slot k from a unit direction, unless something is in the way. */
static void push_shadow_ray(shadow_queue *q, size_t k, sl_vec3 to_light, float distance, sl_rgb irradiance) {
    const sl_gather_hits *h = &q->view->scratch->hits;
    bool far_away = isinf(distance);
    float offset = q->view->gather->offset;
    sl_vec3 shift = sl_v3(offset * h->geometric_x[k], offset * h->geometric_y[k], offset * h->geometric_z[k]);
    /* From the shifted origin to the same point of the light: beside it, the ray could end behind the light. */
    sl_vec3 direction = far_away ? to_light : sl_sub(sl_scale(to_light, distance), shift);
    unsigned i = q->count++;
    q->rays.origin_x[i] = h->position_x[k] + shift.x;
    q->rays.origin_y[i] = h->position_y[k] + shift.y;
    q->rays.origin_z[i] = h->position_z[k] + shift.z;
    q->rays.direction_x[i] = direction.x;
    q->rays.direction_y[i] = direction.y;
    q->rays.direction_z[i] = direction.z;
    q->rays.near[i] = 0.0f;
    q->rays.far[i] = far_away ? INFINITY : 1.0f - 1e-4f; /* short of the light itself */
    q->rays.skip[i] = h->triangle[k];
    q->slot[i] = (uint32_t)k;
    q->light[i] = irradiance;
    if (q->count == SL_PACKET) flush_queue(q);
}

/* Of a unit direction at slot k with the shading normal; 0 if it is below either horizon. */
static float lit_cosine(const sl_gather_hits *h, size_t k, sl_vec3 d) {
    float cosine = h->normal_x[k] * d.x + h->normal_y[k] * d.y + h->normal_z[k] * d.z;
    float above = h->geometric_x[k] * d.x + h->geometric_y[k] * d.y + h->geometric_z[k] * d.z;
    return cosine > 0.0f && above > 0.0f ? cosine : 0.0f;
}

static bool reflects(const sl_gather_hits *h, size_t k) {
    return h->triangle[k] != SL_NO_INDEX && h->diffuse_r[k] + h->diffuse_g[k] + h->diffuse_b[k] > 0.0f;
}

static sl_vec3 position_of(const sl_gather_hits *h, size_t k) {
    return sl_v3(h->position_x[k], h->position_y[k], h->position_z[k]);
}

static void light_by_each(const sl_gather_view *view, shadow_queue *q) {
    const sl_scene *scene = view->gather->scene;
    const sl_gather_hits *h = &view->scratch->hits;
    for (size_t i = 0; i < scene->light_count; i++) {
        for (size_t k = 0; k < view->gather->tables->used; k++) {
            sl_vec3 to_light;
            float distance;
            sl_rgb facing;
            if (!reflects(h, k)) continue;
            if (!sl_light_illuminate(&scene->lights[i], position_of(h, k), &to_light, &distance, &facing)) continue;
            float cosine = lit_cosine(h, k, to_light);
            if (cosine > 0.0f) push_shadow_ray(q, k, to_light, distance, sl_rgb_scale(facing, cosine));
        }
        flush_queue(q); /* packets hold rays to one light */
    }
}

static float unit(uint32_t bits) { return (float)(bits >> 8) * 0x1p-24f; }

/* ---- near emitters ---- */

/* Within about an emitter's size of it, 1 / distance^2 of points sampled by area makes single hits outshine the gather. There every
 * emitter is sampled uniformly in solid angle: L Omega cos theta V is unbiased and never beyond 2 pi L. */
static bool is_near_emitter(const sl_gather *gather, sl_vec3 p) {
    for (size_t i = 0; i < gather->near_count; i++) {
        sl_vec3 d = sl_sub(p, gather->near[i].centre);
        if (sl_dot(d, d) < gather->near[i].radius_squared) return true;
    }
    return false;
}

static sl_vec3d unit_towards(sl_vec3 corner, sl_vec3 p) {
    sl_vec3d d = sl_subd(sl_to_double(corner), sl_to_double(p));
    double length = sl_lengthd(d);
    return length > 0.0 ? sl_scaled(d, 1.0 / length) : d;
}

/* cosine * axis + sine * (the unit vector towards v, square to the axis) */
static sl_vec3d arc(sl_vec3d axis, sl_vec3d v, double cosine) {
    sl_vec3d across = sl_subd(v, sl_scaled(axis, sl_dotd(v, axis)));
    double length = sl_lengthd(across), sine = sqrt(fmax(0.0, 1.0 - cosine * cosine));
    return length > 0.0 ? sl_addd(sl_scaled(axis, cosine), sl_scaled(across, sine / length)) : axis;
}

/* Uniform in the solid angle of the spherical triangle ABC (Arvo 1995): u1 cuts off a triangle of that share of its area, whose
 * corner C' moves along the side AC; u2 walks from B towards C'. False where the triangle is too small to tell its area. */
static bool spherical_point(const sl_vec3d v[3], double u1, double u2, sl_vec3d *direction, double *solid_angle) {
    sl_vec3d a = v[0], b = v[1], c = v[2];
    double volume = fabs(sl_dotd(a, sl_crossd(b, c)));
    double cos_c = sl_dotd(a, b), cos_b = sl_dotd(a, c);
    double area = 2.0 * sl_atan2(volume, 1.0 + cos_c + cos_b + sl_dotd(b, c));
    *solid_angle = area;
    if (!(area > 1e-6)) return false;
    double alpha = sl_atan2(volume, sl_dotd(b, c) - cos_c * cos_b), part = u1 * area - alpha;
    double sin_alpha = sl_sin(alpha), cos_alpha = sl_cos(alpha), s = sl_sin(part), t = sl_cos(part);
    double u = t - cos_alpha, w = s + sin_alpha * cos_c;
    double denominator = (w * s + u * t) * sin_alpha;
    double q = denominator != 0.0 ? ((w * t - u * s) * cos_alpha - w) / denominator : 1.0;
    sl_vec3d moved = arc(a, c, fmin(fmax(q, -1.0), 1.0));
    *direction = arc(b, moved, 1.0 - u2 * (1.0 - sl_dotd(moved, b)));
    return true;
}

/* A near emitter that spans less than a millionth of a steradian is seen edge-on or is very small: it is left out. */
static void light_by_near_emitters(const sl_gather_view *view, shadow_queue *q, size_t k, float u1, float u2, float share) {
    const sl_scene *scene = view->gather->scene;
    const sl_gather_hits *h = &view->scratch->hits;
    sl_vec3 p = position_of(h, k);
    for (size_t i = 0; i < scene->emitter_count; i++) {
        const sl_emitter *e = &scene->emitters[i];
        sl_vec3d v[3], direction;
        double solid_angle;
        if (e->triangle == h->triangle[k]) continue;
        for (int c = 0; c < 3; c++) v[c] = unit_towards(sl_scene_position(scene, scene->vertex[c][e->triangle]), p);
        if (!spherical_point(v, (double)u1, (double)u2, &direction, &solid_angle)) continue;
        sl_vec3d normal = sl_to_double(sl_scene_geometric_normal(scene, e->triangle));
        sl_vec3d first = sl_to_double(sl_scene_position(scene, scene->vertex[0][e->triangle]));
        double facing = -sl_dotd(normal, direction);
        if (!(facing > 0.0) && !e->two_sided) continue;
        double distance = sl_dotd(normal, sl_subd(sl_to_double(p), first)) / facing;
        sl_vec3 to_light = sl_to_float(direction);
        float cosine = lit_cosine(h, k, to_light);
        if (!(cosine > 0.0f) || !(distance > 0.0) || !isfinite(distance)) continue;
        push_shadow_ray(q, k, to_light, (float)distance, sl_rgb_scale(e->radiance, share * (float)solid_angle * cosine));
    }
}

/* ---- samples ---- */

/* Given its emitter, a sample stands for 1 / pdf of solid angle; very near to the emitter that grows beyond a hemisphere, which none
 * fills, and single hits would outshine the gather. So it is cut there (where emitters are few, near ones are sampled by solid
 * angle instead). */
static float bounded(const sl_light_sample *sample) {
    if (sample->triangle == SL_NO_INDEX || !(sample->chance > 0.0f)) return 1.0f;
    float share = sample->pdf / sample->chance * (float)(2.0 * SL_PI);
    return share < 1.0f ? share : 1.0f;
}

/* One light sample at slot k, one of 1 / share. */
static void light_by_sample(const sl_gather_view *view, shadow_queue *q, size_t k, float select, float u1, float u2, float share) {
    const sl_gather_hits *h = &view->scratch->hits;
    sl_light_sample sample;
    sl_vec3 p = position_of(h, k);
    if (is_near_emitter(view->gather, p)) {
        light_by_near_emitters(view, q, k, u1, u2, share);
        return;
    }
    sl_vec3 n = sl_v3(h->normal_x[k], h->normal_y[k], h->normal_z[k]);
    if (!sl_light_sampler_sample_at(view->gather->sampler, p, n, select, u1, u2, &sample)) return;
    float cosine = lit_cosine(h, k, sample.to_light);
    if (!(cosine > 0.0f)) return;
    push_shadow_ray(q, k, sample.to_light, sample.distance, sl_rgb_scale(sample.radiance, share * cosine * bounded(&sample)));
}

/* Steps of the R3 sequence: powers of 1/g, g^4 = g + 1, as fractions of 2^32. */
static void light_by_samples(const sl_gather_view *view, shadow_queue *q) {
    const sl_gather_hits *h = &view->scratch->hits;
    uint64_t key = sl_random_key(view->point->key, 1);
    uint32_t select = sl_random_bits(key, 0), u1 = sl_random_bits(key, 1), u2 = sl_random_bits(key, 2);
    uint32_t samples = view->gather->settings.hit_samples;
    float share = 1.0f / (float)samples;
    for (uint32_t i = 0; i < samples; i++) {
        for (size_t k = 0; k < view->gather->tables->used; k++, select += 3518319155u, u1 += 2882110345u, u2 += 2360945575u) {
            if (reflects(h, k)) light_by_sample(view, q, k, unit(select), unit(u1), unit(u2), share);
        }
    }
    flush_queue(q);
}

static void light_by_rays(const sl_gather_view *view, sl_counters *counters) {
    shadow_queue queue = {.view = view, .counters = counters, .coherent = true};
    if (view->gather->every_light) light_by_each(view, &queue);
    queue.coherent = false;
    if (view->gather->sampler) light_by_samples(view, &queue);
}

/* ---- direct light by shadow maps ------------------------------------------------------------------------------------------ */

static void light_by_maps(const sl_gather_view *view, sl_counters *counters) {
    const sl_gather_hits *h = &view->scratch->hits;
    const unsigned parts = SL_MAPPED_LIGHTS | SL_MAPPED_SKY | SL_MAPPED_FEW;
    for (size_t k = 0; k < view->gather->tables->used; k += SL_LIGHT_BLOCK) {
        size_t rest = view->gather->tables->used - k;
        sl_light_points block = {rest < SL_LIGHT_BLOCK ? rest : SL_LIGHT_BLOCK, h->position_x + k, h->position_y + k, h->position_z + k,
                                 h->geometric_x + k, h->geometric_y + k, h->geometric_z + k, h->normal_x + k, h->normal_y + k, h->normal_z + k};
        sl_shadow_maps_irradiance(view->gather->maps, &block, parts, h->irradiance_r + k, h->irradiance_g + k,
                                  h->irradiance_b + k, counters);
    }
}

/* ---- radiance of the cells --------------------------------------------------------------------------------------------------- */

static float sane(float radiance, uint64_t *nonfinite) {
    if (radiance != radiance) {
        ++*nonfinite;
        return 0.0f;
    }
    if (radiance > RADIANCE_MAX) return RADIANCE_MAX;
    return radiance >= RADIANCE_MIN ? radiance : 0.0f;
}

static sl_rgb emission_of(const sl_gather_view *view, size_t k) {
    const sl_gather_hits *h = &view->scratch->hits;
    const sl_scene *scene = view->gather->scene;
    const sl_gather_settings *settings = &view->gather->settings;
    if (h->triangle[k] == SL_NO_INDEX) {
        const sl_environment *environment = settings->emission ? &scene->environment : settings->background;
        if (!environment || is_below_horizon(view, k)) return sl_grey(0.0f);
        sl_vec3 d = sl_v3(h->direction_x[k], h->direction_y[k], h->direction_z[k]);
        return sl_environment_radiance(environment, sl_normalize_or(d, view->frame.z));
    }
    if (!settings->emission) return sl_grey(0.0f);
    const sl_material *material = &scene->materials[scene->material_index[h->triangle[k]]];
    return h->back[k] > 0.0f && !material->emission_two_sided ? sl_grey(0.0f) : material->emission;
}

static void write_cell(const sl_gather_view *view, size_t k, float length, uint64_t *nonfinite) {
    const sl_gather_hits *h = &view->scratch->hits;
    const sl_gather_planes *p = &view->scratch->planes;
    uint32_t cell = view->gather->tables->order[k];
    const float inverse_pi = (float)(1.0 / SL_PI);
    sl_rgb radiance = {h->diffuse_r[k] * inverse_pi * h->irradiance_r[k], h->diffuse_g[k] * inverse_pi * h->irradiance_g[k],
                       h->diffuse_b[k] * inverse_pi * h->irradiance_b[k]};
    radiance = sl_rgb_add(radiance, emission_of(view, k));
    p->r[cell] = sane(radiance.r, nonfinite);
    p->g[cell] = sane(radiance.g, nonfinite);
    p->b[cell] = sane(radiance.b, nonfinite);
    bool hit = h->triangle[k] != SL_NO_INDEX;
    float nearest_depth = 2.0f * view->gather->offset;
    p->nearness[cell] = hit ? 1.0f / (h->depth[k] > nearest_depth ? h->depth[k] : nearest_depth) : 0.0f;
    p->distance[cell] = hit ? h->depth[k] * length : INFINITY;
}

void sl_gather_shade(const sl_gather_view *view, float *nearest, double *back_weight, sl_counters *counters) {
    const sl_gather *gather = view->gather;
    const sl_gather_tables *t = gather->tables;
    const sl_gather_hits *h = &view->scratch->hits;
    uint64_t nonfinite = 0;
    *nearest = INFINITY;
    *back_weight = 0.0;
    drop_below_horizon(view);
    make_surfaces(view);
    if (gather->maps) light_by_maps(view, counters);
    else light_by_rays(view, counters);
    if (gather->settings.hidden) sl_gather_add_hidden_light(view, counters);
    for (size_t k = 0; k < t->used; k++) {
        float length = t->kind == SL_GATHER_RAYS ? 1.0f : t->length[t->order[k]];
        write_cell(view, k, length, &nonfinite);
        if (h->triangle[k] == SL_NO_INDEX) continue;
        *back_weight += (double)(h->back[k] * t->weight[t->order[k]]);
        sl_vec3 d = sl_v3(h->direction_x[k], h->direction_y[k], h->direction_z[k]);
        if (!(h->cosine[k] > 0.0f) || !(sl_dot(d, view->point->geometric_normal) > 0.0f)) continue;
        float reach = h->depth[k] * length * length / h->cosine[k]; /* r / cos theta' */
        if (reach < *nearest) *nearest = reach;
    }
    if (nonfinite) sl_count(counters, SL_COUNT_NONFINITE, nonfinite);
}
