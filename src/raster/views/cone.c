/* Cones (cone.h) around a light, prepared for tests. */
#include "raster/views/cone.h"

sl_cone sl_cone_around(sl_vec3 apex, const sl_vec3 *points, size_t count) {
    sl_vec3d a = sl_to_double(apex), sum = {0, 0, 0};
    for (size_t i = 0; i < count; i++) {
        sl_vec3d d = sl_subd(sl_to_double(points[i]), a);
        double length = sl_lengthd(d);
        if (length > 0.0) sum = sl_addd(sum, sl_scaled(d, 1.0 / length));
    }
    sl_cone cone = {apex, sl_normalize_or(sl_to_float(sum), sl_v3(0, 0, 0)), 1.0f, 0.0f};
    sl_vec3d axis = sl_to_double(cone.axis);
    double least = 1.0, farthest = 0.0;
    for (size_t i = 0; i < count; i++) {
        sl_vec3d d = sl_subd(sl_to_double(points[i]), a);
        double length = sl_lengthd(d), along = sl_dotd(d, axis);
        if (length > 0.0) least = fmin(least, along / length);
        farthest = fmax(farthest, along);
    }
    cone.cosine = (float)(least - 1e-6); /* the roundings of axis and cosine to float */
    cone.length = (float)(farthest * (1.0 + 1e-6));
    return cone;
}

sl_cone_test sl_cone_test_make(const sl_cone *cone) {
    sl_vec3d axis = sl_to_double(cone->axis);
    double length = sl_lengthd(axis), cosine = (double)cone->cosine;
    sl_cone_test test = {.apex = sl_to_double(cone->apex), .length = (double)cone->length};
    test.everything = !(length > 0.0) || !isfinite(length) || !(cosine >= 0.0) || !sl_is_finite(cone->apex) ||
                      isnan(cone->length);
    if (test.everything) return test;
    test.axis = sl_scaled(axis, 1.0 / length);
    test.cosine = cosine < 1.0 ? cosine : 1.0;
    test.sine = sqrt(1.0 - test.cosine * test.cosine);
    return test;
}
