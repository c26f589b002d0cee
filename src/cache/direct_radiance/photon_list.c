/* Samples become photons: the footprint's printed form, the lobe and the polygon beside it. */
#include "cache/direct_radiance/photon_list.h"

#include "base/math.h"
#include "cache/direct_radiance/footprint.h"

static sl_vec3 to_float(sl_vec3d a) { return sl_to_float(a); }
static sl_rgb rgb_of(const double c[3]) { return (sl_rgb){(float)c[0], (float)c[1], (float)c[2]}; }

static sl_vec3d unit_or(sl_vec3d a, sl_vec3d fallback) {
    double length = sl_lengthd(a);
    return length > 0.0 && isfinite(length) ? sl_scaled(a, 1.0 / length) : fallback;
}

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
        s.radiance[k] = list->map->lambertian ? t->color[k] : 0.0;
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

void sl_photon_add(sl_photon_list *list, const sl_map_face *face, const sl_photon_sample *s) {
    sl_map_photons *photons = list->photons;
    if (photons->count == photons->room) return;
    sl_map_photon *photon = &photons->photon[photons->count];
    *photon = (sl_map_photon){.position = to_float(s->position), .footprint = (float)s->footprint, .flux = rgb_of(s->flux),
                              .cos_alpha = (float)fmin(s->cos_alpha, 1.0), .normal = to_float(s->normal),
                              .printed_area = (float)printed_area(list, face, s), .radiance = rgb_of(s->radiance), .object = s->object};
    if (!photon_is_sound(photon)) return;
    if (photons->lobe) {
        photons->lobe[photons->count] = (sl_photon_lobe){rgb_of(s->diffuse), rgb_of(s->specular), (float)s->exponent,
                                                         to_float(s->to_light), to_float(s->shading)};
    }
    if (photons->quad) sl_photon_quad_find(list->map, face, s, &photons->quad[photons->count]);
    photons->count++;
}

static void add_scaled(sl_vec3d *sum, sl_vec3d a, double s) { *sum = sl_addd(*sum, sl_scaled(a, s)); }

void sl_photon_sum_add(sl_photon_sum *sum, const sl_map_texel *t, double share, double of_block, int column, int row) {
    double weight = share * t->luminance;
    const sl_texel_rectangle place = {column, row, column + 1, row + 1};
    if (!(weight > 0.0)) return;
    if (!(sum->luminance > 0.0)) {
        *sum = (sl_photon_sum){.first_normal = t->normal, .object = t->object, .material = t->material, .rectangle = place};
    }
    add_scaled(&sum->position, t->position, weight);
    add_scaled(&sum->normal, t->normal, weight);
    add_scaled(&sum->shading, t->shading, weight);
    add_scaled(&sum->to_light, t->to_light, weight);
    sum->luminance += weight;
    sum->way += weight * t->way;
    sum->area += share * t->footprint / fmax(t->cos_alpha, SL_GROUP_COS_MIN);
    const sl_rgb s = t->material->specular;
    const double ks[3] = {(double)s.r, (double)s.g, (double)s.b};
    double glossy = weight * fmax(fmax(ks[0], ks[1]), ks[2]);
    for (int k = 0; k < 3; k++) {
        sum->flux[k] += share * t->flux[k];
        sum->radiance[k] += of_block * t->color[k];
        sum->diffuse[k] += share * t->flux[k] * t->color[k];
        sum->specular[k] += share * t->flux[k] * ks[k];
    }
    sum->glossy += glossy;
    sum->exponent += glossy * (double)t->material->exponent;
    sum->rectangle.left = fmin(sum->rectangle.left, place.left);
    sum->rectangle.bottom = fmin(sum->rectangle.bottom, place.bottom);
    sum->rectangle.right = fmax(sum->rectangle.right, place.right);
    sum->rectangle.top = fmax(sum->rectangle.top, place.top);
}

void sl_photon_sum_finish(sl_photon_list *list, const sl_map_face *face, const sl_photon_sum *sum) {
    if (!(sum->luminance > 0.0)) return;
    double mean = 1.0 / sum->luminance;
    sl_photon_sample s = {.position = sl_scaled(sum->position, mean), .normal = unit_or(sum->normal, sum->first_normal),
                          .way = sum->way * mean, .object = sum->object, .rectangle = sum->rectangle};
    s.shading = unit_or(sum->shading, s.normal);
    s.to_light = unit_or(sum->to_light, s.normal);
    s.cos_alpha = fmax(sl_dotd(s.normal, s.to_light), SL_GROUP_COS_MIN);
    s.footprint = sum->area * s.cos_alpha; /* of which the flux weight makes A again */
    for (int k = 0; k < 3; k++) {
        s.flux[k] = sum->flux[k];
        s.radiance[k] = list->map->lambertian ? sum->radiance[k] : 0.0;
        if (list->map->lambertian || !(sum->flux[k] > 0.0)) continue;
        s.diffuse[k] = sum->diffuse[k] / sum->flux[k];
        s.specular[k] = sum->specular[k] / sum->flux[k];
    }
    s.exponent = sum->glossy > 0.0 ? sum->exponent / sum->glossy : 0.0;
    sl_photon_add(list, face, &s);
}
