/* Frames: visibility by the raster hardware, then for each pixel its root and (u, v), its leaf there, and L_e + k_d E / pi + L_s (section on display). */
#include "base/counters.h"
#include "base/math.h"
#include "base/parallel.h"
#include "cache/frame/picture_value.h"
#include "cache/shading_cache/leaf_lookup.h"
#include "cache/shading_cache/story.h"
#include "scene/surface_rules.h"

enum { STRIP = 2048 }; /* pixels of a task */

/* ---- visibility --------------------------------------------------------------------------------------------------------------- */

/* The scene without its curved surfaces, and those as they are tessellated for the view; each pixel keeps the nearer one. */
static sl_status draw_ids(const sl_display *d, const sl_window *w, const sl_view *view, unsigned threads, sl_counters *counters, sl_error *error) {
    const sl_frame_planes *frame = &w->frame;
    sl_view planar = *view;
    planar.left_out = d->left_out;
    sl_target target = {view->width, view->height, frame->id, frame->depth};
    sl_status status = sl_raster_id(w->raster, &planar, threads, &target, counters, error);
    if (status != SL_OK || !d->curved) return status;
    target = (sl_target){view->width, view->height, frame->curved_id, frame->curved_depth};
    status = sl_raster_id(w->tessellation.raster, view, threads, &target, counters, error);
    if (status != SL_OK) return status;
    for (size_t i = 0, pixels = (size_t)view->width * (size_t)view->height; i < pixels; i++) {
        bool curved = frame->curved_id[i] != SL_NO_INDEX && !(frame->id[i] != SL_NO_INDEX && frame->depth[i] >= frame->curved_depth[i]);
        if (curved) frame->id[i] = SL_NO_INDEX;
        else frame->curved_id[i] = SL_NO_INDEX;
    }
    return SL_OK;
}

/* ---- pixels of one triangle --------------------------------------------------------------------------------------------------- */

typedef struct frame_job {
    const sl_display *display;
    const sl_display_copy *copy;
    const sl_window *window;
    sl_view view;
    size_t pixels;
    float *const *out;         /* pictures */
    sl_resolver *resolver;     /* of textures; NULL: there are none */
    const sl_display_ids *ids; /* id maps */
} frame_job;

/* What they have in common. */
typedef struct triangle_run {
    uint32_t root;             /* SL_NO_INDEX: the background */
    const sl_display_root *wanted; /* NULL: not wanted yet */
    bool curved;
    float u[3], v[3];          /* at corner 0, and how much more at corners 1 and 2 */
    bool lobe;                 /* L_s, too */
    sl_rgb emission, diffuse;
    const sl_texture *texture; /* NULL: diffuse is all */
    sl_leaf leaf;              /* that the last pixel was in */
    sl_leaf_field field;
} triangle_run;

static void corner_differences(float p[3]) {
    p[1] -= p[0];
    p[2] -= p[0];
}

/* Of a triangle that is drawn as it stands: plain, or half of a quadrilateral, whose corners go round from wherever the triangle begins. */
static void scene_parameters(const sl_primitives *p, uint32_t t, triangle_run *run) {
    static const float round[3][3][2] = {{{0, 0}, {1, 0}, {0, 1}}, {{0, 0}, {1, 0}, {1, 1}}, {{0, 0}, {1, 1}, {0, 1}}};
    uint32_t primitive = p->of_triangle[t];
    bool plain = p->kind[primitive] == SL_PRIMITIVE_TRIANGLE;
    const float(*corner)[2] = round[plain ? 0 : 1 + (t - p->first_triangle[primitive])];
    double u = 0.0, v = 0.0;
    if (!plain) sl_root_parameters(p, t, 0.0f, 0.0f, &u, &v);
    int first = u == 0.0 && v == 0.0 ? 0 : u == (double)corner[1][0] && v == (double)corner[1][1] ? 1 : 2;
    for (int c = 0; c < 3; c++) {
        run->u[c] = corner[(first + c) % 3][0];
        run->v[c] = corner[(first + c) % 3][1];
    }
}

/* The side that is seen, of a plane. */
static uint32_t seen_root(uint32_t primitive, sl_vec3 geometric, sl_vec3 to_viewer) {
    return 2 * primitive + (sl_side_seen(geometric, to_viewer) < 0.0f ? 1 : 0);
}

static void begin_run(const frame_job *job, uint32_t id, uint32_t curved_id, triangle_run *run) {
    const sl_scene *s = job->window->scene;
    const sl_primitives *p = job->display->primitives;
    run->root = SL_NO_INDEX;
    if (id == SL_NO_INDEX && curved_id == SL_NO_INDEX) return;
    run->curved = id == SL_NO_INDEX;
    sl_vec3 geometric, corner[3];
    uint32_t primitive;
    if (run->curved) {
        const sl_tessellation *t = &job->window->tessellation;
        primitive = t->primitive[curved_id];
        for (int c = 0; c < 3; c++) {
            uint32_t v = t->vertex[c][curved_id];
            corner[c] = sl_v3(t->x[v], t->y[v], t->z[v]);
            run->u[c] = t->u[v];
            run->v[c] = t->v[v];
        }
        geometric = sl_cross(sl_sub(corner[1], corner[0]), sl_sub(corner[2], corner[0]));
    } else {
        primitive = p->of_triangle[id];
        corner[0] = sl_scene_position(s, s->vertex[0][id]);
        scene_parameters(p, id, run);
        geometric = sl_scene_geometric_normal(s, id);
    }
    corner_differences(run->u);
    corner_differences(run->v);
    run->root = seen_root(primitive, geometric, sl_sub(job->view.origin, corner[0]));
    uint32_t wanted = job->copy->root[run->root];
    run->wanted = wanted == SL_NO_INDEX ? NULL : &job->display->root[wanted];
    run->leaf = sl_leaf_begin(run->wanted, p->kind[primitive] == SL_PRIMITIVE_TRIANGLE);
    const sl_material *material = sl_root_material(p, run->root);
    run->lobe = job->copy->lobe_group && sl_material_has_lobe(material);
    run->emission = run->root % 2 == 0 || material->emission_two_sided ? material->emission : sl_grey(0.0f);
    run->diffuse = material->diffuse;
    run->texture = material->texture == SL_NO_INDEX ? NULL : &s->textures[material->texture];
}

/* The leaf of a place, if its root has any; returns whether it is another one than before. */
static bool find_leaf(const frame_job *job, triangle_run *run, float w1, float w2, int32_t *u, int32_t *v) {
    *u = sl_place_of(run->u[0] + w1 * run->u[1] + w2 * run->u[2]);
    *v = sl_place_of(run->v[0] + w1 * run->v[1] + w2 * run->v[2]);
    return run->wanted && !sl_leaf_find(job->copy, &run->leaf, *u, *v);
}

static float as_parameter(int32_t place) { return (float)place * (1.0f / (float)SL_PLACE_ONE); }

/* ---- strips of a frame -------------------------------------------------------------------------------------------------------- */

/* Weights of corners 1 and 2, whichever raster drew the pixel. */
typedef struct strip {
    size_t first, count;
    const uint32_t *id, *curved_id; /* the latter NULL where nothing is curved */
    float w1[STRIP], w2[STRIP];
} strip;

static void begin_pixels(const frame_job *job, size_t first, size_t count, strip *s) {
    uint32_t pixel[STRIP] = {0};
    s->first = first;
    s->count = count;
    s->id = job->window->frame.id + s->first;
    s->curved_id = job->display->curved ? job->window->frame.curved_id + s->first : NULL;
    bool any = false;
    for (size_t i = 0; i < s->count; i++) {
        pixel[i] = (uint32_t)(s->first + i);
        any |= s->curved_id && s->curved_id[i] != SL_NO_INDEX;
    }
    sl_raster_barycentrics(job->window->raster, &job->view, s->count, pixel, s->id, s->w1, s->w2);
    if (!any) return;
    float w1[STRIP], w2[STRIP];
    sl_raster_barycentrics(job->window->tessellation.raster, &job->view, s->count, pixel, s->curved_id, w1, w2);
    for (size_t i = 0; i < s->count; i++) {
        bool curved = s->curved_id[i] != SL_NO_INDEX;
        s->w1[i] = curved ? w1[i] : s->w1[i];
        s->w2[i] = curved ? w2[i] : s->w2[i];
    }
}

static void begin_strip(const frame_job *job, size_t index, strip *s) {
    size_t first = index * STRIP;
    begin_pixels(job, first, job->pixels - first < STRIP ? job->pixels - first : STRIP, s);
}

static void next_pixel(const frame_job *job, const strip *s, size_t i, triangle_run *run) {
    uint32_t curved = s->curved_id ? s->curved_id[i] : SL_NO_INDEX;
    bool same = i > 0 && s->id[i] == s->id[i - 1] && (!s->curved_id || curved == s->curved_id[i - 1]);
    if (!same) begin_run(job, s->id[i], curved, run);
}

static sl_rgb background(const frame_job *job, size_t pixel) {
    const sl_environment *environment = &job->window->scene->environment;
    if (!environment->present) return sl_grey(0.0f);
    size_t width = (size_t)job->view.width;
    return sl_environment_radiance(environment, sl_view_direction(&job->view, (double)(pixel % width) + 0.5, (double)(pixel / width) + 0.5));
}

/* Tessellated surfaces are not the scene's triangles: the texture is looked up where the same (u, v) lies on those. */
static sl_rgb curved_diffuse(const frame_job *job, const triangle_run *run, int32_t u, int32_t v) {
    float w1, w2;
    uint32_t triangle = sl_root_triangle_at(job->display->primitives, run->root, (double)as_parameter(u), (double)as_parameter(v), &w1, &w2);
    return sl_scene_diffuse(job->window->scene, triangle, w1, w2);
}

static sl_rgb diffuse_of(const frame_job *job, const triangle_run *run, int32_t u, int32_t v, const sl_rgb *textured) {
    return !run->texture ? run->diffuse : run->curved ? curved_diffuse(job, run, u, v) : *textured;
}

static sl_rgb shade(const frame_job *job, triangle_run *run, float w1, float w2, const sl_rgb *textured) {
    const sl_rgb guess = job->copy->guess;
    float e[6] = {guess.r, guess.g, guess.b, 0, 0, 0};
    int32_t u, v;
    bool fresh = find_leaf(job, run, w1, w2, &u, &v);
    if (run->wanted && !run->lobe) { /* the constant, so that colours are compiled for it */
        if (fresh) sl_leaf_field_of(job->copy, 1, &run->leaf, &run->field);
        sl_leaf_value(job->copy, 1, &run->leaf, &run->field, e);
    } else if (run->wanted) {
        if (fresh) sl_leaf_field_of(job->copy, 2, &run->leaf, &run->field);
        sl_leaf_value(job->copy, 2, &run->leaf, &run->field, e);
    }
    sl_rgb kd = diffuse_of(job, run, u, v, textured);
    const float over_pi = (float)(1.0 / SL_PI);
    return (sl_rgb){run->emission.r + kd.r * e[0] * over_pi + e[3], run->emission.g + kd.g * e[1] * over_pi + e[4],
                    run->emission.b + kd.b * e[2] * over_pi + e[5]};
}

static void shade_strip(void *context, size_t index, unsigned worker) {
    const frame_job *job = context;
    strip s;
    begin_strip(job, index, &s);
    float kd[3][STRIP];
    if (job->resolver) {
        sl_gbuffer part = {.width = (int)s.count, .height = 1, .diffuse_r = kd[0], .diffuse_g = kd[1], .diffuse_b = kd[2]};
        sl_resolver_run(job->resolver, worker, s.first, s.count, &part);
    }
    triangle_run run = {.root = SL_NO_INDEX};
    for (size_t i = 0; i < s.count; i++) {
        next_pixel(job, &s, i, &run);
        sl_rgb textured = {0}, radiance;
        if (job->resolver) textured = (sl_rgb){kd[0][i], kd[1][i], kd[2][i]};
        radiance = run.root == SL_NO_INDEX ? background(job, s.first + i) : shade(job, &run, s.w1[i], s.w2[i], &textured);
        job->out[0][s.first + i] = sl_picture_value(radiance.r);
        job->out[1][s.first + i] = sl_picture_value(radiance.g);
        job->out[2][s.first + i] = sl_picture_value(radiance.b);
    }
}

static void name_strip(void *context, size_t index, unsigned worker) {
    (void)worker;
    const frame_job *job = context;
    strip s;
    begin_strip(job, index, &s);
    triangle_run run = {.root = SL_NO_INDEX};
    for (size_t i = 0; i < s.count; i++) {
        next_pixel(job, &s, i, &run);
        int32_t u = 0, v = 0;
        bool covered = run.root != SL_NO_INDEX;
        if (covered) find_leaf(job, &run, s.w1[i], s.w2[i], &u, &v);
        if (job->ids->patch) job->ids->patch[s.first + i] = covered && run.wanted ? sl_leaf_patch(&run.leaf) : SL_NO_INDEX;
        if (job->ids->root) job->ids->root[s.first + i] = run.root;
        if (job->ids->u) job->ids->u[s.first + i] = as_parameter(u);
        if (job->ids->v) job->ids->v[s.first + i] = as_parameter(v);
    }
}

/* ---- frames ------------------------------------------------------------------------------------------------------------------- */

static sl_status begin_frame(sl_display *d, const sl_window *window, const sl_display_copy *copy, unsigned threads, frame_job *job, sl_counters *counters,
                             sl_error *error) {
    *job = (frame_job){.display = d, .copy = copy, .window = window, .view = sl_view_scene(window->scene, d->settings.width, d->settings.height),
                       .pixels = (size_t)d->settings.width * (size_t)d->settings.height};
    return draw_ids(d, window, &job->view, threads, counters, error);
}

static void run_strips(frame_job *job, unsigned threads, sl_task *task, sl_counters *counters) {
    sl_parallel_for(threads, (job->pixels + STRIP - 1) / STRIP, task, job);
    const sl_frame_planes *frame = &job->window->frame;
    uint64_t covered = 0;
    for (size_t i = 0; i < job->pixels; i++) {
        covered += frame->id[i] != SL_NO_INDEX || (job->display->curved && frame->curved_id[i] != SL_NO_INDEX);
    }
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, covered);
}

static sl_status draw_copy(sl_display *d, const sl_window *window, const sl_display_copy *copy, unsigned threads, float *const planes[3],
                           sl_counters *counters, sl_error *error) {
    frame_job job;
    sl_status status = begin_frame(d, window, copy, threads, &job, counters, error);
    if (status == SL_OK && d->textured) {
        status = sl_resolver_create(window->raster, 1, &job.view, NULL, window->frame.id, threads, &job.resolver, error);
    }
    if (status != SL_OK) return status;
    job.out = planes;
    run_strips(&job, threads, shade_strip, counters);
    sl_resolver_destroy(job.resolver);
    return SL_OK;
}

/* The display's own window is seen to by builds. */
sl_status sl_window_draw(sl_display *d, sl_window *window, unsigned threads, float *const planes[3], sl_counters *counters, sl_error *error) {
    const sl_display_copy *copy = sl_display_take(d);
    sl_status status = SL_OK;
    if (d->curved && window != &d->own && window->builds != copy->builds) status = sl_tessellate(d, window, error);
    if (status == SL_OK) status = draw_copy(d, window, copy, sl_thread_count(threads), planes, counters, error);
    if (status == SL_OK) window->builds = copy->builds;
    sl_display_give_back(d, copy);
    return status;
}

sl_status sl_display_draw(sl_display *d, unsigned threads, float *const planes[3], sl_counters *counters, sl_error *error) {
    return sl_window_draw(d, &d->own, threads, planes, counters, error);
}

sl_status sl_display_id_map(sl_display *d, unsigned threads, const sl_display_ids *ids, sl_counters *counters, sl_error *error) {
    frame_job job;
    threads = sl_thread_count(threads);
    const sl_display_copy *copy = sl_display_take(d);
    sl_status status = begin_frame(d, &d->own, copy, threads, &job, counters, error);
    if (status == SL_OK) {
        job.ids = ids;
        run_strips(&job, threads, name_strip, counters);
    }
    sl_display_give_back(d, copy);
    if (status != SL_OK) return status;
    size_t planes = 0;
    const void *const wanted[4] = {ids->patch, ids->root, ids->u, ids->v};
    for (int k = 0; k < 4; k++) planes += wanted[k] != NULL;
    sl_count(counters, SL_COUNT_BYTES_READ_BACK, 4 * planes * job.pixels);
    return SL_OK;
}

/* ---- one pixel again ------------------------------------------------------------------------------------------------------------ */

static sl_status texture_at(const frame_job *job, size_t pixel, sl_rgb *textured, sl_error *error) {
    sl_resolver *resolver;
    float kd[3];
    sl_gbuffer part = {.width = 1, .height = 1, .diffuse_r = &kd[0], .diffuse_g = &kd[1], .diffuse_b = &kd[2]};
    sl_status status = sl_resolver_create(job->window->raster, 1, &job->view, NULL, job->window->frame.id, 1, &resolver, error);
    if (status != SL_OK) return status;
    sl_resolver_run(resolver, 0, pixel, 1, &part);
    sl_resolver_destroy(resolver);
    *textured = (sl_rgb){kd[0], kd[1], kd[2]};
    return SL_OK;
}

sl_status sl_display_pixel(sl_display *d, size_t pixel, sl_shown_pixel *shown, sl_error *error) {
    frame_job job = {.display = d, .copy = &d->copy[d->shown], .window = &d->own,
                     .view = sl_view_scene(d->own.scene, d->settings.width, d->settings.height)};
    strip s;
    triangle_run run = {.root = SL_NO_INDEX};
    begin_pixels(&job, pixel, 1, &s);
    next_pixel(&job, &s, 0, &run);
    *shown = (sl_shown_pixel){.copy = job.copy, .root = run.root, .guess = job.copy->guess};
    if (run.root == SL_NO_INDEX) {
        shown->emission = background(&job, pixel);
        return SL_OK;
    }
    int32_t u, v;
    sl_rgb textured = {0};
    find_leaf(&job, &run, s.w1[0], s.w2[0], &u, &v);
    sl_status status = run.texture && !run.curved ? texture_at(&job, pixel, &textured, error) : SL_OK;
    shown->wanted = run.wanted != NULL;
    shown->lobe = run.lobe;
    shown->leaf = run.leaf;
    shown->emission = run.emission;
    shown->diffuse = diffuse_of(&job, &run, u, v, &textured);
    return status;
}
