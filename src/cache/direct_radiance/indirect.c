/* Pass 7: indirect light of receivers by (10), L_r = sum over photons f_r E_j.
 *
 * Where photons and receivers are Lambertian that is a sum of irradiances (the kernel in receiver_kernels.c).
 * Whatever else is wanted of a photon (its lobe, the receiver's, whether it is seen) is done with its weight
 * first, photon by photon, in the same order and with the same bits. Even and odd photons have sums of their
 * own, which are added at the end: their difference tells how much the whole depends on which photons were
 * taken. */
#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "cache/direct_radiance/direct_radiance.h"
#include "cache/direct_radiance/receivers.h"
#include "trace/bsdf.h"

#include <string.h>

struct sl_photon_sums {
    const sl_light_pass *pass;
    size_t count;
    sl_photon_registers *photon;
    sl_weight_form *form;
    sl_lobe_registers *lobe;    /* NULL where all photons are Lambertian */
    sl_photon_polygon *polygon; /* NULL unless polygons are wanted */
    bool plain;                 /* all photons are Lambertian, and of one form */
    /* of the even and the odd photons' sum in half the difference of what each would be alone */
    float share[2];
    sl_sight *sight;            /* NULL: photons are seen from everywhere */
    sl_receiver_kernels kernels;
    sl_sight_kernels sight_kernels;
};
typedef sl_photon_sums indirect_pass;

/* ---- once a frame: the j-indexed values ---- */

static bool make_tables(indirect_pass *p) {
    const sl_map_photons *photons = p->pass->photons;
    bool lobes = photons->lobe != NULL, polygons = p->pass->weight == SL_WEIGHT_POLYGON && photons->quad;
    p->photon = sl_allocate(p->count, sizeof *p->photon);
    p->form = sl_allocate(p->count, sizeof *p->form);
    if (lobes) p->lobe = sl_allocate(p->count, sizeof *p->lobe);
    if (polygons) p->polygon = sl_allocate(p->count, sizeof *p->polygon);
    return p->photon && p->form && (!lobes || p->lobe) && (!polygons || p->polygon);
}

static void fill_tables(indirect_pass *p) {
    const sl_map_photons *photons = p->pass->photons;
    p->plain = !p->lobe;
    for (size_t j = 0; j < p->count; j++) {
        p->form[j] = sl_photon_load(photons, j, p->pass->weight, &p->photon[j]);
        if (p->lobe) (void)sl_photon_with_lobe(photons, j, p->pass->weight, &p->lobe[j]);
        if (p->form[j] != SL_FORM_POLYGON) continue;
        sl_photon_polygon_of(photons, j, &p->polygon[j]);
        p->plain = false;
    }
    size_t odd = p->count / 2, even = p->count - odd;
    p->share[0] = 0.5f * (float)p->count / (float)even;
    p->share[1] = odd ? -0.5f * (float)p->count / (float)odd : 0.0f;
}

static void release(indirect_pass *p) {
    sl_sight_destroy(p->sight);
    sl_free(p->photon);
    sl_free(p->form);
    sl_free(p->lobe);
    sl_free(p->polygon);
}

/* ---- a photon and what is done with its weight ---- */

static void weigh(const indirect_pass *p, const sl_receiver_tile *tile, size_t j,
                  const sl_photon_registers *r, float *weight) {
    if (p->form[j] != SL_FORM_POLYGON) {
        p->kernels.weigh(tile, r, p->form[j] == SL_FORM_COSINE, weight);
        return;
    }
    const sl_light_points points = sl_receiver_tile_points(tile);
    float pi[2][SL_TILE_PIXELS], any = 0.0f;
    for (size_t i = 0; i < tile->padded; i++) pi[0][i] = 1.0f;
    p->kernels.weigh_polygon(tile, r, &p->polygon[j], pi[0], weight);
    for (size_t i = 0; i < tile->padded; i++) any = weight[i] > any ? weight[i] : any;
    if (!(any > 0.0f)) return; /* all of the tile is behind the photon: in a room, often */
    for (int t = 0; t < 2; t++) p->kernels.light.polygon(&points, &p->polygon[j].triangle[t], pi[t]);
    for (size_t i = 0; i < tile->padded; i++) pi[0][i] += pi[1][i];
    p->kernels.weigh_polygon(tile, r, &p->polygon[j], pi[0], weight);
}

static void weigh_unseen(const void *context, const sl_receiver_tile *tile, size_t j, float *weight) {
    const indirect_pass *p = context;
    weigh(p, tile, j, &p->photon[j], weight);
}

static void add(const indirect_pass *p, size_t count, sl_rgb colour, const float *weight,
                const float *visible, float (*sum)[SL_TILE_PIXELS]) {
    p->kernels.light.accumulate(count, colour, weight, visible, sum[0], sum[1], sum[2]);
}

/* Of this photon and the next ones. */
static void see(const indirect_pass *p, const sl_receiver_tile *tile, size_t first, sl_tile_sight *around,
                sl_counters *counters) {
    size_t left = p->count - first;
    sl_sight_see(p->sight, tile, around, first, left < SL_SIGHT_PHOTONS ? left : SL_SIGHT_PHOTONS, counters);
}

/* With the weights that know photons to have an area. */
static sl_lobe_target target_of(const indirect_pass *p, size_t j, const sl_photon_registers *r) {
    const sl_map_photon *photon = &p->pass->photons->photon[j];
    bool disc = p->pass->weight == SL_WEIGHT_FLUX || p->pass->weight == SL_WEIGHT_POLYGON;
    float extent = disc && photon->cos_alpha > 0.0f
                       ? photon->footprint / photon->cos_alpha * (float)(0.25 / SL_PI)
                       : 0.0f;
    if (!(extent > 0.0f) || !isfinite(extent)) extent = 0.0f;
    return (sl_lobe_target){.towards = {r->x, r->y, r->z}, .normal = {r->nx, r->ny, r->nz}, .extent = extent};
}

static void add_photon(const indirect_pass *p, const sl_receiver_tile *tile, bool glossy, size_t j,
                       sl_tile_sight *around, sl_tile_light *sum, sl_counters *counters) {
    const sl_photon_registers r = p->photon[j];
    const sl_rgb colour = {r.red, r.green, r.blue};
    const size_t count = tile->padded;
    float weight[SL_TILE_PIXELS], visible[SL_TILE_PIXELS], of_photon[SL_TILE_PIXELS],
        of_receiver[SL_TILE_PIXELS];
    weigh(p, tile, j, &r, weight);
    for (size_t i = 0; i < count; i++) visible[i] = 1.0f;
    if (p->sight) {
        if (j % SL_SIGHT_PHOTONS == 0) see(p, tile, j, around, counters);
        p->sight_kernels.tell(count, around, j % SL_SIGHT_PHOTONS, visible);
    }
    add(p, count, colour, weight, visible, sum->irradiance);
    if (p->lobe) {
        p->kernels.photon_lobe(tile, &r, &p->lobe[j], of_photon);
        p->kernels.multiply(count, weight, of_photon);
        add(p, count, p->lobe[j].colour, of_photon, visible, sum->irradiance);
    }
    if (!glossy) return;
    const sl_lobe_target target = target_of(p, j, &r);
    p->kernels.receiver_lobe(tile, &target, of_receiver);
    p->kernels.multiply(count, of_receiver, weight);
    add(p, count, colour, weight, visible, sum->lobe);
    if (!p->lobe) return;
    p->kernels.multiply(count, of_receiver, of_photon);
    add(p, count, p->lobe[j].colour, of_photon, visible, sum->lobe);
}

/* ---- a tile ---- */

/* All photons, even and odd ones apart, and both together. */
static void sum_photons(const indirect_pass *p, const sl_receiver_tile *tile, bool glossy,
                        sl_tile_light half[2], sl_tile_light *sum, sl_counters *counters) {
    static const float whole[2] = {1.0f, 1.0f};
    sl_tile_sight around;
    for (int h = 0; h < 2; h++) memset(&half[h], 0, glossy ? sizeof half[h] : sizeof half[h].irradiance);
    if (p->plain && !p->sight && !glossy) {
        p->kernels.sum(tile, p->photon, p->count, sl_weight_is_cosine(p->pass->weight), half);
    } else {
        if (p->sight) sl_sight_begin_tile(p->sight, tile, &around);
        for (size_t j = 0; j < p->count; j++) add_photon(p, tile, glossy, j, &around, &half[j % 2], counters);
    }
    p->kernels.combine(tile->padded, glossy, half, whole, sum);
}

void sl_indirect_light_tile(const sl_photon_sums *p, const sl_receiver_tile *tile, bool glossy,
                            const sl_tile_target *to, sl_counters *counters) {
    sl_tile_light half[2], sum, difference;
    sum_photons(p, tile, glossy, half, &sum, counters);
    p->kernels.reflect_to(tile, &sum, glossy, to->width, to->indirect);
    if (to->spread) {
        p->kernels.combine(tile->padded, glossy, half, p->share, &difference);
        p->kernels.reflect_spread(tile, &difference, glossy, to->spread);
    }
    sl_count(counters, SL_COUNT_PHOTON_LOOK_UPS, tile->count * p->count);
}

/* ---- photon by photon ---- */

static sl_rgb reflected(const sl_receiver_tile *tile, const sl_tile_light *light, bool glossy, size_t lane) {
    float radiance[3];
    for (int c = 0; c < 3; c++) {
        radiance[c] = light->irradiance[c][lane] * tile->diffuse[c][lane];
        if (glossy) radiance[c] += light->lobe[c][lane] * tile->specular[c][lane];
    }
    return (sl_rgb){radiance[0], radiance[1], radiance[2]};
}

void sl_indirect_light_apart(const sl_photon_sums *p, const sl_receiver_tile *tile, bool glossy, size_t lane,
                             sl_photon_told *told, void *context, sl_counters *counters) {
    sl_tile_sight around;
    sl_tile_light one;
    if (p->sight) sl_sight_begin_tile(p->sight, tile, &around);
    for (size_t j = 0; j < p->count; j++) {
        float weight[SL_TILE_PIXELS];
        memset(&one, 0, sizeof one);
        add_photon(p, tile, glossy, j, &around, &one, counters);
        const sl_rgb radiance = reflected(tile, &one, glossy, lane);
        if (radiance.r == 0.0f && radiance.g == 0.0f && radiance.b == 0.0f) continue;
        weigh(p, tile, j, &p->photon[j], weight);
        told(context, j, weight[lane], (float[3]){radiance.r, radiance.g, radiance.b});
    }
}

/* ---- a picture ---- */

sl_status sl_photon_sums_see(sl_photon_sums *sums, const sl_receivers *receivers,
                             const sl_receiver_kinds *kinds, sl_counters *counters, sl_error *error) {
    if (sums->pass->visibility == SL_VISIBILITY_NONE || !sums->pass->tracer) return SL_OK;
    return sl_sight_create(sums->pass, receivers, kinds, weigh_unseen, sums, &sums->sight, counters, error);
}

typedef struct {
    const sl_photon_sums *sums;
    sl_tile_target to;
} picture_pass;

static void light_tile(void *context, const sl_receiver_tile *tile, bool glossy, sl_counters *counters) {
    const picture_pass *p = context;
    sl_indirect_light_tile(p->sums, tile, glossy, &p->to, counters);
}

sl_status sl_light_indirectly(const sl_light_pass *pass, const sl_receivers *receivers,
                              sl_lit_picture *picture, float *spread, sl_counters *counters,
                              sl_error *error) {
    if (!pass->photons || pass->photons->count == 0) return SL_OK;
    sl_photon_sums *sums = NULL;
    sl_receiver_kinds kinds = {.of_material = NULL};
    float *const *indirect = picture->indirect;
    sl_status status = sl_photon_sums_create(pass, &sums, error);
    if (status != SL_OK) return status;
    picture_pass p = {
        sums,
        {.width = receivers->width, .indirect = {indirect[0], indirect[1], indirect[2]}, .spread = spread}};
    status = sl_receiver_kinds_find(pass->scene, pass->trick_albedo, &kinds, error);
    if (status == SL_OK) status = sl_photon_sums_see(sums, receivers, &kinds, counters, error);
    if (status == SL_OK)
        status = sl_receiver_tiles_run(receivers, &kinds, pass->threads, light_tile, &p, counters, error);
    sl_receiver_kinds_release(&kinds);
    sl_photon_sums_destroy(sums);
    return status;
}

/* ---- sums without a picture ---- */

sl_status sl_photon_sums_create(const sl_light_pass *pass, sl_photon_sums **sums, sl_error *error) {
    *sums = sl_allocate(1, sizeof **sums);
    if (!*sums) return sl_fail_memory(error, "photons of a frame");
    **sums = (sl_photon_sums){.pass = pass,
                              .count = pass->photons->count,
                              .kernels = sl_receiver_kernels_for(sl_isa_best()),
                              .sight_kernels = sl_sight_kernels_for(sl_isa_best())};
    if (make_tables(*sums)) {
        fill_tables(*sums);
        return SL_OK;
    }
    sl_photon_sums_destroy(*sums);
    *sums = NULL;
    return sl_fail_memory(error, "photons of a frame");
}

void sl_photon_sums_destroy(sl_photon_sums *sums) {
    if (!sums) return;
    release(sums);
    sl_free(sums);
}

void sl_photon_sums_irradiance(const sl_photon_sums *sums, const sl_receiver_tile *tile,
                               sl_tile_light *light) {
    sl_tile_light half[2];
    sl_counters ignored = {{0}};
    sum_photons(sums, tile, false, half, light, &ignored);
}

/* The samples that stand for the same light's hemisphere in (11), those included where nothing is; photons
 * made by hand are a sample each. */
static float samples_of_light(const sl_map_photons *photons, size_t photon) {
    size_t samples = 0;
    for (size_t l = 0; l < SL_MAP_POINTS_MAX; l++) {
        size_t first = photons->first_of_light[l], end = photons->first_of_light[l + 1];
        if (photon >= first && photon < end)
            samples = photons->samples_of_light[l] ? photons->samples_of_light[l] : end - first;
    }
    return samples ? (float)samples : (float)photons->count;
}

sl_weight_terms sl_weight_terms_of(const sl_map_photons *photons, size_t photon) {
    double nearest = (double)photons->nearest, diagonal = (double)photons->box_diagonal;
    bool has_size = diagonal > 1e-12 && diagonal < 1e12;
    int exponent = 0;
    (void)frexp(diagonal, &exponent);
    return (sl_weight_terms){(float)(nearest * nearest),
                             (float)(2.0 * SL_PI) / samples_of_light(photons, photon),
                             diagonal > 0.0 ? (float)(1.0 / (diagonal * diagonal)) : 0.0f,
                             has_size ? (float)ldexp(1.0, -2 * exponent) : 1.0f};
}

/* The polygon weight's place where the footprint is no polygon is taken by the flux weight. A polygon is
 * multiplied by the flux as it is: the plain weight's colour, in units of 1. */
static sl_weight_form form_of(const sl_map_photons *photons, size_t photon, sl_photon_weight *weight,
                              sl_weight_terms *terms) {
    *terms = sl_weight_terms_of(photons, photon);
    if (sl_weight_is_cosine(*weight)) return SL_FORM_COSINE;
    const sl_photon_quad *quad =
        *weight == SL_WEIGHT_POLYGON && photons->quad ? &photons->quad[photon] : NULL;
    if (!quad || quad->count != 4 || !(quad->area > 0.0f)) return SL_FORM_DISC;
    *weight = SL_WEIGHT_PLAIN;
    terms->unit = 1.0f;
    return SL_FORM_POLYGON;
}

sl_weight_form sl_photon_load(const sl_map_photons *photons, size_t photon, sl_photon_weight weight,
                              sl_photon_registers *registers) {
    sl_lobe_registers lobe;
    sl_weight_terms terms;
    sl_map_photon p =
        photons->lobe ? sl_photon_with_lobe(photons, photon, weight, &lobe) : photons->photon[photon];
    sl_weight_form form = form_of(photons, photon, &weight, &terms);
    *registers = sl_photon_registers_of(&p, weight, terms);
    return form;
}

/* L_o of the printed weights depends on where it is seen from. */
sl_map_photon sl_photon_with_lobe(const sl_map_photons *photons, size_t photon, sl_photon_weight weight,
                                  sl_lobe_registers *out) {
    const sl_photon_lobe *lobe = &photons->lobe[photon];
    sl_map_photon p = photons->photon[photon], glossy;
    sl_rgb arriving = sl_weight_is_printed(weight) ? p.radiance : p.flux;
    glossy = p;
    glossy.flux =
        sl_rgb_mul(arriving, sl_rgb_scale(lobe->specular, (lobe->exponent + 2.0f) * (float)(0.5 / SL_PI)));
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
    sl_vec3 winding = sl_cross(sl_sub(b, a), sl_sub(c, a)),
            centre = sl_scale(sl_add(sl_add(a, b), c), 1.0f / 3.0f);
    bool turned = sl_dot(winding, normal) < 0.0f;
    sl_polygon_light t = {
        .corner = {a, turned ? c : b, turned ? b : c}, .normal = normal, .area = 0.5f * sl_length(winding)};
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
    for (int t = 0; t < 2; t++)
        polygon->triangle[t] = triangle_of(q->corner[0], q->corner[1 + t], q->corner[2 + t], normal);
}

/* ---- the plain form ---- */

/* Pi / A_q at one point, by the lanes' kernel. */
static float polygon_weight(const sl_map_photons *photons, size_t photon, const sl_photon_registers *p,
                            sl_vec3 x, sl_vec3 n, sl_vec3 shading) {
    sl_light_points at = {1, &x.x, &x.y, &x.z, &n.x, &n.y, &n.z, &shading.x, &shading.y, &shading.z};
    sl_photon_polygon polygon;
    float pi[2] = {0.0f, 0.0f};
    sl_photon_polygon_of(photons, photon, &polygon);
    for (int t = 0; t < 2; t++) sl_polygon_light_baseline(&at, &polygon.triangle[t], &pi[t]);
    return sl_polygon_weight(p, &polygon, x, n, pi[0] + pi[1]);
}

sl_rgb sl_photon_irradiance(const sl_map_photons *photons, size_t photon, sl_photon_weight weight, sl_vec3 x,
                            sl_vec3 n, sl_vec3 shading) {
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
    float power = sl_lobe_power(lobe.x * d.x + lobe.y * d.y + lobe.z * d.z, sl_dot(d, d), lobe.exponent),
          share = w * power;
    return (sl_rgb){e.r + lobe.colour.r * share, e.g + lobe.colour.g * share, e.b + lobe.colour.b * share};
}
