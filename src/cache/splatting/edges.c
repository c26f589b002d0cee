/* Finds what pixels show, and which records they ask for.
 *
 * Pixels at edges are looked at again by rays. The rasterizer snaps vertices to 1/256 of a pixel, as hardware
 * does: at the outline of a thing one pixel of a thousand shows what lies behind it, or its far side. That
 * place may be on the other side of a sheet, in another light, and a record there would tell its neighbours
 * of it. */
#include <string.h>

#include "base/batch.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/reflect/reflect.h"
#include "cache/splatting/state.h"

typedef struct {
    const sl_scene *scene;
    const sl_tracer *tracer;
    sl_gbuffer *gbuffer;
    sl_view view;
    uint8_t *edge;         /* 1: looked at again */
} edge_pass;

/* ---- which pixels ---- */

/* Does the neighbour j show another surface than i? Not where both lie in one plane, or in a finely
 * tessellated surface. */
static bool is_edge_between(const sl_gbuffer *g, size_t i, size_t j) {
    const float flat = 0.1f; /* sine of what j may rise above the plane of i */
    if (g->id[i] == g->id[j]) return false;
    if (g->id[i] == SL_NO_INDEX || g->id[j] == SL_NO_INDEX) return true;
    const sl_vec3 d = sl_sub(sl_gbuffer_position(g, j), sl_gbuffer_position(g, i));
    float rise = sl_dot(d, sl_gbuffer_geometric(g, i));
    return !(rise * rise <= flat * flat * sl_dot(d, d));
}

static void find_edges(void *context, size_t y, unsigned worker) {
    (void)worker;
    const edge_pass *p = context;
    const sl_gbuffer *g = p->gbuffer;
    const size_t width = (size_t)g->width, row = y * width, end = row + width;
    const bool below = y > 0, above = y + 1 < (size_t)g->height;
    const uint8_t *wanted = p->scene->sub_frame.wanted;
    for (size_t i = row; i < end; i++) {
        if (wanted && !wanted[i]) continue;
        const bool beside =
            (i > row && is_edge_between(g, i, i - 1)) || (i + 1 < end && is_edge_between(g, i, i + 1));
        p->edge[i] = beside || (below && is_edge_between(g, i, i - width)) ||
                     (above && is_edge_between(g, i, i + width));
    }
}

/* ---- what they show ---- */

static void set_ray(const edge_pass *p, uint32_t pixel, unsigned k, sl_ray16 *rays) {
    const uint32_t width = (uint32_t)p->gbuffer->width;
    const sl_vec3 eye = p->scene->camera.eye;
    const uint32_t x = pixel % width, y = pixel / width;
    const sl_vec3 d = sl_view_direction(&p->view, (double)x + 0.5, (double)y + 0.5);
    /* the view's near plane */
    sl_ray16_set(rays, k, eye, d, 1e-5f * p->scene->scale, INFINITY, SL_NO_INDEX);
}

/* Where the triangle is the ray's, the rasterizer's position is as good. */
static void look_at(const edge_pass *p, const uint32_t *pixels, unsigned count, sl_counters *counters) {
    sl_ray16 rays;
    sl_hit16 hits;
    memset(&rays, 0, sizeof rays);
    for (unsigned k = 0; k < count; k++) set_ray(p, pixels[k], k, &rays);
    sl_trace(p->tracer, &rays, count, true, &hits, counters);
    for (unsigned k = 0; k < count; k++) {
        const uint32_t triangle = hits.triangle[k];
        const sl_vec3 to_eye = sl_v3(-rays.direction_x[k], -rays.direction_y[k], -rays.direction_z[k]);
        sl_surface s;
        if (triangle == p->gbuffer->id[pixels[k]]) continue;
        if (triangle != SL_NO_INDEX) sl_scene_surface(p->scene, triangle, hits.w1[k], hits.w2[k], to_eye, &s);
        sl_gbuffer_show(p->scene, p->gbuffer, pixels[k], triangle, &s);
    }
}

static void look_again(void *context, size_t y, unsigned worker, void *result, sl_counters *counters) {
    (void)worker, (void)result;
    const edge_pass *p = context;
    const size_t width = (size_t)p->gbuffer->width, row = y * width;
    uint32_t pixels[SL_PACKET];
    unsigned count = 0;
    for (size_t i = row; i < row + width; i++) {
        if (p->edge[i]) pixels[count++] = (uint32_t)i;
        if (count < SL_PACKET && i + 1 < row + width) continue;
        if (count) look_at(p, pixels, count, counters);
        count = 0;
    }
}

sl_status sl_look_at_edges(const sl_scene *scene, const sl_tracer *tracer, unsigned threads,
                           sl_gbuffer *gbuffer, sl_counters *counters, sl_error *error) {
    const size_t rows = (size_t)gbuffer->height;
    edge_pass pass = {.scene = scene, .tracer = tracer, .gbuffer = gbuffer,
                      .view = sl_view_scene(scene, gbuffer->width, gbuffer->height),
                      .edge = sl_allocate((size_t)gbuffer->width * rows, sizeof *pass.edge)};
    sl_status status = pass.edge ? SL_OK : sl_fail_memory(error, "pixels at edges");
    if (status == SL_OK) {
        sl_parallel_for(threads, rows, find_edges, &pass);
        sl_batch_run(&(sl_batch){.count = rows, .work = look_again, .context = &pass}, threads, counters);
    }
    sl_free(pass.edge);
    return status;
}

/* ---- which records they ask for ---- */

/* The class of a pixel with geometry; SL_RECEIVER_CLASSES where it reflects nothing but mirrors. */
static sl_receiver_class class_of(const sl_splat_state *s, size_t i) {
    const sl_gbuffer *g = s->gbuffer;
    if (sl_material_is_glossy(&s->scene->materials[g->material[i]])) return SL_RECEIVES_RADIANCE;
    bool diffuse = g->diffuse_r[i] > 0.0f || g->diffuse_g[i] > 0.0f || g->diffuse_b[i] > 0.0f;
    return diffuse ? SL_RECEIVES_IRRADIANCE : SL_RECEIVER_CLASSES;
}

static bool is_sound(const sl_gbuffer *g, size_t i) {
    return sl_is_finite(sl_gbuffer_normal(g, i)) &&
           sl_is_finite(sl_gbuffer_position(g, i));
}

typedef struct {
    size_t receivers[SL_RECEIVER_CLASSES];
} classified;

/* A normal that is not finite would ask for ever. */
static void classify(sl_splat_state *s, size_t i, classified *row, sl_counters *counters) {
    if (s->gbuffer->material[i] == SL_NO_INDEX) return;
    sl_receiver_class class = class_of(s, i);
    if (!is_sound(s->gbuffer, i)) {
        sl_count(counters, SL_COUNT_NONFINITE, 1);
    } else if (class < SL_RECEIVER_CLASSES && s->cache[class].receives) {
        s->cache[class].receives[i] = 1;
        row->receivers[class]++;
    }
}

static void classify_row(void *context, size_t y, unsigned worker, void *result, sl_counters *counters) {
    sl_splat_state *s = context;
    const sl_sub_frame *at = &s->scene->sub_frame;
    const size_t width = (size_t)s->settings.width, row = y * width, end = row + width;
    (void)worker;
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++)
        if (s->cache[c].receives) memset(s->cache[c].receives + row, 0, width * sizeof *s->cache[c].receives);
    for (sl_pixel_run r = sl_sub_frame_run(at, row, end); r.first < r.end;
         r = sl_sub_frame_run(at, r.end, end))
        for (size_t i = r.first; i < r.end; i++) classify(s, i, result, counters);
}

sl_status sl_splat_classify(sl_splat_state *s, sl_error *error) {
    const size_t rows = (size_t)s->settings.height;
    classified *of = sl_allocate(rows, sizeof *of);
    if (!of) return sl_fail_memory(error, "classes of pixels");
    const sl_batch batch = {.count = rows, .work = classify_row, .context = s, .results = of,
                            .result_bytes = sizeof *of};
    sl_batch_run(&batch, s->settings.threads, &s->counters);
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) {
        s->cache[c].receivers = 0;
        for (size_t y = 0; y < rows; y++) s->cache[c].receivers += of[y].receivers[c];
    }
    sl_free(of);
    return SL_OK;
}

/* ---- progress ---- */

double sl_splat_fraction(const sl_splat_state *s) {
    double all = 0.0, done = 0.0;
    if (s->phase <= SL_PHASE_GBUFFER) return 0.0;
    if (s->phase == SL_PHASE_DIRECT) return 0.2 * (double)s->direct_row / (double)s->settings.height;
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) {
        const sl_traversal *t = &s->cache[c].traversal;
        double visited = c < s->class ? 1.0 : c > s->class ? 0.0 : (double)t->visited / (double)t->total;
        if (c == s->class) visited = s->phase == SL_PHASE_SECOND ? 0.9 + 0.1 * visited : 0.9 * visited;
        all += (double)s->cache[c].receivers;
        done += (double)s->cache[c].receivers * visited;
    }
    return s->phase == SL_PHASE_DONE ? 1.0 : 0.2 + 0.8 * (done / all);
}
