/* MIP maps of a scene's textures: means, and the level that a footprint asks for. */
#include "unit_test.h"
#include "base/random.h"
#include "image/color.h"
#include "raster/textures/mip.h"
#include "rendering.h"
#include "scene_files.h"

#include <math.h>
#include <stdio.h>

/* A square of side 1 with one turn of a picture of so many texels, of random colours. */
static sl_scene *textured_square(int width, int height, bool colours) {
    char json[300];
    const uint64_t key = sl_random_key(7, 0);
    sl_image *image = blank_image(width, height, 3);
    for (size_t i = 0; i < 3 * (size_t)width * (size_t)height; i++) image->planes[i] = sl_random_unit(key, i);
    scene_file_text("texels.png", "");
    assert_int_equal(sl_image_write(image, scene_file_path("texels.png"), NULL), SL_OK);
    sl_image_destroy(image);
    scene_file_text("square.mtl", colours ? "newmtl m\nKd 1 1 1\nmap_Kd texels.png\n"
                                          : "newmtl m\nKd 1 1 1\nmap_d texels.png\n");
    scene_file_text("square.obj",
                    "mtllib square.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n"
                    "vt 0 1\nusemtl m\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n");
    snprintf(json, sizeof json,
             "{\"softlux\": 1, \"meshes\": [{\"file\": \"square.obj\"}], \"camera\": {\"eye\": "
             "[0.5, 0.5, 3], \"target\": [0.5, 0.5, 0], \"fov_deg\": 40}}");
    return load_scene(scene_file_text("square.json", json));
}

static void every_level_has_the_texture_s_mean(void **state) {
    static const int sizes[][2] = {{16, 16}, {5, 3}, {1, 7}, {13, 1}, {1, 1}, {31, 64}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        sl_scene *scene = textured_square(sizes[i][0], sizes[i][1], true);
        const sl_texture *texture = &scene->textures[0];
        sl_mip *mips;
        assert_int_equal(sl_mips_create(scene, 1, &mips, NULL), SL_OK);
        const size_t texels = (size_t)texture->width * (size_t)texture->height;
        double mean = 0.0;
        for (size_t t = 0; t < texels; t++)
            mean += (double)sl_srgb_to_linear[texture->texels[4 * t + 1]] / (double)texels;
        for (int k = 1; k < mips[0].count; k++) {
            const sl_mip_level *level = &mips[0].level[k];
            const size_t count = (size_t)level->width * (size_t)level->height;
            double sum = 0.0;
            for (size_t t = 0; t < count; t++) sum += (double)level->texels[4 * t + 1];
            assert_true(fabs(sum / (double)count / SL_MIP_ONE - mean) < 1e-5);
        }
        assert_true(mips[0].level[mips[0].count - 1].width == 1 &&
                    mips[0].level[mips[0].count - 1].height == 1);
        sl_mips_destroy(scene, mips);
        sl_scene_destroy(scene);
    }
}

static void only_textures_that_colour_surfaces_are_filtered(void **state) {
    sl_scene *scene = textured_square(16, 16, false);
    sl_mip *mips;
    assert_int_equal(scene->texture_count, 1);
    assert_int_equal(sl_mips_create(scene, 1, &mips, NULL), SL_OK);
    assert_null(mips);
    assert_int_equal(sl_mips_need(scene), 0);
    sl_scene_destroy(scene);
}

static void a_level_s_texels_are_no_wider_than_the_footprint(void **state) {
    const struct { float squared; int32_t level;
    } cases[] = {{0.0f, 0}, {3.99f, 0}, {4.0f, 1}, {15.9f, 1}, {16.0f, 2}, {1e20f, 9},
                 {INFINITY, 9}, {-1.0f, 0}, {NAN, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_int_equal(sl_mip_level_for(cases[i].squared, 10), cases[i].level);
    assert_int_equal(sl_mip_level_for(1e9f, 1), 0);
}

static void a_wide_footprint_sees_the_mean_and_a_narrow_one_the_texture(void **state) {
    sl_scene *scene = textured_square(32, 32, true);
    sl_mip *mips;
    assert_int_equal(sl_mips_create(scene, 1, &mips, NULL), SL_OK);
    const sl_mip *mip = &mips[0];
    for (int i = 0; i < 20; i++) {
        const float w1 = 0.04f * (float)i, w2 = 0.1f;
        sl_rgb plain = sl_scene_diffuse(scene, 0, w1, w2),
               narrow = sl_scene_diffuse_within(scene, mips, 0, w1, w2, 1.0f / 32.0f),
               wide = sl_scene_diffuse_within(scene, mips, 0, w1, w2, 1.0f),
               none = sl_scene_diffuse_within(scene, NULL, 0, w1, w2, 1.0f);
        assert_true(narrow.g == plain.g && none.g == plain.g);
        assert_true(wide.g == (float)mip->level[mip->count - 1].texels[1] * (1.0f / SL_MIP_ONE));
    }
    sl_mips_destroy(scene, mips);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_level_has_the_texture_s_mean),
        cmocka_unit_test(only_textures_that_colour_surfaces_are_filtered),
        cmocka_unit_test(a_level_s_texels_are_no_wider_than_the_footprint),
        cmocka_unit_test(a_wide_footprint_sees_the_mean_and_a_narrow_one_the_texture),
    };
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
