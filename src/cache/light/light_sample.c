/* A sample of one light at one point: which way it is taken (light_sample.h), and what all samples share.
 *
 *     no extent ------------------------ one shadow ray
 *     turned away, below the horizon --- 0
 *     tiny ----------------------------- closed form x one shadow ray
 *     nothing in the frustum ----------- closed form
 *     else ----------------------------- N x N pixels of the frustum that looks at it
 *     too near for that ---------------- closed form x share of rays
 */
#include "cache/light/light_sample.h"

#include <math.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/light/light_sample_internal.h"
#include "raster/raster.h"

sl_light_sample_settings sl_light_sample_defaults(void) {
    return (sl_light_sample_settings){
        .estimator = SL_LIGHT_RATIO, .size = 64, .largest = 256, .rays = 16};
}

/* ---- what all samples share ---- */

/* Of one-sided triangles: all corners behind the plane of each, but for roundings. */
static bool is_convex(const sl_sampled_light *light, double size) {
    enum { TRIANGLES_MAX = 4096 };
    if (light->two_sided || light->triangles > TRIANGLES_MAX) return false;
    for (size_t t = 0; t < light->triangles; t++) {
        sl_vec3d a = sl_light_corner(light, 3 * t), cross = sl_light_cross(light, t);
        double room = 1e-4 * size * sl_lengthd(cross);
        for (size_t k = 0; k < 3 * light->triangles; k++) {
            if (sl_dotd(cross, sl_subd(sl_light_corner(light, k), a)) > room) return false;
        }
    }
    return true;
}

/* As fmax(a, b), where a is no NaN: gcc 12 for Arm fails at fmax() itself in loops over floats. */
static double larger(double a, double b) { return b > a ? b : a; }

static void measure(const sl_sampled_light *light, sl_light_shape_info *shape) {
    double coordinates = 0.0, off = 0.0;
    sl_vec3d origin = sl_light_corner(light, 0), normal = sl_to_double(light->normal),
             middle = sl_to_double(light->position);
    for (size_t k = 0; k < 3 * light->triangles; k++) {
        sl_vec3 c = light->corner[k];
        coordinates = larger(coordinates, (double)fmaxf(fabsf(c.x), fmaxf(fabsf(c.y), fabsf(c.z))));
        off = larger(off, fabs(sl_dotd(sl_subd(sl_to_double(c), origin), normal)));
        shape->size = larger(shape->size, 2.0 * sl_lengthd(sl_subd(sl_to_double(c), middle)));
    }
    shape->flatness = off + 6e-7 * coordinates;
    shape->closed_form = light->kind == SL_SOURCE_AREA || is_convex(light, shape->size);
}

/* The light's triangles as a mesh of their own. */
static sl_status make_raster(const sl_sampled_light *light, sl_light_shape_info *shape, unsigned threads,
                             sl_error *error) {
    size_t corners = 3 * light->triangles;
    shape->mesh_x = sl_allocate(3 * corners, sizeof *shape->mesh_x);
    shape->mesh_corner = sl_allocate(corners, sizeof *shape->mesh_corner);
    if (!shape->mesh_x || !shape->mesh_corner) return sl_fail_memory(error, "a lamp");
    float *x = shape->mesh_x, *y = x + corners, *z = y + corners;
    uint32_t *vertex[3] = {shape->mesh_corner, shape->mesh_corner + light->triangles,
                           shape->mesh_corner + 2 * light->triangles};
    for (size_t k = 0; k < corners; k++) {
        x[k] = light->corner[k].x;
        y[k] = light->corner[k].y;
        z[k] = light->corner[k].z;
        vertex[k % 3][k / 3] = (uint32_t)k;
    }
    const sl_raster_mesh mesh = {.vertex_count = corners,
                                 .triangle_count = light->triangles,
                                 .x = x,
                                 .y = y,
                                 .z = z,
                                 .vertex = {vertex[0], vertex[1], vertex[2]}};
    return sl_raster_create_mesh(&mesh, threads, &shape->raster, error);
}

static sl_status make_shape(sl_light_sampling *s, size_t index, sl_error *error) {
    const sl_sampled_light *light = &s->lights->light[index];
    const sl_light_sample_settings *settings = &s->settings;
    sl_light_shape_info *shape = &s->shape[index];
    if (!sl_light_has_extent(light)) return SL_OK;
    sl_status status = sl_light_surface_make(light, &shape->surface, error);
    if (status != SL_OK) return status;
    measure(light, shape);
    if (settings->estimator == SL_LIGHT_RAYS) return SL_OK;
    status = make_raster(light, shape, settings->threads, error);
    bool wider = status == SL_OK &&
                 (!s->widest || sl_raster_cluster_count(shape->raster) > sl_raster_cluster_count(s->widest));
    if (wider) s->widest = shape->raster;
    if (light->triangles > s->most_triangles) s->most_triangles = light->triangles;
    return status;
}

sl_status sl_light_sampling_create(const sl_scene *scene, const sl_raster *raster, const sl_tracer *tracer,
                                   const sl_sampled_lights *lights, const sl_light_sample_settings *settings,
                                   sl_light_sampling **sampling, sl_error *error) {
    *sampling = NULL;
    sl_status status = SL_OK;
    sl_light_sampling *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "sampling of lights");
    *s = (sl_light_sampling){.scene = scene,
                             .raster = raster,
                             .tracer = tracer,
                             .lights = lights,
                             .settings = *settings,
                             .isa = sl_isa_best(),
                             .near = 1e-5f * scene->scale,
                             .lift = SL_LIGHT_LIFT * sl_scene_coordinate_near(scene, scene->central_min)};
    s->step = fmaxf(2e-6f * scene->scale, s->lift);
    s->shape = sl_allocate(lights->count, sizeof *s->shape);
    if (!s->shape) status = sl_fail_memory(error, "sampling of lights");
    for (size_t i = 0; i < lights->count && status == SL_OK; i++) status = make_shape(s, i, error);
    if (status != SL_OK) sl_light_sampling_destroy(s);
    else *sampling = s;
    return status;
}

void sl_light_sampling_destroy(sl_light_sampling *s) {
    if (!s) return;
    for (size_t i = 0; s->shape && i < s->lights->count; i++) {
        sl_light_shape_info *shape = &s->shape[i];
        sl_raster_destroy(shape->raster);
        sl_free(shape->mesh_x);
        sl_free(shape->mesh_corner);
        sl_light_surface_release(&shape->surface);
    }
    sl_free(s->shape);
    sl_free(s);
}

void sl_light_sampling_trace_by(sl_light_sampling *s, const sl_tracer *tracer) { s->tracer = tracer; }

double sl_light_sampling_step(const sl_light_sampling *s) { return (double)s->step; }

size_t sl_light_sampling_memory_bytes(const sl_light_sampling *s) {
    size_t bytes = sizeof *s + s->lights->count * sizeof *s->shape;
    for (size_t i = 0; i < s->lights->count; i++) {
        const sl_light_shape_info *shape = &s->shape[i];
        size_t triangles = s->lights->light[i].triangles;
        bytes += triangles * sizeof *shape->surface.area_before;
        if (!shape->raster) continue;
        bytes += sl_raster_memory_bytes(shape->raster) + 9 * triangles * sizeof *shape->mesh_x +
                 3 * triangles * sizeof *shape->mesh_corner;
    }
    return bytes;
}

/* ---- a worker's pictures ---- */

static bool allocate_planes(const sl_light_sampling *sampling, sl_light_sample_scratch *s) {
    size_t side = (size_t)sampling->settings.largest, pixels = side * side;
    bool look_at = sampling->widest != NULL;
    s->id = sl_allocate(pixels, sizeof *s->id);
    s->planes = sl_allocate(2 * pixels, sizeof *s->planes);
    s->halves = sl_allocate(pixels / 2 + 1, sizeof *s->halves);
    s->column_x = sl_allocate(4 * side, sizeof *s->column_x);
    bool ok = s->id && s->planes && s->halves && s->column_x;
    if (!ok) return false;
    s->column_y = s->column_x + side;
    s->row_x = s->column_y + side;
    s->row_y = s->row_x + side;
    if (!look_at) return true;
    s->depth = sl_allocate(pixels, sizeof *s->depth);
    s->light_id = sl_allocate(pixels, sizeof *s->light_id);
    s->light_depth = sl_allocate(pixels, sizeof *s->light_depth);
    s->facing = sl_allocate(sampling->most_triangles, sizeof *s->facing);
    return s->depth && s->light_id && s->light_depth && s->facing;
}

sl_status sl_light_sample_scratch_create(const sl_light_sampling *sampling, sl_light_sample_scratch **scratch,
                                         sl_error *error) {
    *scratch = NULL;
    int side = sampling->settings.largest;
    sl_light_sample_scratch *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "pictures of lights");
    sl_status status = allocate_planes(sampling, s) ? SL_OK : sl_fail_memory(error, "pictures of lights");
    if (status == SL_OK) status = sl_raster_scratch_create(sampling->raster, side, side, &s->raster, error);
    if (status == SL_OK && sampling->widest)
        status = sl_raster_scratch_create(sampling->widest, side, side, &s->light_raster, error);
    if (status != SL_OK) sl_light_sample_scratch_destroy(s);
    else *scratch = s;
    return status;
}

void sl_light_sample_scratch_destroy(sl_light_sample_scratch *s) {
    if (!s) return;
    sl_raster_scratch_destroy(s->raster);
    sl_raster_scratch_destroy(s->light_raster);
    SL_FREE_ALL(s->id, s->planes, s->halves, s->column_x, s->depth, s->light_id, s->light_depth, s->facing,
                s);
}

sl_light_picture sl_light_last_picture(const sl_light_sample_scratch *s) {
    return (sl_light_picture){s->picture_size, s->picture_size > 0 ? s->planes : NULL};
}

/* ---- a sample ---- */

typedef struct {
    sl_light_query query;
    const sl_light_sample_settings *settings;
    const sl_sampled_light *light;
    const sl_light_shape_info *shape;
    double unoccluded, distance;
    bool one_ray;
} sample;

static double value_of(const sample *s, sl_light_sums sums, bool ratio) {
    if (!ratio || !s->shape->closed_form) return sums.seen;
    return s->unoccluded * fmin(sums.seen / sums.all, 1.0);
}

/* Where no weight is known, though light arrives: the middle of what is above the horizon stands for all of
 * it. */
static double by_one_ray(const sample *s) { return sl_light_middle_hidden(&s->query) ? 0.0 : s->unoccluded; }

static double by_rays(const sample *s) {
    sl_light_sums sums = sl_light_rays(&s->query);
    return sums.all > 0.0 ? value_of(s, sums, true) : by_one_ray(s);
}

/* Of a light that no pixel's centre is on, or of which none can tell, there are twice as many pixels. */
static double by_pictures(const sample *s) {
    for (int size = s->settings->size; size <= s->settings->largest; size *= 2) {
        sl_light_sums sums = {.all = 0.0};
        sl_light_shot shot = sl_look_at_shoot(&s->query, size, &sums);
        if (shot == SL_SHOT_IMPOSSIBLE) return by_rays(s);
        if (shot == SL_SHOT_HIDDEN) return 0.0;
        if (shot == SL_SHOT_NOTHING_BETWEEN) {
            sl_count(s->query.counters, SL_COUNT_LIGHT_SAMPLES_SKIPPED, 1);
            return s->unoccluded;
        }
        if (sums.all > 0.0) return value_of(s, sums, s->settings->estimator == SL_LIGHT_RATIO);
    }
    return by_one_ray(s);
}

/* Edge-on, or all but below the horizon: next to nothing of what the light could give at its distance. */
static bool is_nothing(const sample *s, double distance) {
    return !(s->unoccluded > 1e-12 * fmin(1.0, s->shape->surface.area / (SL_PI * distance * distance)));
}

/* Finds from where the light is asked for. False: no light arrives. */
static bool look(sample *s) {
    sl_light_query *q = &s->query;
    s->distance = sl_lengthd(sl_subd(sl_to_double(s->light->position), sl_to_double(q->point->position)));
    s->unoccluded = sl_light_unoccluded(s->light, q->point);
    if (is_nothing(s, s->distance)) {
        sl_count(q->counters, SL_COUNT_LIGHT_SAMPLES_SKIPPED, 1);
        return false;
    }
    q->middle = sl_light_middle(s->light, q->point);
    q->lifted = sl_light_lifted(q->sampling, q->point);
    q->eye = sl_light_eye(q->sampling, q->lifted, q->middle);
    return true;
}

static double area_light(sample *s) {
    sl_light_query *q = &s->query;
    if (!look(s)) return 0.0;
    if (s->one_ray || s->shape->size < SL_TINY_LIGHT * s->distance) return by_one_ray(s);
    return s->settings->estimator == SL_LIGHT_RAYS || !q->scratch ? by_rays(s) : by_pictures(s);
}

static float value_or_nothing(double value) {
    float f = (float)value;
    return f > 0.0f && isfinite(f) ? f : 0.0f;
}

static sample sample_of(const sl_light_sampling *sampling, size_t light, const sl_lit_point *point, int rays,
                        sl_light_sample_scratch *scratch, sl_counters *counters) {
    return (sample){.query = {.sampling = sampling,
                              .light = light,
                              .point = point,
                              .rays = rays,
                              .scratch = scratch,
                              .counters = counters},
                    .settings = &sampling->settings,
                    .light = &sampling->lights->light[light],
                    .shape = &sampling->shape[light]};
}

static float take(sample *s) {
    const sl_light_query *q = &s->query;
    sl_count(q->counters, SL_COUNT_LIGHT_SAMPLES, 1);
    if (!sl_is_finite(q->point->position) || !sl_is_finite(q->point->normal) ||
        !sl_is_finite(q->point->geometric_normal)) {
        sl_count(q->counters, SL_COUNT_LIGHT_SAMPLES_SKIPPED, 1);
        return 0.0f;
    }
    return value_or_nothing(sl_light_has_extent(s->light)
                                ? area_light(s)
                                : sl_light_without_extent(q->sampling, s->light, q->point, q->counters));
}

float sl_light_sample_take(const sl_light_sampling *sampling, size_t light, const sl_lit_point *point,
                           sl_light_sample_scratch *scratch, sl_counters *counters) {
    sample s = sample_of(sampling, light, point, sampling->settings.rays, scratch, counters);
    return take(&s);
}

float sl_light_sample_by_rays(const sl_light_sampling *sampling, size_t light, const sl_lit_point *point,
                              int rays, sl_counters *counters) {
    sample s = sample_of(sampling, light, point, rays, NULL, counters);
    return take(&s);
}

float sl_light_probe(const sl_light_sampling *sampling, size_t light, const sl_lit_point *point, int rays,
                     sl_counters *counters) {
    sl_counters own = {{0}};
    sample s = sample_of(sampling, light, point, rays, NULL, &own);
    s.one_ray = rays == 1;
    float value = take(&s);
    sl_count(counters, SL_COUNT_SHADOW_RAYS, own.value[SL_COUNT_SHADOW_RAYS]);
    return value;
}

double sl_light_by_points(const sl_light_sampling *sampling, size_t light, const sl_lit_point *point,
                          const sl_light_numbers *numbers, const sl_lit_lobe *lobe, sl_light_sums *sums,
                          sl_counters *counters) {
    sample s = sample_of(sampling, light, point, 0, NULL, counters);
    s.query.numbers = numbers;
    s.query.lobe = lobe;
    sl_count(counters, SL_COUNT_LIGHT_SAMPLES, 1);
    if (!look(&s)) return 0.0;
    sl_light_sums more = sl_light_rays(&s.query);
    sums->seen += more.seen;
    sums->all += more.all;
    sums->seen_squares += more.seen_squares;
    sums->all_squares += more.all_squares;
    sums->lobe += more.lobe;
    return s.unoccluded;
}
