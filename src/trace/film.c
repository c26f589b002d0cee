#include "trace/film.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"

/* ---- the lens ---- */

sl_path_lens sl_path_lens_of(const sl_scene *scene, int width, int height) {
    double tangent = sl_tan(0.5 * (double)scene->camera.vertical_fov),
           aspect = (double)width / (double)height;
    return (sl_path_lens){width, height, (float)(tangent * aspect), (float)tangent};
}

sl_path_tangents sl_path_lens_tangents(const sl_path_lens *lens, sl_path_place place) {
    return (sl_path_tangents){(2.0f * place.x / (float)lens->width - 1.0f) * lens->tan_x,
                              (1.0f - 2.0f * place.y / (float)lens->height) * lens->tan_y};
}

sl_vec3 sl_path_lens_direction(const sl_scene *scene, sl_path_tangents t) {
    const sl_camera *c = &scene->camera;
    return sl_normalize_or(sl_sub(sl_mad(sl_scale(c->right, t.x), t.y, c->up), c->back), sl_neg(c->back));
}

/* ---- pixel filters ---- */

/* Returns the integral of the four-term window of Harris 1978 from its left end to t in [0, 1], of all. */
static double integral_to(double t) {
    static const double a0 = 0.35875, a1 = 0.48829, a2 = 0.14128, a3 = 0.01168;
    const double turn = 2.0 * SL_PI;
    return t -
           (a1 * sl_sin(turn * t) - a2 / 2.0 * sl_sin(2.0 * turn * t) + a3 / 3.0 * sl_sin(3.0 * turn * t)) /
               (turn * a0);
}

/* Returns where the integral comes to `share`, by bisection. */
static double place_of(double share) {
    double low = 0.0, high = 1.0;
    for (int i = 0; i < 50; i++) {
        const double middle = 0.5 * (low + high);
        if (integral_to(middle) < share) low = middle;
        else high = middle;
    }
    return 0.5 * (low + high);
}

sl_pixel_shape sl_pixel_shape_of(sl_pixel_filter filter, double radius) {
    sl_pixel_shape shape = {.filter = filter, .radius = filter == SL_FILTER_CENTRE ? 0.0f : 0.5f};
    if (filter != SL_FILTER_BLACKMAN_HARRIS) return shape;
    shape.radius = (float)radius;
    for (int i = 0; i <= SL_FILTER_STEPS; i++)
        shape.offset[i] = (float)((2.0 * place_of((double)i / SL_FILTER_STEPS) - 1.0) * radius);
    return shape;
}

static float inverted(const sl_pixel_shape *shape, float u) {
    const float at = u * (float)SL_FILTER_STEPS;
    const int i = at < (float)(SL_FILTER_STEPS - 1) ? (int)at : SL_FILTER_STEPS - 1;
    const float part = at - (float)i;
    return 0.5f + (1.0f - part) * shape->offset[i] + part * shape->offset[i + 1];
}

void sl_pixel_shape_place(const sl_pixel_shape *shape, float point[2]) {
    if (shape->filter == SL_FILTER_CENTRE) point[0] = point[1] = 0.5f;
    if (shape->filter != SL_FILTER_BLACKMAN_HARRIS) return;
    point[0] = inverted(shape, point[0]);
    point[1] = inverted(shape, point[1]);
}

/* ---- sums ---- */

sl_status sl_halves_create(sl_halves *h, size_t pixels, sl_error *error) {
    *h = (sl_halves){.pixels = pixels};
    for (int half = 0; half < SL_HALVES; half++) {
        h->sums[half] = sl_allocate(3 * pixels, sizeof(double));
        if (!h->sums[half]) return sl_fail_memory(error, "a reference tracer's film");
    }
    return SL_OK;
}

void sl_halves_release(sl_halves *h) {
    for (int half = 0; half < SL_HALVES; half++) sl_free(h->sums[half]);
    *h = (sl_halves){0};
}

size_t sl_halves_memory_bytes(const sl_halves *h) { return SL_HALVES * 3 * h->pixels * sizeof(double); }

void sl_halves_mean(const sl_halves *h, int half, float *r, float *g, float *b) {
    float *planes[3] = {r, g, b};
    uint64_t samples = half < 0 ? h->samples[0] + h->samples[1] : h->samples[half & 1];
    double scale = samples > 0 ? 1.0 / (double)samples : 0.0;
    for (size_t channel = 0; channel < 3; channel++) {
        if (!planes[channel]) continue;
        const double *even = h->sums[0] + channel * h->pixels, *odd = h->sums[1] + channel * h->pixels;
        for (size_t i = 0; i < h->pixels; i++) {
            double sum = half < 0 ? even[i] + odd[i] : half == 0 ? even[i] : odd[i];
            planes[channel][i] = (float)(sum * scale);
        }
    }
}
