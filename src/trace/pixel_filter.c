#include "trace/pixel_filter.h"

#include "base/math.h"

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
