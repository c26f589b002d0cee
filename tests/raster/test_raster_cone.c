/* Cone against box: no box is passed over whose triangle a ray inside the cone hits, and a narrow cone meets
 * few. */
#include "raster/views/cone.h"
#include "raster_support.h"

#include "base/math.h"

/* Moeller and Trumbore 1997, in double; distance along d, or -1. */
static double hit_distance(const sl_scene *s, uint32_t t, sl_vec3d origin, sl_vec3d d) {
    sl_vec3d p[3];
    for (int k = 0; k < 3; k++) p[k] = sl_to_double(sl_scene_position(s, s->vertex[k][t]));
    sl_vec3d e1 = sl_subd(p[1], p[0]), e2 = sl_subd(p[2], p[0]), h = sl_crossd(d, e2),
             from = sl_subd(origin, p[0]);
    double det = sl_dotd(e1, h);
    if (det == 0.0) return -1.0;
    double u = sl_dotd(from, h) / det;
    sl_vec3d q = sl_crossd(from, e1);
    double v = sl_dotd(d, q) / det, at = sl_dotd(e2, q) / det;
    return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && at > 0.0 ? at : -1.0;
}

/* A direction off the axis by at most the half angle, often exactly at its rim. */
static sl_vec3d direction_inside(const sl_cone *cone, uint64_t key, uint64_t n) {
    sl_frame frame = sl_frame_from_normal(sl_normalize_or(cone->axis, sl_v3(0, 0, 1)));
    double least = (double)cone->cosine + 1e-6, unit = n % 3 ? (double)sl_random_unit(key, 2 * n) : 1.0;
    double cosine = 1.0 - (1.0 - least) * unit, phi = 2.0 * SL_PI * (double)sl_random_unit(key, 2 * n + 1);
    double sine = sqrt(fmax(0.0, 1.0 - cosine * cosine));
    sl_vec3d x = sl_to_double(frame.x), y = sl_to_double(frame.y), z = sl_to_double(frame.z);
    return sl_addd(sl_scaled(z, cosine),
                   sl_addd(sl_scaled(x, sine * sl_cos(phi)), sl_scaled(y, sine * sl_sin(phi))));
}

static sl_cone random_cone(const sl_scene *s, uint64_t key, uint64_t n) {
    float length = n % 4 == 0 ? INFINITY : random_between(key, 8 * n, 0.01f, 1.0f) * s->diagonal;
    float spread = sl_exp2f(random_between(key, 8 * n + 1, -12.0f, 0.0f)); /* 1 - cos */
    sl_vec3 apex = sl_v3(random_between(key, 8 * n + 2, s->box_min.x - 1, s->box_max.x + 1),
                         random_between(key, 8 * n + 3, s->box_min.y - 1, s->box_max.y + 1),
                         random_between(key, 8 * n + 4, s->box_min.z - 1, s->box_max.z + 1));
    if (n % 5 == 0) apex = sl_scene_position(s, sl_random_bits(key, 8 * n + 5) % (uint32_t)s->vertex_count);
    sl_vec3 axis = n % 7 == 0 ? sl_v3(0, n % 2 ? 1 : -1, 0)
                              : sl_scale(random_direction(key, 8 * n + 6), 1 + (float)(n % 3));
    return (sl_cone){apex, axis, 1.0f - spread, length};
}

static bool meets_box_of(const sl_cone *cone, const sl_scene *s, uint32_t t) {
    sl_cone_test test = sl_cone_test_make(cone);
    sl_vec3d low = sl_to_double(sl_scene_position(s, s->vertex[0][t])), high = low;
    for (int k = 1; k < 3; k++) {
        sl_vec3d p = sl_to_double(sl_scene_position(s, s->vertex[k][t]));
        low = sl_v3d(fmin(low.x, p.x), fmin(low.y, p.y), fmin(low.z, p.z));
        high = sl_v3d(fmax(high.x, p.x), fmax(high.y, p.y), fmax(high.z, p.z));
    }
    return sl_cone_meets_box(&test, sl_scaled(sl_addd(low, high), 0.5), sl_scaled(sl_subd(high, low), 0.5));
}

static void no_triangle_that_a_ray_in_the_cone_hits_is_missing(void **state) {
    (void)state;
    sl_scene *scene = furnished_room(20, 4);
    size_t hits = 0, met = 0;
    for (uint64_t n = 0; n < 100; n++) {
        sl_cone cone = random_cone(scene, sl_random_key(50, 0), n);
        sl_vec3d axis = sl_to_double(sl_normalize_or(cone.axis, sl_v3(0, 0, 1)));
        for (uint32_t t = 0; t < scene->triangle_count; t++) {
            bool meets = meets_box_of(&cone, scene, t);
            met += meets;
            for (uint64_t r = 0; r < 20; r++) {
                sl_vec3d d = direction_inside(&cone, sl_random_key(51, n), r);
                double at = hit_distance(scene, t, sl_to_double(cone.apex), d);
                if (at < 0.0 || at * sl_dotd(axis, d) > (double)cone.length) continue;
                hits++;
                assert_true(meets);
            }
        }
    }
    assert_true(hits > 500 && met < 100 * scene->triangle_count / 2);
    sl_scene_destroy(scene);
}

static void cones_that_are_none_hold_everything(void **state) {
    (void)state;
    sl_scene *scene = furnished_room(2, 4);
    sl_vec3 apex = sl_v3(2, 1, 2), up = sl_v3(0, 1, 0);
    const sl_cone all[] = {
        {apex, {0, 0, 0}, 0.5f, 1},    {apex, up, -0.1f, 1},       {apex, up, NAN, 1},
        {apex, up, 0.5f, NAN},         {{NAN, 0, 0}, up, 0.5f, 1}, {apex, {0, NAN, 0}, 0.5f, 1},
        sl_cone_around(apex, &apex, 1)};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        for (uint32_t t = 0; t < scene->triangle_count; t++) assert_true(meets_box_of(&all[i], scene, t));
    }
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_triangle_that_a_ray_in_the_cone_hits_is_missing),
        cmocka_unit_test(cones_that_are_none_hold_everything),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
