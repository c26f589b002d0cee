/* Samples that look at all texels of their blocks: filtered radiance and flux groups. */
#include "radiance_maps.h"

static sl_map_photons *photons_by(sl_map_filter filter, const sl_scene *scene, const hand_map *h) {
    const sl_radiance_map_settings settings = {.filter = filter, .weight = SL_WEIGHT_FLUX};
    return take_photons(scene, &h->map, &settings);
}

/* A room of side 2 with a table of one object with it: walls of reflectance `walls`, floor and table 0.8. */
static sl_scene *room_with_table(float walls) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t wall = trace_mesh_diffuse(&mesh, walls), floor = trace_mesh_diffuse(&mesh, 0.8f);
    trace_mesh_box(&mesh, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, wall);
    trace_mesh_quad(&mesh, sl_v3(-1, -0.99f, 1), sl_v3(2, 0, 0), sl_v3(0, 0, -2), floor);
    trace_mesh_quad(&mesh, sl_v3(-0.3f, -0.4f, 0.3f), sl_v3(0.6f, 0, 0), sl_v3(0, 0, -0.6f), floor);
    return trace_mesh_build(&mesh);
}

static void sum_flux(const sl_map_photons *photons, double sum[3]) {
    sum[0] = sum[1] = sum[2] = 0;
    for (size_t j = 0; j < photons->count; j++) {
        sum[0] += (double)photons->photon[j].flux.r;
        sum[1] += (double)photons->photon[j].flux.g;
        sum[2] += (double)photons->photon[j].flux.b;
    }
}

/* The sum over all texels: every texel a photon. */
static void sum_flux_of_texels(const sl_scene *scene, sl_map_light light, int w, double sum[3]) {
    hand_map *h = hand_map_of(scene, light, w, w, true);
    sl_map_photons *photons = photons_by(SL_MAP_FILTER_POINT, scene, h);
    sum_flux(photons, sum);
    destroy_photons(photons, h);
}

/* ---- flux ---- */

static void grouping_leaves_the_sum_of_flux_as_it_is(void **state) {
    sl_scene *scene = room_with_table(0.3f);
    sl_map_light light = hand_light(sl_v3(0.2f, 0.4f, 0.1f));
    double texels[3], sum[3];
    sum_flux_of_texels(scene, light, 24, texels);
    for (int m = 1; m <= 24; m *= m == 3 ? 4 : m == 1 ? 3 : 2) {
        hand_map *h = hand_map_of(scene, light, 24, m, true);
        sl_map_photons *photons = photons_by(SL_MAP_FILTER_FLUX, scene, h);
        sum_flux(photons, sum);
        for (int c = 0; c < 3; c++) assert_true(fabs(sum[c] / texels[c] - 1) < 1e-6);
        assert_true(photons->count <= 4 * 6 * (size_t)(m * m));
        destroy_photons(photons, h);
    }
    sl_scene_destroy(scene);
}

/* One face of 4 x 4 texels as one block; left half of it one surface, right half another. */
static sl_map_photons *photons_of_two(const sl_scene *scene, sl_vec3 left, sl_vec3 left_normal, sl_vec3 right,
                                      sl_vec3 right_normal) {
    hand_map *h = hand_map_begin(hand_light(sl_v3(0, 0, 0)), 6, 4, 1);
    for (size_t i = 0; i < 16; i++) {
        sl_vec3 nudge = sl_v3(0, 0.01f * (float)(i / 4), 0);
        bool first = i % 4 < 2;
        hand_texel(h, i, 0, sl_add(first ? left : right, nudge), first ? left_normal : right_normal,
                   sl_grey(0.5f));
    }
    sl_map_photons *photons = photons_by(SL_MAP_FILTER_FLUX, scene, h);
    hand_map_end(h);
    return photons;
}

static void a_block_across_an_edge_has_a_photon_on_each_side(void **state) {
    sl_scene *scene = room_with_table(0.5f);
    sl_vec3 wall = sl_v3(1, 0, -0.2f), other = sl_v3(0.9f, 0, 0.3f);
    sl_map_photons *photons = photons_of_two(scene, wall, sl_v3(-1, 0, 0), other, sl_v3(0, 0, -1));
    assert_int_equal(photons->count, 2);
    assert_true(fabsf(photons->photon[0].position.x - 1) < 1e-6f && photons->photon[0].normal.x == -1.0f);
    assert_true(fabsf(photons->photon[1].position.z - 0.3f) < 1e-6f && photons->photon[1].normal.z == -1.0f);
    sl_map_photons_destroy(photons);
    sl_scene_destroy(scene);
}

static void a_table_and_the_floor_below_it_are_two_photons(void **state) {
    sl_scene *scene = room_with_table(0.5f);
    sl_vec3 near = sl_v3(0.5f, 0, -0.1f), far = sl_v3(1, 0, 0.2f), normal = sl_v3(-1, 0, 0);
    sl_map_photons *photons = photons_of_two(scene, near, normal, far, normal);
    assert_int_equal(photons->count, 2);
    assert_true(fabsf(photons->photon[0].position.x - 0.5f) < 1e-6f);
    assert_true(fabsf(photons->photon[1].position.x - 1.0f) < 1e-6f);
    sl_map_photons_destroy(photons);
    sl_scene_destroy(scene);
}

static void facets_of_a_curved_surface_are_one_photon(void **state) {
    sl_scene *scene = room_with_table(0.5f);
    hand_map *h = hand_map_begin(hand_light(sl_v3(0, 0, 0)), 6, 4, 1);
    sl_vec3d mean = {0, 0, 0};
    double area = 0, weight = 0;
    /* of a ball of radius 1 around (2, 0, 0), 17 degrees from corner to corner */
    for (size_t i = 0; i < 16; i++) {
        double turn = 0.07 * ((double)(i % 4) - 1.5), tilt = 0.07 * ((double)(i / 4) - 1.5);
        sl_vec3d n = sl_v3d(-sl_cos(turn) * sl_cos(tilt), sl_sin(tilt), sl_sin(turn) * sl_cos(tilt));
        sl_vec3d p = sl_addd(sl_v3d(2, 0, 0), n);
        hand_texel(h, i, 0, sl_to_float(p), sl_to_float(n), sl_grey(0.5f));
        double angle = texel_size(&h->map, i), b2 = sl_dotd(p, p);
        mean = sl_addd(mean, sl_scaled(p, angle));
        weight += angle;
        area += b2 * angle / (-sl_dotd(p, n) / sqrt(b2));
    }
    sl_map_photons *photons = photons_by(SL_MAP_FILTER_FLUX, scene, h);
    assert_int_equal(photons->count, 1);
    const sl_map_photon *p = &photons->photon[0];
    assert_true(sl_lengthd(sl_subd(sl_to_double(p->position), sl_scaled(mean, 1 / weight))) < 1e-6);
    /* A = sum b^2 dOmega / cos alpha */
    assert_true(fabs((double)p->footprint / (double)p->cos_alpha / area - 1) < 1e-5);
    assert_true(p->normal.x < -0.999f);
    destroy_photons(photons, h);
    sl_scene_destroy(scene);
}

static void a_block_of_many_surfaces_has_four_photons(void **state) {
    sl_scene *scene = room_with_table(0.5f);
    hand_map *h = hand_map_begin(hand_light(sl_v3(0, 0, 0)), 6, 8, 1);
    uint64_t key = sl_random_key(3, 1);
    double texels = 0, sum[3];
    for (size_t i = 0; i < 64; i++) {
        sl_vec3 n =
            sl_normalize_or(sl_v3(-0.2f - sl_random_unit(key, 3 * i), sl_random_unit(key, 3 * i + 1) - 0.5f,
                                  sl_random_unit(key, 3 * i + 2) - 0.5f),
                            sl_v3(-1, 0, 0));
        hand_texel(h, i, 0, sl_v3(1 + sl_random_unit(key, i + 1000), 0, 0), n, sl_grey(0.5f));
        texels += 0.5 * 3.0 * texel_size(&h->map, i) / SL_PI;
    }
    sl_map_photons *photons = photons_by(SL_MAP_FILTER_FLUX, scene, h);
    assert_int_equal(photons->count, 4);
    sum_flux(photons, sum);
    assert_true(fabs(sum[1] / texels - 1) < 1e-5);
    destroy_photons(photons, h);
    sl_scene_destroy(scene);
}

/* ---- radiance ---- */

static void filtered_radiance_is_the_mean_of_the_block(void **state) {
    sl_scene *scene = room_with_table(0.5f);
    for (int texels = 2; texels <= 8; texels *= 2) {
        hand_map *h = hand_map_begin(hand_light(sl_v3(0, 0, 0)), 6, 2 * texels, 2);
        uint64_t key = sl_random_key(5, (uint64_t)texels);
        double mean[4] = {0};
        for (int i = 0; i < 4 * texels * texels; i++) {
            hand_texel(h, (size_t)i, 0, sl_v3(1, 0, 0), sl_v3(-1, 0, 0), sl_grey(0));
            if (i % 7 == 3) { /* nothing there counts as black, but where the photons are */
                int x = i % (2 * texels) % texels, y = i / (2 * texels) % texels;
                if (x != (texels - 1) / 2 || y != (texels - 1) / 2) h->map.triangle[i] = SL_NO_INDEX;
            }
            float value = sl_random_unit(key, (uint64_t)i);
            for (int c = 0; c < 3; c++) h->map.color[c][i] = value;
            if (h->map.triangle[i] != SL_NO_INDEX) {
                mean[i / (2 * texels) / texels * 2 + i % (2 * texels) / texels] +=
                    (double)value / (texels * texels);
            }
        }
        sl_map_photons *photons = photons_by(SL_MAP_FILTER_RADIANCE, scene, h);
        assert_int_equal(photons->count, 4);
        for (int j = 0; j < 4; j++) assert_true(fabs((double)photons->photon[j].radiance.g - mean[j]) < 1e-6);
        destroy_photons(photons, h);
    }
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grouping_leaves_the_sum_of_flux_as_it_is),
        cmocka_unit_test(a_block_across_an_edge_has_a_photon_on_each_side),
        cmocka_unit_test(a_table_and_the_floor_below_it_are_two_photons),
        cmocka_unit_test(facets_of_a_curved_surface_are_one_photon),
        cmocka_unit_test(a_block_of_many_surfaces_has_four_photons),
        cmocka_unit_test(filtered_radiance_is_the_mean_of_the_block),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
