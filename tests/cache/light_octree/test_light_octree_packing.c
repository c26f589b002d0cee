/* Directions packed into a float: their error, their exact axes. */
#include "unit_test.h"
#include "base/math.h"
#include "base/random.h"
#include "cache/light_octree/voxel_lights.h"

static sl_vec3d random_unit(uint64_t key, uint64_t i) {
    double z = 2.0 * (double)sl_random_unit(key, 2 * i) - 1.0, r = sqrt(1.0 - z * z),
           phi = 2.0 * SL_PI * (double)sl_random_unit(key, 2 * i + 1);
    return sl_v3d(r * sl_cos(phi), r * sl_sin(phi), z);
}

static double angle_between(sl_vec3d a, sl_vec3d b) {
    return sl_atan2(sl_lengthd(sl_crossd(a, b)), sl_dotd(a, b));
}

static const double DEGREES = 180.0 / SL_PI;

/* Of 8 + 8 bits at most 0.7874 degrees, 0.354 on average. */
static void the_error_stays_below_its_bound(void **state) {
    uint64_t key = sl_random_key(3, 0);
    enum { COUNT = 300000 };
    double most = 0.0, sum = 0.0;
    for (uint64_t i = 0; i < COUNT; i++) {
        sl_vec3d d = random_unit(key, i);
        if (i % 4 == 0) { /* midway between the steps next to the equator, where the error is largest */
            double theta = SL_PI * ((double)(120 + i / 4 % 15) + 0.4999) / 254.0,
                   phi = 2.0 * SL_PI * ((double)(i / 60 % 256) + 0.4999) / 256.0;
            d = sl_v3d(sl_sin(theta) * sl_cos(phi), sl_sin(theta) * sl_sin(phi), sl_cos(theta));
        }
        double angle = angle_between(d, sl_to_double(sl_direction_unpack(sl_direction_pack(d)))) * DEGREES;
        most = angle > most ? angle : most;
        if (i % 4) sum += angle;
    }
    assert_true(most < 0.78740 && most > 0.786);
    assert_true(fabs(sum / (0.75 * COUNT) - 0.354) < 0.002);
}

static void axes_and_codes_are_exact(void **state) {
    const sl_vec3d axes[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    for (int k = 0; k < 6; k++) {
        sl_vec3 back = sl_direction_unpack(sl_direction_pack(sl_scaled(axes[k], 7.0)));
        assert_true((double)back.x == axes[k].x && (double)back.y == axes[k].y &&
                    (double)back.z == axes[k].z);
    }
    for (uint32_t row = 1; row < 254; row++) {
        for (uint32_t column = 0; column < 256; column++) {
            float code = (float)(256 * row + column);
            sl_vec3 d = sl_direction_unpack(code);
            assert_true(fabs((double)sl_length(d) - 1.0) < 2e-7);
            assert_true(sl_direction_pack(sl_to_double(d)) == code);
        }
    }
}

static void what_is_no_direction_becomes_one(void **state) {
    const double odd[] = {0.0, -0.0, (double)NAN, (double)INFINITY, -(double)INFINITY, 1e-320, 1e300};
    for (int k = 0; k < 343; k++) {
        float code = sl_direction_pack(sl_v3d(odd[k % 7], odd[k / 7 % 7], odd[k / 49]));
        assert_true(code >= 0.0f && code < 16777216.0f && code == floorf(code));
    }
    assert_true(sizeof(sl_directional_light) == 16);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_error_stays_below_its_bound),
        cmocka_unit_test(axes_and_codes_are_exact),
        cmocka_unit_test(what_is_no_direction_becomes_one),
    };
    return cmocka_run_group_tests_name("light octree: packed directions", tests, NULL, NULL);
}
