/* The faces of hemicubes: every direction in one face, and the sum of solid angles. */
#include "base/math.h"
#include "raster_support.h"

static double row(const float m[4], sl_vec3d q) {
    return (double)m[0] * q.x + (double)m[1] * q.y + (double)m[2] * q.z + (double)m[3];
}

/* Where the view sees a direction; false if outside its sides. */
static bool project(const sl_view *v, sl_vec3d d, double *x, double *y) {
    double w = row(v->clip[3], d);
    if (!(w > 0.0)) return false;
    *x = row(v->clip[0], d) / w;
    *y = row(v->clip[1], d) / w;
    return fabs(*x) <= 1.0 && fabs(*y) <= 1.0;
}

static sl_frame turned_frame(uint64_t n) {
    sl_frame f = sl_frame_from_normal(random_direction(sl_random_key(72, 0), n));
    float c = 0.6f, s = 0.8f;
    return (sl_frame){sl_add(sl_scale(f.x, c), sl_scale(f.y, s)), sl_sub(sl_scale(f.y, c), sl_scale(f.x, s)),
                      f.z};
}

static void every_direction_above_the_horizon_is_in_one_face_of_a_hemicube(void **state) {
    for (uint64_t n = 0; n < 20000; n++) {
        sl_frame frame = turned_frame(n % 10);
        sl_vec3d d = sl_to_double(random_direction(sl_random_key(73, 0), n));
        double height = sl_dotd(d, sl_to_double(frame.z));
        int found = 0;
        for (int face = 0; face < 5; face++) {
            sl_view view = sl_view_hemicube_face(&frame, sl_v3(0, 0, 0), face, 32, 1e-3f);
            double x, y;
            found += project(&view, d, &x, &y);
        }
        if (fabs(height) > 1e-5) assert_true(height > 0.0 ? found >= 1 && found <= 2 : found == 0);
        if (fabs(height) > 1e-5 && found == 2) { /* only by rounding, at an edge */
            sl_vec3d local = {sl_dotd(d, sl_to_double(frame.x)), sl_dotd(d, sl_to_double(frame.y)), height};
            double a = fabs(local.x), b = fabs(local.y), c = height;
            assert_true(fabs(a - b) < 1e-5 || fabs(b - c) < 1e-5 || fabs(a - c) < 1e-5);
        }
    }
}

/* Pixel areas over (1 + x^2 + y^2)^(3/2), summed over the faces: 2 pi, and with the cosine pi. */
static void pixels_of_a_hemicube_add_up_to_the_hemisphere(void **state) {
    enum { SIZE = 128 };
    sl_frame frame = turned_frame(3);
    double angle = 0.0, projected = 0.0;
    for (int face = 0; face < 5; face++) {
        sl_view view = sl_view_hemicube_face(&frame, sl_v3(5, 6, 7), face, SIZE, 1e-3f);
        assert_int_equal(view.width, face == 1 || face == 2 ? SIZE / 2 : SIZE);
        assert_int_equal(view.height, face == 3 || face == 4 ? SIZE / 2 : SIZE);
        assert_int_equal(view.depth, SL_DEPTH_INVERSE_W);
        /* The pixel's direction solves the three rows: they are orthogonal but for the off-axis shift. */
        sl_vec3d z = sl_v3d((double)view.clip[3][0], (double)view.clip[3][1], (double)view.clip[3][2]);
        sl_vec3d rows[2];
        double shift[2], scale[2];
        for (int k = 0; k < 2; k++) {
            sl_vec3d a = sl_v3d((double)view.clip[k][0], (double)view.clip[k][1], (double)view.clip[k][2]);
            shift[k] = sl_dotd(a, z);
            rows[k] = sl_subd(a, sl_scaled(z, shift[k]));
            scale[k] = sl_lengthd(rows[k]);
        }
        for (int i = 0; i < view.width * view.height; i++) {
            double x = (2.0 * (i % view.width) + 1.0) / view.width - 1.0,
                   y = (2.0 * (i / view.width) + 1.0) / view.height - 1.0;
            double tx = (x - shift[0]) / scale[0], ty = (y - shift[1]) / scale[1];
            sl_vec3d d =
                sl_addd(z, sl_addd(sl_scaled(rows[0], tx / scale[0]), sl_scaled(rows[1], ty / scale[1])));
            double r = sl_lengthd(d), omega = (2.0 / SIZE) * (2.0 / SIZE) / (r * r * r);
            angle += omega;
            projected += omega * sl_dotd(d, sl_to_double(frame.z)) / r;
        }
    }
    assert_true(fabs(angle - 2.0 * SL_PI) < 1e-3);
    assert_true(fabs(projected - SL_PI) < 1e-3);
}

/* Unfolded: across the edge between the top and a side, coordinates along the edge agree. */
static void sides_of_a_hemicube_fold_out_from_the_top(void **state) {
    sl_frame frame = turned_frame(5);
    sl_view top = sl_view_hemicube_face(&frame, sl_v3(0, 0, 0), 0, 32, 1e-3f);
    const double outwards[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    for (int side = 0; side < 4; side++) {
        sl_view view = sl_view_hemicube_face(&frame, sl_v3(0, 0, 0), side + 1, 32, 1e-3f);
        for (int n = -9; n <= 9; n++) {
            double along = n / 10.0, u = outwards[side][0] != 0 ? outwards[side][0] : along,
                   v = outwards[side][1] != 0 ? outwards[side][1] : along;
            sl_vec3d d = sl_addd(sl_to_double(frame.z), sl_addd(sl_scaled(sl_to_double(frame.x), u),
                                                                sl_scaled(sl_to_double(frame.y), v)));
            double x, y, top_x, top_y;
            project(&top, d, &top_x, &top_y);
            project(&view, d, &x, &y);
            bool horizontal = side < 2;
            assert_true(fabs((horizontal ? y : x) - along) < 1e-6 &&
                        fabs((horizontal ? top_y : top_x) - along) < 1e-6);
            /* The side's edge next to the top: its left for +x, its right for -x, and so on. */
            assert_true(fabs((horizontal ? x : y) + outwards[side][horizontal ? 0 : 1]) < 1e-6);
            assert_true(fabs((horizontal ? top_x : top_y) - outwards[side][horizontal ? 0 : 1]) < 1e-6);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_direction_above_the_horizon_is_in_one_face_of_a_hemicube),
        cmocka_unit_test(pixels_of_a_hemicube_add_up_to_the_hemisphere),
        cmocka_unit_test(sides_of_a_hemicube_fold_out_from_the_top),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
