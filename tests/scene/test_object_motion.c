/* What lies on an object goes along with it, from one state of a scene to another. */
#include <math.h>

#include "unit_test.h"
#include "scene/object_motion.h"

static const sl_affine turned = {{{0, -1, 0, 3}, {1, 0, 0, 1}, {0, 0, 1, 2}}};
static const sl_affine grown = {{{2, 0, 0, -1}, {0, 0.5, 0, 0}, {0, 0, 1, 4}}};
static const sl_affine flat = {{{1, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 1, 0}}};

static void assert_near(sl_vec3d a, sl_vec3d b) { assert_true(sl_lengthd(sl_subd(a, b)) < 1e-12); }

static void a_point_goes_where_its_place_at_rest_goes(void **state) {
    const sl_vec3d rest = sl_v3d(0.3, -2.0, 7.0);
    const sl_object_motion m = sl_object_motion_between(&turned, &grown);
    assert_true(m.moves);
    assert_near(sl_affine_point(&m.places, sl_affine_point(&turned, rest)), sl_affine_point(&grown, rest));
}

static void a_normal_stays_square_to_the_surface(void **state) {
    const sl_object_motion m = sl_object_motion_between(&turned, &grown);
    const sl_vec3d along = sl_affine_vector(&m.places, sl_v3d(1.0, 2.0, 0.0));
    const sl_vec3 normal = sl_affine_unit(&m.turns, sl_v3(2.0f, -1.0f, 0.0f));
    assert_true(fabs(sl_dotd(along, sl_to_double(normal))) < 1e-6);
    assert_true(fabsf(sl_dot(normal, normal) - 1.0f) < 1e-6f);
}

static void what_stays_or_was_flat_moves_nothing(void **state) {
    assert_false(sl_object_motion_between(&turned, &turned).moves);
    assert_false(sl_object_motion_between(&flat, &turned).moves);
    assert_true(sl_object_motion_between(&turned, &flat).moves);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_point_goes_where_its_place_at_rest_goes),
        cmocka_unit_test(a_normal_stays_square_to_the_surface),
        cmocka_unit_test(what_stays_or_was_flat_moves_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
