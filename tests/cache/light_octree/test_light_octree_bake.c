/* Light in the texture atlas: what is put in at a surface point comes out at the pixels that show it, and
 * nothing of its neighbours. */
#include "light_octree_support.h"

#include "base/memory.h"
#include "cache/light_octree/atlas/atlas.h"
#include "trace_scenes.h"

typedef struct stage {
    sl_scene *scene;
    const sl_atlas *atlas;
    sl_atlas_canvas *canvas;
    sl_raster *raster;
    sl_view view;
    sl_gbuffer *gbuffer;
    float *out[3];
    sl_counters counters;
} stage;

enum { WIDTH = 160, HEIGHT = 120 };

static stage stage_of(sl_scene *scene, int size) {
    stage s = {.scene = scene, .raster = raster_of(scene), .view = sl_view_scene(scene, WIDTH, HEIGHT)};
    sl_atlas *atlas;
    assert_int_equal(sl_atlas_create(scene, size, &atlas, NULL), SL_OK);
    s.atlas = atlas;
    assert_int_equal(sl_atlas_canvas_create(atlas, scene, 2, &s.canvas, NULL), SL_OK);
    assert_int_equal(sl_gbuffer_create(WIDTH, HEIGHT, &s.gbuffer, NULL), SL_OK);
    assert_int_equal(sl_raster_gbuffer(s.raster, &s.view, 2, s.gbuffer, &s.counters, NULL), SL_OK);
    for (int k = 0; k < 3; k++) s.out[k] = sl_allocate(WIDTH * HEIGHT, sizeof(float));
    return s;
}

static void end_stage(stage *s) {
    for (int k = 0; k < 3; k++) sl_free(s->out[k]);
    sl_gbuffer_destroy(s->gbuffer);
    sl_raster_destroy(s->raster);
    sl_atlas_canvas_destroy(s->canvas);
    sl_scene_destroy(s->scene);
}

static void apply(stage *s) {
    uint8_t side[WIDTH * HEIGHT];
    for (size_t i = 0; i < WIDTH * HEIGHT; i++)
        side[i] = s->gbuffer->material[i] == SL_NO_INDEX
                      ? SL_ATLAS_NEITHER
                      : (uint8_t)sl_atlas_side_seen(s->scene, s->gbuffer, i);
    sl_atlas_apply(s->canvas, s->gbuffer, side, 2, s->out, &s->counters);
}

static sl_scene *scene_from(void fill(trace_mesh *)) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    fill(&mesh);
    mesh.has_camera = sl_camera_look_at(&mesh.camera, sl_v3(2.0f, 1.5f, 3.0f), sl_v3(0.0f, 0.0f, 0.0f),
                                        sl_v3(0.0f, 1.0f, 0.0f), 0.9f);
    return trace_mesh_build(&mesh);
}

static void wall(trace_mesh *m) {
    trace_mesh_quad(m, sl_v3(-1.0f, -1.0f, 0.0f), sl_v3(2.0f, 0.0f, 0.0f), sl_v3(0.0f, 2.0f, 0.0f), 0);
}
static void wall_from_behind(trace_mesh *m) {
    trace_mesh_quad(m, sl_v3(-1.0f, -1.0f, 0.0f), sl_v3(0.0f, 2.0f, 0.0f), sl_v3(2.0f, 0.0f, 0.0f), 0);
}
static void ball_and_box(trace_mesh *m) {
    trace_mesh_sphere(m, sl_v3(0.0f, 0.0f, 0.0f), 0.8f, 16, 0.0f, false, 0);
    trace_mesh_box(m, sl_v3(-2.0f, -1.2f, -2.0f), sl_v3(2.0f, -1.0f, 2.0f), false, 0);
}
static void confetti(trace_mesh *m) { /* pieces smaller than texels */
    for (int i = 0; i < 900; i++) {
        float x = 0.06f * (float)(i % 30) - 0.9f, y = 0.06f * (float)(i / 30) - 0.9f;
        trace_mesh_quad(m, sl_v3(x, y, 0.0f), sl_v3(0.05f, 0.0f, 0.0f), sl_v3(0.0f, 0.05f, 0.0f), 0);
    }
}

/* ---- shaders ---- */

static void constant(const stage *s, size_t i, const float color[3], float rgb[3]) {
    memcpy(rgb, color, 3 * sizeof *rgb);
}

static void position(const stage *s, size_t i, const float color[3], float rgb[3]) {
    const sl_atlas_canvas *c = s->canvas;
    sl_vec3 p[3];
    for (int k = 0; k < 3; k++) p[k] = sl_scene_position(s->scene, s->scene->vertex[k][c->triangle[i]]);
    sl_vec3 at =
        sl_mad(sl_mad(sl_scale(p[0], 1.0f - c->w1[i] - c->w2[i]), c->w1[i], p[1]), c->w2[i], p[2]);
    rgb[0] = at.x + 2.0f, rgb[1] = at.y + 2.0f, rgb[2] = at.z + 2.0f;
}

static void chart_number(const stage *s, size_t i, const float color[3], float rgb[3]) {
    rgb[0] = (float)(s->atlas->chart_of[s->canvas->triangle[i]] + 1);
    rgb[1] = rgb[2] = 1.0f;
}

typedef void shader(const stage *s, size_t i, const float color[3], float rgb[3]);

static void fill(stage *s, sl_atlas_side side, shader *shade, const float color[3]) {
    sl_atlas_canvas *c = s->canvas;
    if (!c->side[side])
        assert_int_equal(sl_texture_image_create(s->atlas->size, s->atlas->size, &c->side[side], NULL),
                         SL_OK);
    const size_t texels = (size_t)s->atlas->size * (size_t)s->atlas->size;
    for (size_t i = 0; i < texels; i++) {
        float *texel = c->side[side]->texels + 4 * i;
        if (c->triangle[i] == SL_NO_INDEX) continue;
        shade(s, i, color, texel);
        texel[3] = 1.0f;
    }
}

/* ---- tests ---- */

static size_t lit_pixels(const stage *s) {
    size_t lit = 0;
    for (size_t i = 0; i < WIDTH * HEIGHT; i++) lit += s->gbuffer->material[i] != SL_NO_INDEX;
    return lit;
}

static void what_varies_evenly_is_looked_up_exactly_but_for_the_rim(void **state) {
    stage s = stage_of(scene_from(wall), 64);
    fill(&s, SL_ATLAS_FRONT, position, NULL);
    uint64_t before = s.counters.value[SL_COUNT_TEXTURE_FETCHES];
    apply(&s);
    assert_int_equal(s.counters.value[SL_COUNT_TEXTURE_FETCHES] - before, lit_pixels(&s)); /* one a pixel */
    double texel = 1.0 / s.atlas->texels_per_unit;
    size_t inside = 0;
    for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
        if (s.gbuffer->material[i] == SL_NO_INDEX) continue;
        double p[3] = {(double)s.gbuffer->position_x[i], (double)s.gbuffer->position_y[i],
                       (double)s.gbuffer->position_z[i]};
        bool rim = fmax(fabs(p[0]), fabs(p[1])) > 1.0 - 1.01 * texel;
        inside += !rim;
        for (int k = 0; k < 3; k++) {
            double off = fabs((double)s.out[k][i] * 2.0 * SL_PI - p[k] - 2.0);
            assert_true(off < (rim ? 1.01 * texel : 1e-4));
        }
    }
    assert_true(inside > 1000);
    end_stage(&s);
}

static void pixels_show_their_own_chart_alone(void **state) {
    sl_scene *scenes[] = {scene_from(ball_and_box), scene_from(confetti)};
    for (int n = 0; n < 2; n++) {
        stage s = stage_of(scenes[n], n ? 150 : 64);
        fill(&s, SL_ATLAS_FRONT, chart_number, NULL);
        fill(&s, SL_ATLAS_BACK, chart_number, NULL);
        apply(&s);
        for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
            if (s.gbuffer->material[i] == SL_NO_INDEX) continue;
            double chart = (double)s.out[0][i] * 2.0 * SL_PI - 1.0;
            assert_true(fabs(chart - s.atlas->chart_of[s.gbuffer->id[i]]) < 2e-3);
        }
        end_stage(&s);
    }
}

static void each_side_shows_its_own_light(void **state) {
    float front[3] = {1.0f, 0.0f, 0.0f}, back[3] = {0.0f, 1.0f, 0.0f};
    sl_scene *scenes[] = {scene_from(wall), scene_from(wall_from_behind)};
    for (int n = 0; n < 2; n++) {
        stage s = stage_of(scenes[n], 64);
        size_t bytes = sl_atlas_canvas_bytes(s.canvas);
        fill(&s, SL_ATLAS_FRONT, constant, front);
        assert_int_equal(sl_atlas_canvas_bytes(s.canvas) - bytes, 64 * 64 * 16);
        for (int both = 0; both < 2; both++) {
            if (both)
                fill(&s, SL_ATLAS_BACK, constant, back);
            apply(&s);
            for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
                double lit = s.gbuffer->material[i] == SL_NO_INDEX ? 0.0 : 0.5 / SL_PI;
                assert_true(fabs((double)s.out[0][i] - (n ? 0.0 : lit)) < 1e-6);
                assert_true(fabs((double)s.out[1][i] - (n && both ? lit : 0.0)) < 1e-6);
            }
        }
        end_stage(&s);
    }
}

static void what_is_not_finite_becomes_black(void **state) {
    stage s = stage_of(scene_from(ball_and_box), 64);
    sl_octree *octree = octree_of(s.scene, 4, 2);
    sl_voxel_lights *lights = whole_voxels(s.scene, octree, 1);
    for (size_t i = 0; i < octree->leaf_count; i++)
        set_light(lights, i, 0, sl_v3d(0, 1, 0), INFINITY, -INFINITY, NAN);
    sl_octree_shading shading = {.texture = texture_of(octree, lights)};
    assert_int_equal(
        sl_atlas_bake(s.canvas, SL_ATLAS_FRONT, s.scene, &shading, 1, &s.counters, NULL), SL_OK);
    for (size_t i = 0; i < 4 * 64 * 64; i++)
        assert_true(s.canvas->side[0]->texels[i] >= 0.0f && s.canvas->side[0]->texels[i] <= 1.0f);
    sl_voxel_texture_destroy((sl_voxel_texture *)shading.texture);
    sl_voxel_lights_destroy(lights);
    sl_octree_destroy(octree);
    end_stage(&s);
}

static void a_texel_is_what_the_octree_says_at_its_point(void **state) {
    stage s = stage_of(scene_from(ball_and_box), 128);
    sl_octree *octree = octree_of(s.scene, 4, 2);
    sl_voxel_lights *lights = whole_voxels(s.scene, octree, 4);
    uint64_t key = sl_random_key(5, 0);
    for (size_t i = 0; i < octree->leaf_count; i++) {
        sl_vec3d d = sl_v3d((double)sl_random_unit(key, 4 * i) - 0.5, 0.6,
                            (double)sl_random_unit(key, 4 * i + 1) - 0.5);
        set_light(lights, i, 0, sl_scaled(d, 1.0 / sl_lengthd(d)), 1.0f, sl_random_unit(key, 4 * i + 2),
                  0.5f);
    }
    sl_voxel_texture *texture = texture_of(octree, lights);
    sl_octree_shading shading = {.texture = texture, .filter = SL_VOXEL_TRILINEAR};
    float *first = sl_allocate(128 * 128, 4 * sizeof *first);
    for (unsigned threads = 1; threads <= 3; threads++) { /* the same bits at any number of threads */
        assert_int_equal(
            sl_atlas_bake(s.canvas, SL_ATLAS_FRONT, s.scene, &shading, threads, &s.counters, NULL),
            SL_OK);
        if (threads == 1) memcpy(first, s.canvas->side[0]->texels, 128 * 128 * 16);
        else assert_memory_equal(first, s.canvas->side[0]->texels, 128 * 128 * 16);
    }
    size_t lit = 0;
    for (size_t i = 0; i < 128 * 128; i += 7) {
        sl_surface surface;
        uint32_t t = s.canvas->triangle[i];
        if (t == SL_NO_INDEX) continue;
        sl_scene_surface(s.scene, t, s.canvas->w1[i], s.canvas->w2[i], sl_scene_geometric_normal(s.scene, t),
                         &surface);
        float rgb[3];
        shade_point(&shading, surface.position, surface.normal, rgb);
        assert_memory_equal(rgb, s.canvas->side[0]->texels + 4 * i, sizeof rgb);
        lit += rgb[0] > 0.0f;
    }
    assert_true(lit > 100);
    sl_free(first);
    sl_voxel_texture_destroy(texture);
    sl_voxel_lights_destroy(lights);
    sl_octree_destroy(octree);
    end_stage(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_varies_evenly_is_looked_up_exactly_but_for_the_rim),
        cmocka_unit_test(pixels_show_their_own_chart_alone),
        cmocka_unit_test(each_side_shows_its_own_light),
        cmocka_unit_test(what_is_not_finite_becomes_black),
        cmocka_unit_test(a_texel_is_what_the_octree_says_at_its_point),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
