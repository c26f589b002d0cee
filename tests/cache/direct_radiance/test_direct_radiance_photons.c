/* Regular sample photons of direct radiance maps, against what their surfaces reflect. */
#include "radiance_maps.h"

#include "cache/direct_radiance/direct_radiance.h"
#include "receiver_support.h"
#include "trace/trace.h"

static const sl_radiance_map_settings points = {.filter = SL_MAP_FILTER_POINT, .weight = SL_WEIGHT_FLUX};

/* A box of side 2 around the origin, reflectance 0.5; some tests want its diagonal alone. */
static sl_scene *room(float reflectance, float specular) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t material = trace_mesh_material(&mesh, reflectance, specular, 7.0f, 0, 0);
    trace_mesh_box(&mesh, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, material);
    return trace_mesh_build(&mesh);
}

/* The plane y = 0 below a light at height h, on face -y of its cube alone. */
static void fill_floor(hand_map *h, float height) {
    const sl_map_face *f = &h->face[3];
    for (int i = 0; i < f->width * f->height; i++) {
        sl_vec3d origin, ray;
        sl_map_face_ray(f, false, i % f->width + 0.5, i / f->width + 0.5, &origin, &ray);
        sl_vec3 p = sl_to_float(sl_addd(origin, sl_scaled(ray, (double)height)));
        p.y = h->light.source.position.y - height;
        hand_texel(h, f->first + (size_t)i, 0, p, sl_v3(0, 1, 0), (sl_rgb){0.5f, 0.25f, 0.0f});
    }
}

static void assert_photons_are_sound(const sl_map_photons *photons) {
    for (size_t j = 0; j < photons->count; j++) {
        const sl_map_photon *p = &photons->photon[j];
        assert_true(sl_is_finite(p->position) && sl_rgb_is_finite(p->flux) && sl_rgb_is_finite(p->radiance));
        assert_true(fabsf(sl_length(p->normal) - 1.0f) < 1e-5f);
        assert_true(p->footprint > 0 && isfinite(p->footprint) && isfinite(p->printed_area) &&
                    p->printed_area >= 0);
        assert_true(p->cos_alpha > 0 && p->cos_alpha <= 1);
        assert_true(p->flux.r >= 0 && p->flux.g >= 0 && p->flux.b >= 0 && sl_rgb_max(p->flux) > 0);
        if (photons->polygon) assert_true(isfinite(photons->polygon[j].over_area));
    }
}

/* ---- where ---- */

static void photon_i_k_lies_at_the_middle_of_its_block(void **state) {
    sl_scene *scene = room(0.5f, 0);
    const int m = 3, texels = 5;
    hand_map *h = hand_map_begin(hand_light(sl_v3(0, 0.5f, 0)), 6, m * texels, m);
    fill_floor(h, 0.5f);
    sl_map_photons *photons = take_photons(scene, &h->map, &points);
    assert_int_equal(photons->count, m * m);
    for (int k = 0; k < m; k++) {
        for (int i = 0; i < m; i++) {
            sl_vec3d origin, ray;
            sl_map_face_ray(&h->face[3], false, (i + 0.5) * texels, (k + 0.5) * texels, &origin, &ray);
            sl_vec3d expected = sl_addd(origin, sl_scaled(ray, 0.5));
            sl_vec3d found = sl_to_double(photons->photon[k * m + i].position);
            assert_true(sl_lengthd(sl_subd(found, expected)) < 1e-6);
        }
    }
    destroy_photons(photons, h);
    sl_scene_destroy(scene);
}

/* ---- how much ---- */

static void flux_is_reflectance_times_intensity_times_solid_angle_over_pi(void **state) {
    sl_scene *scene = room(0.5f, 0);
    for (int m = 1; m <= 8; m *= 2) {
        hand_map *h = hand_map_of(scene, hand_light(sl_v3(0.3f, -0.8f, 0.1f)), 16, m, true);
        sl_map_photons *photons = take_photons(scene, &h->map, &points);
        assert_int_equal(photons->count, 6 * m * m);
        assert_photons_are_sound(photons);
        double sum = 0, s = 2.0 / m;
        for (int j = 0; j < 6 * m * m; j++) {
            double x = -1 + s * (j % m), y = -1 + s * (j / m % m),
                   angle = sl_rectangle_solid_angle(x, y, x + s, y + s);
            const sl_map_photon *p = &photons->photon[j];
            assert_true(fabs((double)p->flux.r / (0.5 * 2.0 * angle / SL_PI) - 1) < 1e-5);
            assert_true(fabs((double)p->flux.b / (0.5 * 5.0 * angle / SL_PI) - 1) < 1e-5);
            double b2 = sl_dotd(sl_subd(sl_to_double(p->position), sl_to_double(h->light.source.position)),
                                sl_subd(sl_to_double(p->position), sl_to_double(h->light.source.position)));
            assert_true(fabs((double)p->footprint / (b2 * angle) - 1) < 1e-5);
            sum += (double)p->flux.g;
        }
        assert_true(fabs(sum / (0.5 * 3.0 * 4.0) - 1) < 1e-5); /* rho I 4 pi / pi */
        destroy_photons(photons, h);
    }
    sl_scene_destroy(scene);
}

static void printed_areas_are_those_of_12_and_13(void **state) {
    sl_scene *scene = room(0.5f, 0);
    const int m = 4;
    hand_map *h = hand_map_begin(hand_light(sl_v3(0, 0.5f, 0)), 6, 12, m);
    fill_floor(h, 0.5f);
    sl_map_photons *photons = take_photons(scene, &h->map, &points);
    for (size_t j = 0; j < photons->count; j++) {
        const sl_map_photon *p = &photons->photon[j];
        sl_vec3d way = sl_subd(sl_to_double(p->position), sl_to_double(h->light.source.position));
        double b = sl_lengthd(way), side = 2 * b * sl_tan(SL_PI / 4 / m); /* 90 degrees / 2m */
        assert_true(fabs((double)p->printed_area * (0.5 / b) / (side * side) - 1) < 1e-5);
        assert_true(fabs((double)p->cos_alpha - 0.5 / b) < 1e-6);
        assert_true(fabs((double)p->radiance.r / (0.5 * 2.0 * (0.5 / b) / (SL_PI * b * b)) - 1) < 1e-5);
    }
    destroy_photons(photons, h);
    sl_scene_destroy(scene);
}

/* ---- lights one after another, mirrors ---- */

static void glossy_scenes_keep_the_flux_that_arrives_and_the_lobe(void **state) {
    sl_scene *scene = room(0.5f, 0.25f);
    hand_map *h = hand_map_of(scene, hand_light(sl_v3(0.1f, 0.2f, 0)), 8, 4, false);
    for (int filter = SL_MAP_FILTER_POINT; filter <= SL_MAP_FILTER_FLUX; filter++) {
        sl_radiance_map_settings settings = {.filter = (sl_map_filter)filter, .weight = SL_WEIGHT_FLUX};
        sl_map_photons *photons = take_photons(scene, &h->map, &settings);
        assert_photons_are_sound(photons);
        double sum = 0;
        for (size_t j = 0; j < photons->count; j++) {
            const sl_photon_lobe *lobe = &photons->lobe[j];
            assert_true(fabsf(lobe->diffuse.g - 0.5f) < 1e-6f && fabsf(lobe->specular.b - 0.25f) < 1e-6f);
            assert_true(fabsf(lobe->exponent - 7.0f) < 1e-5f);
            sl_vec3 to_light =
                sl_normalize_or(sl_sub(h->light.source.position, photons->photon[j].position),
                                sl_v3(0, 0, 0));
            assert_true(sl_dot(lobe->to_light, to_light) > 0.999f);
            sl_vec3 way = sl_sub(h->light.source.position, photons->photon[j].position);
            double irradiance = 3.0 * (double)photons->photon[j].cos_alpha / (double)sl_dot(way, way);
            double printed = (double)photons->photon[j].radiance.g;
            if (filter == SL_MAP_FILTER_POINT) assert_true(fabs(printed / irradiance - 1) < 1e-5);
            if (filter == SL_MAP_FILTER_FLUX) assert_true(printed > 0 && printed < 1.2 * irradiance);
            sum += (double)photons->photon[j].flux.g;
        }
        assert_true(fabs(sum / (3.0 * 4.0 * SL_PI) - 1) < 1e-5);
        sl_map_photons_destroy(photons);
    }
    hand_map_end(h);
    sl_scene_destroy(scene);
}

static void mirrored_texels_arrive_from_where_they_say(void **state) {
    sl_scene *scene = room(0.5f, 0);
    hand_map *h = hand_map_begin(hand_light(sl_v3(0, 0, 0)), 6, 2, 2);
    hand_texel(h, 0, 0, sl_v3(0, -1, 0), sl_v3(0, 1, 0), sl_grey(0.5f));
    for (int c = 0; c < 3; c++) {
        h->map.arrival[c] = hand_plane(h->map.texels);
        h->map.carried[c] = hand_plane(h->map.texels);
        h->map.carried[c][0] = 0.9f;
        h->map.color[c][0] = 0.01f; /* L_o */
    }
    h->map.arrival[0][0] = 0.6f;
    h->map.arrival[1][0] = 0.8f;
    h->map.path[0] = 3.0f;
    sl_map_photons *photons = take_photons(scene, &h->map, &points);
    assert_int_equal(photons->count, 1);
    assert_true(fabsf(photons->photon[0].cos_alpha - 0.8f) < 1e-6f);
    const float footprint = 9.0f * (float)texel_size(&h->map, 0);
    assert_true(fabsf(photons->photon[0].footprint - footprint) < 1e-6f);
    assert_true(fabsf(photons->photon[0].flux.r - 0.01f * footprint / 0.8f) < 1e-6f);
    destroy_photons(photons, h);
    sl_scene_destroy(scene);
}

/* ---- polygons ---- */

static void polygons_are_where_corner_rays_meet_the_tangent_plane(void **state) {
    sl_scene *scene = room(0.5f, 0);
    sl_radiance_map_settings polygons = points;
    polygons.weight = SL_WEIGHT_POLYGON;
    hand_map *h = hand_map_begin(hand_light(sl_v3(0, 0.5f, 0)), 6, 15, 3);
    fill_floor(h, 0.5f);
    for (int filter = SL_MAP_FILTER_POINT; filter <= SL_MAP_FILTER_FLUX; filter++) {
        polygons.filter = (sl_map_filter)filter;
        sl_map_photons *photons = take_photons(scene, &h->map, &polygons);
        assert_int_equal(photons->count, 9);
        for (size_t j = 0; j < 9; j++) { /* a square of 1 x 1 below the light, in nine */
            const sl_photon_polygon *q = &photons->polygon[j];
            assert_true(fabsf(q->over_area - 9.0f) < 1e-3f);
            for (int c = 0; c < 4; c++) assert_true(fabsf(q->corner[c].y) < 1e-5f);
            sl_vec3 turn = sl_cross(sl_sub(q->corner[1], q->corner[0]), sl_sub(q->corner[2], q->corner[1]));
            assert_true(turn.y > 0); /* counter-clockwise as the light sees them */
        }
        sl_map_photons_destroy(photons);
    }
    hand_map_end(h);
    sl_scene_destroy(scene);
}

/* ---- hard cases ---- */

static void photons_too_near_to_their_light_are_dropped_and_counted(void **state) {
    sl_scene *scene = room(0.5f, 0); /* of diagonal 3.46 */
    hand_map *h = hand_map_begin(hand_light(sl_v3(0, 0, 0)), 6, 2, 2);
    hand_texel(h, 0, 0, sl_v3(3.4e-4f, 0, 0), sl_v3(-1, 0, 0), sl_grey(0.5f));
    hand_texel(h, 1, 0, sl_v3(3.5e-4f, 0, 0), sl_v3(-1, 0, 0), sl_grey(0.5f));
    hand_texel(h, 2, 0, sl_v3(1, 0, 0), sl_v3(-1, 0, 0), sl_grey(0.0f)); /* black */
    hand_texel(h, 3, 0, sl_v3(0, 0, 0), sl_v3(-1, 0, 0), sl_grey(0.5f)); /* at the light */
    sl_map_photons *photons = take_photons(scene, &h->map, &points);
    assert_int_equal(photons->count, 1);
    assert_true(photons->photon[0].position.x == 3.5e-4f);
    assert_int_equal(photons->dropped, 6 * 4 - 1);
    assert_photons_are_sound(photons);
    destroy_photons(photons, h);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(photon_i_k_lies_at_the_middle_of_its_block),
        cmocka_unit_test(flux_is_reflectance_times_intensity_times_solid_angle_over_pi),
        cmocka_unit_test(printed_areas_are_those_of_12_and_13),
        cmocka_unit_test(glossy_scenes_keep_the_flux_that_arrives_and_the_lobe),
        cmocka_unit_test(mirrored_texels_arrive_from_where_they_say),
        cmocka_unit_test(polygons_are_where_corner_rays_meet_the_tangent_plane),
        cmocka_unit_test(photons_too_near_to_their_light_are_dropped_and_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
