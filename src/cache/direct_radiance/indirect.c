/* Pass 7: indirect light of receivers by (10), L_r = sum over photons f_r E_j.
 *
 * Where photons and receivers are Lambertian that is a sum of irradiances (the kernel in receiver_kernels.c).
 * Whatever else is wanted of a photon (its lobe, the receiver's, whether it is seen) is done with its weight
 * first, photon by photon, in the same order and with the same bits. */
#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "cache/direct_radiance/direct_radiance.h"
#include "cache/direct_radiance/receivers.h"
#include "trace/bsdf.h"

#include <math.h>
#include <string.h>

struct sl_photon_sums {
    const sl_light_pass *pass;
    size_t count;
    sl_photon_registers *photon;
    sl_weight_form *form;
    sl_lobe_registers *lobe;    /* NULL where all photons are Lambertian */
    bool plain;                 /* all photons are Lambertian, and of one form */
    sl_vec3 *ray_end;           /* of each photon; NULL: photons are seen from everywhere */
    sl_isa isa;
};

/* ---- once a frame: the j-indexed values ---- */

static bool make_tables(sl_photon_sums *p) {
    const sl_map_photons *photons = p->pass->photons;
    const bool seen = p->pass->tracer != NULL, lobes = photons->lobe != NULL;
    p->photon = sl_allocate(p->count, sizeof *p->photon);
    p->form = sl_allocate(p->count, sizeof *p->form);
    if (lobes) p->lobe = sl_allocate(p->count, sizeof *p->lobe);
    if (seen) p->ray_end = sl_allocate(p->count, sizeof *p->ray_end);
    return p->photon && p->form && (!lobes || p->lobe) && (!seen || p->ray_end);
}

/* Returns where rays to a photon end. One that stands for several texels lies at their mean, which on a
 * curved surface is a little inside. Within a group normals differ by at most 20 degrees: the mean is at most
 * 0.09 of the footprint's radius deep. */
static sl_vec3 ray_end(const sl_map_photon *p, float offset) {
    const float area = p->cos_alpha > 0.0f ? p->footprint / p->cos_alpha : 0.0f,
                lift = 0.1f * sqrtf(area * (float)(1.0 / SL_PI));
    return sl_mad(p->position, lift > offset && isfinite(lift) ? lift : offset, p->normal);
}

static void fill_tables(sl_photon_sums *p) {
    const sl_map_photons *photons = p->pass->photons;
    p->plain = !p->lobe && !p->ray_end;
    for (size_t j = 0; j < p->count; j++) {
        p->form[j] = sl_photon_load(photons, j, p->pass->weight, &p->photon[j], p->lobe ? &p->lobe[j] : NULL);
        if (p->ray_end) p->ray_end[j] = ray_end(&photons->photon[j], 1e-5f * p->pass->scene->scale);
        if (p->form[j] == SL_FORM_POLYGON) p->plain = false;
    }
}

/* ---- a photon and what is done with its weight ---- */

static void weigh(const sl_photon_sums *p, const sl_receiver_tile *tile, size_t j,
                  const sl_photon_registers *r, float *weight) {
    if (p->form[j] != SL_FORM_POLYGON) {
        SL_KERNEL_OF(p->isa, sl_photon_weigh)(tile, r, p->form[j] == SL_FORM_COSINE, weight);
        return;
    }
    const sl_light_points points = sl_receiver_tile_points(tile);
    const sl_photon_polygon *polygon = &p->pass->photons->polygon[j];
    float pi[2][SL_TILE_PIXELS], any = 0.0f;
    for (size_t i = 0; i < tile->padded; i++) pi[0][i] = 1.0f;
    SL_KERNEL_OF(p->isa, sl_photon_polygon)(tile, r, polygon, pi[0], weight);
    for (size_t i = 0; i < tile->padded; i++) any = weight[i] > any ? weight[i] : any;
    if (!(any > 0.0f)) return; /* all of the tile is behind the photon: in a room, often */
    for (int t = 0; t < 2; t++) SL_KERNEL_OF(p->isa, sl_polygon_light)(&points, &polygon->triangle[t], pi[t]);
    for (size_t i = 0; i < tile->padded; i++) pi[0][i] += pi[1][i];
    SL_KERNEL_OF(p->isa, sl_photon_polygon)(tile, r, polygon, pi[0], weight);
}

static void multiply(size_t count, const float *restrict b, float *restrict a) {
    for (size_t i = 0; i < count; i++) a[i] *= b[i];
}

static void add(const sl_photon_sums *p, size_t count, sl_rgb colour, const float *weight,
                const float *visible, float (*sum)[SL_TILE_PIXELS]) {
    SL_KERNEL_OF(p->isa, sl_light_accumulate)(count, colour, weight, visible, sum[0], sum[1], sum[2]);
}

/* ---- does a receiver see a photon? ---- */

static void set_ray(const sl_photon_sums *p, const sl_receiver_tile *t, size_t i, size_t j, unsigned k,
                    sl_ray16 *rays) {
    const sl_scene *scene = p->pass->scene;
    const sl_vec3 at = sl_v3(t->x[i], t->y[i], t->z[i]);
    const sl_vec3 origin = sl_mad(at, sl_scene_offset_at(scene, 1e-5f * scene->scale, at),
                                  sl_v3(t->geometric_x[i], t->geometric_y[i], t->geometric_z[i]));
    sl_ray16_set(rays, k, origin, sl_sub(p->ray_end[j], origin), 0.0f, 0.9999f, t->triangle[i]);
}

/* Sets visible to 0 where something stands before photon j: a ray from each receiver that it would light,
 * sixteen together. */
static void see(const sl_photon_sums *p, const sl_receiver_tile *tile, size_t j, const float *weight,
                float *visible, sl_counters *counters) {
    sl_ray16 rays = {0};
    size_t lane[SL_PACKET];
    unsigned count = 0;
    for (size_t i = 0; i < tile->count; i++) {
        if (weight[i] > 0.0f) {
            lane[count] = i;
            set_ray(p, tile, i, j, count++, &rays);
        }
        if (count < SL_PACKET && (i + 1 < tile->count || count == 0)) continue;
        const uint32_t occluded = sl_trace_occluded(p->pass->tracer, &rays, count, true, counters);
        for (unsigned k = 0; k < count; k++) visible[lane[k]] = occluded >> k & 1u ? 0.0f : 1.0f;
        count = 0;
    }
}

/* ---- all that is done with a photon ---- */

/* Returns where a receiver's lobe looks: at a disc, with the weights that give photons an area. */
static sl_lobe_target target_of(const sl_photon_sums *p, size_t j, const sl_photon_registers *r) {
    const sl_map_photon *photon = &p->pass->photons->photon[j];
    bool disc = p->pass->weight == SL_WEIGHT_FLUX || p->pass->weight == SL_WEIGHT_POLYGON;
    float extent = disc && photon->cos_alpha > 0.0f
                       ? photon->footprint / photon->cos_alpha * (float)(0.25 / SL_PI)
                       : 0.0f;
    if (!(extent > 0.0f) || !isfinite(extent)) extent = 0.0f;
    return (sl_lobe_target){.towards = {r->x, r->y, r->z}, .normal = {r->nx, r->ny, r->nz}, .extent = extent};
}

static void add_photon(const sl_photon_sums *p, const sl_receiver_tile *tile, bool glossy, size_t j,
                       sl_tile_light *sum, sl_counters *counters) {
    const sl_photon_registers r = p->photon[j];
    const sl_rgb colour = {r.red, r.green, r.blue};
    const size_t count = tile->padded;
    float weight[SL_TILE_PIXELS], visible[SL_TILE_PIXELS], of_photon[SL_TILE_PIXELS],
        of_receiver[SL_TILE_PIXELS];
    weigh(p, tile, j, &r, weight);
    for (size_t i = 0; i < count; i++) visible[i] = 1.0f;
    if (p->ray_end) see(p, tile, j, weight, visible, counters);
    add(p, count, colour, weight, visible, sum->irradiance);
    if (p->lobe) {
        SL_KERNEL_OF(p->isa, sl_photon_lobe_power)(tile, &r, &p->lobe[j], of_photon);
        multiply(count, weight, of_photon);
        add(p, count, p->lobe[j].colour, of_photon, visible, sum->irradiance);
    }
    if (!glossy) return;
    const sl_lobe_target target = target_of(p, j, &r);
    SL_KERNEL_OF(p->isa, sl_receiver_lobe_power)(tile, &target, of_receiver);
    multiply(count, of_receiver, weight);
    add(p, count, colour, weight, visible, sum->lobe);
    if (!p->lobe) return;
    multiply(count, of_receiver, of_photon);
    add(p, count, p->lobe[j].colour, of_photon, visible, sum->lobe);
}

/* ---- a tile ---- */

static void sum_photons(const sl_photon_sums *p, const sl_receiver_tile *tile, bool glossy,
                        sl_tile_light *sum, sl_counters *counters) {
    memset(sum, 0, glossy ? sizeof *sum : sizeof sum->irradiance);
    if (p->plain && !glossy) {
        SL_KERNEL_OF(p->isa, sl_photons_sum)(tile, p->photon, p->count, sl_weight_is_cosine(p->pass->weight),
                                             sum);
        return;
    }
    for (size_t j = 0; j < p->count; j++) add_photon(p, tile, glossy, j, sum, counters);
}

void sl_indirect_light_tile(const sl_photon_sums *p, const sl_receiver_tile *tile, bool glossy,
                            const sl_tile_target *to, sl_counters *counters) {
    sl_tile_light sum;
    sum_photons(p, tile, glossy, &sum, counters);
    SL_KERNEL_OF(p->isa, sl_receivers_reflect_to)(tile, &sum, glossy, to->indirect);
    sl_count(counters, SL_COUNT_PHOTON_LOOK_UPS, tile->count * p->count);
}

/* ---- photon by photon ---- */

static void explain_photon(const sl_photon_sums *p, const sl_receiver_tile *tile, bool glossy, size_t j,
                           sl_rgb throughput, sl_explanation_writer *writer) {
    const sl_map_photon *photon = &p->pass->photons->photon[j];
    const float left[3] = {throughput.r, throughput.g, throughput.b};
    sl_explanation_term term = {.layer = "indirect",
                                .kind = "photon of the map",
                                .index = j,
                                .placed = true,
                                .position = {photon->position.x, photon->position.y, photon->position.z},
                                .value = {photon->flux.r, photon->flux.g, photon->flux.b}};
    sl_counters ignored = {{0}};
    sl_tile_light light;
    float weight[SL_TILE_PIXELS];
    bool any = false;
    memset(&light, 0, sizeof light);
    add_photon(p, tile, glossy, j, &light, &ignored);
    for (int c = 0; c < 3; c++) {
        float radiance = light.irradiance[c][0] * tile->diffuse[c][0];
        if (glossy) radiance += light.lobe[c][0] * tile->specular[c][0];
        term.contribution[c] = (double)radiance * (double)left[c];
        any |= radiance != 0.0f;
    }
    if (!any) return;
    weigh(p, tile, j, &p->photon[j], weight);
    term.weight = (double)weight[0];
    sl_explanation_add(writer, &term);
}

void sl_indirect_light_explain(const sl_photon_sums *p, const sl_receiver_tile *tile, bool glossy,
                               sl_rgb throughput, sl_explanation_writer *writer) {
    for (size_t j = 0; j < p->count; j++) explain_photon(p, tile, glossy, j, throughput, writer);
}

/* ---- a frame's ---- */

sl_status sl_photon_sums_create(const sl_light_pass *pass, sl_photon_sums **sums, sl_error *error) {
    *sums = sl_allocate(1, sizeof **sums);
    if (!*sums) return sl_fail_memory(error, "photons of a frame");
    **sums = (sl_photon_sums){.pass = pass,
                              .count = pass->photons->count,
                              .isa = sl_isa_best()};
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
    SL_FREE_ALL(sums->ray_end, sums->photon, sums->form, sums->lobe, sums);
}

void sl_photon_sums_irradiance(const sl_photon_sums *sums, const sl_receiver_tile *tile,
                               sl_tile_light *light) {
    sl_counters ignored = {{0}};
    sum_photons(sums, tile, false, light, &ignored);
}

/* ---- photons as they are looked up ---- */

static sl_weight_terms terms_of(const sl_map_photons *photons, size_t photon) {
    double nearest = (double)photons->nearest, diagonal = (double)photons->box_diagonal;
    const uint32_t own = photons->photon[photon].samples;
    const float samples = own ? (float)own : (float)photons->count;
    bool has_size = diagonal > 1e-12 && diagonal < 1e12;
    int exponent = 0;
    (void)frexp(diagonal, &exponent);
    return (sl_weight_terms){(float)(nearest * nearest),
                             (float)(2.0 * SL_PI) / samples,
                             diagonal > 0.0 ? (float)(1.0 / (diagonal * diagonal)) : 0.0f,
                             has_size ? (float)ldexp(1.0, -2 * exponent) : 1.0f};
}

/* Chooses the form of a photon's weight: where its footprint is no polygon the flux weight stands in. A
 * polygon is multiplied by the flux as it is: the plain weight's colour, in units of 1. */
static sl_weight_form form_of(const sl_map_photons *photons, size_t photon, sl_photon_weight *weight,
                              sl_weight_terms *terms) {
    *terms = terms_of(photons, photon);
    if (sl_weight_is_cosine(*weight)) return SL_FORM_COSINE;
    if (*weight != SL_WEIGHT_POLYGON || !photons->polygon || !(photons->polygon[photon].over_area > 0.0f))
        return SL_FORM_DISC;
    *weight = SL_WEIGHT_PLAIN;
    terms->unit = 1.0f;
    return SL_FORM_POLYGON;
}

/* L_o of the printed weights depends on where it is seen from. */
sl_weight_form sl_photon_load(const sl_map_photons *photons, size_t photon, sl_photon_weight weight,
                              sl_photon_registers *registers, sl_lobe_registers *out) {
    const sl_photon_lobe *lobe = photons->lobe ? &photons->lobe[photon] : NULL;
    sl_map_photon p = photons->photon[photon];
    const sl_rgb arriving = sl_weight_is_printed(weight) ? p.radiance : p.flux;
    sl_weight_terms terms;
    const sl_weight_form form = form_of(photons, photon, &weight, &terms);
    if (lobe) {
        const float scale = (lobe->exponent + 2.0f) * (float)(0.5 / SL_PI);
        const sl_vec3 mirrored = sl_normalize_or(sl_reflect(lobe->to_light, lobe->normal), lobe->normal);
        p.flux = p.radiance = sl_rgb_mul(arriving, sl_rgb_scale(lobe->specular, scale));
        const sl_photon_registers r = sl_photon_registers_of(&p, weight, terms);
        *out = (sl_lobe_registers){mirrored.x, mirrored.y, mirrored.z, lobe->exponent,
                                   {r.red, r.green, r.blue}};
        p.flux = p.radiance = sl_rgb_mul(arriving, sl_rgb_scale(lobe->diffuse, (float)(1.0 / SL_PI)));
    }
    *registers = sl_photon_registers_of(&p, weight, terms);
    return form;
}
