#include "cache/reflect/reflect.h"

#include "base/math.h"
#include "base/batch.h"
#include "base/error.h"
#include "base/memory.h"
#include "raster/textures/mip.h"
#include "scene/bump.h"
#include "trace/bsdf.h"

#include <string.h>

/* ---- which pixels ---- */

static bool shows_mirror(const sl_scene *scene, const sl_gbuffer *g, size_t pixel) {
    return g->id[pixel] != SL_NO_INDEX && sl_material_is_mirror(&scene->materials[g->material[pixel]]);
}

sl_rgb sl_reflections_throughput(const sl_reflections *r, size_t pixel) {
    for (size_t k = 0; r && k < r->count; k++)
        if (r->pixel[k] == pixel) return r->throughput[k];
    return sl_grey(1.0f);
}

void sl_reflections_destroy(sl_reflections *r) {
    if (!r) return;
    SL_FREE_ALL(r->pixel, r->throughput, r->background, r->way, r);
}

static sl_status list_pixels(const sl_scene *scene, const sl_gbuffer *g, sl_reflections **reflections,
                             sl_error *error) {
    size_t pixels = (size_t)g->width * (size_t)g->height, count = 0;
    for (size_t i = 0; i < pixels; i++) count += shows_mirror(scene, g, i);
    if (!count) return SL_OK;
    sl_reflections *r = sl_allocate(1, sizeof *r);
    if (r) {
        r->pixel = sl_allocate(count, sizeof *r->pixel);
        r->throughput = sl_allocate(count, sizeof *r->throughput);
        r->background = sl_allocate(count, sizeof *r->background);
        r->way = sl_allocate(count, sizeof *r->way);
    }
    if (!r || !r->pixel || !r->throughput || !r->background || !r->way) {
        sl_reflections_destroy(r);
        return sl_fail_memory(error, "reflections");
    }
    for (size_t i = 0; i < pixels; i++) {
        if (shows_mirror(scene, g, i)) r->pixel[r->count++] = (uint32_t)i;
    }
    *reflections = r;
    return SL_OK;
}

/* From the viewer's own eye, as long as no mirror tells otherwise. */
static sl_status place_viewers(sl_vec3 eye, sl_gbuffer *g, sl_error *error) {
    size_t pixels = (size_t)g->width * (size_t)g->height;
    g->seen_from = sl_allocate(pixels, sizeof *g->seen_from);
    if (!g->seen_from) return sl_fail_memory(error, "reflections");
    for (size_t i = 0; i < pixels; i++) g->seen_from[i] = eye;
    return SL_OK;
}

/* ---- rays ---- */

typedef struct {
    const sl_scene *scene;
    const sl_tracer *tracer;
    const sl_viewer *viewer;
    sl_gbuffer *gbuffer;
    sl_reflections *reflections;
    float half_pixel; /* at a distance of 1 */
} reflecting;

/* A ray that is on its way from a mirror. */
typedef struct {
    size_t slot; /* in the list */
    sl_vec3 origin, direction;
    uint32_t skip;
} reflected;

/* Returns the unit direction in which the mirror at p is seen, and how far away that is. */
static sl_vec3 look_at(const sl_viewer *viewer, sl_vec3 p, sl_vec3 fallback, float *way) {
    const sl_vec3 d = sl_sub(p, viewer->eye);
    *way = sl_dot(d, viewer->along);
    if (*way != 0.0f) return viewer->along;
    *way = sl_length(d);
    return sl_normalize_or(d, fallback);
}

static reflected first_ray(const reflecting *c, size_t slot) {
    const sl_gbuffer *g = c->gbuffer;
    size_t i = c->reflections->pixel[slot];
    sl_vec3 p = sl_gbuffer_position(g, i),
            n = sl_gbuffer_normal(g, i);
    sl_vec3 geometric = sl_gbuffer_geometric(g, i);
    sl_vec3 incoming = look_at(c->viewer, p, sl_neg(geometric), &c->reflections->way[slot]);
    c->reflections->throughput[slot] = c->scene->materials[g->material[i]].mirror;
    return (reflected){slot, p, sl_reflect_off(incoming, n, geometric), g->id[i]};
}

void sl_gbuffer_show(const sl_scene *scene, sl_gbuffer *g, size_t i, uint32_t triangle, const sl_surface *s) {
    g->id[i] = g->material[i] = SL_NO_INDEX;
    g->diffuse_r[i] = g->diffuse_g[i] = g->diffuse_b[i] = 0.0f;
    if (triangle == SL_NO_INDEX) return;
    g->id[i] = triangle;
    g->material[i] = scene->material_index[triangle];
    g->position_x[i] = s->position.x, g->position_y[i] = s->position.y, g->position_z[i] = s->position.z;
    g->normal_x[i] = s->normal.x, g->normal_y[i] = s->normal.y, g->normal_z[i] = s->normal.z;
    g->geometric_x[i] = s->geometric_normal.x, g->geometric_y[i] = s->geometric_normal.y,
    g->geometric_z[i] = s->geometric_normal.z;
    g->diffuse_r[i] = s->diffuse.r, g->diffuse_g[i] = s->diffuse.g, g->diffuse_b[i] = s->diffuse.b;
}

static void show_nothing(const reflecting *c, const reflected *ray) {
    sl_gbuffer_show(c->scene, c->gbuffer, c->reflections->pixel[ray->slot], SL_NO_INDEX, NULL);
}

static void show_surface(const reflecting *c, const reflected *ray, uint32_t triangle, const sl_surface *s) {
    size_t i = c->reflections->pixel[ray->slot];
    sl_gbuffer_show(c->scene, c->gbuffer, i, triangle, s);
    c->gbuffer->seen_from[i] = ray->origin;
}

/* Returns k_d of what a mirror shows, filtered over as much of it as half a pixel sees. */
static sl_rgb diffuse_seen(const reflecting *c, const reflected *ray, uint32_t triangle, float w1, float w2,
                           sl_rgb unfiltered) {
    if (!c->scene->sub_frame.mips || sl_material_is_bumpy(sl_triangle_material(c->scene, triangle)))
        return unfiltered;
    return sl_scene_diffuse_within(c->scene, c->scene->sub_frame.mips, triangle, w1, w2,
                                   c->half_pixel * c->reflections->way[ray->slot]);
}

/* Where the ray ends; or, at a mirror, the ray that goes on from there. */
static bool goes_on(const reflecting *c, reflected *ray, uint32_t triangle, float t, float w1, float w2) {
    sl_rgb *throughput = &c->reflections->throughput[ray->slot];
    if (triangle == SL_NO_INDEX) {
        c->reflections->background[ray->slot] =
            sl_rgb_mul(*throughput, sl_environment_radiance(&c->scene->environment, ray->direction));
        show_nothing(c, ray);
        return false;
    }
    sl_surface s;
    sl_scene_surface(c->scene, triangle, w1, w2, sl_neg(ray->direction), &s);
    c->reflections->way[ray->slot] += t;
    s.diffuse = diffuse_seen(c, ray, triangle, w1, w2, s.diffuse);
    if (!sl_material_is_mirror(s.material)) {
        show_surface(c, ray, triangle, &s);
        return false;
    }
    *throughput = sl_rgb_mul(*throughput, s.material->mirror);
    *ray = (reflected){ray->slot, s.position, sl_reflect_off(ray->direction, s.normal, s.geometric_normal),
                       triangle};
    return true;
}

static unsigned advance(const reflecting *c, reflected *rays, unsigned count, sl_counters *counters) {
    sl_ray16 packet;
    sl_hit16 hits;
    memset(&packet, 0, sizeof packet);
    for (unsigned i = 0; i < count; i++)
        sl_ray16_set(&packet, i, rays[i].origin, rays[i].direction, 0.0f, INFINITY, rays[i].skip);
    if (c->tracer) sl_trace(c->tracer, &packet, count, true, &hits, counters);
    else memset(hits.triangle, 0xff, sizeof hits.triangle); /* SL_NO_INDEX */
    unsigned left = 0;
    for (unsigned i = 0; i < count; i++) {
        if (goes_on(c, &rays[i], hits.triangle[i], hits.t[i], hits.w1[i], hits.w2[i])) rays[left++] = rays[i];
    }
    return left;
}

static void reflect_packet(void *context, size_t index, unsigned worker, void *result,
                           sl_counters *counters) {
    (void)worker, (void)result;
    const reflecting *c = context;
    reflected rays[SL_PACKET];
    size_t first = index * SL_PACKET, count = c->reflections->count - first;
    unsigned left = count < SL_PACKET ? (unsigned)count : SL_PACKET;
    for (unsigned i = 0; i < left; i++) rays[i] = first_ray(c, first + i);
    for (int k = 0; k < SL_REFLECTIONS_MAX && left; k++) left = advance(c, rays, left, counters);
    for (unsigned i = 0; i < left; i++) show_nothing(c, &rays[i]);
}

sl_status sl_reflect_seen(const sl_scene *scene, const sl_tracer *tracer, unsigned threads,
                          const sl_viewer *viewer, sl_gbuffer *gbuffer, sl_reflections **reflections,
                          sl_counters *counters, sl_error *error) {
    *reflections = NULL;
    sl_free(gbuffer->seen_from); /* of another view */
    gbuffer->seen_from = NULL;
    sl_status status = list_pixels(scene, gbuffer, reflections, error);
    if (status != SL_OK || !*reflections) return status;
    status = place_viewers(viewer->eye, gbuffer, error);
    if (status != SL_OK) {
        sl_reflections_destroy(*reflections);
        *reflections = NULL;
        return status;
    }
    size_t packets = ((*reflections)->count + SL_PACKET - 1) / SL_PACKET;
    reflecting c = {scene, tracer, viewer, gbuffer, *reflections,
                    (float)(sl_tan(0.5 * (double)scene->camera.vertical_fov) / (double)gbuffer->height)};
    sl_batch_run(&(sl_batch){.count = packets, .work = reflect_packet, .context = &c}, threads, counters);
    return SL_OK;
}

sl_status sl_reflect_pixels(const sl_scene *scene, const sl_tracer *tracer, unsigned threads,
                            sl_gbuffer *gbuffer, sl_reflections **reflections, sl_counters *counters,
                            sl_error *error) {
    const sl_viewer camera = {.eye = scene->camera.eye};
    return sl_reflect_seen(scene, tracer, threads, &camera, gbuffer, reflections, counters, error);
}
