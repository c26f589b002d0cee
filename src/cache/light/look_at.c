/* The paper's frustum: it looks at the light and just holds it, whatever its shape. The scene is drawn first:
 * where all of it is nearer than the light, that is hidden. Then the light alone: that is where it is, and
 * which of its triangles show their front; where the scene is nearer, it is hidden. Each pixel counts with
 * its solid angle and cosine; the light's own cosine is in the solid angle already. */
#include <math.h>
#include <string.h>

#include "cache/light/light_sample_internal.h"

static void find_facing(const sl_sampled_light *light, sl_vec3 eye, uint8_t *facing) {
    for (size_t t = 0; t < light->triangles; t++) {
        sl_vec3d d[3];
        for (size_t k = 0; k < 3; k++)
            d[k] = sl_subd(sl_to_double(light->corner[3 * t + k]), sl_to_double(eye));
        facing[t] =
            light->two_sided || sl_dotd(sl_crossd(sl_subd(d[1], d[0]), sl_subd(d[2], d[0])), d[0]) < 0.0;
    }
}

/* The receiver's number among the light's triangles: SL_NO_INDEX where it is none of them. */
static uint32_t own_triangle(const sl_sampled_light *light, uint32_t triangle) {
    size_t low = 0, high = light->triangles;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (light->triangle[middle] < triangle) low = middle + 1;
        else high = middle;
    }
    return low < light->triangles && light->triangle[low] == triangle ? (uint32_t)low : SL_NO_INDEX;
}

static void set_tangents(float *tangent, int size, float first, float last) {
    for (int i = 0; i < size; i++) {
        tangent[i] =
            (float)((double)first + ((double)last - (double)first) * (((double)i + 0.5) / (double)size));
    }
}

/* Returns whether all that the scene's picture shows is nearer than the light's nearest: nothing of the
 * light is seen then, whatever its own picture is like. */
static bool hides_all(const float *depth, size_t pixels, float nearest) {
    enum { BLOCK = 512 };
    if (!(nearest > 0.0f)) return false;
    const float limit = 1.001f / nearest; /* depths are 1/w */
    for (size_t i = 0; i < pixels; i += BLOCK) {
        int farther = 0;
        size_t end = i + BLOCK < pixels ? i + BLOCK : pixels;
        for (size_t k = i; k < end; k++) farther |= !(depth[k] > limit);
        if (farther) return false;
    }
    return true;
}

/* The paper's picture lies along an edge of the light. For the ratio it is turned against it, as a window is,
 * by a slope of 0.382. */
static sl_light_sight find_view(const sl_light_query *query, int size, sl_light_view *v) {
    const sl_light_sampling *sampling = query->sampling;
    const sl_sampled_light *light = &sampling->lights->light[query->light];
    const sl_light_shape shape = {light->corner, light->triangles, light->two_sided};
    const sl_vec3 normal = query->point->geometric_normal;
    sl_light_sight sight = sl_view_light(query->lifted, normal, &shape, size, size, sampling->near, v);
    if (sight != SL_LIGHT_IN_VIEW || sampling->settings.estimator != SL_LIGHT_RATIO) return sight;
    const float cosine = 0.93417236f, sine = 0.35682209f; /* of the angle whose tangent is (3 - sqrt 5) / 2 */
    const sl_frame turned = {sl_mad(sl_scale(v->frame.x, cosine), sine, v->frame.y),
                             sl_mad(sl_scale(v->frame.y, cosine), -sine, v->frame.x), v->frame.z};
    return sl_view_light_window(query->lifted, normal, &shape, &turned, size, size, sampling->near, v);
}

sl_light_shot sl_look_at_shoot(const sl_light_query *query, int size, sl_light_sums *sums) {
    const sl_light_sampling *sampling = query->sampling;
    const sl_sampled_light *light = &sampling->lights->light[query->light];
    const sl_lit_point *point = query->point;
    const sl_vec3 eye = query->lifted;
    sl_light_sample_scratch *s = query->scratch;
    sl_light_view v;
    *sums = (sl_light_sums){.all = 0.0};
    sl_light_sight sight = find_view(query, size, &v);
    if (sight == SL_LIGHT_HIDDEN) return SL_SHOT_TAKEN;
    if (sight == SL_LIGHT_TOO_WIDE || !(v.left < v.right) || !(v.bottom < v.top)) return SL_SHOT_IMPOSSIBLE;
    const sl_target light_target = {size, size, s->light_id, s->light_depth},
                    target = {size, size, s->id, s->depth};
    v.view.skip_triangle = point->triangle;
    sl_raster_id_small(sampling->raster, &v.view, &target, s->raster, query->counters);
    if (hides_all(s->depth, (size_t)size * (size_t)size, v.nearest)) {
        memset(s->planes, 0, (size_t)size * (size_t)size * sizeof *s->planes);
        s->picture_size = size;
        return SL_SHOT_HIDDEN;
    }
    v.view.skip_triangle = own_triangle(light, point->triangle);
    sl_raster_id_small(sampling->shape[query->light].raster, &v.view, &light_target, s->light_raster,
                       query->counters);
    find_facing(light, eye, s->facing);
    set_tangents(s->column_x, size, v.left, v.right);
    set_tangents(s->row_y, size, v.bottom, v.top);
    sl_light_pixels pixels = {.size = size,
                              .column_x = s->column_x,
                              .row_y = s->row_y,
                              .step_x = (v.right - v.left) / (float)size,
                              .step_y = (v.top - v.bottom) / (float)size,
                              .normal = sl_frame_to_local(&v.frame, point->normal),
                              .geometric = sl_frame_to_local(&v.frame, point->geometric_normal),
                              .scale = 0.318309886f,
                              .seen = s->planes,
                              .all = s->planes + (size_t)size * (size_t)size};
    sampling->kernels.look_at(&pixels, s->light_id, s->facing, s->light_depth, s->depth);
    s->picture_size = size;
    *sums = sl_light_reduce(query, size);
    return SL_SHOT_TAKEN;
}
