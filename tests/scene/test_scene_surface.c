/* Surface points and the sky: sides, normals, textures, alpha masks, directions, and sampling against its own
 * density. */
#include <math.h>

#include "unit_test.h"
#include "base/math.h"
#include "base/random.h"
#include "scene/scene.h"
#include "scene/texture.h"
#include "scene_parts.h"

static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
static const float uvs[6] = {0, 0, 1, 0, 0, 1};
static const uint32_t face[3] = {0, 1, 2};

static sl_scene *triangle(const float *normals, const sl_material *material, sl_texture *texture) {
    sl_scene_parts parts = {.vertex_count = 3,
                            .positions = corners,
                            .normals = normals,
                            .texture_coordinates = uvs,
                            .triangle_count = 1,
                            .indices = face,
                            .material_count = material ? 1 : 0,
                            .materials = material,
                            .texture_count = texture ? 1 : 0,
                            .textures = texture};
    return scene_built(&parts);
}

static void the_side_seen_decides_which_way_normals_point(void **state) {
    sl_scene *s = triangle(NULL, NULL, NULL);
    sl_surface above, below, edge;
    sl_scene_surface(s, 0, 0.25f, 0.5f, sl_v3(0, 0, 2), &above);
    sl_scene_surface(s, 0, 0.25f, 0.5f, sl_v3(3, 1, -2), &below);
    sl_scene_surface(s, 0, 0.25f, 0.5f, sl_v3(1, 0, 0), &edge);
    assert_true(above.front && above.geometric_normal.z == 1.0f && above.normal.z == 1.0f);
    assert_false(below.front);
    assert_true(below.geometric_normal.z == -1.0f && below.normal.z == -1.0f);
    assert_true(edge.front && edge.normal.z == 1.0f);
    assert_true(above.position.x == 0.25f && above.position.y == 0.5f && above.position.z == 0.0f);
    assert_true(above.diffuse.g == 0.5f && above.material == &s->materials[0]);
    sl_scene_destroy(s);
}

static void shading_normals_are_flipped_into_the_geometric_hemisphere(void **state) {
    const float inverted[9] = {0.6f, 0, -0.8f, 0.6f, 0, -0.8f, 0.6f, 0, -0.8f};
    sl_scene *s = triangle(inverted, NULL, NULL);
    sl_surface p;
    sl_scene_surface(s, 0, 0.3f, 0.3f, sl_v3(0, 0, 1), &p);
    assert_true(p.geometric_normal.z == 1.0f && fabsf(p.normal.z - 0.8f) < 1e-6f &&
                fabsf(p.normal.x + 0.6f) < 1e-6f);
    sl_scene_surface(s, 0, 0.3f, 0.3f, sl_v3(0, 0, -1), &p);
    assert_true(p.geometric_normal.z == -1.0f && fabsf(p.normal.z + 0.8f) < 1e-6f);
    sl_scene_destroy(s);
}

static void normals_that_cancel_or_lie_in_the_plane_give_way_to_the_geometric_one(void **state) {
    const float opposed[9] = {0, 0, 1, 0, 0, -1, 0, 0, 1}, flat[9] = {1, 0, 0, 1, 0, 0, 1, 0, 0};
    const float *sets[2] = {opposed, flat};
    for (int i = 0; i < 2; i++) {
        sl_scene *s = triangle(sets[i], NULL, NULL);
        sl_surface p;
        sl_scene_surface(s, 0, 0.5f, 0.0f, sl_v3(0, 0, 1), &p);
        assert_true(p.normal.x == 0.0f && p.normal.y == 0.0f && p.normal.z == 1.0f);
        sl_scene_destroy(s);
    }
}

/* Bottom row: black, white; top row: mid grey, transparent red. */
static uint8_t two_by_two[16] = {188, 188, 188, 255, 255, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255, 255};

static void textures_are_bilinear_repeat_and_are_decoded_before_filtering(void **state) {
    const sl_texture t = {.width = 2, .height = 2, .has_alpha = true, .texels = two_by_two};
    assert_true(sl_texture_color(&t, 0.25f, 0.25f).r == 0.0f);  /* v = 0 is the bottom row */
    assert_true(sl_texture_color(&t, 0.75f, 0.25f).r == 1.0f);
    /* ((188/255 + .055)/1.055)^2.4 */
    assert_true(fabsf(sl_texture_color(&t, 0.25f, 0.75f).r - 0.50289f) < 1e-5f);
    /* linear half, not sRGB half */
    assert_true(fabsf(sl_texture_color(&t, 0.5f, 0.25f).r - 0.5f) < 1e-6f);
    assert_true(fabsf(sl_texture_color(&t, 0.0f, 0.25f).r - 0.5f) < 1e-6f);      /* across the seam */
    const float places[3] = {-3.0f, 5.0f, 1024.0f};
    for (int i = 0; i < 3; i++)
        assert_true(sl_texture_color(&t, 0.75f + places[i], 0.25f - places[i]).g == 1.0f);
    assert_true(isfinite(sl_texture_color(&t, NAN, INFINITY).r));
    assert_true(isfinite(sl_texture_color(&t, -1e-30f, 3e38f).r));
}

static void alpha_masks_are_tested_at_one_half(void **state) {
    sl_texture texture = {.width = 2, .height = 2, .has_alpha = true, .texels = two_by_two};
    const sl_material m = {.diffuse = {1, 1, 1}, .texture = SL_NO_INDEX, .alpha_texture = 0};
    sl_scene *s = triangle(NULL, &m, &texture);
    assert_true(sl_scene_has_alpha(s, 0));
    assert_true(sl_scene_is_opaque(s, 0, 0.25f, 0.25f));
    assert_false(sl_scene_is_opaque(s, 0, 0.75f, 0.75f));
    assert_true(sl_scene_is_opaque(s, 0, 0.49f, 0.75f));
    assert_false(sl_scene_is_opaque(s, 0, 0.51f, 0.75f));
    sl_scene_destroy(s);
    texture.has_alpha = false; /* then luminance, of the bytes as they stand: 188/255 is above one half */
    s = triangle(NULL, &m, &texture);
    assert_false(sl_scene_is_opaque(s, 0, 0.25f, 0.25f));
    assert_true(sl_scene_is_opaque(s, 0, 0.75f, 0.25f));
    assert_true(sl_scene_is_opaque(s, 0, 0.25f, 0.75f));
    sl_scene_destroy(s);
}

/* ---- the sky --------------------------------------------------------------------------------- */

enum { WIDTH = 16, HEIGHT = 8 };

static sl_scene *scene_under(const sl_environment *environment) {
    sl_scene_parts parts = {.vertex_count = 3,
                            .positions = corners,
                            .triangle_count = 1,
                            .indices = face,
                            .environment = environment};
    return scene_built(&parts);
}

static sl_scene *scene_under_numbered_sky(void) {
    static float texels[3 * WIDTH * HEIGHT];
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        texels[3 * i] = (float)(i % 7);
        texels[3 * i + 1] = (float)i;
        texels[3 * i + 2] = (float)(i % 3);
    }
    return scene_under(
        &(sl_environment){.present = true, .width = WIDTH, .height = HEIGHT, .texels = texels});
}

static void directions_follow_the_stated_convention(void **state) {
    sl_scene *s = scene_under_numbered_sky();
    const sl_environment *e = &s->environment;
    for (int row = 0; row < HEIGHT; row++) {
        for (int column = 0; column < WIDTH; column++) {
            double phi = 2.0 * SL_PI * ((column + 0.5) / WIDTH - 0.5), theta = SL_PI * (row + 0.5) / HEIGHT;
            sl_vec3 d =
                sl_v3((float)(sin(theta) * sin(phi)), (float)cos(theta), (float)(-sin(theta) * cos(phi)));
            assert_true(sl_environment_radiance(e, d).g == (float)(row * WIDTH + column));
        }
    }
    /* the middle is ahead */
    assert_true(sl_environment_radiance(e, sl_v3(0, 0, -1)).g == (float)(HEIGHT / 2 * WIDTH + WIDTH / 2));
    assert_true(isfinite(sl_environment_radiance(e, sl_v3(0, 1, 0)).g) &&
                isfinite(sl_environment_radiance(e, sl_v3(0, -1, 0)).g));
    sl_scene_destroy(s);
}

/* Importance sampling with its own density must give the integral of radiance: sum of texel times solid
 * angle. */
static void sky_samples_estimate_the_sky_without_bias(void **state) {
    sl_scene *s = scene_under_numbered_sky();
    const sl_environment *e = &s->environment;
    double exact = 0.0, estimate = 0.0;
    for (int row = 0; row < HEIGHT; row++) {
        double cap = 2.0 * SL_PI / WIDTH * (cos(SL_PI * row / HEIGHT) - cos(SL_PI * (row + 1) / HEIGHT));
        for (int column = 0; column < WIDTH; column++) exact += cap * (row * WIDTH + column);
    }
    const int samples = 200000;
    uint64_t key = sl_random_key(5, 1);
    for (int i = 0; i < samples; i++) {
        sl_rgb radiance;
        float pdf;
        sl_vec3 d = sl_environment_sample(e, sl_random_unit(key, 2 * (uint64_t)i),
                                          sl_random_unit(key, 2 * (uint64_t)i + 1), &radiance, &pdf);
        assert_true(pdf > 0.0f && isfinite(pdf) && fabsf(sl_dot(d, d) - 1.0f) < 1e-5f);
        estimate += (double)radiance.g / (double)pdf;
    }
    assert_true(fabs(estimate / samples / exact - 1.0) < 0.01);
    sl_scene_destroy(s);
}

static void a_black_or_damaged_sky_is_no_sky(void **state) {
    float texels[6] = {NAN, -1.0f, INFINITY, 0, 0, 0};
    sl_scene *s = scene_under(&(sl_environment){.present = true, .width = 2, .height = 1, .texels = texels});
    assert_false(s->environment.present);
    sl_rgb radiance;
    float pdf;
    sl_environment_sample(&s->environment, 0.5f, 0.5f, &radiance, &pdf);
    assert_true(pdf == 0.0f && sl_rgb_max(radiance) == 0.0f);
    assert_true(sl_environment_pdf(&s->environment, sl_v3(0, 1, 0)) == 0.0f);
    sl_scene_destroy(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_side_seen_decides_which_way_normals_point),
        cmocka_unit_test(shading_normals_are_flipped_into_the_geometric_hemisphere),
        cmocka_unit_test(normals_that_cancel_or_lie_in_the_plane_give_way_to_the_geometric_one),
        cmocka_unit_test(textures_are_bilinear_repeat_and_are_decoded_before_filtering),
        cmocka_unit_test(alpha_masks_are_tested_at_one_half),
        cmocka_unit_test(directions_follow_the_stated_convention),
        cmocka_unit_test(sky_samples_estimate_the_sky_without_bias),
        cmocka_unit_test(a_black_or_damaged_sky_is_no_sky),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
