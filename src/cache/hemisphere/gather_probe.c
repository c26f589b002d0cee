/* A few gathers on trial, for about the price of twenty: points that the scene's own camera sees, one in each of 4 x 4 parts of its
 * picture, and what the raster hardware counts in drawing their views. */
#include "cache/hemisphere/gather_cost.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/hemisphere/gather_internal.h"

enum { PARTS = 4, POINTS = PARTS * PARTS, SHADED_SIZE = 16, TILE_CELLS = 16 };

typedef struct probe {
    sl_gather gather; /* the caller's, with kind, size and tables of its own */
    sl_gather_scratch *scratch;
    size_t count;
    sl_gather_point point[POINTS];
} probe;

/* ---- points ---- */

static void add_point(probe *p, uint32_t triangle, float w1, float w2, sl_vec3 to_viewer) {
    sl_surface s;
    sl_scene_surface(p->gather.scene, triangle, w1, w2, to_viewer, &s);
    p->point[p->count] = (sl_gather_point){.position = s.position, .geometric_normal = s.geometric_normal, .normal = s.normal,
                                           .triangle = triangle, .key = p->count};
    p->count++;
}

static sl_status points_of_camera(probe *p, sl_error *error) {
    const sl_scene *scene = p->gather.scene;
    const sl_camera *c = &scene->camera;
    uint32_t id[POINTS], pixel[POINTS];
    float w1[POINTS], w2[POINTS], depth[POINTS], tangent = (float)sl_tan(0.5 * (double)c->vertical_fov);
    float aspect = scene->film_height > 0 ? (float)scene->film_width / (float)scene->film_height : 1.0f;
    if (!(tangent > 0.0f) || !(aspect > 0.0f)) return SL_OK;
    sl_frame frame = {c->right, c->up, sl_neg(c->back)};
    float wide = tangent * aspect, near = 2.0f * p->gather.offset;
    sl_view view = sl_view_pyramid(&frame, c->eye, -wide, wide, -tangent, tangent, PARTS, PARTS, near);
    sl_target target = {.width = PARTS, .height = PARTS, .id = id, .depth = depth};
    sl_counters counters = {{0}};
    sl_raster_scratch *scratch;
    sl_status status = sl_raster_scratch_create(p->gather.raster, PARTS, PARTS, &scratch, error);
    if (status != SL_OK) return status;
    sl_raster_id_small(p->gather.raster, &view, &target, scratch, &counters);
    for (uint32_t i = 0; i < POINTS; i++) pixel[i] = i;
    sl_raster_barycentrics(p->gather.raster, &view, POINTS, pixel, id, w1, w2);
    for (uint32_t i = 0; i < POINTS; i++) {
        if (id[i] == SL_NO_INDEX) continue;
        add_point(p, id[i], w1[i], w2[i], sl_sub(c->eye, sl_scene_position(scene, scene->vertex[0][id[i]])));
    }
    sl_raster_scratch_destroy(scratch);
    return SL_OK;
}

/* Where the camera sees nothing: triangles spread evenly over the list, in front of them. */
static void points_of_triangles(probe *p) {
    const sl_scene *scene = p->gather.scene;
    size_t wanted = scene->triangle_count < POINTS ? scene->triangle_count : POINTS;
    for (size_t i = 0; i < wanted; i++) {
        uint32_t t = (uint32_t)(scene->triangle_count * (2 * i + 1) / (2 * wanted));
        add_point(p, t, 1.0f / 3.0f, 1.0f / 3.0f, sl_scene_geometric_normal(scene, t));
    }
}

/* ---- counting ---- */

/* Different triangles in every tile of cells: a packet of rays goes so many ways. */
static double visible_triangles(const probe *p) {
    const uint32_t *id = p->scratch->hits.triangle;
    size_t used = p->gather.tables->used, different = 0;
    for (size_t first = 0; first < used; first += TILE_CELLS) {
        for (size_t k = first; k < used && k < first + TILE_CELLS; k++) {
            size_t other = first;
            while (id[other] != id[k]) other++;
            different += other == k;
        }
    }
    return (double)different;
}

static double seen(const probe *p) {
    double hits = 0.0;
    for (size_t k = 0; k < p->gather.tables->used; k++) hits += p->scratch->hits.triangle[k] != SL_NO_INDEX;
    return hits;
}

static sl_status prepare(probe *p, sl_gather_kind kind, int size, sl_error *error) {
    sl_gather_settings *s = &p->gather.settings;
    s->kind = kind;
    s->size = size;
    sl_status status = sl_gather_tables_create(kind, size, (double)p->gather.half_tangent, s->border, &p->gather.tables, error);
    return status == SL_OK ? sl_gather_scratch_create(&p->gather, &p->scratch, error) : status;
}

static void release(probe *p) {
    sl_gather_scratch_destroy(p->scratch);
    sl_gather_tables_destroy(p->gather.tables);
    p->scratch = NULL;
    p->gather.tables = NULL;
}

static void count_views(probe *p, sl_gather_counts *c) {
    sl_counters counters = {{0}};
    double points = (double)p->count;
    for (size_t i = 0; i < p->count; i++) {
        sl_gather_see(&p->gather, &p->point[i], p->scratch, &counters);
        c->visible += visible_triangles(p) / points;
        c->hits += seen(p) / points;
    }
    c->samples = p->gather.sampler || p->gather.sources ? c->hits * (double)p->gather.settings.hit_samples : 0.0;
    c->cells = (double)p->gather.tables->used;
    c->passes = (double)counters.value[SL_COUNT_RASTER_PASSES] / points;
    c->clusters_tested = (double)counters.value[SL_COUNT_CLUSTERS_TESTED] / points;
    c->triangles_submitted = (double)counters.value[SL_COUNT_TRIANGLES_SUBMITTED] / points;
    c->triangles_rasterized = (double)counters.value[SL_COUNT_TRIANGLES_RASTERIZED] / points;
}

/* How a hit is lit does not depend on N nor on the instrument: small planes tell. */
static void count_light(probe *p, sl_gather_counts *c) {
    sl_counters counters = {{0}};
    sl_irradiance unused;
    double hits = 0.0;
    for (size_t i = 0; i < p->count; i++) {
        sl_gather_irradiance(&p->gather, &p->point[i], p->scratch, &unused, &counters);
        hits += seen(p);
    }
    if (!(hits > 0.0)) return;
    c->shadow_rays = c->hits * (double)counters.value[SL_COUNT_SHADOW_RAYS] / hits;
    c->shadow_lookups = c->hits * (double)counters.value[SL_COUNT_SHADOW_LOOKUPS] / hits;
}

sl_status sl_gather_probe(const sl_gather *gather, sl_gather_kind kind, int size, sl_gather_counts *counts, sl_error *error) {
    *counts = (sl_gather_counts){.triangles = (double)gather->scene->triangle_count};
    probe *p = sl_allocate(1, sizeof *p);
    if (!p) return sl_fail_memory(error, "a gather's probe");
    p->gather = *gather;
    p->gather.tables = NULL;
    sl_status status = points_of_camera(p, error);
    if (status == SL_OK && p->count == 0) points_of_triangles(p);
    if (status == SL_OK && p->count > 0) {
        status = prepare(p, kind == SL_GATHER_RAYS ? SL_GATHER_PLANE : kind, size, error);
        if (status == SL_OK) count_views(p, counts);
        release(p);
        if (status == SL_OK) status = prepare(p, SL_GATHER_PLANE, SHADED_SIZE, error);
        if (status == SL_OK) count_light(p, counts);
        release(p);
    }
    sl_free(p);
    return status;
}
