/* A light glides past a box, and samples change surface: what that does to the irradiance from frame to
 * frame. */
#include "radiance_maps.h"

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
    uint32_t material = trace_mesh_diffuse(&mesh, 0.7f);
    trace_mesh_box(&mesh, sl_v3(0, 0, 0), sl_v3(1, 1, 1), true, material);
    trace_mesh_box(&mesh, sl_v3(0.35f, 0, 0.45f), sl_v3(0.65f, 0.5f, 0.75f), false, material);
    return trace_mesh_build(&mesh);
}

static sl_map_light light_of_frame(int frame) {
    return (sl_map_light){.source.kind = SL_SOURCE_POINT,
                          .source.position = {0.1f + 0.8f * (float)frame / (FRAMES - 1), 0.3f, 0.25f},
                          .source.colour = {1, 1, 1}};
}

static sl_radiance_map_settings sampled(int w, int m, sl_map_filter filter) {
    return (sl_radiance_map_settings){
        .samples = m, .map_size = w, .filter = filter, .weight = SL_WEIGHT_FLUX};
}

static sl_map_photons *photons_of_light(const sl_scene *scene, const sl_raster *raster,
                                        sl_radiance_map_settings settings, const sl_map_lights *lights) {
    const sl_radiance_map_options options = {.lambertian = true, .normals = true, .threads = 1};
    sl_radiance_map *map = NULL;
    sl_counters counters = {{0}};
    sl_error error;
    if (sl_radiance_map_render(scene, raster, lights, &settings, &options, &map, &counters, &error) != SL_OK)
        fail_msg("%s", error.message);
    sl_map_photons *photons = take_photons(scene, map, &settings);
    sl_radiance_map_destroy(map);
    return photons;
}

static sl_map_photons *photons_of_frame(const sl_scene *scene, const sl_raster *raster,
                                        sl_radiance_map_settings settings, int frame) {
    sl_map_light light = light_of_frame(frame);
    const sl_map_lights lights = {.count = 1, .light = &light};
    return photons_of_light(scene, raster, settings, &lights);
}

/* [frame][receiver]; of all photons together. */
typedef struct film {
    double e[FRAMES][RECEIVERS], mean;
} film;

static void shoot(const sl_scene *scene, const sl_raster *raster, sl_radiance_map_settings settings,
                  film *out) {
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

/* Of each receiver and frame, the change since the frame before: of the film, and that less the reference's;
 * of the mean irradiance. */
static flashes flashes_of(const film *f, const film *reference) {
    flashes found = {0, 0, 0, 0};
    for (int k = 0; k < FRAMES; k++) {
        for (int i = 0; i < RECEIVERS; i++) {
            double e = f->e[k][i] - reference->e[k][i];
            found.error += e * e / (FRAMES * RECEIVERS);
            if (k == 0) continue;
            double change = f->e[k][i] - f->e[k - 1][i],
                   flash = e - (f->e[k - 1][i] - reference->e[k - 1][i]);
            found.change = fmax(found.change, fabs(change));
            found.largest = fmax(found.largest, fabs(flash));
            found.root_mean_square += flash * flash / ((FRAMES - 1) * RECEIVERS);
        }
    }
    double mean = reference->mean;
    return (flashes){found.largest / mean, found.change / mean, sqrt(found.root_mean_square) / mean,
                     sqrt(found.error) / mean};
}

static void a_gliding_light_flashes_with_points_and_less_with_groups(void **state) {
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
        const sl_radiance_map_settings ways[3] = {sampled(w, m, SL_MAP_FILTER_POINT),
                                                  sampled(w, m, SL_MAP_FILTER_RADIANCE),
                                                  sampled(w, m, SL_MAP_FILTER_FLUX)};
        const char *const names[3] = {"point", "radiance", "flux"};
        flashes found[3];
        for (int i = 0; i < 3; i++) {
            shoot(scene, raster, ways[i], &films[1]);
            found[i] = flashes_of(&films[1], &films[0]);
            print_message("m = %d %-8s: largest change %.3f, flash %.3f, root mean square %.4f; error %.3f\n",
                          m, names[i], found[i].change, found[i].largest, found[i].root_mean_square,
                          found[i].error);
        }
        assert_true(found[2].root_mean_square < 0.8 * found[0].root_mean_square);
    }
    free(films);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_gliding_light_flashes_with_points_and_less_with_groups),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
