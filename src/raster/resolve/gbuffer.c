/* G-buffer: visibility first, then every visible pixel is resolved once from its triangle's index. */
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "raster/resolve/resolve.h"
#include "scene/bump.h"
#include "scene/surface_rules.h"

enum { STRIP = 16384 }; /* pixels of a task */

/* ---- the buffer ---- */

static void list_planes(sl_gbuffer *g, void **planes[17]) {
    void **all[17] = {(void **)&g->id,          (void **)&g->depth,       (void **)&g->position_x,
                      (void **)&g->position_y,  (void **)&g->position_z,  (void **)&g->normal_x,
                      (void **)&g->normal_y,    (void **)&g->normal_z,    (void **)&g->geometric_x,
                      (void **)&g->geometric_y, (void **)&g->geometric_z, (void **)&g->diffuse_r,
                      (void **)&g->diffuse_g,   (void **)&g->diffuse_b,   (void **)&g->material};
    for (int k = 0; k < 17; k++) planes[k] = all[k];
}

sl_status sl_gbuffer_create(int width, int height, sl_gbuffer **gbuffer, sl_error *error) {
    *gbuffer = NULL;
    if (width < 1 || height < 1 || width > SL_RASTER_MAX_SIZE || height > SL_RASTER_MAX_SIZE) {
        return sl_fail(error, SL_ERROR_USAGE, "a G-buffer of %d x %d pixels: from 1 to %d each way", width,
                       height, (int)SL_RASTER_MAX_SIZE);
    }
    sl_gbuffer *g = sl_allocate(1, sizeof *g);
    bool ok = g != NULL;
    void **planes[17];
    if (ok) list_planes(g, planes);
    for (int k = 0; ok && k < 17 && planes[k]; k++) {
        *planes[k] = sl_allocate((size_t)width * (size_t)height, 4);
        ok = *planes[k] != NULL;
    }
    if (!ok) {
        sl_gbuffer_destroy(g);
        return sl_fail_memory(error, "the G-buffer");
    }
    g->width = width;
    g->height = height;
    *gbuffer = g;
    return SL_OK;
}

void sl_gbuffer_destroy(sl_gbuffer *g) {
    if (!g) return;
    void **planes[17];
    list_planes(g, planes);
    for (int k = 0; k < 17 && planes[k]; k++) sl_free(*planes[k]);
    sl_free(g->seen_from);
    sl_free(g);
}

/* ---- resolution ---- */

typedef struct {
    sl_resolve_block pixels;
    sl_surface_block surface;
    sl_vector_planes diffuse;
    uint32_t index[SL_RESOLVE_ROOM];
} workspace;

/* The picture is resolved into planes of its own size, or of a part of it that begins at pixel `start`. */
typedef struct {
    const sl_raster *raster;
    const sl_pass_view *view;
    const uint32_t *id;
    sl_gbuffer *out;
    size_t start; /* of the planes */
} resolution;

static void fetch_normals(const sl_scene *scene, workspace *w) {
    sl_surface_block *s = &w->surface;
    bool facets = true;
    for (uint32_t r = 0; r < w->pixels.runs; r++) {
        uint32_t triangle = sl_run_triangle(&w->pixels, r);
        sl_vec3 face = {0}, n[3] = {{0}};
        if (triangle != SL_NO_INDEX) {
            face = sl_scene_geometric_normal(scene, triangle);
            for (int k = 0; k < 3; k++) n[k] = sl_scene_normal(scene, scene->vertex[k][triangle]);
        }
        for (int k = 0; k < 3; k++) {
            sl_put(s->corner_normal.x[k], s->corner_normal.y[k], s->corner_normal.z[k], r, n[k]);
            facets &= (n[k].x == n[0].x) & (n[k].y == n[0].y) & (n[k].z == n[0].z);
        }
        sl_put(s->face_x, s->face_y, s->face_z, r, face);
    }
    s->facets = facets;
}

static inline void put(const resolution *r, void *plane, size_t first, const void *values, uint32_t count) {
    if (plane) memcpy((char *)plane + 4 * (first - r->start), values, 4 * (size_t)count);
}

/* ---- bumps: surface.c decides, pixel by pixel; few materials have them ---- */

static bool is_bumpy(const sl_scene *scene, uint32_t triangle) {
    return triangle != SL_NO_INDEX && sl_material_is_bumpy(sl_triangle_material(scene, triangle));
}

static void bumpy_surface(const sl_scene *scene, const sl_pass_view *view, uint32_t triangle, float w1,
                          float w2, sl_surface *surface) {
    const sl_vec3 eye = sl_v3(view->origin[0], view->origin[1], view->origin[2]),
                  to_viewer = sl_sub(eye, sl_position_at(scene, triangle, w1, w2));
    sl_scene_surface(scene, triangle, w1, w2, to_viewer, surface);
}

/* NULL planes stay as they are. */
static void resolve_bumps(const sl_scene *scene, const sl_pass_view *view, const sl_resolve_block *pixels,
                          sl_vector_planes *normal, sl_vector_planes *diffuse) {
    for (uint32_t run = 0; run < pixels->runs; run++) {
        uint32_t triangle = sl_run_triangle(pixels, run);
        if (!is_bumpy(scene, triangle)) continue;
        for (uint32_t i = pixels->start[run]; i < pixels->start[run + 1]; i++) {
            sl_surface s;
            bumpy_surface(scene, view, triangle, pixels->w1[i], pixels->w2[i], &s);
            if (normal) normal->x[i] = s.normal.x, normal->y[i] = s.normal.y, normal->z[i] = s.normal.z;
            if (diffuse)
                diffuse->x[i] = s.diffuse.r, diffuse->y[i] = s.diffuse.g, diffuse->z[i] = s.diffuse.b;
        }
    }
}

static void resolve_surfaces(const resolution *r, const sl_pass_view *view, size_t first, workspace *w) {
    sl_surface_block *s = &w->surface;
    fetch_normals(r->raster->scene, w);
    SL_KERNEL_OF(r->raster->isa, sl_resolve_surfaces)(&w->pixels, view, s);
    resolve_bumps(r->raster->scene, view, &w->pixels, &s->normal, NULL);
    uint32_t count = w->pixels.count;
    put(r, r->out->position_x, first, s->position.x, count);
    put(r, r->out->position_y, first, s->position.y, count);
    put(r, r->out->position_z, first, s->position.z, count);
    put(r, r->out->normal_x, first, s->normal.x, count);
    put(r, r->out->normal_y, first, s->normal.y, count);
    put(r, r->out->normal_z, first, s->normal.z, count);
    put(r, r->out->geometric_x, first, s->geometric.x, count);
    put(r, r->out->geometric_y, first, s->geometric.y, count);
    put(r, r->out->geometric_z, first, s->geometric.z, count);
}

/* ---- what the material says ---- */

static const sl_material *material_of(const sl_scene *scene, uint32_t triangle) {
    return triangle == SL_NO_INDEX ? NULL : sl_triangle_material(scene, triangle);
}

static void fetch_albedo(const sl_scene *scene, const sl_resolve_block *pixels, sl_albedo_block *a) {
    for (uint32_t run = 0; run < pixels->runs; run++) {
        uint32_t triangle = sl_run_triangle(pixels, run);
        const sl_material *material = material_of(scene, triangle);
        bool textured = material && material->texture != SL_NO_INDEX;
        a->red[run] = material ? material->diffuse.r : 0.0f;
        a->green[run] = material ? material->diffuse.g : 0.0f;
        a->blue[run] = material ? material->diffuse.b : 0.0f;
        a->texture[run] = textured ? &scene->textures[material->texture] : NULL;
        a->mip[run] = textured && scene->sub_frame.mips ? &scene->sub_frame.mips[material->texture] : NULL;
        for (int k = 0; k < 3 && textured; k++) {
            a->u[k][run] = scene->texture_u[scene->vertex[k][triangle]];
            a->v[k][run] = scene->texture_v[scene->vertex[k][triangle]];
        }
    }
}

void sl_resolve_diffuse(const sl_raster *raster, const sl_pass_view *view, const sl_resolve_block *block,
                        sl_vector_planes *diffuse) {
    sl_albedo_block albedo;
    fetch_albedo(raster->scene, block, &albedo);
    SL_KERNEL_OF(raster->isa, sl_resolve_albedo)(block, &albedo, diffuse);
    resolve_bumps(raster->scene, view, block, NULL, diffuse);
}

static void resolve_diffuse(const resolution *r, const sl_pass_view *view, size_t first, workspace *w) {
    sl_resolve_diffuse(r->raster, view, &w->pixels, &w->diffuse);
    put(r, r->out->diffuse_r, first, w->diffuse.x, w->pixels.count);
    put(r, r->out->diffuse_g, first, w->diffuse.y, w->pixels.count);
    put(r, r->out->diffuse_b, first, w->diffuse.z, w->pixels.count);
}

static void resolve_material(const resolution *r, size_t first, workspace *w) {
    uint32_t value[SL_RESOLVE_RUNS];
    for (uint32_t run = 0; run < w->pixels.runs; run++) {
        uint32_t triangle = sl_run_triangle(&w->pixels, run);
        value[run] = triangle == SL_NO_INDEX ? SL_NO_INDEX : r->raster->scene->material_index[triangle];
    }
    SL_KERNEL_OF(r->raster->isa, sl_resolve_spread_index)(&w->pixels, value, w->index);
    put(r, r->out->material, first, w->index, w->pixels.count);
}

/* Returns how many pixels show a triangle. */
static uint64_t resolve_pixels(const resolution *r, size_t first, size_t end, workspace *w) {
    const sl_gbuffer *g = r->out;
    uint64_t shaded = 0;
    while (first < end) {
        const sl_pass_view *view = r->view;
        size_t count = sl_resolve_next(r->raster, view, end - first, first, NULL, r->id + first, &w->pixels);
        if (g->position_x) resolve_surfaces(r, view, first, w);
        if (g->diffuse_r) resolve_diffuse(r, view, first, w);
        if (g->material) resolve_material(r, first, w);
        shaded += sl_resolve_shaded(&w->pixels);
        first += count;
    }
    return shaded;
}

/* ---- part by part ---- */

struct sl_resolver {
    const sl_raster *raster;
    sl_pass_view view;
    const uint32_t *id;
    workspace *worker; /* too large for a thread's stack */
};

sl_status sl_resolver_create(const sl_raster *raster, const sl_view *view, const uint32_t *id,
                             unsigned workers, sl_resolver **resolver, sl_error *error) {
    *resolver = NULL;
    if (!raster->scene)
        return sl_fail(error, SL_ERROR_USAGE, "a G-buffer needs a scene: triangles alone have no materials");
    sl_resolver *r = sl_allocate(1, sizeof *r);
    if (!r) return sl_fail_memory(error, "the G-buffer's resolution");
    *r = (sl_resolver){raster, sl_pass_view_make(view, view->width, view->height), id,
                       sl_allocate(workers, sizeof *r->worker)};
    if (!r->worker) {
        sl_resolver_destroy(r);
        return sl_fail_memory(error, "the G-buffer's resolution");
    }
    *resolver = r;
    return SL_OK;
}

void sl_resolver_destroy(sl_resolver *r) {
    if (!r) return;
    sl_free(r->worker);
    sl_free(r);
}

/* Into planes whose first pixel is number `start` of the picture. */
static uint64_t run(const sl_resolver *r, unsigned worker, size_t first, size_t count, size_t start,
                    sl_gbuffer *out) {
    const resolution part = {r->raster, &r->view, r->id, out, start};
    return resolve_pixels(&part, first, first + count, &r->worker[worker]);
}

uint64_t sl_resolver_run(const sl_resolver *r, unsigned worker, size_t first, size_t count,
                         sl_gbuffer *part) {
    return run(r, worker, first, count, first, part);
}

/* ---- a whole picture ---- */

typedef struct {
    const sl_resolver *resolver;
    sl_gbuffer *out;
    size_t pixels;
    uint64_t *shaded; /* by strip */
} strips;

static void resolve_strip(void *context, size_t index, unsigned worker) {
    const strips *s = context;
    const size_t first = index * STRIP, left = s->pixels - first;
    s->shaded[index] = run(s->resolver, worker, first, left < STRIP ? left : STRIP, 0, s->out);
}

sl_status sl_raster_resolve(const sl_raster *raster, const sl_view *view, unsigned threads,
                            sl_gbuffer *g, sl_counters *counters, sl_error *error) {
    size_t pixels = (size_t)view->width * (size_t)view->height, count = (pixels + STRIP - 1) / STRIP;
    sl_resolver *resolver;
    sl_status status = sl_resolver_create(raster, view, g->id, sl_thread_count(threads), &resolver, error);
    if (status != SL_OK) return status;
    strips s = {resolver, g, pixels, sl_allocate(count, sizeof *s.shaded)};
    if (s.shaded) sl_parallel_for(sl_thread_count(threads), count, resolve_strip, &s);
    else status = sl_fail_memory(error, "the G-buffer's resolution");
    for (size_t n = 0; s.shaded && n < count; n++) sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, s.shaded[n]);
    sl_free(s.shaded);
    sl_resolver_destroy(resolver);
    return status;
}

sl_status sl_raster_gbuffer(const sl_raster *raster, const sl_view *view, unsigned threads,
                            sl_gbuffer *gbuffer, sl_counters *counters, sl_error *error) {
    sl_target target = {view->width, view->height, gbuffer->id, gbuffer->depth};
    sl_status status = sl_raster_id(raster, view, threads, &target, counters, error);
    return status == SL_OK ? sl_raster_resolve(raster, view, threads, gbuffer, counters, error) : status;
}
