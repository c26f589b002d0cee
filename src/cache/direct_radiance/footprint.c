#include "cache/direct_radiance/footprint.h"

#include <math.h>

#include "base/math.h"

/* Solid angle of [0,x] x [0,y]; odd in both. The product stands over a root that never vanishes. */
static double corner_angle(double x, double y) { return sl_atan(x * y / sqrt(1.0 + x * x + y * y)); }

double sl_rectangle_solid_angle(double x0, double y0, double x1, double y1) {
    return (corner_angle(x1, y1) - corner_angle(x0, y1)) - (corner_angle(x1, y0) - corner_angle(x0, y0));
}

double sl_printed_footprint(double b, double fov, int m) {
    double side = 2.0 * b * sl_tan(fov / (2.0 * (double)m));
    return side * side;
}

double sl_printed_tilted_footprint(double footprint, double cos_alpha) {
    if (!(cos_alpha >= 0.0)) return 0.0;
    return cos_alpha > 0.0 ? footprint / cos_alpha : footprint > 0.0 ? INFINITY : 0.0;
}
