/* Frames: visibility by the raster hardware, then for each pixel its root and (u, v), its leaf there, and L_e
 * + k_d E / pi + L_s (section on display). */
#include <string.h>

#include "base/counters.h"
#include "base/math.h"
#include "cache/frame/picture_value.h"
#include "cache/patches/display/leaf_lookup.h"
#include "scene/surface_rules.h"

/* ---- visibility ------------------------------------------------------------------------------ */

/* The scene without its curved surfaces, and those as they are tessellated for the view; each pixel keeps the
 * nearer one. */
static sl_status draw_ids(const sl_window *w, const sl_view *view, sl_counters *counters, sl_error *error) {
    const sl_display *d = w->display;
    sl_view planar = *view;
    planar.left_out = d->left_out;
    sl_target target = {view->width, view->height, w->id, w->depth};
    sl_status status = sl_raster_id(w->raster, &planar, w->threads, &target, counters, error);
    if (status != SL_OK || !d->curved) return status;
    target = (sl_target){view->width, view->height, w->curved_id, w->curved_depth};
    status = sl_raster_id(w->tessellation.raster, view, w->threads, &target, counters, error);
    if (status != SL_OK) return status;
    for (size_t i = 0, pixels = (size_t)view->width * (size_t)view->height; i < pixels; i++) {
        bool curved = w->curved_id[i] != SL_NO_INDEX &&
                      !(w->id[i] != SL_NO_INDEX && w->depth[i] >= w->curved_depth[i]);
        if (curved) w->id[i] = SL_NO_INDEX;
        else w->curved_id[i] = SL_NO_INDEX;
    }
    return SL_OK;
}

/* ---- pixels of one triangle ------------------------------------------------------------------ */

typedef struct frame_job {
    const sl_display *display;
    const sl_display_copy *copy;
    const sl_window *window;
    sl_view view;
    /* one of these: a picture (sl_window_draw()), an id map, one pixel */
    float *const *out;
    const sl_display_ids *ids;
    sl_shown_root *shown;
} frame_job;

/* The Gouraud pass interpolates a place (u, v) in the root, of a triangle that is drawn as it stands ... */
static void scene_places(const void *context, uint32_t triangle, float *value) {
    sl_root_corner_parameters(((const frame_job *)context)->display->primitives, triangle, value);
}

/* ... or of a tessellated one. */
static void curved_places(const void *context, uint32_t triangle, float *value) {
    const sl_scene *t = ((const frame_job *)context)->window->tessellation.scene;
    for (int c = 0; c < 3; c++) {
        value[2 * c] = t->texture_u[t->vertex[c][triangle]];
        value[2 * c + 1] = t->texture_v[t->vertex[c][triangle]];
    }
}

/* The side that is seen of a tessellated triangle. */
static uint32_t curved_root(const frame_job *job, uint32_t id) {
    const sl_tessellation *t = &job->window->tessellation;
    sl_vec3 corner[3];
    for (int c = 0; c < 3; c++) corner[c] = sl_scene_position(t->scene, t->scene->vertex[c][id]);
    sl_vec3 geometric = sl_cross(sl_sub(corner[1], corner[0]), sl_sub(corner[2], corner[0]));
    return 2 * t->primitive[id] + (sl_side_seen(geometric, sl_sub(job->view.origin, corner[0])) < 0.0f);
}

static void begin_run(const frame_job *job, uint32_t id, bool curved, sl_shown_root *run) {
    const sl_scene *s = job->window->scene;
    const sl_primitives *p = job->display->primitives;
    run->root = SL_NO_INDEX;
    if (id == SL_NO_INDEX) return;
    run->curved = curved;
    run->root = curved ? curved_root(job, id) : sl_root_seen(p, s, id, job->view.origin);
    uint32_t wanted = job->copy->root[run->root];
    run->wanted = wanted == SL_NO_INDEX ? NULL : &job->copy->wanted[wanted];
    run->leaf = sl_leaf_begin(run->wanted, p->kind[run->root / 2] == SL_PRIMITIVE_TRIANGLE);
    const sl_material *material = sl_root_material(p, run->root);
    run->lobe = job->copy->channels > 3 && sl_material_has_lobe(material);
    run->emission = sl_root_emission(material, run->root);
    run->diffuse = material->diffuse;
    run->texture = material->texture == SL_NO_INDEX ? NULL : &s->textures[material->texture];
}

/* The leaf of a place, if its root has any; returns whether it is another one than before. */
static bool find_leaf(const frame_job *job, sl_shown_root *run, const float place[2], int32_t *u,
                      int32_t *v) {
    *u = sl_place_of(place[0]);
    *v = sl_place_of(place[1]);
    return run->wanted && !sl_leaf_find(job->copy, &run->leaf, *u, *v);
}

static float as_parameter(int32_t place) { return (float)place * (1.0f / (float)SL_PLACE_ONE); }

/* ---- pixels of a frame ----------------------------------------------------------------------- */

static sl_rgb background(const frame_job *job, size_t pixel) {
    const size_t width = (size_t)job->view.width;
    return sl_view_emission(&job->view, job->window->scene, SL_NO_INDEX, pixel % width, pixel / width);
}

/* Tessellated surfaces are not the scene's triangles: the texture is looked up where the same (u, v) lies on
 * those. */
static sl_rgb curved_diffuse(const frame_job *job, const sl_shown_root *run, int32_t u, int32_t v) {
    float w1, w2;
    uint32_t triangle = sl_root_triangle_at(job->display->primitives, run->root, (double)as_parameter(u),
                                            (double)as_parameter(v), &w1, &w2);
    return sl_scene_diffuse(job->window->scene, triangle, w1, w2);
}

static sl_rgb diffuse_of(const frame_job *job, const sl_shown_root *run, int32_t u, int32_t v,
                         const sl_rgb *textured) {
    return !run->texture ? run->diffuse : run->curved ? curved_diffuse(job, run, u, v) : *textured;
}

static sl_rgb shade(const frame_job *job, sl_shown_root *run, const float place[2], const sl_rgb *textured) {
    const sl_rgb guess = job->copy->guess;
    float e[6] = {guess.r, guess.g, guess.b, 0, 0, 0};
    int32_t u, v;
    bool fresh = find_leaf(job, run, place, &u, &v);
    if (run->wanted && !run->lobe) { /* the constant, so that colours are compiled for it */
        if (fresh) sl_leaf_field_of(job->copy, 1, &run->leaf, &run->field);
        sl_leaf_value(job->copy, 1, &run->leaf, &run->field, e);
    } else if (run->wanted) {
        if (fresh) sl_leaf_field_of(job->copy, 2, &run->leaf, &run->field);
        sl_leaf_value(job->copy, 2, &run->leaf, &run->field, e);
    }
    sl_rgb kd = diffuse_of(job, run, u, v, textured);
    const float over_pi = (float)(1.0 / SL_PI);
    return (sl_rgb){run->emission.r + kd.r * e[0] * over_pi + e[3],
                    run->emission.g + kd.g * e[1] * over_pi + e[4],
                    run->emission.b + kd.b * e[2] * over_pi + e[5]};
}

static void put(float *const planes[3], size_t pixel, sl_rgb light) {
    planes[0][pixel] = sl_picture_value(light.r);
    planes[1][pixel] = sl_picture_value(light.g);
    planes[2][pixel] = sl_picture_value(light.b);
}

static void put_pixel(const frame_job *job, size_t pixel, sl_rgb radiance, sl_rgb emission) {
    put(job->out, pixel, radiance);
    if (job->out[3]) put(job->out + 3, pixel, emission);
}

static void name_pixel(const sl_display_ids *ids, size_t pixel, uint32_t patch, uint32_t root, int32_t u,
                       int32_t v) {
    if (ids->patch) ids->patch[pixel] = patch;
    if (ids->root) ids->root[pixel] = root;
    if (ids->u) ids->u[pixel] = as_parameter(u);
    if (ids->v) ids->v[pixel] = as_parameter(v);
}

static void do_background(const frame_job *job, size_t pixel) {
    if (job->ids) {
        name_pixel(job->ids, pixel, SL_NO_INDEX, SL_NO_INDEX, 0, 0);
        return;
    }
    const sl_rgb seen = background(job, pixel);
    if (job->shown) job->shown->emission = seen;
    else put_pixel(job, pixel, seen, seen);
}

static void do_pixel(const frame_job *job, size_t pixel, sl_shown_root *run, const float place[2],
                     const sl_rgb *textured) {
    int32_t u, v;
    if (job->out) {
        put_pixel(job, pixel, shade(job, run, place, textured), run->emission);
        return;
    }
    find_leaf(job, run, place, &u, &v);
    if (job->ids) {
        name_pixel(job->ids, pixel, run->wanted ? sl_leaf_patch(&run->leaf) : SL_NO_INDEX, run->root, u, v);
        return;
    }
    *job->shown = *run;
    job->shown->diffuse = diffuse_of(job, run, u, v, textured);
}

static bool is_background(const frame_job *job, size_t pixel) {
    return !job->display->curved || job->window->curved_id[pixel] == SL_NO_INDEX;
}

/* Does for the Gouraud pass what is asked of the pixels of one of the two rasterizers; the background is
 * the first one's. */
static void do_pixels(const frame_job *job, const sl_gouraud_pixels *p, bool curved) {
    sl_shown_root run = {.root = SL_NO_INDEX};
    for (size_t i = 0; i < p->count; i++) {
        if (p->id[i] == SL_NO_INDEX) {
            if (!curved && is_background(job, p->first + i)) do_background(job, p->first + i);
            continue;
        }
        if (i == 0 || p->id[i] != p->id[i - 1]) begin_run(job, p->id[i], curved, &run);
        sl_rgb textured = {0};
        if (p->diffuse[0]) textured = (sl_rgb){p->diffuse[0][i], p->diffuse[1][i], p->diffuse[2][i]};
        do_pixel(job, p->first + i, &run, (const float[2]){p->value[0][i], p->value[1][i]}, &textured);
    }
}

static void do_planar(void *context, const sl_gouraud_pixels *pixels) { do_pixels(context, pixels, false); }
static void do_curved(void *context, const sl_gouraud_pixels *pixels) { do_pixels(context, pixels, true); }

/* ---- frames ---------------------------------------------------------------------------------- */

static frame_job job_of(const sl_window *window, int copy) {
    const sl_display *d = window->display;
    return (frame_job){.display = d,
                       .copy = &d->copy[copy],
                       .window = window,
                       .view = sl_view_scene(window->scene, d->settings.width, d->settings.height)};
}

/* count: pixels from `first` on; 0: all. */
static void draw_gouraud(frame_job *job, size_t first, size_t count, sl_counters *counters) {
    const sl_window *w = job->window;
    sl_gouraud_pass pass = {.channels = 2,
                            .corners = scene_places,
                            .textured = job->display->textured && !job->ids,
                            .shade = do_planar,
                            .context = job,
                            .first = first,
                            .count = count};
    sl_raster_gouraud(w->raster, &job->view, w->threads, w->id, &pass, counters);
    if (!job->display->curved) return;
    pass.corners = curved_places;
    pass.textured = false;
    pass.shade = do_curved;
    sl_raster_gouraud(w->tessellation.raster, &job->view, w->threads, w->curved_id, &pass, counters);
}

/* The display's own window is seen to by builds. */
sl_status sl_window_draw(sl_window *window, float *const planes[6], sl_counters *counters, sl_error *error) {
    sl_display *d = window->display;
    uint64_t builds;
    const int copy = sl_copies_take(&d->copies, &builds);
    sl_status status = SL_OK;
    if (d->curved && window != &d->own && window->builds != builds) status = sl_tessellate(window, error);
    frame_job job = job_of(window, copy);
    job.out = planes;
    if (status == SL_OK) status = draw_ids(window, &job.view, counters, error);
    if (status == SL_OK) {
        draw_gouraud(&job, 0, 0, counters);
        window->builds = builds;
    }
    sl_copies_give_back(&d->copies, copy);
    return status;
}

sl_status sl_display_id_map(sl_display *d, const sl_display_ids *ids, sl_counters *counters,
                            sl_error *error) {
    frame_job job = job_of(&d->own, d->copies.shown);
    job.ids = ids;
    sl_status status = draw_ids(&d->own, &job.view, counters, error);
    if (status != SL_OK) return status;
    draw_gouraud(&job, 0, 0, counters);
    size_t planes = 0;
    const void *const wanted[4] = {ids->patch, ids->root, ids->u, ids->v};
    for (int k = 0; k < 4; k++) planes += wanted[k] != NULL;
    sl_count(counters, SL_COUNT_BYTES_READ_BACK,
             4 * planes * (size_t)d->settings.width * (size_t)d->settings.height);
    return SL_OK;
}

void sl_display_pixel(sl_display *d, size_t pixel, sl_shown_root *shown) {
    frame_job job = job_of(&d->own, d->copies.shown);
    sl_counters none = {{0}};
    *shown = (sl_shown_root){.root = SL_NO_INDEX};
    job.shown = shown;
    draw_gouraud(&job, pixel, 1, &none);
}
