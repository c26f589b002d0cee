#include "cache/light_octree/photon_pixels.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/light_octree/direct_photons.h"
#include "cache/light_octree/surroundings.h"

enum { PIXELS_AT_ONCE = 16384 };

/* ---- the area that photons are strewn over ---- */

typedef struct strewn {
    const sl_surroundings *surroundings;
    sl_surroundings_marks *marks; /* a worker */
    double least_cosine;
    sl_photon_area kind;
} strewn;

/* As of a voxel's photons (voxel_gather.c): next to no surface means that the disc is nearer to the truth. A
 * plane's section is that of the pixel's own plane, which is the disc. */
static double area_of(const void *context, const sl_ellipsoid *e, unsigned worker) {
    const strewn *s = context;
    double disc = sl_disc_area(e);
    if (s->kind != SL_PHOTON_AREA_CLIP) return disc;
    sl_strewn_area found = sl_surroundings_area(s->surroundings, e, s->least_cosine, &s->marks[worker]);
    double area = found.sheet ? found.front + found.back : found.front;
    return area > 1e-3 * disc ? area : disc;
}

static void forget(strewn *s, sl_surroundings *surroundings, unsigned workers) {
    for (unsigned w = 0; s->marks && w < workers; w++) sl_free(s->marks[w].mark);
    sl_free(s->marks);
    sl_surroundings_destroy(surroundings);
}

static sl_status look_around(const sl_photon_pixels *p, unsigned workers, strewn *s,
                             sl_surroundings **surroundings, sl_error *error) {
    *surroundings = NULL;
    if (s->kind != SL_PHOTON_AREA_CLIP) return SL_OK;
    sl_status status =
        sl_surroundings_create(p->scene, p->octree, p->radius / 16.0, p->threads, surroundings, error);
    if (status != SL_OK) return status;
    s->surroundings = *surroundings;
    s->marks = sl_allocate(workers, sizeof *s->marks);
    for (unsigned w = 0; s->marks && w < workers; w++) {
        s->marks[w].mark = sl_allocate(p->scene->triangle_count, sizeof *s->marks[w].mark);
        if (!s->marks[w].mark) return sl_fail_memory(error, "photons of pixels");
    }
    return s->marks ? SL_OK : sl_fail_memory(error, "photons of pixels");
}

/* ---- pixels ---- */

typedef struct points {
    size_t *pixel;
    sl_surface *surface;
    sl_vec3 *to_viewer;
    sl_rgb *radiance;
} points;

static bool allocate(points *list, size_t room) {
    list->pixel = sl_allocate(room, sizeof *list->pixel);
    list->surface = sl_allocate(room, sizeof *list->surface);
    list->to_viewer = sl_allocate(room, sizeof *list->to_viewer);
    list->radiance = sl_allocate(room, sizeof *list->radiance);
    return list->pixel && list->surface && list->to_viewer && list->radiance;
}

static void release(points *list) {
    sl_free(list->pixel);
    sl_free(list->surface);
    sl_free(list->to_viewer);
    sl_free(list->radiance);
}

static void take_point(const sl_photon_pixels *p, size_t pixel, points *list, size_t at) {
    const sl_gbuffer *g = p->gbuffer;
    sl_vec3 viewer = g->seen_from ? g->seen_from[pixel] : p->scene->camera.eye;
    sl_surface *s = &list->surface[at];
    *s = (sl_surface){.position = sl_v3(g->position_x[pixel], g->position_y[pixel], g->position_z[pixel]),
                      .geometric_normal =
                          sl_v3(g->geometric_x[pixel], g->geometric_y[pixel], g->geometric_z[pixel]),
                      .normal = sl_v3(g->normal_x[pixel], g->normal_y[pixel], g->normal_z[pixel]),
                      .diffuse = {g->diffuse_r[pixel], g->diffuse_g[pixel], g->diffuse_b[pixel]},
                      .material = &p->scene->materials[g->material[pixel]],
                      .front = true};
    list->to_viewer[at] = sl_normalize_or(sl_sub(viewer, s->position), s->geometric_normal);
    list->pixel[at] = pixel;
}

/* The next pixels that show a surface; *next moves behind them. */
static size_t take_points(const sl_photon_pixels *p, size_t *next, size_t pixels, points *list) {
    size_t count = 0;
    for (; *next < pixels && count < PIXELS_AT_ONCE; ++*next) {
        if (p->gbuffer->material[*next] != SL_NO_INDEX) take_point(p, *next, list, count++);
    }
    return count;
}

static sl_status light_points(const sl_photon_pixels *p, const sl_direct_photons *photons, points *list,
                              float *const indirect[3], sl_counters *counters, sl_error *error) {
    size_t pixels = (size_t)p->gbuffer->width * (size_t)p->gbuffer->height, next = 0, count;
    sl_status status = SL_OK;
    while (status == SL_OK && (count = take_points(p, &next, pixels, list)) > 0) {
        status = sl_direct_photons_radiance(photons, count, list->surface, list->to_viewer, list->radiance,
                                            NULL, counters, error);
        for (size_t i = 0; status == SL_OK && i < count; i++) {
            indirect[0][list->pixel[i]] = list->radiance[i].r;
            indirect[1][list->pixel[i]] = list->radiance[i].g;
            indirect[2][list->pixel[i]] = list->radiance[i].b;
        }
    }
    return status;
}

sl_status sl_photon_light_pixels(const sl_photon_pixels *p, float *const indirect[3], sl_counters *counters,
                                 sl_error *error) {
    const sl_light_octree_settings *o = p->settings;
    size_t pixels = (size_t)p->gbuffer->width * (size_t)p->gbuffer->height;
    unsigned workers = sl_thread_count(p->threads);
    strewn areas = {.least_cosine = sl_cos(o->acceptance), .kind = o->area};
    sl_surroundings *surroundings;
    points list = {NULL, NULL, NULL, NULL};
    for (int k = 0; k < 3; k++) {
        for (size_t i = 0; i < pixels; i++) indirect[k][i] = 0.0f;
    }
    sl_status status = look_around(p, workers, &areas, &surroundings, error);
    if (status == SL_OK && !allocate(&list, PIXELS_AT_ONCE))
        status = sl_fail_memory(error, "photons of pixels");
    const sl_direct_photons photons = {.tree = p->tree,
                                       .neighbours = (size_t)o->neighbours,
                                       .radius = p->radius,
                                       .flatness = o->flatness,
                                       .cos_acceptance = areas.least_cosine,
                                       .area = area_of,
                                       .area_context = &areas,
                                       .threads = p->threads};
    if (status == SL_OK) status = light_points(p, &photons, &list, indirect, counters, error);
    release(&list);
    forget(&areas, surroundings, workers);
    return status;
}
