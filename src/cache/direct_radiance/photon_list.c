/* Samples become photons: the footprint's printed form, the lobe and the polygon beside it. */
#include "cache/direct_radiance/photon_list.h"

#include "base/math.h"
#include "cache/direct_radiance/footprint.h"

static sl_rgb rgb_of(const double c[3]) { return (sl_rgb){(float)c[0], (float)c[1], (float)c[2]}; }

/* The material without the texture, which the map's true colour has. */
static void find_lobe(const sl_radiance_map *map, const sl_map_texel *t, double diffuse[3], double specular[3], double *exponent) {
    if (map->lambertian) return;
    const sl_rgb s = t->material->specular;
    const double ks[3] = {(double)s.r, (double)s.g, (double)s.b};
    for (int k = 0; k < 3; k++) {
        diffuse[k] = t->color[k];
        specular[k] = ks[k];
    }
    *exponent = (double)t->material->exponent;
}

sl_photon_sample sl_photon_of_texel(const sl_photon_list *list, const sl_map_texel *t, double times, sl_texel_rectangle rectangle) {
    sl_photon_sample s = {.position = t->position, .normal = t->normal, .shading = t->shading, .to_light = t->to_light,
                          .cos_alpha = t->cos_alpha, .footprint = times * t->footprint, .way = t->way, .object = t->object,
                          .rectangle = rectangle};
    for (int k = 0; k < 3; k++) {
        s.flux[k] = times * t->flux[k];
        s.radiance[k] = sl_printed_radiance(list->map, t, k);
    }
    find_lobe(list->map, t, s.diffuse, s.specular, &s.exponent);
    return s;
}

/* A of (13) with A' of (12) and w := m; a directional light's A' is its block's area. */
static double printed_area(const sl_photon_list *list, const sl_map_face *face, const sl_photon_sample *s) {
    double footprint;
    if (sl_face_is_directional(list->map, face)) {
        footprint = (face->right - face->left) / face->columns * ((face->top - face->bottom) / face->rows);
    } else {
        footprint = sl_printed_footprint(s->way, sl_atan(face->right) - sl_atan(face->left), face->columns);
    }
    return sl_printed_tilted_footprint(footprint, s->cos_alpha);
}

static bool photon_is_sound(const sl_map_photon *p) {
    return sl_is_finite(p->position) && sl_is_finite(p->normal) && sl_rgb_is_finite(p->flux) && sl_rgb_is_finite(p->radiance) &&
           isfinite(p->printed_area) && isfinite(p->footprint) && p->footprint > 0.0f && p->cos_alpha > 0.0f &&
           sl_rgb_max(p->flux) > 0.0f;
}

/* Texels of several surfaces in one photon have a mean plane that may pass close to the light, where the polygon is far smaller than what
 * they cover: its radiance would be that much too large. */
static bool holds_surface(const sl_photon_quad *quad, const sl_photon_sample *s) {
    return 2.0 * (double)quad->area * s->cos_alpha >= s->footprint;
}

void sl_photon_add(sl_photon_list *list, const sl_map_face *face, const sl_photon_sample *s) {
    sl_map_photons *photons = list->photons;
    if (photons->count == photons->room) return;
    sl_map_photon *photon = &photons->photon[photons->count];
    *photon = (sl_map_photon){.position = sl_to_float(s->position), .footprint = (float)s->footprint, .flux = rgb_of(s->flux),
                              .cos_alpha = (float)fmin(s->cos_alpha, 1.0), .normal = sl_to_float(s->normal),
                              .printed_area = (float)printed_area(list, face, s), .radiance = rgb_of(s->radiance), .object = s->object};
    if (!photon_is_sound(photon)) return;
    if (photons->lobe) {
        photons->lobe[photons->count] = (sl_photon_lobe){rgb_of(s->diffuse), rgb_of(s->specular), (float)s->exponent,
                                                         sl_to_float(s->to_light), sl_to_float(s->shading)};
    }
    if (photons->quad) {
        sl_photon_quad *quad = &photons->quad[photons->count];
        sl_photon_quad_find(list->map, face, s, quad);
        if (!holds_surface(quad, s)) *quad = (sl_photon_quad){0};
        quad->depth = sqrtf(quad->area) * (s->bent ? 0.05f : 1e-4f); /* 0.09 of the radius, as in visibility.c; or rounding */
    }
    photons->count++;
}
