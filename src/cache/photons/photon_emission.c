#include "cache/photons/photon_emission.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "trace/bsdf.h"

struct sl_photon_sources {
    const sl_scene *scene;
    size_t count;    /* emitters, then lights, then the environment if there is one */
    double *power;   /* of each */
    double *sums;    /* cumulative */
    double total;
};

static double luminance(sl_rgb c) {
    return 0.2126 * (double)c.r + 0.7152 * (double)c.g + 0.0722 * (double)c.b;
}

/* ---- parallel light enters the scene's box --------------------------------------------------- */

/* Returns the areas of the box's three lit faces, as light of that direction sees them. */
static sl_vec3d lit_faces(const sl_scene *scene, sl_vec3d direction) {
    sl_vec3d size = sl_subd(sl_to_double(scene->box_max), sl_to_double(scene->box_min));
    return sl_v3d(fabs(direction.x) * size.y * size.z, fabs(direction.y) * size.z * size.x,
                  fabs(direction.z) * size.x * size.y);
}

static double seen_area(const sl_scene *scene, sl_vec3d direction) {
    sl_vec3d faces = lit_faces(scene, direction);
    return faces.x + faces.y + faces.z;
}

/* The integral of seen_area() over the sphere: a convex body's mean cross-section is a quarter of its surface
 * (Cauchy). */
static double seen_from_everywhere(const sl_scene *scene) {
    sl_vec3d size = sl_subd(sl_to_double(scene->box_max), sl_to_double(scene->box_min));
    return SL_PI * 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
}

static double at_face(double low, double high, double direction) { return direction > 0.0 ? low : high; }

/* A point of a lit face, uniform as the light sees them, and a little back: the scene may touch the face. */
static sl_vec3 entry_point(const sl_scene *scene, sl_vec3d direction, float face, float u, float v) {
    sl_vec3d faces = lit_faces(scene, direction), low = sl_to_double(scene->box_min),
             high = sl_to_double(scene->box_max);
    double chosen = (double)face * (faces.x + faces.y + faces.z), s = (double)u, t = (double)v;
    sl_vec3d p = sl_v3d(low.x + s * (high.x - low.x), low.y + t * (high.y - low.y),
                        at_face(low.z, high.z, direction.z));
    if (chosen < faces.x) {
        p = sl_v3d(at_face(low.x, high.x, direction.x), low.y + s * (high.y - low.y),
                   low.z + t * (high.z - low.z));
    } else if (chosen < faces.x + faces.y) {
        p = sl_v3d(low.x + s * (high.x - low.x), at_face(low.y, high.y, direction.y),
                   low.z + t * (high.z - low.z));
    }
    return sl_to_float(sl_subd(p, sl_scaled(direction, 1e-2 * (double)scene->diagonal)));
}

/* ---- powers ---------------------------------------------------------------------------------- */

/* Smoothstep's mean is a half; a spot without width gives nothing. */
static double spot_solid_angle(const sl_light *light) {
    return 2.0 * SL_PI * fmax(1.0 - 0.5 * ((double)light->cos_inner + (double)light->cos_outer), 0.0);
}

static double emitter_area(const sl_emitter *emitter) {
    return SL_PI * (double)emitter->area * (emitter->two_sided ? 2.0 : 1.0);
}

/* Returns what its intensity, or irradiance, is to be multiplied by for its flux. */
static double light_extent(const sl_scene *scene, const sl_light *light) {
    switch (light->type) {
    case SL_LIGHT_POINT: return 4.0 * SL_PI;
    case SL_LIGHT_SPOT: return spot_solid_angle(light);
    case SL_LIGHT_DIRECTIONAL: return seen_area(scene, sl_to_double(light->direction));
    }
    return 0.0;
}

static double environment_power(const sl_scene *scene) {
    const sl_environment *e = &scene->environment;
    if (e->width == 0) return luminance(e->constant) * seen_from_everywhere(scene);
    double flux = 0.0;
    for (int row = 0; row < e->height; row++) {
        double line = 0.0;
        for (int column = 0; column < e->width; column++) {
            sl_rgb radiance;
            float solid_angle;
            sl_vec3 direction = sl_environment_texel(e, row, column, &radiance, &solid_angle);
            line += luminance(radiance) * (double)solid_angle * seen_area(scene, sl_to_double(direction));
        }
        flux += line;
    }
    return flux;
}

static void fill_powers(sl_photon_sources *sources) {
    const sl_scene *scene = sources->scene;
    double *power = sources->power;
    for (size_t i = 0; i < scene->emitter_count; i++) {
        *power++ = luminance(scene->emitters[i].radiance) * emitter_area(&scene->emitters[i]);
    }
    for (size_t i = 0; i < scene->light_count; i++) {
        *power++ = luminance(scene->lights[i].intensity) * light_extent(scene, &scene->lights[i]);
    }
    if (scene->environment.present) *power = environment_power(scene);
    for (size_t i = 0; i < sources->count; i++) {
        if (!(sources->power[i] > 0.0) || !isfinite(sources->power[i])) sources->power[i] = 0.0;
        sources->sums[i] = sources->total += sources->power[i];
    }
    if (!isfinite(sources->total)) sources->total = 0.0;
}

sl_status sl_photon_sources_create(const sl_scene *scene, sl_photon_sources **out, sl_error *error) {
    *out = NULL;
    sl_photon_sources *sources = sl_allocate(1, sizeof *sources);
    if (!sources) return sl_fail_memory(error, "the photons' lights");
    sources->scene = scene;
    sources->count = scene->emitter_count + scene->light_count + (scene->environment.present ? 1 : 0);
    sources->power = sl_allocate(sources->count, sizeof *sources->power);
    sources->sums = sl_allocate(sources->count, sizeof *sources->sums);
    if (!sources->power || !sources->sums) {
        sl_photon_sources_destroy(sources);
        return sl_fail_memory(error, "the photons' lights");
    }
    fill_powers(sources);
    *out = sources;
    return SL_OK;
}

void sl_photon_sources_destroy(sl_photon_sources *sources) {
    if (!sources) return;
    sl_free(sources->power);
    sl_free(sources->sums);
    sl_free(sources);
}

double sl_photon_sources_power(const sl_photon_sources *sources) { return sources->total; }

/* ---- emission -------------------------------------------------------------------------------- */

/* The first source whose sum exceeds u: never one without power. Rounding may leave a gap at the end: it is
 * the last source's. */
static size_t choose(const sl_photon_sources *sources, double u) {
    size_t low = 0, high = sources->count - 1;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (u < sources->sums[middle]) high = middle;
        else low = middle + 1;
    }
    while (low > 0 && !(sources->power[low] > 0.0)) low--;
    return low;
}

/* Of the whole light's flux, colour x extent, as if all photons were its own: P(choice) = its power / total.
 */
static sl_rgb shared_flux(const sl_photon_sources *sources, size_t source, sl_rgb colour, double extent) {
    double scale = extent * (sources->total / sources->power[source]);
    return (sl_rgb){(float)((double)colour.r * scale), (float)((double)colour.g * scale),
                    (float)((double)colour.b * scale)};
}

/* x in [0,1] with density proportional to smoothstep(x) = 3 x^2 - 2 x^3: the root of 2 x^3 - x^4 = u, which
 * rises, by halving. */
static double smoothstep_sample(double u) {
    double low = 0.0, high = 1.0;
    for (int i = 0; i < 32; i++) {
        double x = 0.5 * (low + high);
        if (x * x * x * (2.0 - x) < u) low = x;
        else high = x;
    }
    return 0.5 * (low + high);
}

/* The cosine of a spot's photon with its axis: uniform in the inner cone, which holds 1 - cos_inner of all.
 */
static float spot_cosine(const sl_light *light, float number) {
    double inner = (double)light->cos_inner, outer = (double)light->cos_outer;
    double full = 1.0 - inner, edge = fmax(0.5 * (inner - outer), 0.0), u = (double)number * (full + edge);
    if (u < full || !(edge > 0.0)) return (float)fmax(1.0 - u, inner);
    return (float)(outer + (inner - outer) * smoothstep_sample(fmin((u - full) / edge, 1.0)));
}

static void emit_from_light(const sl_scene *scene, const sl_light *light, const float *number,
                            sl_emitted_photon *photon) {
    photon->triangle = SL_NO_INDEX;
    photon->origin = light->position;
    photon->parallel = light->type == SL_LIGHT_DIRECTIONAL;
    if (light->type == SL_LIGHT_POINT) {
        photon->direction = sl_direction_around(sl_v3(0.0f, 0.0f, 1.0f), 1.0f - 2.0f * number[0], number[1]);
    } else if (light->type == SL_LIGHT_SPOT) {
        photon->direction = sl_direction_around(light->direction, spot_cosine(light, number[0]), number[1]);
    } else {
        photon->direction = light->direction;
        photon->origin = entry_point(scene, sl_to_double(light->direction), number[2], number[0], number[1]);
    }
}

static bool emit_from_triangle(const sl_scene *scene, const sl_emitter *emitter, const float *number,
                               sl_emitted_photon *photon) {
    uint32_t t = emitter->triangle;
    /* Uniform on the triangle: (1 - sqrt u1, sqrt u1 (1 - u2), sqrt u1 u2). */
    float s = sqrtf(number[2]), w1 = s * (1.0f - number[3]), w2 = s * number[3];
    if (sl_scene_has_alpha(scene, t) && !sl_scene_is_opaque(scene, t, w1, w2)) return false;
    sl_vec3 side = sl_scene_geometric_normal(scene, t);
    if (emitter->two_sided && number[4] < 0.5f) side = sl_neg(side);
    sl_surface surface;
    sl_scene_surface(scene, t, w1, w2, side, &surface);
    photon->origin = sl_surface_lift(scene, t, &surface);
    photon->direction = sl_direction_around(side, sqrtf(1.0f - number[0]), number[1]);
    photon->triangle = t;
    photon->parallel = false;
    return true;
}

bool sl_photon_emit(const sl_photon_sources *sources, double select, const float number[SL_EMISSION_NUMBERS],
                    sl_emitted_photon *photon) {
    const sl_scene *scene = sources->scene;
    if (!(sources->total > 0.0)) return false;
    size_t i = choose(sources, select * sources->total);
    photon->environment = i >= scene->emitter_count + scene->light_count;
    if (i < scene->emitter_count) {
        const sl_emitter *emitter = &scene->emitters[i];
        photon->flux = shared_flux(sources, i, emitter->radiance, emitter_area(emitter));
        return emit_from_triangle(scene, emitter, number, photon);
    }
    if (i < scene->emitter_count + scene->light_count) {
        const sl_light *light = &scene->lights[i - scene->emitter_count];
        photon->flux = shared_flux(sources, i, light->intensity, light_extent(scene, light));
        emit_from_light(scene, light, number, photon);
        return true;
    }
    sl_rgb radiance;
    float pdf;
    photon->direction =
        sl_neg(sl_environment_sample(&scene->environment, number[0], number[1], &radiance, &pdf));
    if (!(pdf > 0.0f)) return false;
    sl_vec3d direction = sl_to_double(photon->direction);
    photon->flux = shared_flux(sources, i, radiance, seen_area(scene, direction) / (double)pdf);
    photon->origin = entry_point(scene, direction, number[4], number[2], number[3]);
    photon->triangle = SL_NO_INDEX;
    photon->parallel = true;
    return true;
}
