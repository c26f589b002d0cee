/* The pyramid around an area light: nothing of the light that the point can see is left out, whatever the
 * light's size and place. */
#include "raster/views/light_view.h"
#include "base/math.h"
#include "raster_support.h"

enum { SAMPLES = 60 };

typedef struct {
    sl_vec3 corner[3 * 40];
    sl_light_shape shape;
} lamp;

static void set_quad(lamp *l, sl_vec3 centre, sl_vec3 a, sl_vec3 b) { /* shines along a x b */
    sl_vec3 p[4] = {sl_sub(sl_sub(centre, a), b), sl_sub(sl_add(centre, a), b), sl_add(sl_add(centre, a), b),
                    sl_add(sl_sub(centre, a), b)};
    const int order[6] = {0, 1, 2, 0, 2, 3};
    for (int i = 0; i < 6; i++) l->corner[i] = p[order[i]];
    l->shape = (sl_light_shape){l->corner, 2, false};
}

/* ---- what must hold ---- */

/* The transform's arithmetic on a point relative to the eye. */
static float clip_row(const float row[4], sl_vec3 q) {
    return ((row[0] * q.x + row[1] * q.y) + row[2] * q.z) + row[3];
}

static bool inside_all_planes(const sl_view *v, sl_vec3 q) {
    float x = clip_row(v->clip[0], q), y = clip_row(v->clip[1], q), z = clip_row(v->clip[2], q),
          w = clip_row(v->clip[3], q);
    return x <= w && x >= -w && y <= w && y >= -w && z >= 0.0f && w > 0.0f;
}

/* Random points, corners and points of edges of every triangle that are above the horizon and turned to the
 * eye. */
static int check_all_seen(const sl_light_view *view, sl_vec3 eye, sl_vec3 normal, const sl_light_shape *light,
                          uint64_t key) {
    int seen = 0;
    for (size_t t = 0; t < light->triangles; t++) {
        sl_vec3d d[3];
        for (size_t k = 0; k < 3; k++)
            d[k] = sl_subd(sl_to_double(light->corner[3 * t + k]), sl_to_double(eye));
        sl_vec3d m = sl_crossd(sl_subd(d[1], d[0]), sl_subd(d[2], d[0]));
        if (!light->two_sided && !(sl_dotd(m, d[0]) < 0.0)) continue;
        for (uint64_t s = 0; s < SAMPLES; s++) {
            double u = (double)sl_random_unit(key, 3 * s + t * 1000),
                   v = (double)sl_random_unit(key, 3 * s + 1 + t * 1000);
            if (s < 3) u = s == 1, v = s == 2;
            else if (s < 20) u = s % 3 == 0 ? 0.0 : u, v = s % 3 == 1 ? 0.0 : s % 3 == 2 ? 1.0 - u : v;
            if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
            sl_vec3d q =
                sl_addd(sl_scaled(d[0], 1.0 - u - v), sl_addd(sl_scaled(d[1], u), sl_scaled(d[2], v)));
            if (sl_lengthd(sl_to_double(normal)) > 0.0 && !(sl_dotd(q, sl_to_double(normal)) > 0.0)) continue;
            if (!(sl_lengthd(q) > 0.0)) continue;
            seen++;
            if (!inside_all_planes(&view->view, sl_to_float(q))) {
                fail_msg("triangle %zu at (%g, %g): %.9g %.9g %.9g is outside", t, u, v, q.x, q.y, q.z);
            }
        }
    }
    return seen;
}

typedef struct {
    int hidden, in_view, too_wide;
} outcomes;

static void check(const lamp *l, sl_vec3 eye, sl_vec3 normal, uint64_t key, outcomes *o) {
    sl_light_view view;
    sl_light_sight sight = sl_view_light(eye, normal, &l->shape, 64, 64, 1e-3f, &view);
    o->hidden += sight == SL_LIGHT_HIDDEN;
    o->in_view += sight == SL_LIGHT_IN_VIEW;
    o->too_wide += sight == SL_LIGHT_TOO_WIDE;
    if (sight == SL_LIGHT_IN_VIEW) check_all_seen(&view, eye, normal, &l->shape, key);
    if (sight == SL_LIGHT_HIDDEN) {
        sl_light_view unused = {.view = {.width = 1}};
        assert_int_equal(check_all_seen(&unused, eye, normal, &l->shape, key), 0);
    }
}

/* ---- tests ---- */

static void every_visible_point_of_a_random_light_projects_inside(void **state) {
    uint64_t key = sl_random_key(41, 0);
    outcomes o = {0, 0, 0};
    for (uint64_t n = 0; n < 4000; n++) {
        lamp l;
        float size = random_between(key, 16 * n, 0.01f, 2.0f);
        sl_vec3 a = sl_scale(random_direction(key, 100000 + 4 * n), size),
                b = random_direction(key, 100001 + 4 * n);
        sl_vec3 centre =
            sl_scale(random_direction(key, 100002 + 4 * n), random_between(key, 16 * n + 1, 0.1f, 5.0f));
        set_quad(&l, centre, a, sl_scale(b, random_between(key, 16 * n + 2, 0.01f, 2.0f)));
        l.shape.two_sided = n % 3 == 0;
        sl_vec3 eye = sl_v3(random_between(key, 16 * n + 3, -1, 1), random_between(key, 16 * n + 4, -1, 1),
                            random_between(key, 16 * n + 5, -1, 1));
        check(&l, eye, n % 5 ? random_direction(key, 100003 + 4 * n) : sl_v3(0, 0, 0), key + n, &o);
    }
    assert_true(o.hidden > 800 && o.in_view > 1500 && o.too_wide > 5);
}

static void lights_at_the_horizon_or_nearly_touched_stay_inside(void **state) {
    uint64_t key = sl_random_key(41, 2);
    outcomes o = {0, 0, 0};
    for (uint64_t n = 0; n < 2000; n++) { /* above a unit square's point or just beside it, ever lower */
        lamp l;
        set_quad(&l, sl_v3(0, 0, 0), sl_v3(0.5f, 0, 0), sl_v3(0, 0.5f, 0));
        float height = sl_exp2f(random_between(key, 4 * n, -40.0f, 1.0f));
        sl_vec3 eye =
            sl_v3(random_between(key, 4 * n + 1, -1, 1), random_between(key, 4 * n + 2, -1, 1), height);
        check(&l, eye, n % 2 ? sl_v3(0, 0, -1) : random_direction(key, 90000 + n), key + n, &o);
    }
    assert_true(o.too_wide > 300 && o.in_view > 300);
    for (uint64_t n = 0; n < 1000; n++) { /* a wall that stands in the receiver's plane, partly below */
        lamp l;
        set_quad(&l, sl_v3(0, 1, random_between(key, n, -1.2f, 1.2f)), sl_v3(-1, 0, 0), sl_v3(0, 0, 1));
        l.shape.two_sided = true;
        check(&l, sl_v3(0, 0, 0), sl_v3(0, 0, 1), key + n, &o);
    }
}

static void what_cannot_shine_on_the_point_is_hidden(void **state) {
    lamp l;
    sl_light_view view;
    sl_vec3 up = sl_v3(0, 0, 1), zero = sl_v3(0, 0, 0);
    set_quad(&l, sl_v3(0, 0, 2), sl_v3(0.5f, 0, 0), sl_v3(0, -0.5f, 0)); /* shines downwards */
    assert_int_equal(sl_view_light(zero, up, &l.shape, 8, 8, 1e-3f, &view), SL_LIGHT_IN_VIEW);
    /* behind */
    assert_int_equal(sl_view_light(zero, sl_v3(0, 0, -1), &l.shape, 8, 8, 1e-3f, &view), SL_LIGHT_HIDDEN);
    assert_int_equal(sl_view_light(sl_v3(0, 0, 3), up, &l.shape, 8, 8, 1e-3f, &view), SL_LIGHT_HIDDEN);
    /* its back */
    assert_int_equal(sl_view_light(sl_v3(0, 0, 3), zero, &l.shape, 8, 8, 1e-3f, &view), SL_LIGHT_HIDDEN);
    /* its plane */
    assert_int_equal(sl_view_light(sl_v3(5, 0, 2), sl_v3(-1, 0, 0), &l.shape, 8, 8, 1e-3f, &view),
                     SL_LIGHT_HIDDEN);
    /* in it */
    assert_int_equal(sl_view_light(sl_v3(0, 0, 2), zero, &l.shape, 8, 8, 1e-3f, &view), SL_LIGHT_HIDDEN);
    assert_int_equal(sl_view_light(sl_v3(NAN, 0, 0), up, &l.shape, 8, 8, 1e-3f, &view), SL_LIGHT_HIDDEN);
    l.shape.triangles = 0;
    assert_int_equal(sl_view_light(zero, up, &l.shape, 8, 8, 1e-3f, &view), SL_LIGHT_HIDDEN);
    set_quad(&l, sl_v3(0, 0, 2), sl_v3(0, 0, 0), sl_v3(0, 0.5f, 0)); /* no area */
    assert_int_equal(sl_view_light(zero, up, &l.shape, 8, 8, 1e-3f, &view), SL_LIGHT_HIDDEN);
    set_quad(&l, sl_v3(0, 0, 2), sl_v3(0.5f, 0, 0), sl_v3(0, -0.5f, 0));
    for (int i = 0; i < 3; i++) l.corner[i].y = NAN; /* the other half remains */
    assert_int_equal(sl_view_light(zero, up, &l.shape, 8, 8, 1e-3f, &view), SL_LIGHT_IN_VIEW);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_visible_point_of_a_random_light_projects_inside),
        cmocka_unit_test(lights_at_the_horizon_or_nearly_touched_stay_inside),
        cmocka_unit_test(what_cannot_shine_on_the_point_is_hidden),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
