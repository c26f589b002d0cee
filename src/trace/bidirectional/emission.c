/* Where light subpaths start (trace/emission.h), a light being chosen as the light sampler chooses it, and
 * with which densities. */
#include <math.h>

#include "base/math.h"
#include "trace/bidirectional/subpath.h"
#include "trace/emission.h"

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
        double area = sl_seen_area(scene, towards);
        return area > 0.0 ? cosine / area : 0.0;
    }
    sl_vec3d offset = sl_subd(sl_to_double(surface->origin), sl_to_double(light->origin));
    double squared = sl_dotd(offset, offset);
    if (!(squared > 0.0)) return 0.0;
    double per_length = 1.0 / sqrt(squared),
           arriving = fabs(sl_dotd(sl_to_double(surface->geometric_normal), offset)) * per_length;
    double pdf;
    if (kind == DELTA) {
        const sl_light *l = delta_light(scene, light->light);
        pdf = sl_cone_pdf(l, (float)(sl_dotd(sl_to_double(l->direction), offset) * per_length));
    } else {
        const sl_emitter *e = &scene->emitters[light->light];
        double cosine =
            sl_dotd(sl_to_double(sl_scene_geometric_normal(scene, e->triangle)), offset) * per_length;
        pdf = e->two_sided ? 0.5 * fabs(cosine) / SL_PI : fmax(cosine, 0.0) / SL_PI;
    }
    return pdf * arriving / squared;
}

/* ---- starting -------------------------------------------------------------------------------- */

bool sl_emission_sample(const sl_path_maker *m, const float where[3], const float whither[3],
                        sl_path_vertex *v, sl_vec3 *direction, double *pdf, bool *parallel) {
    sl_emission e;
    float u = where[0];
    *v = (sl_path_vertex){.kind = SL_VERTEX_LIGHT, .triangle = SL_NO_INDEX};
    if (!sl_light_sampler_choose(m->lights, &u, &v->light)) return false;
    double chance = sl_light_sampler_chance(m->lights, v->light);
    const float number[SL_EMISSION_NUMBERS] = {whither[0], whither[1], u, where[1], whither[2]};
    if (!sl_light_emit(m->scene, v->light, number, 1.0 / (chance * m->radius * m->radius), &e)) return false;
    v->origin = e.origin;
    v->geometric_normal = e.normal;
    v->back = e.parallel ? sl_neg(e.direction) : e.normal;
    v->triangle = e.triangle;
    v->pdf_forward = chance * e.origin_pdf;
    v->weight = e.flux;
    *direction = e.direction;
    *pdf = e.pdf;
    *parallel = e.parallel;
    return e.pdf > 0.0 && sl_rgb_is_finite(v->weight) && sl_rgb_max(v->weight) > 0.0f &&
           sl_is_finite(v->origin);
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
