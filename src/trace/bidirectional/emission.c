/* Where light subpaths start. A light is chosen as the light sampler chooses it, in proportion to its power.
 * An emissive triangle then sends light from a uniform point with the density cos / pi; a point light evenly,
 * a spot evenly into its cone; directional lights and the environment from a disc as wide as the scene, which
 * faces their direction. */
#include <math.h>

#include "base/math.h"
#include "trace/bidirectional/subpath.h"

typedef enum light_kind { EMITTER, DELTA, SKY } light_kind;

static light_kind kind_of(const sl_scene *scene, uint32_t entry) {
    if (entry < scene->emitter_count) return EMITTER;
    return entry < scene->emitter_count + scene->light_count ? DELTA : SKY;
}

static const sl_light *delta_light(const sl_scene *scene, uint32_t entry) {
    return &scene->lights[entry - scene->emitter_count];
}

bool sl_emission_is_delta(const sl_path_maker *m, uint32_t entry) {
    return kind_of(m->scene, entry) == DELTA;
}

bool sl_emission_is_infinite(const sl_path_maker *m, uint32_t entry) {
    light_kind kind = kind_of(m->scene, entry);
    return kind == SKY || (kind == DELTA && delta_light(m->scene, entry)->type == SL_LIGHT_DIRECTIONAL);
}

/* ---- densities ------------------------------------------------------------------------------- */

/* Per solid angle; 0 where a cone is too narrow to start in. */
static double cone_pdf(const sl_light *light) {
    if (light->type == SL_LIGHT_POINT) return 0.25 / SL_PI;
    double solid_angle = 2.0 * SL_PI * (1.0 - fmin((double)light->cos_outer, (double)light->cos_inner));
    return solid_angle > 1e-6 ? 1.0 / solid_angle : 0.0;
}

double sl_emission_origin_pdf(const sl_path_maker *m, const sl_path_vertex *light) {
    double chance = sl_light_sampler_chance(m->lights, light->light);
    switch (kind_of(m->scene, light->light)) {
    case EMITTER: return chance / (double)m->scene->emitters[light->light].area;
    case DELTA: return chance;
    case SKY: break;
    }
    /* The eye's walk that left the scene looks along -back; a light's `back` is towards it. */
    sl_vec3 towards = light->kind == SL_VERTEX_SKY ? sl_neg(light->back) : light->back;
    return chance * (double)sl_environment_pdf(&m->scene->environment, towards);
}

double sl_emission_pdf(const sl_path_maker *m, const sl_path_vertex *light, const sl_path_vertex *surface) {
    const sl_scene *scene = m->scene;
    light_kind kind = kind_of(scene, light->light);
    if (sl_emission_is_infinite(m, light->light)) {
        sl_vec3 towards = light->kind == SL_VERTEX_SKY ? sl_neg(light->back) : light->back;
        double cosine = fabs((double)sl_dot(surface->geometric_normal, towards));
        return cosine / (SL_PI * m->radius * m->radius);
    }
    sl_vec3d offset = sl_subd(sl_to_double(surface->origin), sl_to_double(light->origin));
    double squared = sl_dotd(offset, offset);
    if (!(squared > 0.0)) return 0.0;
    double per_length = 1.0 / sqrt(squared),
           arriving = fabs(sl_dotd(sl_to_double(surface->geometric_normal), offset)) * per_length;
    double pdf;
    if (kind == DELTA) {
        const sl_light *l = delta_light(scene, light->light);
        pdf = cone_pdf(l);
        double cosine = sl_dotd(sl_to_double(l->direction), offset) * per_length;
        if (l->type == SL_LIGHT_SPOT && cosine < fmin((double)l->cos_outer, (double)l->cos_inner)) pdf = 0.0;
    } else {
        const sl_emitter *e = &scene->emitters[light->light];
        double cosine =
            sl_dotd(sl_to_double(sl_scene_geometric_normal(scene, e->triangle)), offset) * per_length;
        pdf = e->two_sided ? 0.5 * fabs(cosine) / SL_PI : fmax(cosine, 0.0) / SL_PI;
    }
    return pdf * arriving / squared;
}

/* ---- starting -------------------------------------------------------------------------------- */

/* Flux over density, in units of the scene's radius squared, so that it neither overflows nor vanishes in
 * scenes of any size. */
static sl_rgb flux(const sl_path_maker *m, sl_rgb strength, double per_pdf) {
    return sl_rgb_scale(strength, (float)(per_pdf / (m->radius * m->radius)));
}

static bool start_emitter(const sl_path_maker *m, double chance, float u1, const float where[3],
                          const float whither[3], sl_path_vertex *v, sl_vec3 *direction, double *pdf) {
    const sl_scene *scene = m->scene;
    const sl_emitter *e = &scene->emitters[v->light];
    uint32_t t = e->triangle;
    double s = sqrt((double)u1), w1 = s * (1.0 - (double)where[1]), w2 = s * (double)where[1];
    if (sl_scene_has_alpha(scene, t) && !sl_scene_is_opaque(scene, t, (float)w1, (float)w2)) return false;
    float side = e->two_sided && whither[2] < 0.5f ? -1.0f : 1.0f;
    v->geometric_normal = sl_scale(sl_scene_geometric_normal(scene, t), side);
    sl_surface surface;
    sl_scene_surface(scene, t, (float)w1, (float)w2, v->geometric_normal, &surface);
    v->origin = sl_surface_lift(scene, t, &surface);
    v->back = v->geometric_normal;
    v->triangle = t;
    *direction = sl_direction_around(v->geometric_normal, sqrtf(1.0f - whither[0]), whither[1]);
    double cosine = (double)sl_dot(*direction, v->geometric_normal);
    if (!(cosine > 0.0)) return false;
    double sides = e->two_sided ? 2.0 : 1.0;
    *pdf = cosine / (sides * SL_PI);
    v->pdf_forward = chance / (double)e->area;
    v->weight = flux(m, e->radiance, sides * SL_PI * (double)e->area / chance);
    return true;
}

static bool start_in_cone(const sl_path_maker *m, const sl_light *light, double chance,
                          const float whither[3], sl_path_vertex *v, sl_vec3 *direction, double *pdf) {
    *pdf = cone_pdf(light);
    if (!(*pdf > 0.0)) return false;
    sl_vec3 axis = light->type == SL_LIGHT_SPOT ? light->direction : sl_v3(0.0f, 0.0f, 1.0f);
    float widest = light->type == SL_LIGHT_SPOT ? fminf(light->cos_outer, light->cos_inner) : -1.0f;
    *direction = sl_direction_around(axis, 1.0f - whither[0] * (1.0f - widest), whither[1]);
    v->origin = light->position;
    v->pdf_forward = chance;
    /* The light's own rule for its strength, asked where float tells directions best. */
    sl_light centred = *light;
    centred.position = sl_v3(0.0f, 0.0f, 0.0f);
    sl_vec3 to_light;
    float distance;
    sl_rgb irradiance;
    if (!sl_light_illuminate(&centred, *direction, &to_light, &distance, &irradiance)) return false;
    v->weight = flux(m, irradiance, (double)distance * (double)distance / (chance * *pdf));
    return true;
}

/* On the disc that faces the light, outside of the scene. */
static void start_on_disc(const sl_path_maker *m, sl_vec3 towards, const float whither[3], sl_path_vertex *v,
                          double *pdf) {
    float sine, cosine;
    sl_sincos_turnf(whither[1], &sine, &cosine);
    double r = m->radius * sqrt((double)whither[0]);
    sl_frame frame = sl_frame_from_normal(towards);
    sl_vec3d p = sl_addd(m->centre, sl_scaled(sl_to_double(towards), 1.01 * m->radius));
    p = sl_addd(p, sl_addd(sl_scaled(sl_to_double(frame.x), r * (double)cosine),
                           sl_scaled(sl_to_double(frame.y), r * (double)sine)));
    v->origin = sl_to_float(p);
    v->back = towards;
    v->geometric_normal = sl_neg(towards);
    *pdf = 1.0 / (SL_PI * m->radius * m->radius);
}

bool sl_emission_sample(const sl_path_maker *m, const float where[3], const float whither[3],
                        sl_path_vertex *v, sl_vec3 *origin, sl_vec3 *direction, double *pdf, bool *parallel) {
    const sl_scene *scene = m->scene;
    *v = (sl_path_vertex){.kind = SL_VERTEX_LIGHT, .triangle = SL_NO_INDEX};
    float u1 = where[0];
    if (!sl_light_sampler_choose(m->lights, &u1, &v->light)) return false;
    double chance = sl_light_sampler_chance(m->lights, v->light);
    *parallel = sl_emission_is_infinite(m, v->light);
    bool lit = true;
    sl_rgb radiance;
    float sky_pdf;
    switch (kind_of(scene, v->light)) {
    case EMITTER: lit = start_emitter(m, chance, u1, where, whither, v, direction, pdf); break;
    case DELTA: {
        const sl_light *light = delta_light(scene, v->light);
        if (!*parallel) {
            lit = start_in_cone(m, light, chance, whither, v, direction, pdf);
            break;
        }
        start_on_disc(m, sl_neg(light->direction), whither, v, pdf);
        v->pdf_forward = chance;
        v->weight = flux(m, light->intensity, 1.0 / (chance * *pdf));
        *direction = light->direction;
        break;
    }
    case SKY: {
        sl_vec3 towards = sl_environment_sample(&scene->environment, u1, where[1], &radiance, &sky_pdf);
        v->pdf_forward = chance * (double)sky_pdf;
        if (!(v->pdf_forward > 0.0)) return false;
        start_on_disc(m, towards, whither, v, pdf);
        v->weight = flux(m, radiance, 1.0 / (v->pdf_forward * *pdf));
        *direction = sl_neg(towards);
        break;
    }
    }
    *origin = v->origin;
    return lit && sl_rgb_is_finite(v->weight) && sl_rgb_max(v->weight) > 0.0f && sl_is_finite(v->origin);
}

/* ---- lights that eye subpaths aim at --------------------------------------------------------- */

sl_path_vertex sl_emission_sampled(const sl_path_maker *m, sl_vec3 p, const sl_light_sample *sample) {
    sl_path_vertex v = {.kind = SL_VERTEX_LIGHT,
                        .triangle = sample->triangle,
                        .light = sample->entry,
                        .back = sample->to_light};
    if (!sl_emission_is_infinite(m, sample->entry)) v.origin = sl_mad(p, sample->distance, sample->to_light);
    if (sample->triangle != SL_NO_INDEX)
        v.geometric_normal = sl_scene_geometric_normal(m->scene, sample->triangle);
    bool from_sky = kind_of(m->scene, sample->entry) == SKY;
    v.pdf_forward = from_sky ? (double)sample->pdf : sl_emission_origin_pdf(m, &v);
    return v;
}
