/* Solid angle and cosine of a square picture's pixels, in closed form (the multi-mesh paper's weight texture).
 *
 * The midpoint rule, pixel area / (1 + x^2 + y^2)^2, is off by up to 1 % for a pixel of 64 x 64 at 160 degrees, and so is the sum by 2e-3 with
 * 16 x 16. The integral over a pixel is known: the form factor from a point to a rectangle that is parallel to it, from the foot of the perpendicular
 * to (x, y) at unit distance, is
 *     G(x, y) = [x / sqrt(1 + x^2) atan(y / sqrt(1 + x^2)) + y / sqrt(1 + y^2) atan(x / sqrt(1 + y^2))] / (2 pi). */
#include "cache/multi_mesh/gather_weights.h"

#include "base/math.h"
#include "cache/multi_mesh/gather.h"

static double parallel_form_factor(double x, double y) {
    double a = sqrt(1.0 + x * x), b = sqrt(1.0 + y * y);
    return (x / a * sl_atan(y / a) + y / b * sl_atan(x / b)) / (2.0 * SL_PI);
}

/* Of the rectangle [x0, x1] x [y0, y1]. */
static double parallel_rectangle(double x0, double x1, double y0, double y1) {
    return parallel_form_factor(x1, y1) - parallel_form_factor(x0, y1) - parallel_form_factor(x1, y0) + parallel_form_factor(x0, y0);
}

void sl_mesh_gather_top_weights(int size, double t, float *weight) {
    int half = size / 2;
    for (int j = 0; j < half; j++) {
        for (int i = 0; i <= j; i++) { /* an octant, from the middle of the picture outwards */
            double step = t / half;
            float w = (float)(SL_PI * parallel_rectangle(i * step, (i + 1) * step, j * step, (j + 1) * step));
            for (int turn = 0; turn < 8; turn++) {
                int a = turn & 1 ? i : j, b = turn & 1 ? j : i;
                int x = turn & 2 ? half + a : half - 1 - a, y = turn & 4 ? half + b : half - 1 - b;
                weight[y * size + x] = w;
            }
        }
    }
}

/* The integral of cos theta dw = v du dv / (1 + u^2 + v^2)^2 over [0, u] x [v, infinity). */
static double upright_above(double u, double v) {
    double a = sqrt(1.0 + v * v);
    return 0.5 * sl_atan(u / a) / a;
}

void sl_mesh_gather_side_weights(int width, int height, double v, float *weight) {
    int half = width / 2;
    for (int y = 0; y < height; y++) {
        double low = v * y / height, high = v * (y + 1) / height;
        for (int i = 0; i < half; i++) {
            double left = (double)i / half, right = (double)(i + 1) / half;
            double inside = (upright_above(right, low) - upright_above(left, low)) - (upright_above(right, high) - upright_above(left, high));
            weight[y * width + half + i] = weight[y * width + half - 1 - i] = (float)inside;
        }
    }
}

double sl_gather_coverage(double phi) {
    double s = sl_sin(phi);
    return 4.0 / SL_PI * s * sl_atan(s);
}
