/* Indirect light as the 160-degree gather of multi-mesh caching sees it: what bounces, what does not, the
 * sky, and hard geometry and input. */
#include "multi_mesh_gather_support.h"

#include "raster/raster.h"

static bool near(double a, double b, double tolerance) { return fabs(a - b) <= tolerance; }

static trace_mesh lit_mesh(sl_vec3 light) { /* closed surfaces are rooms if there is light in them */
    trace_mesh m = trace_mesh_begin();
    m.lights[m.light_count++] = (sl_light){.type = SL_LIGHT_POINT, .position = light, .intensity = {1, 1, 1}};
    return m;
}

/* ---- the bounce's reflectance, lamps, two bounces -------------------------------------------- */

static void a_red_wall_tints_a_white_floor_though_no_camera_sees_it(void **state) {
    for (int black = 0; black < 2; black++) {
        trace_mesh m = trace_mesh_begin();
        uint32_t white = trace_mesh_diffuse(&m, 0.8f), red = trace_mesh_diffuse(&m, 0);
        m.materials[red].diffuse = black ? sl_grey(0.0f) : (sl_rgb){0.6f, 0.1f, 0.0f};
        trace_mesh_quad(&m, sl_v3(-1, -1, 0), sl_v3(2, 0, 0), sl_v3(0, 2, 0), white);
        trace_mesh_quad(&m, sl_v3(-1, -1, 0), sl_v3(0, 0, 2), sl_v3(2, 0, 0), red);
        /* the wall is behind it */
        sl_camera_look_at(&m.camera, sl_v3(0, 0, 1), sl_v3(0, 3, 0), sl_v3(0, 0, 1), 1.0f);
        m.has_camera = true;
        gathering g = even_gathering(&m, 0.2f, 3, 1.0f);
        sl_mesh_point p = face_point(g.scene, 0, 0.3f, 0.3f);
        sl_rgb e = take(&g, &p);
        if (black) assert_true(e.r == 0.0f && e.g == 0.0f && e.b == 0.0f);
        else assert_true(e.r > 0.2f && near((double)(e.g / e.r), 0.1 / 0.6, 1e-5) && e.b == 0.0f);
        gathering_destroy(&g);
    }
}

static void light_that_a_lamp_sends_is_not_gathered(void **state) {
    sl_rgb seen[2];
    for (int lit = 0; lit < 2; lit++) {
        trace_mesh m = lit_mesh(sl_v3(0, 0, 0));
        uint32_t lamp;
        trace_mesh_box(&m, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, trace_mesh_diffuse(&m, 0.5f));
        lamp = trace_mesh_material(&m, 0.3f, 0, 0, 0, lit ? 1000.0f : 0.0f);
        trace_mesh_quad(&m, sl_v3(-0.3f, -0.3f, 0.9f), sl_v3(0, 0.6f, 0), sl_v3(0.6f, 0, 0), lamp);
        gathering g = even_gathering(&m, 10.0f, 0, 1.0f);
        sl_mesh_point p = free_point(sl_v3(0.1f, 0.2f, -0.9f), sl_v3(0, 0, 1));
        seen[lit] = take(&g, &p);
        gathering_destroy(&g);
    }
    assert_memory_equal(&seen[0], &seen[1], sizeof *seen);
    assert_true(seen[0].r > 0.3f && (double)seen[0].r < 0.5 * SL_PI);
}

/* ---- pictures -------------------------------------------------------------------------------- */

/* Uneven triangles at random levels, values at random: pixels of the picture against the rasterizer's own
 * weights and the coarse mesh's values. */
static void every_pixel_is_reflectance_times_value_at_the_point_that_it_shows(void **state) {
    trace_mesh m = lit_mesh(sl_v3(0, 0, 0));
    trace_mesh_box(&m, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, trace_mesh_diffuse(&m, 0.5f));
    uint32_t light_grey = trace_mesh_diffuse(&m, 0.7f);
    trace_mesh_sphere(&m, sl_v3(0.3f, 0.2f, 0.1f), 0.4f, 8, 0.0f, false, light_grey);
    /* a board, sliced */
    trace_mesh_quad(&m, sl_v3(-0.8f, -0.5f, -0.3f), sl_v3(0, 0.15f, 0), sl_v3(1.6f, 0, 0), light_grey);
    sl_gather_settings settings = usual_settings();
    gathering g = gathering_of(trace_mesh_build(&m), 0.3f, 5, &settings);
    for (size_t v = 0; v < g.coarse->vertex_count; v++)
        sl_coarse_set(g.coarse, v, (sl_rgb){(float)(v * 37 % 101), (float)(v % 13), 5.0f});
    sl_coarse_finish(g.coarse, 1);
    sl_mesh_point p =
        free_point(sl_v3(-0.2f, 0.1f, -0.7f), sl_normalize_or(sl_v3(0.2f, -0.3f, 1), sl_v3(0, 0, 1)));
    (void)take(&g, &p);
    sl_gather_picture picture = sl_gather_last_picture(g.scratch);
    const float *planes[3] = {picture.r, picture.g, picture.b};
    const int n = picture.width;
    assert_int_equal(n, 128);
    float t = (float)sl_tan(80.0 / 180.0 * SL_PI);
    sl_frame frame = sl_known_colours_frame(p.lit.normal);
    float offset = 1e-5f * g.scene->scale;
    sl_vec3 eye = sl_mad(p.lit.position, offset, p.lit.geometric_normal);
    sl_view view = sl_view_pyramid(&frame, eye, -t, t, -t, t, n, n,
                                   1e-3f * offset);
    uint32_t *id = malloc(sizeof *id * 128 * 128), *pixel = malloc(sizeof *pixel * 128 * 128);
    float *w1 = malloc(sizeof *w1 * 128 * 128), *w2 = malloc(sizeof *w2 * 128 * 128);
    assert_true(id && pixel && w1 && w2);
    for (uint32_t i = 0; i < 128 * 128; i++) pixel[i] = i;
    sl_target target = {.width = n, .height = n, .id = id};
    assert_int_equal(sl_raster_id(g.raster, &view, 1, &target, &g.counters, NULL), SL_OK);
    sl_raster_barycentrics(g.raster, &view, 128 * 128, pixel, id, w1, w2);
    int off = 0;
    for (size_t i = 0; i < 128 * 128; i++) {
        assert_true(id[i] != SL_NO_INDEX);
        sl_rgb value = coarse_colour(g.coarse, 2 * id[i], w1[i], w2[i]);
        float diffuse = id[i] < 12 ? 0.5f : 0.7f;
        off += !near((double)planes[0][i], (double)value.r, 0.02) ||
               !near((double)planes[1][i], (double)value.g, 0.003);
        assert_true(near((double)planes[2][i], (double)(diffuse * 5.0f), 1e-5));
    }
    assert_true(off < 128 * 128 / 500); /* where vertices were snapped across an edge of the coarse mesh */
    free(id);
    free(pixel);
    free(w1);
    free(w2);
    gathering_destroy(&g);
}

/* ---- the sky --------------------------------------------------------------------------------- */

/* An outlier far below, so that there is a scene. */
static trace_mesh outlier(const sl_environment *environment) {
    trace_mesh m = trace_mesh_begin();
    m.environment = environment;
    trace_mesh_quad(&m, sl_v3(0, 0, -10), sl_v3(0.1f, 0, 0), sl_v3(0, 0.1f, 0), trace_mesh_diffuse(&m, 0.5f));
    return m;
}

static void where_nothing_is_the_sky_is_seen_or_black(void **state) {
    sl_environment sky = {.present = true, .constant = {1, 2, 3}};
    for (int present = 0; present < 2; present++) {
        trace_mesh m = outlier(present ? &sky : NULL);
        gathering g = even_gathering(&m, 1.0f, 0, 1.0f);
        sl_mesh_point p = free_point(sl_v3(0, 0, 0), sl_v3(0, 0, 1));
        sl_rgb e = take(&g, &p);
        assert_true(near((double)e.r, present * SL_PI, 1e-5) &&
                    near((double)e.b, present * 3.0 * SL_PI, 3e-5));
        gathering_destroy(&g);
    }
}

/* A shading normal tilted by alpha against the geometric one: pi (1 + cos alpha) / 2 of what lies above both
 * horizons. */
static void what_lies_below_the_surface_is_black_though_the_shading_normal_faces_it(void **state) {
    sl_environment sky = {.present = true, .constant = {1, 1, 1}};
    trace_mesh m = outlier(&sky);
    sl_gather_settings settings = usual_settings();
    settings.size = 512;
    gathering g = gathering_of(trace_mesh_build(&m), 1.0f, 0, &settings);
    set_all(&g, sl_grey(1.0f));
    for (double alpha = 0.0; alpha < 1.5; alpha += 0.3) {
        sl_mesh_point p = free_point(sl_v3(0, 0, 0), sl_v3((float)sl_sin(alpha), 0, (float)sl_cos(alpha)));
        p.lit.geometric_normal = sl_v3(0, 0, 1);
        assert_true(near((double)take(&g, &p).r, 0.5 * SL_PI * (1.0 + sl_cos(alpha)), 0.026 * SL_PI));
    }
    gathering_destroy(&g);
}

/* A sun of 2.8 degrees, one texel, seen from 40 directions: radiance x solid angle x cosine, wherever it
 * falls between pixels. */
static void the_light_of_a_small_sun_is_kept(void **state) {
    enum { WIDTH = 128, HEIGHT = 64, ROW = 20, COLUMN = 37 };
    static float texels[3 * WIDTH * HEIGHT];
    for (int c = 0; c < 3; c++) texels[3 * (ROW * WIDTH + COLUMN) + c] = 1000.0f;
    sl_environment sky = {.present = true, .width = WIDTH, .height = HEIGHT, .texels = texels};
    trace_mesh m = outlier(&sky);
    sl_gather_settings settings = usual_settings();
    gathering g = gathering_of(trace_mesh_build(&m), 1.0f, 0, &settings);
    sl_rgb radiance;
    float solid_angle;
    sl_vec3 sun = sl_environment_texel(&g.scene->environment, ROW, COLUMN, &radiance, &solid_angle);
    assert_true(near((double)radiance.r, 1000.0, 1e-3));
    double mean = 0.0;
    for (int k = 0; k < 40; k++) {
        double angle = 0.025 * k, turn = 0.7 * k;
        sl_frame f = sl_frame_from_normal(sun);
        sl_vec3 n = sl_frame_to_world(&f, sl_v3((float)(sl_sin(angle) * sl_cos(turn)),
                                                (float)(sl_sin(angle) * sl_sin(turn)), (float)sl_cos(angle)));
        sl_mesh_point p = free_point(sl_v3(0, 0, 0), n);
        double ratio = (double)take(&g, &p).r / (1000.0 * (double)solid_angle * sl_cos(angle)) * 0.9755;
        assert_true(near(ratio, 1.0, 0.2));
        mean += ratio / 40.0;
    }
    assert_true(near(mean, 1.0, 0.04));
    gathering_destroy(&g);
}

/* ---- hard geometry --------------------------------------------------------------------------- */

/* A grid of small squares far from the origin: neighbours in the same plane must not rise above the horizon.
 */
static void a_flat_surface_does_not_light_itself(void **state) {
    trace_mesh m = trace_mesh_begin();
    uint32_t grey = trace_mesh_diffuse(&m, 0.5f);
    sl_frame f = sl_frame_from_normal(sl_normalize_or(sl_v3(0.3f, -0.5f, 0.8f), sl_v3(0, 0, 1)));
    for (int i = 0; i < 20; i++) {
        for (int j = 0; j < 20; j++) {
            sl_vec3 corner = sl_mad(sl_mad(sl_v3(30, 20, 10), 0.1f * (float)i, f.x), 0.1f * (float)j, f.y);
            trace_mesh_quad(&m, corner, sl_scale(f.x, 0.1f), sl_scale(f.y, 0.1f), grey);
        }
    }
    gathering g = even_gathering(&m, 10.0f, 0, 1.0f);
    for (uint32_t t = 0; t < 800; t += 17) {
        for (int k = 0; k < 3; k++) {
            const float w[3][2] = {{0.3f, 0.3f}, {0, 0}, {0.5f, 0}};
            sl_mesh_point p = face_point(g.scene, 2 * t, w[k][0], w[k][1]);
            if (k) p.lit.triangle = SL_NO_INDEX; /* as where several meet */
            assert_true(take(&g, &p).r < 1e-6f);
        }
    }
    gathering_destroy(&g);
}

/* A floor that ends at a wall: at their common edge the wall fills half of the hemisphere, whichever face the
 * point is said to be of. */
static void on_a_crease_the_wall_beyond_is_seen_from_within(void **state) {
    trace_mesh m = trace_mesh_begin();
    uint32_t grey = trace_mesh_diffuse(&m, 0.5f);
    trace_mesh_quad(&m, sl_v3(0, -50, 0), sl_v3(50, 0, 0), sl_v3(0, 100, 0), grey);
    trace_mesh_quad(&m, sl_v3(0, -50, 0), sl_v3(0, 100, 0), sl_v3(0, 0, 50), grey);
    gathering g = even_gathering(&m, 1e3f, 0, 2.0f);
    for (uint32_t face = 0; face < 8; face += 2) {
        /* those corners that lie inside the edge between floor and wall: moved to its middle */
        for (int k = 0; k < 3; k++) {
            sl_mesh_point p = face_point(g.scene, face, 0.0f, 0.0f);
            p.lit.position = sl_v3(0, 3.0f * (float)k, 0);
            p.lit.triangle = k ? SL_NO_INDEX : face / 2;
            assert_true(near((double)take(&g, &p).r, 0.5 * SL_PI, 0.01 * SL_PI));
        }
    }
    gathering_destroy(&g);
}

/* From any vertex of a ball's outside the whole sky is seen and nothing of the ball, from any of a hollow's
 * inside nothing but it. */
static void at_vertices_bulges_see_the_sky_and_hollows_see_themselves(void **state) {
    sl_environment sky = {.present = true, .constant = {1, 0, 0}};
    for (int hollow = 0; hollow < 2; hollow++) {
        trace_mesh m = hollow ? lit_mesh(sl_v3(0, 0, 0)) : trace_mesh_begin();
        m.environment = &sky;
        uint32_t green = trace_mesh_diffuse(&m, 0);
        m.materials[green].diffuse = (sl_rgb){0, 1, 0};
        trace_mesh_sphere(&m, sl_v3(0, 0, 0), 1.0f, 10, 0.0f, hollow == 1, green);
        gathering g = even_gathering(&m, 1e3f, 0, 1.0f);
        for (uint32_t t = 0; t < g.scene->triangle_count; t += 7) {
            sl_mesh_point p = face_point(g.scene, 2 * t, 0, 0);
            p.lit.normal = p.lit.geometric_normal =
                sl_normalize_or(hollow ? sl_neg(p.lit.position) : p.lit.position, sl_v3(0, 0, 1));
            p.lit.triangle = SL_NO_INDEX;
            sl_rgb e = take(&g, &p);
            assert_true(near((double)(hollow ? e.g : e.r), SL_PI, 0.002));
            assert_true((hollow ? e.r : e.g) < 0.002f);
        }
        gathering_destroy(&g);
    }
}

/* ---- hard input ------------------------------------------------------------------------------ */

static void points_that_are_no_numbers_get_no_light_and_are_counted(void **state) {
    trace_mesh m = lit_mesh(sl_v3(0, 0, 0));
    trace_mesh_box(&m, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, trace_mesh_diffuse(&m, 0.5f));
    gathering g = even_gathering(&m, 1.0f, 2, 1.0f);
    const sl_mesh_point good = face_point(g.scene, 0, 0.3f, 0.3f);
    sl_mesh_point bad[5] = {good, good, good, good, good};
    bad[0].lit.position.x = NAN;
    bad[1].lit.position.z = INFINITY;
    bad[2].lit.normal = bad[2].lit.geometric_normal = sl_v3(0, 0, 0);
    bad[3].lit.normal = sl_v3(NAN, 0, 1); /* the geometric one stands in */
    bad[4].lit.position = sl_v3(1e30f, 1e30f, 1e30f);
    for (int k = 0; k < 5; k++) {
        sl_rgb e = take(&g, &bad[k]);
        assert_true(sl_rgb_is_finite(e) && e.r >= 0.0f);
        if (k < 3) assert_true(e.r == 0.0f);
        if (k == 3) assert_true(near((double)e.r, 0.5 * SL_PI, 1e-4));
    }
    assert_int_equal(g.counters.value[SL_COUNT_NONFINITE], 3);
    set_all(&g, sl_grey(3e38f));
    assert_true(sl_rgb_is_finite(take(&g, &good)));
    gathering_destroy(&g);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_red_wall_tints_a_white_floor_though_no_camera_sees_it),
        cmocka_unit_test(light_that_a_lamp_sends_is_not_gathered),
        cmocka_unit_test(every_pixel_is_reflectance_times_value_at_the_point_that_it_shows),
        cmocka_unit_test(where_nothing_is_the_sky_is_seen_or_black),
        cmocka_unit_test(what_lies_below_the_surface_is_black_though_the_shading_normal_faces_it),
        cmocka_unit_test(the_light_of_a_small_sun_is_kept),
        cmocka_unit_test(a_flat_surface_does_not_light_itself),
        cmocka_unit_test(on_a_crease_the_wall_beyond_is_seen_from_within),
        cmocka_unit_test(at_vertices_bulges_see_the_sky_and_hollows_see_themselves),
        cmocka_unit_test(points_that_are_no_numbers_get_no_light_and_are_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
