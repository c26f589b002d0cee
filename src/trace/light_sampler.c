/* Direct light by Monte Carlo: one light is chosen in proportion to its power, then a point of it. Emissive
 * triangles are sampled uniformly by area, dA = d^2 / cos theta' d omega (Shirley, Wang and Zimmerman 1996);
 * the sky by its own distribution; lights without extent as they are. */
#include <math.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "trace/emission.h"
#include "trace/light_tree.h"
#include "trace/trace.h"

struct sl_light_sampler {
    const sl_scene *scene;
    size_t count;   /* emitters, then lights, then the environment if there is one */
    double *sums;   /* cumulative probabilities, the last chosen one ends at 1 */
    double *chance; /* of each */
    sl_light_tree *tree; /* of the emitters, where they are chosen by place; else NULL */
    double tree_share;   /* the probability that an emitter is chosen, whichever */
    double power;        /* luminance, W, of all */
};

/* ---- powers ---------------------------------------------------------------------------------- */

/* Never 0 for a light without width, or that sees the box edge-on: it still shines. */
static double power_of(const sl_scene *scene, size_t entry) {
    double power = sl_light_power(scene, (uint32_t)entry), least = 0.0;
    if (entry >= scene->emitter_count && entry < scene->emitter_count + scene->light_count) {
        const sl_light *light = &scene->lights[entry - scene->emitter_count];
        double extent = light->type == SL_LIGHT_DIRECTIONAL
                            ? (double)scene->diagonal * (double)scene->diagonal
                            : 2.0 * SL_PI;
        least = 1e-6 * extent * (double)sl_luminance(light->intensity);
    }
    power = fmax(power, least);
    return power > 0.0 && isfinite(power) ? power : 0.0;
}

static void fill_powers(sl_light_sampler *sampler, bool sky_light) {
    size_t sky = sampler->scene->emitter_count + sampler->scene->light_count;
    for (size_t i = 0; i < sampler->count; i++)
        sampler->chance[i] = i < sky || sky_light ? power_of(sampler->scene, i) : 0.0;
}

static void normalize(sl_light_sampler *sampler) {
    double total = 0.0;
    for (size_t i = 0; i < sampler->count; i++) total += sampler->chance[i];
    sampler->power = isfinite(total) ? total : 0.0;
    double sum = 0.0;
    size_t last = 0;
    for (size_t i = 0; i < sampler->count; i++) {
        sampler->chance[i] = total > 0.0 ? sampler->chance[i] / total : 0.0;
        sampler->sums[i] = sum += sampler->chance[i];
        if (sampler->chance[i] > 0.0) last = i;
    }
    /* Rounding must not leave a gap at the end into which a number could fall. */
    for (size_t i = last; total > 0.0 && i < sampler->count; i++) sampler->sums[i] = 1.0;
}

static sl_status create(const sl_scene *scene, bool sky_light, sl_light_sampler **out, sl_error *error) {
    *out = NULL;
    sl_light_sampler *sampler = sl_allocate(1, sizeof *sampler);
    if (!sampler) return sl_fail_memory(error, "the light sampler");
    sampler->scene = scene;
    sampler->count = scene->emitter_count + scene->light_count + (scene->environment.present ? 1 : 0);
    sampler->sums = sl_allocate(sampler->count, sizeof *sampler->sums);
    sampler->chance = sl_allocate(sampler->count, sizeof *sampler->chance);
    if (!sampler->sums || !sampler->chance) {
        sl_light_sampler_destroy(sampler);
        return sl_fail_memory(error, "the light sampler");
    }
    fill_powers(sampler, sky_light);
    normalize(sampler);
    *out = sampler;
    return SL_OK;
}

sl_status sl_light_sampler_create(const sl_scene *scene, sl_light_sampler **out, sl_error *error) {
    return create(scene, true, out, error);
}

sl_status sl_light_sampler_create_for(const sl_scene *scene, const sl_transport *transport,
                                      sl_light_sampler **out, sl_error *error) {
    return create(scene, transport->sky_light, out, error);
}

sl_status sl_light_sampler_plant_tree(sl_light_sampler *sampler, sl_error *error) {
    size_t emitters = sampler->scene->emitter_count;
    if (emitters == 0 || !(sampler->sums[emitters - 1] > 0.0)) return SL_OK;
    sampler->tree_share = sampler->sums[emitters - 1];
    return sl_light_tree_create(sampler->scene, &sampler->tree, error);
}

void sl_light_sampler_destroy(sl_light_sampler *sampler) {
    if (!sampler) return;
    sl_light_tree_destroy(sampler->tree);
    SL_FREE_ALL(sampler->sums, sampler->chance, sampler);
}

/* ---- sampling -------------------------------------------------------------------------------- */

/* The first entry whose cumulative probability exceeds u: never one that has none. */
static size_t choose(const sl_light_sampler *sampler, double u) {
    return sl_first_above(sampler->sums, sampler->count, u);
}

/* Solid-angle density of a uniform point of the triangle, seen along `direction` from `distance`; 0 from the
 * dark side. */
static double area_pdf(const sl_scene *scene, const sl_emitter *emitter, sl_vec3d direction,
                       double distance) {
    sl_vec3d normal = sl_to_double(sl_scene_geometric_normal(scene, emitter->triangle));
    double cosine = -sl_dotd(normal, direction);
    if (emitter->two_sided) cosine = fabs(cosine);
    if (!(cosine > 0.0) || !(distance > 0.0)) return 0.0;
    double pdf = distance * distance / ((double)emitter->area * cosine);
    return isfinite(pdf) ? pdf : 0.0;
}

static bool sample_emitter(const sl_scene *scene, const sl_emitter *emitter, double chance, sl_vec3 p,
                           float u1, float u2, sl_light_sample *sample) {
    /* Uniform on the triangle: (1 - sqrt u1, sqrt u1 (1 - u2), sqrt u1 u2). */
    double s = sqrt((double)u1), w1 = s * (1.0 - (double)u2), w2 = s * (double)u2;
    uint32_t t = emitter->triangle;
    sl_vec3d a = sl_to_double(sl_scene_position(scene, scene->vertex[0][t]));
    sl_vec3d b = sl_subd(sl_to_double(sl_scene_position(scene, scene->vertex[1][t])), a);
    sl_vec3d c = sl_subd(sl_to_double(sl_scene_position(scene, scene->vertex[2][t])), a);
    sl_vec3d to = sl_addd(sl_subd(a, sl_to_double(p)), sl_addd(sl_scaled(b, w1), sl_scaled(c, w2)));
    double distance = sl_lengthd(to);
    if (!(distance > 0.0) || !isfinite(distance)) return false;
    sl_vec3 direction = sl_to_float(sl_scaled(to, 1.0 / distance));
    double pdf = chance * area_pdf(scene, emitter, sl_to_double(direction), distance);
    if (!(pdf > 0.0)) return false;
    if (sl_scene_has_alpha(scene, t) && !sl_scene_is_opaque(scene, t, (float)w1, (float)w2)) return false;
    *sample = (sl_light_sample){direction,
                                (float)distance,
                                sl_rgb_scale(emitter->radiance, (float)(1.0 / pdf)),
                                (float)pdf,
                                (float)chance,
                                t,
                                (uint32_t)(emitter - scene->emitters)};
    return true;
}

static bool sample_light(const sl_light *light, double chance, sl_vec3 p, sl_light_sample *sample) {
    *sample = (sl_light_sample){.pdf = 0.0f, .chance = (float)chance, .triangle = SL_NO_INDEX};
    if (!sl_light_illuminate(light, p, &sample->to_light, &sample->distance, &sample->radiance)) return false;
    sample->radiance = sl_rgb_scale(sample->radiance, (float)(1.0 / chance));
    return true;
}

static bool sample_environment(const sl_environment *environment, double chance, float u1, float u2,
                               sl_light_sample *sample) {
    sl_rgb radiance;
    float pdf;
    sl_vec3 direction = sl_environment_sample(environment, u1, u2, &radiance, &pdf);
    double whole_pdf = chance * (double)pdf;
    if (!(whole_pdf > 0.0)) return false;
    *sample =
        (sl_light_sample){direction,        INFINITY,      sl_rgb_scale(radiance, (float)(1.0 / whole_pdf)),
                          (float)whole_pdf, (float)chance, SL_NO_INDEX,
                          SL_NO_INDEX};
    return true;
}

static bool sample_entry(const sl_light_sampler *sampler, size_t i, double chance, sl_vec3 p, float u1,
                         float u2, sl_light_sample *sample) {
    const sl_scene *scene = sampler->scene;
    if (!(chance > 0.0) || !sl_is_finite(p)) return false;
    bool lit;
    if (i < scene->emitter_count) lit = sample_emitter(scene, &scene->emitters[i], chance, p, u1, u2, sample);
    else if (i < scene->emitter_count + scene->light_count) {
        lit = sample_light(&scene->lights[i - scene->emitter_count], chance, p, sample);
    } else lit = sample_environment(&scene->environment, chance, u1, u2, sample);
    sample->entry = (uint32_t)i;
    return lit && sl_rgb_is_finite(sample->radiance) && sl_rgb_max(sample->radiance) > 0.0f;
}

/* The first part of the numbers leads to the tree, the rest to lights and environment as ever. */
bool sl_light_sampler_sample_at(const sl_light_sampler *sampler, sl_vec3 p, sl_vec3 normal, float select,
                                float u1, float u2, sl_light_sample *sample) {
    if (sampler->count == 0) return false;
    if (!sampler->tree || !((double)select < sampler->tree_share)) {
        const size_t i = choose(sampler, (double)select);
        return sample_entry(sampler, i, sampler->chance[i], p, u1, u2, sample);
    }
    uint32_t emitter;
    float chance, within = fminf((float)((double)select / sampler->tree_share), 0x1.fffffep-1f);
    if (!sl_is_finite(p) || !sl_light_tree_choose(sampler->tree, p, normal, within, &emitter, &chance))
        return false;
    return sample_entry(sampler, emitter, sampler->tree_share * (double)chance, p, u1, u2, sample);
}

double sl_light_sampler_power(const sl_light_sampler *sampler) { return sampler->power; }

uint32_t sl_light_sampler_entry(const sl_light_sampler *sampler, double u) {
    return (uint32_t)choose(sampler, u);
}

bool sl_light_sampler_choose(const sl_light_sampler *sampler, float *u, uint32_t *entry) {
    if (sampler->count == 0) return false;
    size_t i = choose(sampler, (double)*u);
    double start = i > 0 ? sampler->sums[i - 1] : 0.0, width = sampler->sums[i] - start;
    float rest = width > 0.0 ? (float)(((double)*u - start) / width) : 0.0f;
    *u = fminf(rest, 0x1.fffffep-1f);
    *entry = (uint32_t)i;
    return sampler->chance[i] > 0.0;
}

double sl_light_sampler_chance(const sl_light_sampler *sampler, uint32_t entry) {
    return sampler->chance[entry];
}

bool sl_light_sampler_sample_2d(const sl_light_sampler *sampler, sl_vec3 p, float u1, float u2,
                                sl_light_sample *sample) {
    uint32_t entry;
    return sl_light_sampler_choose(sampler, &u1, &entry) &&
           sample_entry(sampler, entry, sampler->chance[entry], p, u1, u2, sample);
}

float sl_light_sampler_pdf(const sl_light_sampler *sampler, sl_vec3 p, sl_vec3 direction, uint32_t triangle,
                           float distance) {
    (void)p; /* sampling by area is the same from everywhere */
    const sl_scene *scene = sampler->scene;
    if (triangle == SL_NO_INDEX) {
        if (!scene->environment.present) return 0.0f;
        return (float)(sampler->chance[sampler->count - 1] *
                       (double)sl_environment_pdf(&scene->environment, direction));
    }
    uint32_t emitter = scene->emitter_of_triangle[triangle];
    if (emitter == SL_NO_INDEX) return 0.0f;
    return (float)(sampler->chance[emitter] *
                   area_pdf(scene, &scene->emitters[emitter], sl_to_double(direction), (double)distance));
}
