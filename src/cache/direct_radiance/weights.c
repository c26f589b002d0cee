#include "cache/direct_radiance/weights.h"

#include "cache/direct_radiance/light_receivers.h"
#include "cache/direct_radiance/receiver_kernels.h"
#include "trace/bsdf.h"

/* The samples that stand for the same light's hemisphere in (11), those included where nothing is; photons made by hand are a sample
 * each. */
static float samples_of_light(const sl_map_photons *photons, size_t photon) {
    size_t samples = 0;
    for (size_t l = 0; l < SL_MAP_POINTS_MAX; l++) {
        size_t first = photons->first_of_light[l], end = photons->first_of_light[l + 1];
        if (photon >= first && photon < end) samples = photons->samples_of_light[l] ? photons->samples_of_light[l] : end - first;
    }
    return samples ? (float)samples : (float)photons->count;
}

sl_weight_terms sl_weight_terms_of(const sl_map_photons *photons, size_t photon) {
    double nearest = (double)photons->nearest, diagonal = (double)photons->box_diagonal;
    bool has_size = diagonal > 1e-12 && diagonal < 1e12;
    int exponent = 0;
    (void)frexp(diagonal, &exponent);
    return (sl_weight_terms){(float)(nearest * nearest), (float)(2.0 * SL_PI) / samples_of_light(photons, photon),
                             diagonal > 0.0 ? (float)(1.0 / (diagonal * diagonal)) : 0.0f,
                             has_size ? (float)ldexp(1.0, -2 * exponent) : 1.0f};
}

/* The polygon weight's place where the footprint is no polygon is taken by the flux weight. A polygon is multiplied by the flux as it is:
 * the plain weight's colour, in units of 1. */
static sl_weight_form form_of(const sl_map_photons *photons, size_t photon, sl_photon_weight *weight, sl_weight_terms *terms) {
    *terms = sl_weight_terms_of(photons, photon);
    if (sl_weight_is_cosine(*weight)) return SL_FORM_COSINE;
    const sl_photon_quad *quad = *weight == SL_WEIGHT_POLYGON && photons->quad ? &photons->quad[photon] : NULL;
    if (!quad || quad->count != 4 || !(quad->area > 0.0f)) return SL_FORM_DISC;
    *weight = SL_WEIGHT_PLAIN;
    terms->unit = 1.0f;
    return SL_FORM_POLYGON;
}

sl_weight_form sl_photon_load(const sl_map_photons *photons, size_t photon, sl_photon_weight weight, sl_photon_registers *registers) {
    sl_lobe_registers lobe;
    sl_weight_terms terms;
    sl_map_photon p = photons->lobe ? sl_photon_with_lobe(photons, photon, weight, &lobe) : photons->photon[photon];
    sl_weight_form form = form_of(photons, photon, &weight, &terms);
    *registers = sl_photon_registers_of(&p, weight, terms);
    return form;
}

/* L_o of the printed weights depends on where it is seen from. */
sl_map_photon sl_photon_with_lobe(const sl_map_photons *photons, size_t photon, sl_photon_weight weight, sl_lobe_registers *out) {
    const sl_photon_lobe *lobe = &photons->lobe[photon];
    sl_map_photon p = photons->photon[photon], glossy;
    sl_rgb arriving = sl_weight_is_printed(weight) ? p.radiance : p.flux;
    glossy = p;
    glossy.flux = sl_rgb_mul(arriving, sl_rgb_scale(lobe->specular, (lobe->exponent + 2.0f) * (float)(0.5 / SL_PI)));
    glossy.radiance = glossy.flux;
    sl_weight_terms terms;
    (void)form_of(photons, photon, &weight, &terms);
    sl_photon_registers r = sl_photon_registers_of(&glossy, weight, terms);
    sl_vec3 mirrored = sl_normalize_or(sl_reflect(lobe->to_light, lobe->normal), lobe->normal);
    *out = (sl_lobe_registers){mirrored.x, mirrored.y, mirrored.z, lobe->exponent, {r.red, r.green, r.blue}};
    p.flux = p.radiance = sl_rgb_mul(arriving, sl_rgb_scale(lobe->diffuse, (float)(1.0 / SL_PI)));
    return p;
}

static sl_polygon_light triangle_of(sl_vec3 a, sl_vec3 b, sl_vec3 c, sl_vec3 normal) {
    sl_vec3 winding = sl_cross(sl_sub(b, a), sl_sub(c, a)), centre = sl_scale(sl_add(sl_add(a, b), c), 1.0f / 3.0f);
    bool turned = sl_dot(winding, normal) < 0.0f;
    sl_polygon_light t = {.corner = {a, turned ? c : b, turned ? b : c}, .normal = normal, .area = 0.5f * sl_length(winding)};
    for (int k = 0; k < 3; k++) {
        sl_vec3 d = sl_sub(t.corner[k], centre);
        t.extent_squared = fmaxf(t.extent_squared, sl_dot(d, d));
    }
    return t;
}

void sl_photon_polygon_of(const sl_map_photons *photons, size_t photon, sl_photon_polygon *polygon) {
    const sl_photon_quad *q = &photons->quad[photon];
    sl_vec3 normal = photons->photon[photon].normal;
    for (int c = 0; c < 4; c++) polygon->corner[c] = q->corner[c];
    polygon->depth = q->depth;
    polygon->over_area = q->area > 0.0f ? 1.0f / q->area : 0.0f;
    for (int t = 0; t < 2; t++) polygon->triangle[t] = triangle_of(q->corner[0], q->corner[1 + t], q->corner[2 + t], normal);
}

/* ---- the plain form ---- */

/* Pi / A_q at one point, by the lanes' kernel. */
static float polygon_weight(const sl_map_photons *photons, size_t photon, const sl_photon_registers *p, sl_vec3 x, sl_vec3 n,
                            sl_vec3 shading) {
    sl_light_points at = {1, &x.x, &x.y, &x.z, &n.x, &n.y, &n.z, &shading.x, &shading.y, &shading.z};
    sl_photon_polygon polygon;
    float pi[2] = {0.0f, 0.0f};
    sl_photon_polygon_of(photons, photon, &polygon);
    for (int t = 0; t < 2; t++) sl_polygon_light_baseline(&at, &polygon.triangle[t], &pi[t]);
    return sl_polygon_weight(p, &polygon, x, n, pi[0] + pi[1]);
}

sl_rgb sl_photon_irradiance(const sl_map_photons *photons, size_t photon, sl_photon_weight weight, sl_vec3 x, sl_vec3 n, sl_vec3 shading) {
    sl_photon_registers p;
    sl_weight_form form = sl_photon_load(photons, photon, weight, &p);
    float w = form == SL_FORM_COSINE ? sl_cosine_weight(&p, x, n, shading)
              : form == SL_FORM_DISC ? sl_disc_weight(&p, x, n, shading)
                                     : polygon_weight(photons, photon, &p, x, n, shading);
    sl_rgb e = {p.red * w, p.green * w, p.blue * w};
    if (!photons->lobe) return e;
    sl_lobe_registers lobe;
    (void)sl_photon_with_lobe(photons, photon, weight, &lobe);
    sl_vec3 d = sl_v3(x.x - p.x, x.y - p.y, x.z - p.z);
    float power = sl_lobe_power(lobe.x * d.x + lobe.y * d.y + lobe.z * d.z, sl_dot(d, d), lobe.exponent), share = w * power;
    return (sl_rgb){e.r + lobe.colour.r * share, e.g + lobe.colour.g * share, e.b + lobe.colour.b * share};
}
