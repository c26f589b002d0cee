/* A light glides past a box, and samples change surface: what that does to the irradiance from frame to frame. */
#include "radiance_maps.h"

#include "cache/direct_radiance/steady.h"

enum { FRAMES = 50, RECEIVERS = 96 };

typedef struct receivers {
    sl_vec3d x[RECEIVERS], n[RECEIVERS];
} receivers;

/* 4 x 4 points on each wall. */
static receivers on_the_walls(void) {
    receivers r;
    for (int i = 0; i < RECEIVERS; i++) {
        int face = i / 16, axis = face / 2;
        double p[3], n[3] = {0, 0, 0};
        p[axis] = face % 2;
        p[(axis + 1) % 3] = (i % 4 + 0.5) / 4;
        p[(axis + 2) % 3] = (i / 4 % 4 + 0.5) / 4;
        n[axis] = face % 2 ? -1 : 1;
        r.x[i] = sl_v3d(p[0], p[1], p[2]);
        r.n[i] = sl_v3d(n[0], n[1], n[2]);
    }
    return r;
}

static sl_scene *room_with_box(void) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t material = trace_mesh_material(&mesh, 0.7f, 0, 0, 0, 0);
    trace_mesh_box(&mesh, sl_v3(0, 0, 0), sl_v3(1, 1, 1), true, material);
    trace_mesh_box(&mesh, sl_v3(0.35f, 0, 0.45f), sl_v3(0.65f, 0.5f, 0.75f), false, material);
    return trace_mesh_build(&mesh);
}

static sl_map_light light_of_frame(int frame) {
    return (sl_map_light){.kind = SL_MAP_LIGHT_POINT, .position = {0.1f + 0.8f * (float)frame / (FRAMES - 1), 0.3f, 0.25f},
                          .intensity = {1, 1, 1}};
}

static sl_radiance_map_settings sampled(int w, int m, sl_map_filter filter, bool steady) {
    return (sl_radiance_map_settings){.samples = m, .map_size = w, .filter = filter, .weight = SL_WEIGHT_FLUX, .steady_samples = steady};
}

static sl_map_photons *photons_of_light(const sl_scene *scene, const sl_raster *raster, sl_radiance_map_settings settings,
                                        const sl_map_lights *lights) {
    const sl_radiance_map_options options = {.lambertian = true, .normals = true, .threads = 1};
    sl_radiance_map *map = NULL;
    sl_counters counters = {{0}};
    sl_error error;
    if (sl_radiance_map_render(scene, raster, lights, &settings, &options, &map, &counters, &error) != SL_OK) fail_msg("%s", error.message);
    sl_map_photons *photons = take_photons(scene, map, &settings);
    sl_radiance_map_destroy(map);
    return photons;
}

static sl_map_photons *photons_of_frame(const sl_scene *scene, const sl_raster *raster, sl_radiance_map_settings settings, int frame) {
    sl_map_light light = light_of_frame(frame);
    const sl_map_lights lights = {.count = 1, .light = &light};
    return photons_of_light(scene, raster, settings, &lights);
}

/* [frame][receiver]; of all photons together. */
typedef struct film {
    double e[FRAMES][RECEIVERS], mean;
} film;

static void shoot(const sl_scene *scene, const sl_raster *raster, sl_radiance_map_settings settings, film *out) {
    receivers r = on_the_walls();
    out->mean = 0;
    for (int k = 0; k < FRAMES; k++) {
        sl_map_photons *photons = photons_of_frame(scene, raster, settings, k);
        for (int i = 0; i < RECEIVERS; i++) {
            out->e[k][i] = flux_irradiance(photons, r.x[i], r.n[i]);
            out->mean += out->e[k][i] / (FRAMES * RECEIVERS);
        }
        sl_map_photons_destroy(photons);
    }
}

typedef struct flashes {
    double largest, change, root_mean_square, error;
} flashes;

/* Of each receiver and frame, the change since the frame before: of the film, and that less the reference's; of the mean irradiance. */
static flashes flashes_of(const film *f, const film *reference) {
    flashes found = {0, 0, 0, 0};
    for (int k = 0; k < FRAMES; k++) {
        for (int i = 0; i < RECEIVERS; i++) {
            double e = f->e[k][i] - reference->e[k][i];
            found.error += e * e / (FRAMES * RECEIVERS);
            if (k == 0) continue;
            double change = f->e[k][i] - f->e[k - 1][i], flash = e - (f->e[k - 1][i] - reference->e[k - 1][i]);
            found.change = fmax(found.change, fabs(change));
            found.largest = fmax(found.largest, fabs(flash));
            found.root_mean_square += flash * flash / ((FRAMES - 1) * RECEIVERS);
        }
    }
    double mean = reference->mean;
    return (flashes){found.largest / mean, found.change / mean, sqrt(found.root_mean_square) / mean, sqrt(found.error) / mean};
}

static void a_gliding_light_flashes_with_points_less_with_groups_and_least_with_steady_samples(void **state) {
    (void)state;
    sl_scene *scene = room_with_box();
    sl_raster *raster;
    assert_int_equal(sl_raster_create(scene, 1, &raster, NULL), SL_OK);
    film *films = calloc(2, sizeof *films);
    assert_non_null(films);
    shoot(scene, raster, sampled(48, 48, SL_MAP_FILTER_POINT, false), &films[0]);
    double natural = flashes_of(&films[0], &films[0]).change;
    print_message("largest change of 13,824 photons: %.3f of the mean irradiance\n", natural);
    for (int m = 3; m <= 8; m = m == 3 ? 4 : 2 * m) {
        int w = m == 3 ? 18 : 16;
        const sl_radiance_map_settings ways[4] = {sampled(w, m, SL_MAP_FILTER_POINT, false), sampled(w, m, SL_MAP_FILTER_RADIANCE, false),
                                                  sampled(w, m, SL_MAP_FILTER_FLUX, false), sampled(w, m, SL_MAP_FILTER_FLUX, true)};
        const char *const names[4] = {"point", "radiance", "flux", "steady"};
        flashes found[4];
        for (int i = 0; i < 4; i++) {
            shoot(scene, raster, ways[i], &films[1]);
            found[i] = flashes_of(&films[1], &films[0]);
            print_message("m = %d %-8s: largest change %.3f, flash %.3f, root mean square %.4f; error %.3f\n", m, names[i],
                          found[i].change, found[i].largest, found[i].root_mean_square, found[i].error);
        }
        assert_true(found[2].root_mean_square < 0.8 * found[0].root_mean_square);
        assert_true(found[3].root_mean_square < 0.6 * found[2].root_mean_square);
        assert_true(found[3].largest < 0.6 * found[0].largest && found[3].largest < found[2].largest);
        assert_true(found[3].change < 1.5 * natural);
    }
    free(films);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

static void a_frame_alone_is_the_frame_of_a_sequence(void **state) {
    (void)state;
    sl_scene *scene = room_with_box();
    sl_raster *raster;
    assert_int_equal(sl_raster_create(scene, 1, &raster, NULL), SL_OK);
    sl_radiance_map_settings settings = sampled(16, 4, SL_MAP_FILTER_FLUX, true);
    sl_map_photons *alone = photons_of_frame(scene, raster, settings, 7);
    for (int k = 0; k <= 7; k++) {
        sl_map_photons *photons = photons_of_frame(scene, raster, settings, k);
        if (k == 7) {
            assert_int_equal(photons->count, alone->count);
            assert_memory_equal(photons->photon, alone->photon, alone->count * sizeof *alone->photon);
        }
        sl_map_photons_destroy(photons);
    }
    sl_map_photons_destroy(alone);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

/* Of every kind of light, the pictures still hold all of its flux, and photons all that meets a closed room. */
static void steady_pictures_hold_all_the_light(void **state) {
    (void)state;
    sl_scene *scene = room_with_box();
    sl_raster *raster;
    assert_int_equal(sl_raster_create(scene, 1, &raster, NULL), SL_OK);
    sl_map_light lights[4] = {light_of_frame(3), light_of_frame(20), light_of_frame(20), light_of_frame(20)};
    lights[1].kind = SL_MAP_LIGHT_SPOT;
    lights[2].kind = SL_MAP_LIGHT_AREA;
    lights[3].kind = SL_MAP_LIGHT_DIRECTIONAL;
    const double exact[4] = {4.0, 2.0 * (1.0 - 0.5 * (0.8 + 0.6)), 1.0,
                             1.3 / sqrt(0.91) / SL_PI}; /* Phi / pi: I = 1, or E = 1 on the cube's projection */
    for (int k = 0; k < 4; k++) {
        lights[k].direction = sl_normalize_or(sl_v3(0.3f, -0.9f, 0.1f), sl_v3(0, -1, 0));
        lights[k].cos_inner = 0.8f;
        lights[k].cos_outer = 0.6f;
        lights[k].area = 0.01f;
        const sl_map_lights one = {.count = 1, .light = &lights[k]};
        double sum[2] = {0, 0};
        for (int steady = 0; steady < 2; steady++) {
            sl_map_photons *photons = photons_of_light(scene, raster, sampled(16, 4, SL_MAP_FILTER_FLUX, steady), &one);
            for (size_t j = 0; j < photons->count; j++) sum[steady] += (double)photons->photon[j].flux.g / 0.7;
            if (k == 0) assert_true(photons->samples_of_light[0] == 6 * 16);
            sl_map_photons_destroy(photons);
        }
        print_message("light of kind %d: %.4f, steady %.4f\n", k, sum[0], sum[1]);
        assert_true(fabs(sum[1] / sum[0] - 1) < 0.03);
        assert_true(fabs(sum[1] / exact[k] - 1) < 0.02);
    }
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

static void assert_right_handed(sl_frame f) {
    assert_true(fabsf(sl_dot(f.x, f.y)) < 1e-6f && fabsf(sl_dot(f.y, f.z)) < 1e-6f && fabsf(sl_dot(f.z, f.x)) < 1e-6f);
    sl_vec3 z = sl_sub(sl_cross(f.x, f.y), f.z);
    assert_true(sl_length(z) < 1e-6f && fabsf(sl_length(f.x) - 1) < 1e-6f);
}

static void turned_pictures_still_see_all_directions_once(void **state) {
    (void)state;
    for (int i = 0; i < 2000; i++) {
        double y = -1 + 2 * (i + 0.5) / 2000, r = sqrt(1 - y * y), turn = 2 * SL_PI * i * 0.618034;
        sl_vec3 d = sl_to_float(sl_v3d(r * sl_cos(turn), y, r * sl_sin(turn)));
        int faces = 0;
        for (int f = 0; f < 6; f++) {
            sl_vec3 local;
            sl_frame frame = sl_cube_face_frame(f), turned = sl_steady_cube_frame(frame);
            local = sl_frame_to_local(&turned, d);
            faces += local.z > 0 && fabsf(local.x) < local.z && fabsf(local.y) < local.z;
            sl_frame round = {turned.x, sl_cross(turned.z, turned.x), turned.z};
            assert_right_handed(round);
            sl_vec3 kept = sl_sub(sl_steady_roll(round).z, round.z);
            assert_true(sl_length(kept) == 0);
            assert_right_handed(sl_steady_roll(round));
        }
        assert_int_equal(faces, 1);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_gliding_light_flashes_with_points_less_with_groups_and_least_with_steady_samples),
        cmocka_unit_test(a_frame_alone_is_the_frame_of_a_sequence),
        cmocka_unit_test(steady_pictures_hold_all_the_light),
        cmocka_unit_test(turned_pictures_still_see_all_directions_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
