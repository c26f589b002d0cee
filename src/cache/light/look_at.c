/* The paper's frustum: it looks at the light and just holds it, whatever its shape. The scene is drawn first:
 * where all of it is nearer than the light, that is hidden. Then the light alone: that is where it is, and
 * which of its triangles show their front; where the scene is nearer, it is hidden. Each pixel counts with
 * its solid angle and cosine; the light's own cosine is in the solid angle already. */
#include <math.h>
#include <string.h>

#include "base/math.h"
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

/* The picture's position in its frustum's rectangle, each half of whose sides counts as 1: turned, and so
 * much larger that it holds it. The paper's lies along an edge of the light. Edges of a scene run along its
 * lamps more often than not, and an edge along the pixels hides whole columns at a time, which shows as
 * bands. So for the ratio it is turned, by a slope of 0.382: of all numbers one of those that fractions come
 * near the least, so that an edge cuts pixels evenly. */
typedef struct {
    double cosine, sine, size;
} turn;

static turn turn_of(const sl_light_sampling *sampling) {
    const double cosine = 0.9341723589627157, sine = 0.3568220897730899; /* tangent: (3 - sqrt 5) / 2 */
    if (sampling->settings.estimator != SL_LIGHT_RATIO) return (turn){1.0, 0.0, 1.0};
    return (turn){cosine, sine, cosine + sine};
}

static void turn_view(const turn *t, sl_view *view) {
    const float cosine = (float)(t->cosine / t->size), sine = (float)(t->sine / t->size);
    for (int k = 0; k < 4; k++) {
        const float x = view->clip[0][k], y = view->clip[1][k];
        view->clip[0][k] = cosine * x + sine * y;
        view->clip[1][k] = cosine * y - sine * x;
    }
}

static void set_tangents(const sl_light_view *v, const turn *t, int size, sl_light_sample_scratch *s) {
    const double half_x = 0.5 * t->size * ((double)v->right - (double)v->left),
                 half_y = 0.5 * t->size * ((double)v->top - (double)v->bottom);
    for (int i = 0; i < size; i++) {
        const double at = ((double)(2 * i + 1) - (double)size) / (double)size; /* in the picture, in [-1,1] */
        s->column_x[i] = (float)(0.5 * ((double)v->left + (double)v->right) + half_x * t->cosine * at);
        s->column_y[i] = (float)(half_y * t->sine * at);
        s->row_x[i] = (float)(-half_x * t->sine * at);
        s->row_y[i] = (float)(0.5 * ((double)v->bottom + (double)v->top) + half_y * t->cosine * at);
    }
}

/* Where pixels are not small the midpoint rule's error would show. */
static bool is_coarse(const sl_light_view *v, int size) {
    return fmaxf(v->right - v->left, v->top - v->bottom) > 0.1f * (float)size;
}

/* Depth being 1/w, the view's third row holds a plane that cuts and nothing else: here the light's own,
 * behind which nothing hides it. False: the eye is too near to it. */
static bool end_at_plane(const sl_light_query *query, sl_vec3 eye, sl_view *view) {
    const sl_sampled_light *light = &query->sampling->lights->light[query->light];
    sl_vec3d out = sl_to_double(light->normal);
    double height = sl_dotd(sl_subd(sl_to_double(eye), sl_to_double(light->corner[0])), out),
           sign = height < 0.0 ? -1.0 : 1.0; /* of a two-sided light: its back */
    height *= sign;
    double far =
        height - fmax(SL_LIGHT_MARGIN * height, 2.0 * query->sampling->shape[query->light].flatness);
    out = sl_scaled(out, sign);
    const float row[4] = {(float)out.x, (float)out.y, (float)out.z, (float)far};
    memcpy(view->clip[2], row, sizeof row);
    return far > 0.0;
}

sl_light_shot sl_look_at_shoot(const sl_light_query *query, int size, sl_light_sums *sums) {
    const sl_light_sampling *sampling = query->sampling;
    const sl_sampled_light *light = &sampling->lights->light[query->light];
    const sl_lit_point *point = query->point;
    const bool planar =
        light->kind == SL_SOURCE_AREA && sampling->settings.estimator == SL_LIGHT_RATIO;
    /* where no near plane cuts walls that stand on the point, the eye steps past them */
    const sl_vec3 eye = planar ? query->eye : query->lifted;
    sl_light_sample_scratch *s = query->scratch;
    sl_light_view v;
    *sums = (sl_light_sums){.all = 0.0};
    const sl_light_shape shape = {light->corner, light->triangles, light->two_sided};
    const turn t = turn_of(sampling);
    sl_light_sight sight =
        sl_view_light(eye, point->geometric_normal, &shape, size, size, sampling->near, &v);
    if (sight == SL_LIGHT_HIDDEN) return SL_SHOT_TAKEN;
    if (sight == SL_LIGHT_TOO_WIDE || !(v.left < v.right) || !(v.bottom < v.top) || is_coarse(&v, size))
        return SL_SHOT_IMPOSSIBLE;
    const sl_target light_target = {size, size, s->light_id, s->light_depth},
                    target = {size, size, s->id, s->depth};
    turn_view(&t, &v.view);
    v.view.skip_triangle = point->triangle;
    float behind[4];
    memcpy(behind, v.view.clip[2], sizeof behind);
    if (planar) {
        if (!end_at_plane(query, eye, &v.view)) return SL_SHOT_IMPOSSIBLE;
        if (!sl_raster_meets(sampling->raster, &v.view)) return SL_SHOT_NOTHING_BETWEEN;
    }
    sl_raster_id_small(sampling->raster, &v.view, &target, s->raster, query->counters);
    memcpy(v.view.clip[2], behind, sizeof behind);
    if (hides_all(s->depth, (size_t)size * (size_t)size, v.nearest)) {
        memset(s->planes, 0, (size_t)size * (size_t)size * sizeof *s->planes);
        s->picture_size = size;
        return SL_SHOT_HIDDEN;
    }
    v.view.skip_triangle = own_triangle(light, point->triangle);
    sl_raster_id_small(sampling->shape[query->light].raster, &v.view, &light_target, s->light_raster,
                       query->counters);
    find_facing(light, eye, s->facing);
    set_tangents(&v, &t, size, s);
    sl_light_pixels pixels = {.size = size,
                              .column_x = s->column_x,
                              .column_y = s->column_y,
                              .row_x = s->row_x,
                              .row_y = s->row_y,
                              .normal = sl_frame_to_local(&v.frame, point->normal),
                              .geometric = sl_frame_to_local(&v.frame, point->geometric_normal),
                              .scale = (float)(t.size * t.size / SL_PI) * ((v.right - v.left) / (float)size) *
                                       ((v.top - v.bottom) / (float)size),
                              .seen = s->planes,
                              .all = s->planes + (size_t)size * (size_t)size};
    SL_KERNEL_OF(sampling->isa, sl_look_at_weigh)(&pixels, s->light_id, s->facing, s->light_depth, s->depth);
    s->picture_size = size;
    double sum[2];
    sl_raster_sum(s->planes, size, 2, s->halves, sum, query->counters);
    *sums = (sl_light_sums){.seen = sum[0], .all = sum[1]};
    return SL_SHOT_TAKEN;
}
