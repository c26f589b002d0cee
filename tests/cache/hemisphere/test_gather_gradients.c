/* Gradients against closed forms (Lambert's of polygon lights, the inside of a sphere) and against
 * differences of finer gathers. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/math.h"
#include "gather_world.h"

static void assert_near(double a, double b, double eps) {
    if (!(fabs(a - b) <= eps)) fail_msg("%.9g is not %.9g (+- %g)", a, b, eps);
}

static sl_gather_settings settings_of(sl_gather_kind kind, int size) {
    sl_gather_settings s = sl_gather_defaults();
    s.kind = kind;
    s.size = size;
    s.emission = true;
    s.jitter = false;
    s.direct = SL_DIRECT_RAYS;
    return s;
}

static const sl_gather_kind kinds[3] = {SL_GATHER_PLANE, SL_GATHER_HEMICUBE, SL_GATHER_RAYS};

static world *light_above(bool occluder) {
    world *w = world_new();
    world_quad(w, sl_v3(-0.7f, -0.4f, 1.3f), sl_v3(-0.7f, 0.9f, 1.3f), sl_v3(1.1f, 0.9f, 1.3f),
               sl_v3(1.1f, -0.4f, 1.3f), world_material(w, sl_grey(0), sl_grey(5)));
    if (occluder) {
        world_quad(w, sl_v3(-0.1f, -0.2f, 0.6f), sl_v3(-0.1f, 0.45f, 0.6f), sl_v3(0.5f, 0.45f, 0.6f),
                   sl_v3(0.5f, -0.2f, 0.6f), world_material(w, sl_grey(0), sl_grey(0)));
    }
    world_build(w);
    return w;
}

static void polygon_light_moves_and_turns_as_its_closed_form(void **state) {
    (void)state;
    world *w = light_above(false);
    for (int k = 0; k < 3; k++) {
        sl_gather_settings s = settings_of(kinds[k], 256);
        sl_irradiance e = gather_once(w, &s, sl_v3(0.35f, 0.2f, 0), sl_v3(0, 0, 1));
        assert_near((double)e.value.g, 4.643140759564, 0.08);
        assert_near((double)e.translational[1].x, -0.648396539400, 0.08);
        assert_near((double)e.translational[1].y, 0.305188879962, 0.08);
        assert_near((double)e.translational[1].z, 0, 0);
        assert_near((double)e.rotational[1].x, -0.136330404, 0.06);
        assert_near((double)e.rotational[1].y, -0.326685256, 0.06);
        assert_near((double)e.rotational[1].z, 0, 0);
    }
    world_free(w);
}

/* The wall is cut by the horizon; the second normal is tilted. The plane does not see down to the horizon. */
static void clipped_wall_moves_as_its_closed_form(void **state) {
    (void)state;
    world *w = world_new();
    world_quad(w, sl_v3(1.2f, -0.5f, -0.6f), sl_v3(1.2f, -0.5f, 1.1f), sl_v3(1.2f, 0.9f, 1.1f),
               sl_v3(1.2f, 0.9f, -0.6f), world_material(w, sl_grey(0), sl_grey(5)));
    world_build(w);
    for (int k = 1; k < 3; k++) {
        sl_gather_settings s = settings_of(kinds[k], 256);
        sl_irradiance e = gather_once(w, &s, sl_v3(0.1f, 0.2f, 0), sl_v3(0, 0, 1));
        assert_near((double)e.value.r, 1.338699193443, 0.03);
        assert_near((double)e.translational[0].x, 2.136970274, 0.08);
        assert_near((double)e.translational[0].y, 0, 0.05);
        sl_vec3 n = sl_v3(0.36f, 0.48f, 0.8f);
        e = gather_once(w, &s, sl_v3(0.1f, 0.2f, 0), n);
        assert_near((double)e.value.r, 2.726858117647, 0.04);
        double exact[3] = {3.302700934, -1.501339400, -1.379378227}; /* its tangential part */
        double along = exact[0] * 0.36 + exact[1] * 0.48 + exact[2] * 0.8;
        assert_near((double)e.translational[0].x, exact[0] - along * 0.36, 0.1);
        assert_near((double)e.translational[0].y, exact[1] - along * 0.48, 0.1);
        assert_near((double)e.translational[0].z, exact[2] - along * 0.8, 0.1);
    }
    world_free(w);
}

/* Silhouettes of an occluder move with the occluder, not with what lies behind: without that the gradient has
 * another sign. */
static void occluder_moves_before_the_light(void **state) {
    (void)state;
    world *w = light_above(true);
    for (int k = 0; k < 3; k++) {
        sl_gather_settings s = settings_of(kinds[k], 256);
        sl_irradiance e = gather_once(w, &s, sl_v3(0.35f, 0.2f, 0), sl_v3(0, 0, 1));
        assert_near((double)e.value.b, 1.48128, 0.06);
        assert_near((double)e.translational[2].x, 2.3814, 0.12);
        assert_near((double)e.translational[2].y, 3.1224, 0.15);
    }
    world_free(w);
}

/* L = 1 + x / 2 on the unit sphere, seen from its lowest point: E = pi; moving along the sphere turns the
 * normal as well, and the two gradients cancel. */
static void gradients_cancel_on_the_inside_of_a_sphere(void **state) {
    (void)state;
    enum { SHADES = 256 };
    world *w = world_new();
    uint32_t shades[SHADES];
    for (int i = 0; i < SHADES; i++) {
        float x = ((float)i + 0.5f) * (2.0f / SHADES) - 1.0f;
        shades[i] = world_material(w, sl_grey(0), sl_grey(1.0f + 0.5f * x));
    }
    world_sphere(w, 1, 128, shades, SHADES);
    world_build(w);
    for (int k = 1; k < 3; k++) {
        sl_gather_settings s = settings_of(kinds[k], 128);
        sl_irradiance e = gather_once(w, &s, sl_v3(0.003f, 0.002f, -0.9995f), sl_v3(0, 0, 1));
        assert_near((double)e.value.g, SL_PI, 0.01);
        assert_near((double)e.rotational[1].x, 0, 0.02);
        assert_near((double)e.rotational[1].y, SL_PI / 4, kinds[k] == SL_GATHER_RAYS ? 0.03 : 0.01);
        assert_near((double)e.translational[1].x, SL_PI / 4, 0.04);
        assert_near((double)e.translational[1].y, 0, 0.03);
        double step = 0.1; /* n' = (-s, 0, 1): n x n' = (0, -s, 0) */
        assert_near(step * (double)e.translational[1].x - step * (double)e.rotational[1].y, 0, 0.006);
    }
    world_free(w);
}

/* Central differences of a fine gather, at room points, against the gradients of 64 x 64. The errors are
 * relative to E, 1/m or 1/rad. The plane's are the largest: it lacks the directions near the horizon. */
typedef struct errors {
    double translational, rotational, true_translational, true_rotational;
} errors;

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(polygon_light_moves_and_turns_as_its_closed_form),
        cmocka_unit_test(clipped_wall_moves_as_its_closed_form),
        cmocka_unit_test(occluder_moves_before_the_light),
        cmocka_unit_test(gradients_cancel_on_the_inside_of_a_sphere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
