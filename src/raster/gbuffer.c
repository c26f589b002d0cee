/* G-buffer: visibility first, then every visible pixel is resolved once from its triangle's index. */
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "raster/internal.h"

enum { STRIP = 1024 }; /* pixels resolved together */

/* ---- the buffer ---- */

static void list_planes(sl_gbuffer *g, void **planes[17]) {
    void **all[17] = {(void **)&g->id,          (void **)&g->depth,       (void **)&g->position_x, (void **)&g->position_y,
                      (void **)&g->position_z,  (void **)&g->normal_x,    (void **)&g->normal_y,   (void **)&g->normal_z,
                      (void **)&g->geometric_x, (void **)&g->geometric_y, (void **)&g->geometric_z, (void **)&g->diffuse_r,
                      (void **)&g->diffuse_g,   (void **)&g->diffuse_b,   (void **)&g->material};
    for (int k = 0; k < 17; k++) planes[k] = all[k];
}

sl_status sl_gbuffer_create(int width, int height, sl_gbuffer **gbuffer, sl_error *error) {
    *gbuffer = NULL;
    if (width < 1 || height < 1 || width > SL_RASTER_MAX_SIZE || height > SL_RASTER_MAX_SIZE) {
        return sl_fail(error, SL_ERROR_USAGE, "a G-buffer of %d x %d pixels: from 1 to %d each way", width, height,
                       (int)SL_RASTER_MAX_SIZE);
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
    sl_free(g);
}

/* ---- resolution ---- */

typedef struct {
    const sl_raster *raster;
    const sl_view *view;
    const uint32_t *id;
    sl_gbuffer *out;
    size_t pixels;
    uint64_t *shaded; /* by strip */
} resolution;

static inline void put(float *plane, size_t i, float value) {
    if (plane) plane[i] = value;
}

static void put_surface(sl_gbuffer *g, size_t i, const sl_surface *s, uint32_t material) {
    put(g->position_x, i, s->position.x);
    put(g->position_y, i, s->position.y);
    put(g->position_z, i, s->position.z);
    put(g->normal_x, i, s->normal.x);
    put(g->normal_y, i, s->normal.y);
    put(g->normal_z, i, s->normal.z);
    put(g->geometric_x, i, s->geometric_normal.x);
    put(g->geometric_y, i, s->geometric_normal.y);
    put(g->geometric_z, i, s->geometric_normal.z);
    put(g->diffuse_r, i, s->diffuse.r);
    put(g->diffuse_g, i, s->diffuse.g);
    put(g->diffuse_b, i, s->diffuse.b);
    if (g->material) g->material[i] = material;
}

static void resolve_pixel(const resolution *r, size_t i, uint32_t triangle, float w1, float w2) {
    const sl_scene *scene = r->raster->scene;
    sl_surface surface;
    float w0 = (1.0f - w1) - w2;
    sl_vec3 a = sl_scene_position(scene, scene->vertex[0][triangle]);
    sl_vec3 b = sl_scene_position(scene, scene->vertex[1][triangle]);
    sl_vec3 c = sl_scene_position(scene, scene->vertex[2][triangle]);
    sl_vec3 p = sl_add(sl_add(sl_scale(a, w0), sl_scale(b, w1)), sl_scale(c, w2));
    sl_scene_surface(scene, triangle, w1, w2, sl_sub(r->view->origin, p), &surface);
    put_surface(r->out, i, &surface, scene->material_index[triangle]);
}

static void resolve_strip(void *context, size_t index, unsigned worker) {
    (void)worker;
    const resolution *r = context;
    static const sl_surface nothing;
    size_t first = index * STRIP, count = r->pixels - first < STRIP ? r->pixels - first : STRIP;
    uint32_t pixel[STRIP] = {0};
    float w1[STRIP], w2[STRIP];
    for (size_t n = 0; n < count; n++) pixel[n] = (uint32_t)(first + n);
    sl_raster_barycentrics(r->raster, r->view, count, pixel, r->id + first, w1, w2);
    uint64_t shaded = 0;
    for (size_t n = 0; n < count; n++) {
        uint32_t triangle = r->id[first + n];
        if (triangle == SL_NO_INDEX) {
            put_surface(r->out, first + n, &nothing, SL_NO_INDEX);
        } else {
            resolve_pixel(r, first + n, triangle, w1[n], w2[n]);
            shaded++;
        }
    }
    r->shaded[index] = shaded;
}

sl_status sl_raster_gbuffer(const sl_raster *raster, const sl_view *view, unsigned threads, sl_gbuffer *gbuffer,
                            sl_counters *counters, sl_error *error) {
    size_t pixels = (size_t)view->width * (size_t)view->height, strips = (pixels + STRIP - 1) / STRIP;
    uint32_t *id = gbuffer->id ? gbuffer->id : sl_allocate(pixels, sizeof *id);
    uint64_t *shaded = sl_allocate(strips, sizeof *shaded);
    sl_status status = SL_ERROR_RESOURCES;
    if (!id || !shaded) {
        sl_fail_memory(error, "the G-buffer's id plane");
    } else {
        sl_target target = {view->width, view->height, id, gbuffer->depth};
        status = sl_raster_id(raster, view, threads, &target, counters, error);
    }
    if (status == SL_OK) {
        resolution r = {raster, view, id, gbuffer, pixels, shaded};
        sl_parallel_for(sl_thread_count(threads), strips, resolve_strip, &r);
        for (size_t s = 0; s < strips; s++) sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, shaded[s]);
    }
    if (!gbuffer->id) sl_free(id);
    sl_free(shaded);
    return status;
}
