/* Bump and parallax mapping: normals and colours of the raised surface, and the light octree's light on
 * them. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "raster/raster.h"
#include "rendering.h"
#include "scene/bump.h"
#include "scene_parts.h"

enum { SIZE = 8 };

/* A floor y = 0, 2 x 2, front up, u along x and v along -z; heights by a function of the texel. */
static sl_scene *floor_with(int height(int column, int row), float depth) {
    static uint8_t texels[4 * SIZE * SIZE];
    for (int row = 0; row < SIZE; row++) {
        for (int column = 0; column < SIZE; column++)
            memset(texels + 4 * (row * SIZE + column), height(column, row), 4);
    }
    const float xyz[] = {-1, 0, 1, 1, 0, 1, 1, 0, -1, -1, 0, -1}, uv[] = {0, 0, 1, 0, 1, 1, 0, 1};
    const uint32_t corners[] = {0, 1, 2, 0, 2, 3};
    char name[] = "heights";
    const sl_texture texture = {.file = name, .width = SIZE, .height = SIZE, .texels = texels};
    const sl_material m = {.diffuse = {0.5f, 0.5f, 0.5f},
                           .texture = SL_NO_INDEX,
                           .alpha_texture = SL_NO_INDEX,
                           .height_map = 0,
                           .bump_depth = depth};
    const sl_light light = {.type = SL_LIGHT_POINT, .position = {0, 3, 0}, .intensity = {1, 1, 1}};
    const sl_scene_parts parts = {.vertex_count = 4,
                                  .positions = xyz,
                                  .texture_coordinates = uv,
                                  .triangle_count = 2,
                                  .indices = corners,
                                  .material_count = 1,
                                  .materials = &m,
                                  .texture_count = 1,
                                  .textures = &texture,
                                  .light_count = 1,
                                  .lights = &light};
    return scene_built(&parts);
}

static int even(int column, int row) { return (void)column, (void)row, 200; }
static int ramp(int column, int row) { return (void)row, 20 * column; }
static int slope_up(int column, int row) { return (void)column, 20 * row; } /* rows go down: v falls */
static int hills(int column, int row) { return (column * 37 + row * 91) % 256; }

static sl_surface surface_at(const sl_scene *scene, sl_vec3 to_viewer) {
    sl_surface s;
    sl_scene_surface(scene, 0, 0.25f, 0.25f, to_viewer, &s);
    return s;
}

static void a_flat_height_map_changes_no_normal(void **state) {
    sl_scene *scene = floor_with(even, 0.1f);
    sl_surface s = surface_at(scene, sl_v3(0.3f, 1, 0.2f));
    assert_true(s.normal.x == 0.0f && s.normal.y == 1.0f && s.normal.z == 0.0f);
    sl_scene_destroy(scene);
}

/* Twenty of 255 steps a texel, eight texels a width of 2: the raised surface has a slope of 0.1 * 8 * 20 /
 * 255. */
static void a_ramp_tilts_the_normal_by_its_slope_seen_from_either_side(void **state) {
    float slope = 0.1f * 8.0f * 20.0f / 255.0f;
    sl_scene *along_x = floor_with(ramp, 0.1f), *along_z = floor_with(slope_up, 0.1f);
    for (int side = -1; side <= 1; side += 2) {
        sl_vec3 up = sl_v3(0, (float)side, 0);
        sl_surface x = surface_at(along_x, up), z = surface_at(along_z, up);
        float length = 1.0f / sqrtf(1.0f + slope * slope);
        assert_true(fabsf(x.normal.x + (float)side * slope * length) < 1e-5f &&
                    fabsf(x.normal.y - (float)side * length) < 1e-5f);
        assert_true(fabsf(z.normal.z + (float)side * slope * length) < 1e-5f &&
                    fabsf(z.normal.y - (float)side * length) < 1e-5f);
        assert_true(fabsf(x.normal.z) < 1e-6f && fabsf(z.normal.x) < 1e-6f);
    }
    sl_scene_destroy(along_x);
    sl_scene_destroy(along_z);
}

/* v_xy (s h + b) with b = -s / 2 (Welsh 2004). */
static void what_is_above_the_surface_is_seen_nearer_to_the_viewer(void **state) {
    sl_scene *scene = floor_with(even, 0.1f);
    sl_surface s = surface_at(scene, sl_v3(0, 1, 0));
    float u = 0.5f, v = 0.5f, above = 0.1f * (200.0f / 255.0f - 0.5f);
    sl_bump(scene, 0, sl_v3(0.6f, 0.8f, 0), &u, &v, &s);
    assert_true(fabsf(u - (0.5f + 0.6f * above)) < 1e-6f && fabsf(v - 0.5f) < 1e-6f);
    sl_bump(scene, 0, sl_v3(0, 1, 0), &u, &v, &s);
    assert_true(fabsf(u - (0.5f + 0.6f * above)) < 1e-6f); /* seen from above nothing moves */
    sl_scene_destroy(scene);
}

static void without_texture_coordinates_nothing_is_raised(void **state) {
    sl_scene *scene = floor_with(hills, 0.5f);
    for (size_t i = 0; i < scene->vertex_count; i++) scene->texture_u[i] = scene->texture_v[i] = 0.25f;
    sl_surface s = surface_at(scene, sl_v3(0.1f, 1, 0));
    assert_true(s.normal.x == 0.0f && s.normal.y == 1.0f && s.normal.z == 0.0f);
    sl_scene_destroy(scene);
}

/* Bricks lit by way of a ceiling: the lobes of the voxels see each brick's own normal. */
static void the_octrees_lobes_light_bumps_as_paths_do(void **state) {
    sl_scene *scene = load_scene("scenes/bricks.json");
    sl_settings octree = small_settings("light-octree", 64, 48), path = small_settings("path", 64, 48);
    octree.threads = path.threads = 2;
    octree.light_octree.indirect_only = path.light_octree.indirect_only = true;
    path.transport = "matched:light-octree";
    path.spp = 96;
    sl_image *truth = render(scene, &path, NULL), *bumpy = render(scene, &octree, NULL);
    for (size_t i = 0; i < scene->material_count; i++) scene->materials[i].height_map = SL_NO_INDEX;
    sl_image *flat = render(scene, &octree, NULL);
    sl_comparison b = comparison_of(bumpy, truth);
    sl_comparison f = comparison_of(flat, truth);
    print_message("relMSE less noise: %.4f with bumps, %.4f without; bias %.2f %%\n",
                  b.rel_mse - b.rel_mse_noise, f.rel_mse - f.rel_mse_noise, 100.0 * b.bias);
    assert_true(fabs(b.bias) < 0.05);
    assert_true(b.rel_mse - b.rel_mse_noise < 0.7 * (f.rel_mse - f.rel_mse_noise));
    destroy_pictures(truth, bumpy);
    destroy_picture(flat, scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_flat_height_map_changes_no_normal),
        cmocka_unit_test(a_ramp_tilts_the_normal_by_its_slope_seen_from_either_side),
        cmocka_unit_test(what_is_above_the_surface_is_seen_nearer_to_the_viewer),
        cmocka_unit_test(without_texture_coordinates_nothing_is_raised),
        cmocka_unit_test(the_octrees_lobes_light_bumps_as_paths_do),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
