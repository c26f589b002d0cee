/* Direct light of pixels, by rays and by maps, against closed forms: lights without extent, few and many
 * emitters, sky and sun, glossy lobes. */
#define _POSIX_C_SOURCE 200809L
#include <stdlib.h>
#include <string.h>

#include <math.h>

#include "unit_test.h"
#include "base/math.h"
#include "cache/light/direct.h"
#include "rendering.h"
#include "trace_scenes.h"
#include "polygon_truth.h"

/* ---- a picture of direct light ------------------------------------------------------------ */

enum { SIZE = 72, PIXELS = SIZE * SIZE };

typedef struct {
    float rgb[3 * PIXELS];
    sl_gbuffer *gbuffer;
    sl_counters counters;
} picture;

typedef struct {
    uint32_t samples;
    uint64_t seed;
    unsigned threads;
    bool maps;
    int strip; /* rows at a time */
} options;

static picture *direct_light(const sl_scene *scene, options o) {
    picture *p = calloc(1, sizeof *p);
    sl_raster *raster = NULL;
    sl_tracer *tracer = NULL;
    sl_shadow_maps *maps = NULL;
    sl_direct *direct = NULL;
    sl_environment sky, sun;
    assert_non_null(p);
    assert_int_equal(sl_raster_create(scene, 1, &raster, NULL), SL_OK);
    tracer = tracer_of(scene);
    assert_int_equal(sl_environment_split(&scene->environment, 10.0, &sky, &sun, NULL), SL_OK);
    sl_shadow_map_settings map_settings = {
        .size = 1024, .sun = sun.present ? &sun : NULL, .threads = o.threads};
    if (o.maps)
        assert_int_equal(sl_shadow_maps_create(scene, raster, &map_settings, &maps, &p->counters, NULL),
                         SL_OK);
    sl_direct_settings settings = {.light_samples = o.samples,
                                   .seed = o.seed,
                                   .threads = o.threads,
                                   .maps = maps,
                                   .sun = sun.present ? &sun : NULL};
    assert_int_equal(sl_direct_create(scene, tracer, &settings, &direct, NULL), SL_OK);
    assert_int_equal(sl_gbuffer_create(SIZE, SIZE, &p->gbuffer, NULL), SL_OK);
    sl_frame frame = {scene->camera.right, scene->camera.up, sl_neg(scene->camera.back)};
    float top = (float)sl_tan(0.5 * (double)scene->camera.vertical_fov);
    sl_view view =
        sl_view_pyramid(&frame, scene->camera.eye, -top, top, -top, top, SIZE, SIZE, 1e-5f * scene->diagonal);
    assert_int_equal(sl_raster_gbuffer(raster, &view, 1, p->gbuffer, &p->counters, NULL), SL_OK);
    float *const planes[3] = {p->rgb, p->rgb + PIXELS, p->rgb + 2 * PIXELS};
    for (int row = 0; row < SIZE;)
        assert_int_equal(sl_direct_rows(direct, p->gbuffer, o.strip, &row, planes, &p->counters, NULL),
                         SL_OK);
    sl_direct_destroy(direct);
    sl_shadow_maps_destroy(maps);
    sl_environment_release(&sky);
    sl_environment_release(&sun);
    sl_tracer_destroy(tracer);
    sl_raster_destroy(raster);
    return p;
}

static void picture_free(picture *p) {
    sl_gbuffer_destroy(p->gbuffer);
    free(p);
}

static double mean_of(const picture *p) {
    double sum = 0.0;
    for (size_t i = 0; i < 3 * PIXELS; i++) sum += (double)p->rgb[i];
    return sum / (3.0 * PIXELS);
}

/* Root of the mean squared difference over the mean. */
static double difference(const picture *a, const picture *b) {
    double sum = 0.0;
    for (size_t i = 0; i < 3 * PIXELS; i++)
        sum += ((double)a->rgb[i] - (double)b->rgb[i]) * ((double)a->rgb[i] - (double)b->rgb[i]);
    return sqrt(sum / (3.0 * PIXELS)) / mean_of(b);
}

/* A floor of 20 x 20 at y = 0, seen from above. */
static trace_mesh a_floor(float diffuse, float specular, float exponent) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t floor = trace_mesh_material(&mesh, diffuse, specular, exponent, 0.0f, 0.0f);
    trace_mesh_quad(&mesh, sl_v3(-10, 0, -10), sl_v3(0, 0, 20), sl_v3(20, 0, 0), floor);
    mesh.has_camera =
        sl_camera_look_at(&mesh.camera, sl_v3(0.3f, 6, 4), sl_v3(0, 0, 0), sl_v3(0, 1, 0), 0.9f);
    assert_true(mesh.has_camera);
    return mesh;
}

/* ---- lights without extent ------------------------------------------------------------ */

/* E = I h / (h^2 + r^2)^(3/2), reflected rho / pi of it. */
static void a_point_light_on_a_floor_is_the_closed_form_by_rays_and_by_maps(void **state) {
    trace_mesh mesh = a_floor(0.6f, 0.0f, 0.0f);
    mesh.lights[mesh.light_count++] =
        (sl_light){.type = SL_LIGHT_POINT, .position = {0.5f, 2.0f, -0.25f}, .intensity = {7, 8, 9}};
    sl_scene *scene = trace_mesh_build(&mesh);
    for (int maps = 0; maps < 2; maps++) {
        picture *p = direct_light(scene, (options){8, 0, 2, maps, 64});
        for (size_t i = 0; i < PIXELS; i++) {
            if (p->gbuffer->material[i] == SL_NO_INDEX) continue;
            double dx = 0.5 - (double)p->gbuffer->position_x[i],
                   dz = -0.25 - (double)p->gbuffer->position_z[i];
            double squared = 4.0 + dx * dx + dz * dz,
                   truth = 0.6 / SL_PI * 8.0 * 2.0 / (squared * sqrt(squared));
            assert_true(fabs((double)p->rgb[PIXELS + i] - truth) < 1e-5 * truth);
        }
        assert_int_equal(p->counters.value[SL_COUNT_SHADOW_RAYS] > 0, !maps);
        picture_free(p);
    }
    sl_scene_destroy(scene);
}

/* ---- emitters ------------------------------------------------------------ */

/* A ceiling of side x side lamps two metres above the floor, as many triangles as two a lamp. */
static sl_scene *lamps(int side) {
    trace_mesh mesh = a_floor(0.5f, 0.0f, 0.0f);
    uint32_t lamp = trace_mesh_lamp(&mesh, 5.0f);
    float step = 3.0f / (float)side;
    for (int i = 0; i < side * side; i++) {
        sl_vec3 corner = sl_v3(-1.5f + step * (float)(i % side), 2.0f, -1.5f + step * (float)(i / side));
        /* shines downwards */
        trace_mesh_quad(&mesh, corner, sl_v3(0.6f * step, 0, 0), sl_v3(0, 0, 0.6f * step), lamp);
    }
    mesh.has_camera =
        sl_camera_look_at(&mesh.camera, sl_v3(0.2f, 1.5f, 2.5f), sl_v3(0, 0, 0), sl_v3(0, 1, 0), 0.9f);
    return trace_mesh_build(&mesh);
}

static double lamps_at(const sl_scene *scene, sl_vec3 p) {
    double sum = 0.0;
    for (size_t e = 0; e < scene->emitter_count; e++) {
        sl_vec3d corners[3];
        for (int c = 0; c < 3; c++)
            corners[c] =
                sl_to_double(sl_scene_position(scene, scene->vertex[c][scene->emitters[e].triangle]));
        sum += (double)scene->emitters[e].radiance.r *
               polygon_irradiance(sl_to_double(p), sl_v3d(0, 1, 0), corners, 3, NULL);
    }
    return sum;
}

/* Nothing is in the way: up to 256 triangles there is no noise at all, even from one sample; beyond, their
 * samples are unbiased. */
static void unoccluded_emitters_have_no_noise_and_many_have_no_bias(void **state) {
    const int sides[] = {1, 8, 12};
    for (int run = 0; run < 3; run++) {
        sl_scene *scene = lamps(sides[run]);
        assert_true(lamps_at(scene, sl_v3(0, 0, 0)) > 0.0);
        picture *p = direct_light(scene, (options){run == 2 ? 16 : 1, 3, 2, false, 64});
        double sum = 0.0, truths = 0.0;
        for (size_t i = 0; i < PIXELS; i++) {
            const sl_gbuffer *g = p->gbuffer;
            if (g->material[i] != scene->material_index[0] || g->normal_y[i] < 0.5f) continue;
            double truth =
                0.5 / SL_PI * lamps_at(scene, sl_v3(g->position_x[i], g->position_y[i], g->position_z[i]));
            if (run < 2) assert_true(fabs((double)p->rgb[i] - truth) < 1e-3 * truth + 1e-5);
            sum += (double)p->rgb[i];
            truths += truth;
        }
        print_message("%zu triangles: %+.5f\n", scene->emitter_count, sum / truths - 1.0);
        assert_true(truths > 0.0 && fabs(sum / truths - 1.0) < 0.005);
        picture_free(p);
        sl_scene_destroy(scene);
    }
}

/* Lamps, side by side in rows, half hidden by a plate so far above the floor: as wide a penumbra. */
static sl_scene *half_hidden_lamps(int rows, float height, float specular, float exponent) {
    trace_mesh mesh = a_floor(0.5f, specular, exponent);
    uint32_t lamp = trace_mesh_lamp(&mesh, 20.0f), plate = trace_mesh_diffuse(&mesh, 0.3f);
    const float side = 1.0f / (float)rows;
    for (int i = 0; i < rows * rows; i++)
        trace_mesh_quad(&mesh, sl_v3(side * (float)(i % rows) - 0.5f, 3, side * (float)(i / rows) - 0.5f),
                        sl_v3(side, 0, 0), sl_v3(0, 0, side), lamp);
    trace_mesh_box(&mesh, sl_v3(-1.0f, height, -1.0f), sl_v3(0.1f, height + 0.05f, 1.0f), false, plate);
    return trace_mesh_build(&mesh);
}

static sl_scene *half_hidden(float height, float specular, float exponent) {
    return half_hidden_lamps(1, height, specular, exponent);
}

static void few_samples_of_a_penumbra_are_those_of_many_but_for_noise(void **state) {
    sl_scene *scene = half_hidden(1.0f, 0.0f, 0.0f);
    picture *many = direct_light(scene, (options){512, 1, 2, false, 64}),
            *maps = direct_light(scene, (options){8, 2, 2, true, 64});
    double last = 1.0;
    for (uint32_t samples = 4; samples <= 64; samples *= 4) {
        picture *few = direct_light(scene, (options){samples, 2, 2, false, 64});
        double error = difference(few, many);
        print_message("%u samples: rms %.4f, bias %+.5f\n", samples, error,
                      mean_of(few) / mean_of(many) - 1.0);
        assert_true(fabs(mean_of(few) / mean_of(many) - 1.0) < 0.004);
        assert_true(error < 0.6 * last); /* it converges, whatever is smoothed */
        last = error;
        picture_free(few);
    }
    assert_true(last < 0.01);
    print_message("maps: rms %.4f, bias %+.5f\n", difference(maps, many),
                  mean_of(maps) / mean_of(many) - 1.0);
    assert_true(difference(maps, many) < 0.03 && fabs(mean_of(maps) / mean_of(many) - 1.0) < 0.004);
    picture_free(many);
    picture_free(maps);
    sl_scene_destroy(scene);
}

/* Of so many sub-frames, among eight of which 16 samples of a pixel are shared out. */
static picture *mean_of_sub_frames(sl_scene *scene, unsigned sub_frames) {
    picture *mean = calloc(1, sizeof *mean);
    assert_non_null(mean);
    scene->sub_frame.share = 8;
    for (unsigned turn = 0; turn < sub_frames; turn++) {
        scene->sub_frame.turn = turn;
        picture *p = direct_light(scene, (options){16, 2, 2, false, 64});
        for (size_t i = 0; i < 3 * PIXELS; i++) mean->rgb[i] += p->rgb[i] / (float)sub_frames;
        picture_free(p);
    }
    return mean;
}

/* Eight times as many random samples would leave .35 of the error. */
static void a_film_s_light_samples_of_a_pixel_are_spread_over_its_sub_frames(void **state) {
    for (int run = 0; run < 3; run++) {
        sl_scene *scene = half_hidden_lamps(run == 2 ? 5 : 1, 1.0f, run == 1 ? 0.4f : 0.0f, 30.0f);
        picture *many = direct_light(scene, (options){2048, 1, 2, false, 64}),
                *few = mean_of_sub_frames(scene, 4), *all = mean_of_sub_frames(scene, 32);
        print_message("%s: rms %.5f of 4, %.5f of 32, bias %+.5f\n",
                      run == 2 ? "25 lamps" : run == 1 ? "a glossy floor" : "a lamp", difference(few, many),
                      difference(all, many), mean_of(all) / mean_of(many) - 1.0);
        assert_true(difference(all, many) < 0.28 * difference(few, many));
        assert_true(fabs(mean_of(all) / mean_of(many) - 1.0) < 0.002);
        picture_free(many);
        picture_free(few);
        picture_free(all);
        sl_scene_destroy(scene);
    }
}

static void shared_out_among_many_sub_frames_a_narrow_penumbra_stays_narrow(void **state) {
    sl_scene *scene = half_hidden(0.4f, 0.0f, 0.0f);
    picture *many = direct_light(scene, (options){512, 1, 2, false, 64}),
            *mean = mean_of_sub_frames(scene, 32);
    print_message("rms %.4f, bias %+.5f\n", difference(mean, many), mean_of(mean) / mean_of(many) - 1.0);
    assert_true(difference(mean, many) < 0.01);
    picture_free(many);
    picture_free(mean);
    sl_scene_destroy(scene);
}

/* ---- window frames ------------------------------------------------------------ */

static bool faces(const sl_gbuffer *g, size_t i, sl_vec3 n) {
    return g->material[i] != SL_NO_INDEX &&
           sl_dot(sl_v3(g->geometric_x[i], g->geometric_y[i], g->geometric_z[i]), n) > 0.99f;
}

/* A lamp eight metres wide, and two posts that stand on it, 0.2 m apart; seen is the inner face of one. */
static sl_scene *posts_on_a_lamp(void) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t post = trace_mesh_diffuse(&mesh, 0.5f), lamp = trace_mesh_lamp(&mesh, 3.0f);
    trace_mesh_quad(&mesh, sl_v3(-2, 0, -0.5f), sl_v3(0, 0, 1), sl_v3(8, 0, 0), lamp); /* shines upwards */
    trace_mesh_box(&mesh, sl_v3(-0.05f, 0, -2), sl_v3(0, 0.3f, 2), false, post);
    trace_mesh_box(&mesh, sl_v3(0.2f, 0, -2), sl_v3(0.25f, 0.3f, 2), false, post);
    mesh.has_camera =
        sl_camera_look_at(&mesh.camera, sl_v3(0.18f, 0.1f, 0), sl_v3(0, 0.08f, 0), sl_v3(0, 1, 0), 0.8f);
    return trace_mesh_build(&mesh);
}

/* The part between the posts is a fortieth of the lamp, but gives nearly all of what would arrive without
 * them. */
static void between_two_posts_on_a_wide_lamp_shines_the_lamp_between_them(void **state) {
    const sl_vec3d between[4] = {{0, 0, -0.5}, {0, 0, 0.5}, {0.2, 0, 0.5}, {0.2, 0, -0.5}};
    sl_scene *scene = posts_on_a_lamp();
    for (uint32_t samples = 4; samples <= 64; samples *= 4) {
        picture *p = direct_light(scene, (options){samples, 1, 2, false, 64});
        double sum = 0.0, truths = 0.0, square = 0.0;
        size_t count = 0;
        for (size_t i = 0; i < PIXELS; i++) {
            const sl_gbuffer *g = p->gbuffer;
            if (!faces(g, i, sl_v3(1, 0, 0))) continue;
            sl_vec3d at =
                sl_v3d((double)g->position_x[i], (double)g->position_y[i], (double)g->position_z[i]);
            double truth = 0.5 / SL_PI * 3.0 * polygon_irradiance(at, sl_v3d(1, 0, 0), between, 4, NULL);
            sum += (double)p->rgb[i];
            truths += truth;
            square += ((double)p->rgb[i] / truth - 1.0) * ((double)p->rgb[i] / truth - 1.0);
            count++;
        }
        double rms = sqrt(square / (double)count), bias = sum / truths - 1.0;
        print_message("%u samples: bias %+.4f, relative rms %.4f\n", samples, bias, rms);
        assert_true(count > PIXELS / 2);
        assert_true(fabs(bias) < 0.01);
        assert_true(rms < 0.2 / sqrt((double)samples));
        picture_free(p);
    }
    sl_scene_destroy(scene);
}

/* ---- glossy lobes ------------------------------------------------------------ */

typedef struct {
    double half_width, bottom, top, exponent, bias, rms; /* the last two: at most */
    int pieces;                                          /* across and upwards: many lamps, side by side */
} lamp_case;

/* A glossy floor, and a lamp of radiance 3 in the plane z = -3 that shines towards +z; the floor hides what
 * is below it. */
static sl_scene *floor_and_lamp(const lamp_case *c) {
    trace_mesh mesh = a_floor(0.0f, 0.5f, (float)c->exponent);
    uint32_t lamp = trace_mesh_lamp(&mesh, 3.0f);
    float wide = 2.0f * (float)c->half_width / (float)c->pieces,
          high = (float)(c->top - c->bottom) / (float)c->pieces;
    for (int k = 0; k < c->pieces * c->pieces; k++) {
        sl_vec3 corner = sl_v3((float)(k % c->pieces) * wide - (float)c->half_width,
                               (float)c->bottom + (float)(k / c->pieces) * high, -3);
        trace_mesh_quad(&mesh, corner, sl_v3(wide, 0, 0), sl_v3(0, high, 0), lamp);
    }
    mesh.has_camera =
        sl_camera_look_at(&mesh.camera, sl_v3(0, 3, 3), sl_v3(0, 0, -1.5f), sl_v3(0, 1, 0), 0.7f);
    return trace_mesh_build(&mesh);
}

/* The lobe times the cosine over what of the lamp is above the floor, by a grid that is finest next to the
 * point: from its foot to the lamp's left and right end (either way where the foot lies beyond that end). */
static double lobe_of_lamp(const lamp_case *c, sl_vec3 eye, sl_vec3d at) {
    enum { GRID = 64 };
    sl_vec3d viewer = sl_subd(sl_to_double(eye), at),
             mirrored = sl_scaled(sl_v3d(-viewer.x, viewer.y, -viewer.z), 1.0 / sl_lengthd(viewer));
    double low = fmax(c->bottom, 0.0), high = c->top - low, sum = 0.0;
    for (int k = 0; k < 2 * GRID * GRID; k++) {
        double end = k < GRID * GRID ? -c->half_width : c->half_width, to_end = end - at.x,
               sign = end > 0.0 ? 1.0 : -1.0;
        double v = (double)(k / GRID % GRID) / GRID, u = (double)(k % GRID) / GRID, step = 1.0 / GRID;
        double y = low + high * (v + 0.5 * step) * (v + 0.5 * step), tall = high * step * (2.0 * v + step);
        double x = to_end * (u + 0.5 * step) * (u + 0.5 * step),
               wide = sign * to_end * step * (2.0 * u + step);
        sl_vec3d d = sl_v3d(x, y, -3.0 - at.z);
        double squared = sl_dotd(d, d), alpha = sl_dotd(d, mirrored) / sqrt(squared);
        if (alpha > 0.0) sum += pow(alpha, c->exponent) * d.y * -d.z / (squared * squared) * tall * wide;
    }
    return 3.0 * 0.5 * (c->exponent + 2.0) / (2.0 * SL_PI) * sum;
}

/* Beside a lamp as wide as the view, points spread over the lamp nearly all fall where the lobe is not. */
static void few_samples_show_a_lamp_in_a_lobe_however_near_and_wide_it_is(void **state) {
    const lamp_case cases[] = {{2.0, 0.02, 2.5, 20.0, 0.015, 0.15, 1},
                               {2.0, 0.02, 2.5, 200.0, 0.015, 0.15, 1},
                               {2.0, -4.0, 2.5, 60.0, 0.015, 0.15, 1},
                               {1e-4, 1.0, 1.0002, 20.0, 0.001, 0.001, 1},
                               {2.0, 0.02, 2.5, 60.0, 0.015, 0.15, 10}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        sl_scene *scene = floor_and_lamp(&cases[k]);
        picture *p = direct_light(scene, (options){16, 1, 2, false, 64});
        double sum = 0.0, truths = 0.0, squares = 0.0;
        size_t count = 0;
        for (size_t i = 0; i < PIXELS; i += 5) {
            const sl_gbuffer *g = p->gbuffer;
            if (!faces(g, i, sl_v3(0, 1, 0)) || g->position_z[i] < -2.99f) continue;
            double truth = lobe_of_lamp(&cases[k], scene->camera.eye,
                                        sl_v3d((double)g->position_x[i], 0.0, (double)g->position_z[i]));
            sum += (double)p->rgb[i];
            truths += truth;
            squares += ((double)p->rgb[i] - truth) * ((double)p->rgb[i] - truth);
            count++;
        }
        double bias = sum / truths - 1.0, rms = sqrt(squares / (double)count) / (truths / (double)count);
        print_message("exponent %g, lamp from %g to %g: %zu pixels, bias %+.4f, rms %.4f\n",
                      cases[k].exponent, cases[k].bottom, cases[k].top, count, bias, rms);
        assert_true(count > PIXELS / 20);
        assert_true(fabs(bias) < cases[k].bias);
        assert_true(rms < cases[k].rms);
        picture_free(p);
        sl_scene_destroy(scene);
    }
}

/* ---- sky and sun ------------------------------------------------------------ */

enum { WIDTH = 64, HEIGHT = 32 };

/* An even sky, and a sun of `texels` squared, 40 degrees up in the south. */
static sl_environment a_day(float values[3 * WIDTH * HEIGHT], int texels, float radiance) {
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        int row = i / WIDTH, column = i % WIDTH;
        bool sun = row >= 8 && row < 8 + texels && column >= 30 && column < 30 + texels;
        for (int c = 0; c < 3; c++)
            values[3 * i + c] = sun ? radiance * (1.0f - 0.2f * (float)c) : 0.5f + 0.1f * (float)c;
    }
    return (sl_environment){.present = true, .width = WIDTH, .height = HEIGHT, .texels = values};
}

/* An open plane: every pixel is the sum over the sun's texels, by maps as by rays. */
static void the_sun_on_an_open_plane_is_the_sum_of_its_texels(void **state) {
    for (int run = 0; run < 3; run++) {
        float *values = calloc(3 * WIDTH * HEIGHT, sizeof *values);
        assert_non_null(values);
        sl_environment day = a_day(values, run == 2 ? 9 : 2, 400.0f), sky, sun;
        assert_int_equal(sl_environment_split(&day, 10.0, &sky, &sun, NULL), SL_OK);
        double truth = 0.0;
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            sl_rgb radiance;
            float solid_angle;
            sl_vec3 d = sl_environment_texel(&sun, i / WIDTH, i % WIDTH, &radiance, &solid_angle);
            truth += fmax(0.0, (double)d.y) * (double)(radiance.r * solid_angle) * 0.5 / SL_PI;
        }
        trace_mesh mesh = a_floor(0.5f, 0.0f, 0.0f);
        mesh.environment = &day;
        sl_scene *scene = trace_mesh_build(&mesh);
        picture *p = direct_light(scene, (options){run == 2 ? 32 : 4, 0, 2, run == 1, 64});
        double sum = 0.0, worst = 0.0;
        size_t count = 0;
        for (size_t i = 0; i < PIXELS; i++) {
            if (p->gbuffer->material[i] == SL_NO_INDEX) continue;
            sum += (double)p->rgb[i];
            worst = fmax(worst, fabs((double)p->rgb[i] / truth - 1.0));
            count++;
        }
        print_message("sun of %d texels %s: mean %+.5f, worst %.5f\n", run == 2 ? 81 : 4,
                      run == 1 ? "by maps" : "by rays", sum / (double)count / truth - 1.0, worst);
        assert_true(fabs(sum / (double)count / truth - 1.0) < (run == 1 ? 0.02 : 0.005));
        assert_true(worst < (run == 1 ? 0.02 : 0.3));
        picture_free(p);
        sl_scene_destroy(scene);
        sl_environment_release(&sky);
        sl_environment_release(&sun);
        free(values);
    }
}

/* Sky by the records, sun by the pixels: together what the path tracer sees, neither twice. */
static void a_court_under_sky_and_sun_is_what_the_path_tracer_says(void **state) {
    float *values = calloc(3 * WIDTH * HEIGHT, sizeof *values);
    assert_non_null(values);
    sl_environment day = a_day(values, 2, 300.0f);
    trace_mesh mesh = a_floor(0.5f, 0.0f, 0.0f);
    uint32_t wall = trace_mesh_diffuse(&mesh, 0.7f),
             block = trace_mesh_material(&mesh, 0.4f, 0.3f, 10.0f, 0.0f, 0.0f);
    trace_mesh_box(&mesh, sl_v3(-3, 0, -3), sl_v3(-2.5f, 2, 3), false, wall);
    trace_mesh_box(&mesh, sl_v3(-0.5f, 0, -0.5f), sl_v3(0.8f, 1.5f, 0.6f), false, block);
    mesh.environment = &day;
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_settings path = small_settings("path", SIZE, SIZE);
    path.transport = "matched:splatting";
    path.spp = 512;
    sl_image *truth = render(scene, &path, NULL);
    for (int maps = 0; maps < 2; maps++) {
        sl_settings settings = small_settings("splatting", SIZE, SIZE);
        settings.direct = maps ? SL_DIRECT_SHADOW_MAPS : SL_DIRECT_RAYS;
        sl_image *image = render(scene, &settings, NULL);
        sl_comparison result = comparison_of(image, truth);
        print_message("%s: root of relMSE less noise %.4f, bias %+.4f\n", maps ? "maps" : "rays",
                      sqrt(fmax(0.0, result.rel_mse - result.rel_mse_noise)), result.bias);
        assert_true(sqrt(fmax(0.0, result.rel_mse - result.rel_mse_noise)) < (maps ? 0.15 : 0.075));
        assert_true(fabs(result.bias) < (maps ? 0.03 : 0.008));
        sl_image_destroy(image);
    }
    sl_image_destroy(truth);
    sl_scene_destroy(scene);
    free(values);
}

/* ---- the same bits ------------------------------------------------------------ */

static void threads_instruction_sets_and_strips_do_not_change_a_bit(void **state) {
    const char *names[3] = {"baseline", "avx2", "avx512"};
    /* penumbra and lobe, a lamp of many triangles, sun, maps, a near lamp */
    for (int kind = 0; kind < 5; kind++) {
        float *values = calloc(3 * WIDTH * HEIGHT, sizeof *values);
        assert_non_null(values);
        sl_environment day = a_day(values, 2, 300.0f);
        trace_mesh mesh = a_floor(0.5f, 0.3f, 12.0f);
        mesh.environment = &day;
        sl_scene *scene = kind == 2   ? trace_mesh_build(&mesh)
                          : kind == 1 ? lamps(5)
                          : kind == 4 ? posts_on_a_lamp()
                                      : half_hidden(1.0f, 0.3f, 40.0f);
        if (kind != 2) trace_mesh_discard(&mesh);
        picture *first = NULL;
        for (int run = 0; run < 5; run++) {
            setenv("SOFTLUX_ISA", names[run % 3], 1);
            const int strip = run < 4 ? 64 : kind == 3 ? 24 : 7;
            picture *p = direct_light(scene, (options){8, 9, run == 3 ? 3 : 1, kind == 3, strip});
            if (first) assert_memory_equal(first->rgb, p->rgb, sizeof p->rgb);
            if (first) picture_free(p);
            else first = p;
        }
        assert_true(mean_of(first) > 0.0);
        picture_free(first);
        sl_scene_destroy(scene);
        free(values);
    }
    unsetenv("SOFTLUX_ISA");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_point_light_on_a_floor_is_the_closed_form_by_rays_and_by_maps),
        cmocka_unit_test(unoccluded_emitters_have_no_noise_and_many_have_no_bias),
        cmocka_unit_test(few_samples_of_a_penumbra_are_those_of_many_but_for_noise),
        cmocka_unit_test(a_film_s_light_samples_of_a_pixel_are_spread_over_its_sub_frames),
        cmocka_unit_test(shared_out_among_many_sub_frames_a_narrow_penumbra_stays_narrow),
        cmocka_unit_test(between_two_posts_on_a_wide_lamp_shines_the_lamp_between_them),
        cmocka_unit_test(few_samples_show_a_lamp_in_a_lobe_however_near_and_wide_it_is),
        cmocka_unit_test(the_sun_on_an_open_plane_is_the_sum_of_its_texels),
        cmocka_unit_test(a_court_under_sky_and_sun_is_what_the_path_tracer_says),
        cmocka_unit_test(threads_instruction_sets_and_strips_do_not_change_a_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
