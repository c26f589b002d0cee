/* A light glides past a box, and samples change surface: what that does to the irradiance from frame to frame (section 2.7). */
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

/* One way to take photons. */
typedef struct sampling {
    int w, m;
    sl_radiance_map_settings settings;
} sampling;

static sampling sampled(int w, int m, sl_map_filter filter) { return (sampling){w, m, {.filter = filter}}; }

/* With what steady samples ask of the map: turned axes and more texels. */
static sampling steadily(int w, int m) {
    return (sampling){sl_steady_map_size(w), m, {.filter = SL_MAP_FILTER_FLUX, .steady_samples = true}};
}

static sl_map_photons *photons_of_frame(const sl_scene *scene, const sl_raster *raster, const sampling *s, int frame) {
    hand_map *h = hand_map_begin(light_of_frame(frame), 6, s->w, s->m);
    for (int f = 0; f < 6 && s->settings.steady_samples; f++) {
        h->face[f].frame = sl_steady_cube_frame(h->face[f].frame);
        h->face[f].view = sl_view_pyramid(&h->face[f].frame, h->light.position, -1, 1, -1, 1, s->w, s->w, 1e-4f);
    }
    hand_map_render(h, raster);
    sl_map_photons *photons = take_photons(scene, &h->map, &s->settings);
    hand_map_end(h);
    return photons;
}

/* [frame][receiver]; of all photons together. */
typedef struct film {
    double e[FRAMES][RECEIVERS], mean;
} film;

static void shoot(const sl_scene *scene, const sl_raster *raster, sampling s, film *out) {
    receivers r = on_the_walls();
    out->mean = 0;
    for (int k = 0; k < FRAMES; k++) {
        sl_map_photons *photons = photons_of_frame(scene, raster, &s, k);
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
    shoot(scene, raster, sampled(48, 48, SL_MAP_FILTER_POINT), &films[0]);
    double natural = flashes_of(&films[0], &films[0]).change;
    print_message("largest change of 13,824 photons: %.3f of the mean irradiance\n", natural);
    for (int m = 3; m <= 8; m = m == 3 ? 4 : 2 * m) {
        int w = m == 3 ? 18 : 16;
        const sampling ways[4] = {sampled(w, m, SL_MAP_FILTER_POINT), sampled(w, m, SL_MAP_FILTER_RADIANCE),
                                  sampled(w, m, SL_MAP_FILTER_FLUX), steadily(w, m)};
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
    sampling s = steadily(16, 4);
    sl_map_photons *alone = photons_of_frame(scene, raster, &s, 7);
    for (int k = 0; k <= 7; k++) {
        sl_map_photons *photons = photons_of_frame(scene, raster, &s, k);
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
        cmocka_unit_test(turned_pictures_still_see_all_directions_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
