/* What is resolved from ids: positions, normals, Gouraud colours. */
#include "raster_support.h"

enum { WIDTH = 160, HEIGHT = 120, PIXELS = WIDTH * HEIGHT };

typedef struct fixture {
    sl_scene *scene;
    sl_raster *raster;
    sl_view view[4];
    sl_gbuffer *gbuffer[4];
} fixture;

static double project(const float row[4], sl_vec3d q) {
    return (double)row[0] * q.x + (double)row[1] * q.y + (double)row[2] * q.z + (double)row[3];
}

static void position_reprojects_to_its_pixel(void **state) {
    const fixture *f = *state;
    for (int n = 0; n < 4; n++) {
        const sl_gbuffer *g = f->gbuffer[n];
        const sl_view *view = &f->view[n];
        double worst = 0.0;
        for (int i = 0; i < PIXELS; i++) {
            if (g->id[i] == SL_NO_INDEX) continue;
            sl_vec3d q =
                sl_subd(sl_v3d((double)g->position_x[i], (double)g->position_y[i], (double)g->position_z[i]),
                        sl_to_double(view->origin));
            double w = project(view->clip[3], q);
            double x = (project(view->clip[0], q) / w + 1.0) * 0.5 * WIDTH - 0.5;
            double y = (project(view->clip[1], q) / w + 1.0) * 0.5 * HEIGHT - 0.5;
            double off = fmax(fabs(x - i % WIDTH), fabs(y - i / WIDTH)); /* NaN would fail below */
            assert_true(w > 0.0 && off < 0.01);
            worst = fmax(worst, off);
        }
        assert_true(worst > 0.0);
    }
}

static void gouraud_of_an_affine_function_equals_its_value_at_the_position(void **state) {
    const fixture *f = *state;
    enum { CHANNELS = 3 };
    const float slope[CHANNELS][4] = {{1, 0, 0, 0}, {-0.5f, 0.25f, 2, 3}, {0.1f, -1, 0.7f, 1}};
    float *attributes = malloc(f->scene->vertex_count * CHANNELS * sizeof *attributes);
    float *out = malloc((size_t)PIXELS * CHANNELS * sizeof *out);
    assert_true(attributes && out);
    for (uint32_t v = 0; v < f->scene->vertex_count; v++) {
        sl_vec3 p = sl_scene_position(f->scene, v);
        for (size_t k = 0; k < CHANNELS; k++) {
            attributes[v * CHANNELS + k] =
                slope[k][0] * p.x + slope[k][1] * p.y + slope[k][2] * p.z + slope[k][3];
        }
    }
    for (int n = 0; n < 4; n++) {
        const sl_gbuffer *g = f->gbuffer[n];
        sl_counters counters = {{0}};
        sl_raster_gouraud(f->raster, &f->view[n], 2, g->id,
                          &(sl_gouraud_pass){.channels = CHANNELS, .vertex = attributes, .out = out},
                          &counters);
        uint64_t seen = 0;
        for (int i = 0; i < PIXELS; i++) {
            seen += g->id[i] != SL_NO_INDEX;
            for (int k = 0; k < CHANNELS; k++) {
                float expected = slope[k][0] * g->position_x[i] + slope[k][1] * g->position_y[i] +
                                 slope[k][2] * g->position_z[i] + slope[k][3];
                if (g->id[i] == SL_NO_INDEX) expected = 0.0f;
                assert_true(fabsf(out[k * PIXELS + i] - expected) < 1e-5f);
            }
        }
        assert_int_equal(counters.value[SL_COUNT_FRAGMENTS_SHADED], seen);
    }
    free(attributes);
    free(out);
}

static void triangle_seen_edge_on_has_finite_weights(void **state) {
    (void)state;
    const float xyz[9] = {0, 0, 1, 0, 0, 2, 0, 0.0f, 3.5f};
    const float flat[9] = {-1, 0, 1, 1, 0, 1, 0, 0, 3};
    sl_frame frame = {sl_v3(1, 0, 0), sl_v3(0, 1, 0), sl_v3(0, 0, 1)};
    sl_view view = sl_view_pyramid(&frame, sl_v3(0, 0, 0), -1, 1, -1, 1, 9, 9, 1e-3f);
    const float *cases[2] = {xyz, flat};
    for (int c = 0; c < 2; c++) {
        sl_scene *scene = scene_of_triangles(flat, 1);
        memcpy(scene->position_x, (const float[3]){cases[c][0], cases[c][3], cases[c][6]}, 12);
        memcpy(scene->position_y, (const float[3]){cases[c][1], cases[c][4], cases[c][7]}, 12);
        memcpy(scene->position_z, (const float[3]){cases[c][2], cases[c][5], cases[c][8]}, 12);
        sl_raster *raster = raster_of(scene);
        for (uint32_t i = 0; i < 81; i++) {
            float w1, w2;
            uint32_t zero = 0;
            sl_raster_barycentrics(raster, &view, 1, &i, &zero, &w1, &w2);
            assert_true(w1 >= 0.0f && w2 >= 0.0f && w1 + w2 <= 1.0000002f);
        }
        sl_raster_destroy(raster);
        sl_scene_destroy(scene);
    }
}

static void flip_turns_rows_over(void **state) {
    (void)state;
    const float plane[6] = {0, 1, 2, 3, 4, 5};
    float image[6];
    sl_raster_flip(plane, 2, 3, image);
    const float expected[6] = {4, 5, 2, 3, 0, 1};
    assert_memory_equal(image, expected, sizeof image);
}

static int set_up(void **state) {
    fixture *f = calloc(1, sizeof *f);
    f->scene = furnished_room(60, 6);
    f->raster = raster_of(f->scene);
    sl_camera camera;
    assert_true(sl_camera_look_at(&camera, sl_v3(0.5f, 1.6f, 0.4f), sl_v3(2, 1, 2.5f), sl_v3(0, 1, 0), 1.0f));
    f->view[0] = sl_view_camera(&camera, WIDTH, HEIGHT, 0.01f, 20.0f);
    assert_true(sl_camera_look_at(&camera, sl_v3(2, 1.5f, 7), sl_v3(2, 1, 2.5f), sl_v3(0, 1, 0), 1.4f));
    /* near plane inside the room, background around */
    f->view[1] = sl_view_camera(&camera, WIDTH, HEIGHT, 2.5f, 100.0f);
    sl_frame frame = sl_frame_from_normal(sl_v3(0, 1, 0));
    f->view[2] = sl_view_pyramid(&frame, sl_v3(1, 1e-4f, 2), -2.7474774f, 2.7474774f, -2.7474774f, 2.7474774f,
                                 WIDTH, HEIGHT, 1e-4f);
    f->view[3] = sl_view_cube_face(sl_v3(2, 1.5f, 2.5f), 3, WIDTH, 1e-3f);
    f->view[3].height = HEIGHT;
    for (int n = 0; n < 4; n++) {
        sl_counters counters = {{0}};
        assert_int_equal(sl_gbuffer_create(WIDTH, HEIGHT, &f->gbuffer[n], NULL), SL_OK);
        assert_int_equal(sl_raster_gbuffer(f->raster, &f->view[n], 2, f->gbuffer[n], &counters, NULL), SL_OK);
        assert_true(counters.value[SL_COUNT_FRAGMENTS_SHADED] > PIXELS / 4);
    }
    *state = f;
    return 0;
}

static int tear_down(void **state) {
    fixture *f = *state;
    for (int n = 0; n < 4; n++) sl_gbuffer_destroy(f->gbuffer[n]);
    sl_raster_destroy(f->raster);
    sl_scene_destroy(f->scene);
    free(f);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(position_reprojects_to_its_pixel),
        cmocka_unit_test(gouraud_of_an_affine_function_equals_its_value_at_the_position),
        cmocka_unit_test(triangle_seen_edge_on_has_finite_weights),
        cmocka_unit_test(flip_turns_rows_over),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
