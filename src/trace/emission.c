#include "trace/emission.h"

#include "base/math.h"
#include "trace/bsdf.h"

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

double sl_seen_area(const sl_scene *scene, sl_vec3 direction) {
    sl_vec3d faces = lit_faces(scene, sl_to_double(direction));
    return faces.x + faces.y + faces.z;
}

/* The integral of sl_seen_area() over the sphere: a convex body's mean cross-section is a quarter of its
 * surface (Cauchy). */
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

static bool enter_box(const sl_scene *scene, sl_vec3 direction, float face, float u, float v,
                      sl_emission *e) {
    double area = sl_seen_area(scene, direction);
    e->direction = e->normal = direction;
    e->origin = entry_point(scene, sl_to_double(direction), face, u, v);
    e->parallel = true;
    e->pdf = 1.0 / area;
    return area > 0.0;
}

/* ---- powers ---------------------------------------------------------------------------------- */

/* Smoothstep's mean is a half; a spot without width gives nothing. */
static double cone_solid_angle(const sl_light *light) {
    if (light->type == SL_LIGHT_POINT) return 4.0 * SL_PI;
    return 2.0 * SL_PI * fmax(1.0 - 0.5 * ((double)light->cos_inner + (double)light->cos_outer), 0.0);
}

double sl_cone_pdf(const sl_light *light, float cosine) {
    double solid_angle = cone_solid_angle(light);
    if (!(solid_angle > 0.0)) return 0.0;
    const bool spot = light->type == SL_LIGHT_SPOT;
    return (spot ? (double)sl_spot_falloff(cosine, light->cos_inner, light->cos_outer) : 1.0) / solid_angle;
}

static double emitter_extent(const sl_emitter *emitter) {
    return SL_PI * (double)emitter->area * (emitter->two_sided ? 2.0 : 1.0);
}

/* Returns what its intensity, or irradiance, is to be multiplied by for its flux. */
static double light_extent(const sl_scene *scene, const sl_light *light) {
    return light->type == SL_LIGHT_DIRECTIONAL ? sl_seen_area(scene, light->direction)
                                               : cone_solid_angle(light);
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
            line += luminance(radiance) * (double)solid_angle * sl_seen_area(scene, direction);
        }
        flux += line;
    }
    return flux;
}

double sl_light_power(const sl_scene *scene, uint32_t entry) {
    size_t light = entry - scene->emitter_count;
    if (entry < scene->emitter_count)
        return luminance(scene->emitters[entry].radiance) * emitter_extent(&scene->emitters[entry]);
    if (light >= scene->light_count) return environment_power(scene);
    return luminance(scene->lights[light].intensity) * light_extent(scene, &scene->lights[light]);
}

/* ---- emission -------------------------------------------------------------------------------- */

static sl_rgb times(sl_rgb colour, double scale) {
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

/* The cosine of a spot's ray with its axis: uniform in the inner cone, which holds 1 - cos_inner of all. */
static float spot_cosine(const sl_light *light, float number) {
    double inner = (double)light->cos_inner, outer = (double)light->cos_outer;
    double full = 1.0 - inner, edge = fmax(0.5 * (inner - outer), 0.0), u = (double)number * (full + edge);
    if (u < full || !(edge > 0.0)) return (float)fmax(1.0 - u, inner);
    return (float)(outer + (inner - outer) * smoothstep_sample(fmin((u - full) / edge, 1.0)));
}

static bool emit_from_light(const sl_scene *scene, const sl_light *light, const float *number,
                            sl_emission *e) {
    if (light->type == SL_LIGHT_DIRECTIONAL)
        return enter_box(scene, light->direction, number[2], number[0], number[1], e);
    bool spot = light->type == SL_LIGHT_SPOT;
    sl_vec3 axis = spot ? light->direction : sl_v3(0.0f, 0.0f, 1.0f);
    float cosine = spot ? spot_cosine(light, number[0]) : 1.0f - 2.0f * number[0];
    e->origin = light->position;
    e->direction = sl_direction_around(axis, cosine, number[1]);
    e->pdf = sl_cone_pdf(light, cosine);
    return true;
}

static bool emit_from_triangle(const sl_scene *scene, const sl_emitter *emitter, const float *number,
                               sl_emission *e) {
    uint32_t t = emitter->triangle;
    /* Uniform on the triangle: (1 - sqrt u1, sqrt u1 (1 - u2), sqrt u1 u2). */
    float s = sqrtf(number[2]), w1 = s * (1.0f - number[3]), w2 = s * number[3];
    if (sl_scene_has_alpha(scene, t) && !sl_scene_is_opaque(scene, t, w1, w2)) return false;
    e->normal = sl_scene_geometric_normal(scene, t);
    if (emitter->two_sided && number[4] < 0.5f) e->normal = sl_neg(e->normal);
    sl_surface surface;
    sl_scene_surface(scene, t, w1, w2, e->normal, &surface);
    float cosine = sqrtf(1.0f - number[0]);
    e->origin = sl_surface_lift(scene, t, &surface);
    e->direction = sl_direction_around(e->normal, cosine, number[1]);
    e->triangle = t;
    e->pdf = (double)cosine / (emitter->two_sided ? 2.0 * SL_PI : SL_PI);
    e->origin_pdf = 1.0 / (double)emitter->area;
    return true;
}

static bool emit_from_sky(const sl_scene *scene, const float *number, double scale, sl_emission *e) {
    sl_rgb radiance;
    float pdf;
    sl_vec3 towards = sl_environment_sample(&scene->environment, number[0], number[1], &radiance, &pdf);
    if (!(pdf > 0.0f) || !enter_box(scene, sl_neg(towards), number[4], number[2], number[3], e)) return false;
    e->environment = true;
    e->origin_pdf = (double)pdf;
    e->flux = times(radiance, sl_seen_area(scene, e->direction) / (double)pdf * scale);
    return true;
}

bool sl_light_emit(const sl_scene *scene, uint32_t entry, const float number[SL_EMISSION_NUMBERS],
                   double scale, sl_emission *e) {
    size_t light = entry - scene->emitter_count;
    *e = (sl_emission){.triangle = SL_NO_INDEX, .origin_pdf = 1.0};
    if (entry < scene->emitter_count) {
        const sl_emitter *emitter = &scene->emitters[entry];
        e->flux = times(emitter->radiance, emitter_extent(emitter) * scale);
        return emit_from_triangle(scene, emitter, number, e);
    }
    if (light >= scene->light_count) return emit_from_sky(scene, number, scale, e);
    e->flux = times(scene->lights[light].intensity, light_extent(scene, &scene->lights[light]) * scale);
    return emit_from_light(scene, &scene->lights[light], number, e);
}
