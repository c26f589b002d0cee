/* Pass 7: indirect light of receivers by (10), L_r = sum over photons f_r E_j.
 *
 * Where photons and receivers are Lambertian that is a sum of irradiances (the kernel in weight_kernels.c). Whatever else is wanted
 * of a photon (its lobe, the receiver's, whether it is seen) is done with its weight first, photon by photon, in the same order and
 * with the same bits. Even and odd photons have sums of their own, which are added at the end: their difference tells how much the
 * whole depends on which photons were taken. */
#include <string.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "cache/direct_radiance/light_tiles.h"
#include "cache/direct_radiance/visibility.h"

struct sl_photon_sums {
    const sl_light_pass *pass;
    size_t count;
    sl_photon_registers *photon;
    sl_weight_form *form;
    sl_lobe_registers *lobe;    /* NULL where all photons are Lambertian */
    sl_photon_polygon *polygon; /* NULL unless polygons are wanted */
    bool plain;                 /* all photons are Lambertian, and of one form */
    float share[2];             /* of the even and the odd photons' sum in half the difference of what each would be alone */
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

static void weigh(const indirect_pass *p, const sl_receiver_tile *tile, size_t j, const sl_photon_registers *r, float *weight) {
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

static void add(const indirect_pass *p, size_t count, sl_rgb colour, const float *weight, const float *visible,
                float (*sum)[SL_TILE_PIXELS]) {
    p->kernels.light.accumulate(count, colour, weight, visible, sum[0], sum[1], sum[2]);
}

/* Of this photon and the next ones. */
static void see(const indirect_pass *p, const sl_receiver_tile *tile, size_t first, sl_tile_sight *around, sl_counters *counters) {
    size_t left = p->count - first;
    sl_sight_see(p->sight, tile, around, first, left < SL_SIGHT_PHOTONS ? left : SL_SIGHT_PHOTONS, counters);
}

/* With the weights that know photons to have an area. */
static sl_lobe_target target_of(const indirect_pass *p, size_t j, const sl_photon_registers *r) {
    const sl_map_photon *photon = &p->pass->photons->photon[j];
    bool disc = p->pass->weight == SL_WEIGHT_FLUX || p->pass->weight == SL_WEIGHT_POLYGON;
    float extent = disc && photon->cos_alpha > 0.0f ? photon->footprint / photon->cos_alpha * (float)(0.25 / SL_PI) : 0.0f;
    if (!(extent > 0.0f) || !isfinite(extent)) extent = 0.0f;
    return (sl_lobe_target){.towards = {r->x, r->y, r->z}, .normal = {r->nx, r->ny, r->nz}, .extent = extent};
}

static void add_photon(const indirect_pass *p, const sl_receiver_tile *tile, bool glossy, size_t j, sl_tile_sight *around,
                       sl_tile_light *sum, sl_counters *counters) {
    const sl_photon_registers r = p->photon[j];
    const sl_rgb colour = {r.red, r.green, r.blue};
    const size_t count = tile->padded;
    float weight[SL_TILE_PIXELS], visible[SL_TILE_PIXELS], of_photon[SL_TILE_PIXELS], of_receiver[SL_TILE_PIXELS];
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
static void sum_photons(const indirect_pass *p, const sl_receiver_tile *tile, bool glossy, sl_tile_light half[2], sl_tile_light *sum,
                        sl_counters *counters) {
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

void sl_indirect_light_tile(const sl_photon_sums *p, const sl_receiver_tile *tile, bool glossy, const sl_tile_target *to,
                            sl_counters *counters) {
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

void sl_indirect_light_apart(const sl_photon_sums *p, const sl_receiver_tile *tile, bool glossy, size_t lane, sl_photon_told *told,
                             void *context, sl_counters *counters) {
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

sl_status sl_photon_sums_see(sl_photon_sums *sums, const sl_receivers *receivers, const sl_receiver_kinds *kinds, sl_counters *counters,
                             sl_error *error) {
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

sl_status sl_light_indirectly(const sl_light_pass *pass, const sl_receivers *receivers, sl_lit_picture *picture, float *spread,
                              sl_counters *counters, sl_error *error) {
    if (!pass->photons || pass->photons->count == 0) return SL_OK;
    sl_photon_sums *sums = NULL;
    sl_receiver_kinds kinds = {.of_material = NULL};
    float *const *indirect = picture->indirect;
    sl_status status = sl_photon_sums_create(pass, &sums, error);
    if (status != SL_OK) return status;
    picture_pass p = {sums, {.width = receivers->width, .indirect = {indirect[0], indirect[1], indirect[2]}, .spread = spread}};
    status = sl_receiver_kinds_find(pass->scene, pass->trick_albedo, &kinds, error);
    if (status == SL_OK) status = sl_photon_sums_see(sums, receivers, &kinds, counters, error);
    if (status == SL_OK) status = sl_receiver_tiles_run(receivers, &kinds, pass->threads, light_tile, &p, counters, error);
    sl_receiver_kinds_release(&kinds);
    sl_photon_sums_destroy(sums);
    return status;
}

/* ---- sums without a picture ---- */

sl_status sl_photon_sums_create(const sl_light_pass *pass, sl_photon_sums **sums, sl_error *error) {
    *sums = sl_allocate(1, sizeof **sums);
    if (!*sums) return sl_fail_memory(error, "photons of a frame");
    **sums = (sl_photon_sums){.pass = pass, .count = pass->photons->count, .kernels = sl_receiver_kernels_for(sl_isa_best()),
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

void sl_photon_sums_irradiance(const sl_photon_sums *sums, const sl_receiver_tile *tile, sl_tile_light *light) {
    sl_tile_light half[2];
    sl_counters ignored = {{0}};
    sum_photons(sums, tile, false, half, light, &ignored);
}
