#include "cache/hemisphere/hit_light.h"

#include <string.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"

enum { EVERY_LIGHT_MAX = 8 };

sl_gather_settings sl_gather_defaults(void) {
    return (sl_gather_settings){.kind = SL_GATHER_RAYS,
                                .size = 64,
                                .plane_fov = (float)(140.0 / 180.0 * SL_PI),
                                .border = SL_BORDER_RADIAL,
                                .jitter = true,
                                .more_rays = 0.5f,
                                .hit_samples = 1};
}

/* ---- creation -------------------------------------------------------------------------------- */

/* Lights without extent light every hit, unless they are many; samples are drawn from what is left. */
static sl_status make_sources(sl_gather *gather, sl_error *error) {
    const sl_scene *scene = gather->scene;
    gather->extended = *scene;
    gather->every_light = scene->light_count <= EVERY_LIGHT_MAX;
    if (gather->every_light) gather->extended.light_count = 0;
    if (gather->extended.light_count + scene->emitter_count == 0 && !scene->environment.present) return SL_OK;
    sl_status status = gather->every_light ? sl_hit_sources_make(gather, error) : SL_OK;
    if (status != SL_OK || (gather->every_light && (gather->sides.count > 0 || scene->emitter_count == 0)))
        return status;
    gather->sources = 0;
    status = sl_light_sampler_create(&gather->extended, &gather->sampler, error);
    return status == SL_OK ? sl_light_sampler_plant_tree(gather->sampler, error) : status;
}

static sl_status make_parts(sl_gather *gather, unsigned threads, sl_error *error) {
    sl_gather_settings *s = &gather->settings;
    double pixel = 2.0 * (double)gather->half_tangent / s->size;
    if (s->colours) gather->colours = *s->colours;
    sl_status status = SL_OK;
    if (s->colours) status = sl_gather_sky_create(&gather->scene->environment, pixel, &gather->sky, error);
    else if (!s->maps) status = make_sources(gather, error);
    if (status != SL_OK) return status;
    status = sl_gather_tables_create(s->kind, s->size, (double)gather->half_tangent, s->border,
                                     !s->colours, &gather->tables, error);
    if (status != SL_OK || s->harmonics_order == 0) return status;
    return sl_projection_create(gather->tables, s->harmonics_order, threads, &gather->projection, error);
}

static void find_lobes(sl_gather *g) {
    if (!g->settings.all_lobes || g->settings.maps || !g->tracer) return;
    for (size_t i = 0; i < g->scene->material_count; i++) {
        g->glossy = g->glossy || sl_material_is_glossy(&g->scene->materials[i]);
        g->mirrors = g->mirrors || sl_material_is_mirror(&g->scene->materials[i]);
    }
}

sl_status sl_gather_create(const sl_scene *scene, const sl_raster *raster, const sl_tracer *tracer,
                           const sl_gather_settings *settings, unsigned threads, sl_gather **out,
                           sl_error *error) {
    *out = NULL;
    sl_gather *gather = sl_allocate(1, sizeof *gather);
    if (!gather) return sl_fail_memory(error, "the gather");
    gather->scene = scene;
    gather->raster = raster;
    gather->tracer = tracer;
    gather->settings = *settings;
    find_lobes(gather);
    if (gather->settings.hit_samples < 1) gather->settings.hit_samples = 1;
    if (!(gather->settings.more_rays >= 0.0f)) gather->settings.more_rays = 0.0f;
    if (gather->settings.more_rays > 4.0f) gather->settings.more_rays = 4.0f;
    gather->offset = 1e-5f * scene->scale;
    gather->isa = sl_isa_best();
    gather->half_tangent = (float)sl_tan(0.5 * (double)settings->plane_fov);
    sl_status status = make_parts(gather, threads, error);
    if (status == SL_OK) *out = gather;
    else sl_gather_destroy(gather);
    return status;
}

void sl_gather_destroy(sl_gather *gather) {
    if (!gather) return;
    sl_gather_tables_destroy(gather->tables);
    sl_projection_destroy(gather->projection);
    sl_texture_image_destroy(gather->sky);
    sl_light_sides_release(&gather->sides);
    sl_free(gather->strength);
    sl_light_sampler_destroy(gather->sampler);
    sl_free(gather);
}

size_t sl_gather_memory_bytes(const sl_gather *gather) {
    return sizeof *gather + sl_gather_tables_bytes(gather->tables) +
           (gather->projection ? sl_projection_bytes(gather->projection) : 0) +
           sl_gather_sky_memory_bytes(gather->sky) +
           gather->sides.count * (sizeof *gather->sides.polygon + (SL_SIDE_VALUES + 3) * sizeof(float));
}

/* ---- scratch --------------------------------------------------------------------------------- */

/* Float planes of `stride` each, then those of whole numbers; behind `lead` zeros what belongs to cells. */
static bool allocate_planes(sl_gather_scratch *s, size_t lead, size_t stride) {
    enum { PLANES = 42, CELL_PLANES = 7, IDS = 5 };
    sl_gather_hits *h = &s->hits;
    sl_gather_planes *p = &s->planes;
    float **const plane[PLANES] = {
        &p->r, &p->g, &p->b, &p->nearness, &p->distance, &p->first, &p->mean, /* CELL_PLANES */
        &h->depth, &h->w1, &h->w2, &h->direction_x, &h->direction_y, &h->direction_z,
        &h->position_x, &h->position_y, &h->position_z, &h->normal_x, &h->normal_y, &h->normal_z,
        &h->geometric_x, &h->geometric_y, &h->geometric_z, &h->cosine, &h->back,
        &h->diffuse_r, &h->diffuse_g, &h->diffuse_b, &h->irradiance_r, &h->irradiance_g, &h->irradiance_b,
        &h->glossy_r, &h->glossy_g, &h->glossy_b,
        &s->slot_share, &s->more_a, &s->more_b, &s->target_depth, &s->target_w1, &s->target_w2,
        &s->cell_depth, &s->cell_w1, &s->cell_w2};
    uint32_t **const id[IDS] = {&h->triangle, &s->slot_cell, &s->more_bits, &s->target_id, &s->cell_id};
    s->block = sl_allocate_planes(stride, PLANES, plane);
    s->ids = sl_allocate(IDS * stride, sizeof *s->ids);
    if (!s->block || !s->ids) return false;
    for (int i = 0; i < CELL_PLANES; i++) *plane[i] += lead;
    for (size_t i = 0; i < IDS; i++) *id[i] = s->ids + i * stride;
    return true;
}

static bool allocate_slots(const sl_gather *gather, sl_gather_scratch *s) {
    const sl_gather_tables *t = gather->tables;
    size_t lead = ((size_t)t->width + 16) / 16 * 16; /* the row below the first */
    bool more = t->kind == SL_GATHER_RAYS && gather->settings.jitter;
    s->slots_max = t->used + (more ? (size_t)(gather->settings.more_rays * (float)t->used) : 0);
    const bool onward = gather->settings.second && gather->settings.onward_reach > 0.0f && gather->tracer;
    const size_t last = s->slots_max + (onward ? sl_onward_most(s->slots_max) : 0);
    size_t slots = last > t->padded ? last : t->padded,
           stride = lead + (slots + 15) / 16 * 16;
    s->texel = sl_allocate(slots, sizeof *s->texel);
    if (gather->mirrors) s->mirrored = sl_allocate(slots, sizeof *s->mirrored);
    if (onward && !sl_onward_allocate(s->slots_max, &s->onward)) return false;
    if (!allocate_planes(s, lead, stride) || !s->texel || (gather->mirrors && !s->mirrored)) return false;
    for (size_t k = 0; k < t->used; k++) s->slot_cell[k] = t->order[k];
    return !gather->sources || sl_light_scratch_create(gather, slots, &s->light, NULL) == SL_OK;
}

/* Of known colours: the picture, where it shows which triangle, the picture times weights, halves of that. */
static bool allocate_coloured(sl_gather_scratch *s, size_t cells) {
    float *block = sl_allocate(9 * cells, sizeof *block);
    s->block = block;
    s->cell_id = s->ids = sl_allocate(cells, sizeof *s->ids);
    if (!block || !s->ids) return false;
    s->planes = (sl_gather_planes){.r = block, .g = block + cells, .b = block + 2 * cells};
    s->cell_w1 = block + 3 * cells;
    s->cell_w2 = block + 4 * cells;
    s->weighted = block + 5 * cells;
    s->halved = block + 8 * cells;
    return true;
}

sl_status sl_gather_scratch_create(const sl_gather *gather, sl_gather_scratch **out, sl_error *error) {
    const sl_gather_tables *t = gather->tables;
    *out = NULL;
    sl_gather_scratch *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "a gather's buffers");
    s->gather = gather;
    s->pixels = sl_allocate(t->cells, sizeof(uint32_t));
    for (size_t i = 0; s->pixels && i < t->cells; i++) s->pixels[i] = (uint32_t)i;
    bool room = gather->colours.face ? allocate_coloured(s, t->cells) : allocate_slots(gather, s);
    sl_status status = room && s->pixels ? SL_OK : sl_fail_memory(error, "a gather's buffers");
    if (status == SL_OK && t->kind != SL_GATHER_RAYS)
        status = sl_raster_scratch_create(gather->raster, t->size, t->size, &s->raster, error);
    if (status == SL_OK) *out = s;
    else sl_gather_scratch_destroy(s);
    return status;
}

void sl_gather_scratch_destroy(sl_gather_scratch *scratch) {
    if (!scratch) return;
    sl_raster_scratch_destroy(scratch->raster);
    sl_light_scratch_destroy(scratch->light);
    sl_onward_free(&scratch->onward);
    SL_FREE_ALL(scratch->block, scratch->ids, scratch->pixels, scratch->texel, scratch->mirrored, scratch);
}

sl_status sl_gathers_create(const sl_scene *scene, const sl_raster *raster, const sl_tracer *tracer,
                            const sl_gather_settings *settings, unsigned threads, sl_gathers *g,
                            sl_error *error) {
    *g = (sl_gathers){.threads = threads};
    sl_status status = sl_gather_create(scene, raster, tracer, settings, threads, &g->gather, error);
    if (status == SL_OK) {
        g->scratch = sl_allocate(threads, sizeof *g->scratch);
        if (!g->scratch) status = sl_fail_memory(error, "gathers");
    }
    for (unsigned i = 0; status == SL_OK && i < threads; i++)
        status = sl_gather_scratch_create(g->gather, &g->scratch[i], error);
    if (status != SL_OK) sl_gathers_destroy(g);
    return status;
}

void sl_gathers_destroy(sl_gathers *g) {
    for (unsigned i = 0; g->scratch && i < g->threads; i++) sl_gather_scratch_destroy(g->scratch[i]);
    sl_free(g->scratch);
    sl_gather_destroy(g->gather);
    *g = (sl_gathers){0};
}

sl_gather_picture sl_gather_last_picture(const sl_gather_scratch *s) {
    const sl_gather_tables *t = s->gather->tables;
    return (sl_gather_picture){t->width,    t->height,   s->planes.r,
                               s->planes.g, s->planes.b, s->planes.distance};
}

/* ---- one gather ------------------------------------------------------------------------------ */

/* The picture's plane stands on the shading normal; the eye lies off the surface along the geometric one. */
sl_gather_view sl_gather_view_of(const sl_gather *gather, const sl_gather_point *point,
                                 sl_gather_scratch *scratch) {
    sl_vec3 normal =
        sl_normalize_or(point->normal, sl_normalize_or(point->geometric_normal, sl_v3(0.0f, 0.0f, 1.0f)));
    float offset = sl_scene_offset_at(gather->scene, gather->offset, point->position);
    return (sl_gather_view){.gather = gather,
                            .point = point,
                            .scratch = scratch,
                            .frame = sl_frame_from_normal(normal),
                            .eye = sl_mad(point->position, offset, point->geometric_normal)};
}

/* Visibility alone, by the instrument chosen. */
static sl_gather_view see(const sl_gather *gather, const sl_gather_point *point, sl_gather_scratch *scratch,
                          sl_counters *counters) {
    sl_gather_view view = sl_gather_view_of(gather, point, scratch);
    scratch->slots = gather->tables->used;
    scratch->onward.count = 0;
    scratch->onward.first = SIZE_MAX;
    for (size_t k = 0; k < scratch->slots; k++) scratch->slot_share[k] = 1.0f;
    if (gather->settings.kind == SL_GATHER_RAYS) sl_gather_see_rays(&view, counters);
    else sl_gather_see_raster(&view, counters);
    return view;
}

static sl_vec3 tangential(const sl_frame *f, const double v[2]) {
    return sl_to_float(sl_addd(sl_scaled(sl_to_double(f->x), v[0]), sl_scaled(sl_to_double(f->y), v[1])));
}

/* Returns the eigenvalue of the larger absolute value. */
static float greatest_curvature(const sl_curvature *h) {
    double mean = 0.5 * (h->xx + h->yy), half = 0.5 * (h->xx - h->yy),
           radius = sqrt(half * half + h->xy * h->xy);
    return (float)(mean < 0.0 ? mean - radius : mean + radius);
}

/* Turns the sums of gather_kernels.c into the world. */
static void finish(const sl_gather_view *view, const sl_gather_sums *sums, sl_irradiance *out) {
    const sl_gather_tables *t = view->gather->tables;
    out->curvature = greatest_curvature(&sums->curvature);
    out->value = (sl_rgb){(float)sums->irradiance[0], (float)sums->irradiance[1], (float)sums->irradiance[2]};
    for (int c = 0; c < 3; c++) {
        out->rotational[c] = tangential(&view->frame, sums->rotational[c]);
        out->translational[c] = tangential(&view->frame, sums->translational[c]);
    }
    /* 1/R = (1/pi) sum W / r, the harmonic mean of distances (Ward et al. 1988), weighed by the cosine; W
     * need not sum to pi where a plane's border is left off. */
    out->harmonic_mean =
        sums->inverse_distance > 0.0 ? (float)(t->weight_sum / sums->inverse_distance) : INFINITY;
}

static void gather_light(const sl_gather *gather, const sl_gather_point *point, bool second_alone,
                         sl_gather_scratch *scratch, sl_irradiance *irradiance, sl_counters *counters) {
    sl_gather_sums sums;
    float nearest;
    double back_weight;
    sl_count(counters, SL_COUNT_GATHERS, 1);
    sl_gather_view view = see(gather, point, scratch, counters);
    view.second_alone = second_alone;
    sl_gather_shade(&view, &nearest, &back_weight, counters);
    SL_KERNEL_OF(gather->isa, sl_gather_sums)(gather->tables, &scratch->planes, &sums);
    finish(&view, &sums, irradiance);
    irradiance->nearest = nearest;
    irradiance->back_share = (float)(back_weight / gather->tables->weight_sum);
}

void sl_gather_irradiance(const sl_gather *gather, const sl_gather_point *point, sl_gather_scratch *scratch,
                          sl_irradiance *irradiance, sl_counters *counters) {
    gather_light(gather, point, false, scratch, irradiance, counters);
}

void sl_gather_second_irradiance(const sl_gather *gather, const sl_gather_point *point,
                                 sl_gather_scratch *scratch, sl_irradiance *irradiance,
                                 sl_counters *counters) {
    gather_light(gather, point, true, scratch, irradiance, counters);
}

void sl_gather_radiance(const sl_gather *gather, const sl_gather_point *point, sl_gather_scratch *scratch,
                        sl_irradiance *irradiance, float *coefficients, sl_counters *counters) {
    const sl_gather_planes *p = &scratch->planes;
    sl_gather_irradiance(gather, point, scratch, irradiance, counters);
    const float *const picture[4] = {p->r, p->g, p->b, p->nearness};
    if (gather->projection) sl_project(gather->projection, gather->isa, picture, coefficients);
}
