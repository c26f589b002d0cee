/* Direct Radiance Mapping's lights: what each gives, which triangles make one, and the footprint of a
 * picture's part. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "base/math.h"
#include "cache/direct_radiance/map.h"
#include "cache/direct_radiance/lights.h"
#include "trace_scenes.h"

static sl_map_lights *find(const sl_scene *scene, int subdivision) {
    sl_map_lights *lights;
    sl_error error = {0};
    if (sl_map_lights_find(scene, subdivision, &lights, &error) != SL_OK) fail_msg("%s", error.message);
    return lights;
}

static bool close_to(double a, double b, double relative) {
    return fabs(a - b) <= relative * (fabs(a) + fabs(b)) * 0.5;
}

static sl_light light_at(sl_light_type type, float intensity) {
    return (sl_light){.type = type,
                      .position = {0.3f, 2.0f, -0.1f},
                      .direction = {0, -1, 0},
                      .intensity = sl_grey(intensity),
                      .cos_inner = 0.9f,
                      .cos_outer = 0.7f};
}

/* A floor, so that there is a scene. */
static trace_mesh floor_mesh(void) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_quad(&mesh, sl_v3(-2, 0, 2), sl_v3(4, 0, 0), sl_v3(0, 0, -4),
                    trace_mesh_material(&mesh, 0.7f, 0, 0, 0, 0));
    return mesh;
}

/* The panel [x0, x0 + 1] x [0, 1] at height y, shining down, of n x n quads. */
static void add_panel(trace_mesh *mesh, float x0, float y, int n, uint32_t material) {
    for (int i = 0; i < n * n; i++) {
        float side = 1.0f / (float)n, x = x0 + side * (float)(i % n), z = side * (float)(i / n);
        trace_mesh_quad(mesh, sl_v3(x, y, z), sl_v3(side, 0, 0), sl_v3(0, 0, side), material);
    }
}

/* ---- behind bars ---- */

/* A panel of side 1 that shines down at height 2, and a bar of that width across its middle, so far below it;
 * open: the point that the light has, and its share of the intensity. */
static sl_map_light_point point_behind_bar(float width, float below, sl_light_openings *found) {
    trace_mesh mesh = floor_mesh();
    add_panel(&mesh, 0, 2, 1, trace_mesh_material(&mesh, 0, 0, 0, 0, 5));
    trace_mesh_quad(&mesh, sl_v3(-0.5f, 2 - below, 0.5f - 0.5f * width), sl_v3(2, 0, 0), sl_v3(0, 0, width),
                    0);
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_raster *raster;
    sl_counters counters = {{0}};
    assert_int_equal(sl_raster_create(scene, 1, &raster, NULL), SL_OK);
    sl_map_lights *lights = find(scene, 1);
    sl_map_light_point point = lights->point[0];
    const float whole = point.intensity.g;
    assert_int_equal(sl_map_lights_find_openings(scene, raster, 1, 1, lights, found, &counters, NULL), SL_OK);
    point = lights->point[0];
    assert_memory_equal(&lights->light[0].position, &point.position, sizeof point.position);
    point.intensity = sl_rgb_scale(point.intensity, 1.0f / whole);
    sl_map_lights_destroy(lights);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
    return point;
}

static void a_point_behind_a_bar_moves_to_where_the_light_gets_out(void **state) {
    (void)state;
    sl_light_openings found;
    sl_map_light_point point = point_behind_bar(0.3f, 0.02f, &found);
    assert_true(found.points == 1 && found.moved == 1 && found.shut == 0);
    assert_true(fabsf(point.position.z - 0.5f) > 0.15f && point.position.z > 0 && point.position.z < 1);
    assert_true(point.intensity.g > 0.5f && point.intensity.g < 0.95f); /* 0.7 gets out */
}

static void a_point_before_which_nothing_stands_close_stays_where_it_is(void **state) {
    (void)state;
    sl_light_openings found;
    sl_map_light_point point = point_behind_bar(0.3f, 1.2f, &found);
    assert_true(found.points == 1 && found.moved == 0 && found.shut == 0);
    assert_true(point.position.x == 0.5f && point.position.z == 0.5f && point.intensity.g == 1.0f);
}

static void a_lamp_that_is_shut_in_is_told_of(void **state) {
    (void)state;
    sl_light_openings found;
    sl_map_light_point point = point_behind_bar(1.4f, 0.02f, &found);
    assert_true(found.points == 1 && found.moved == 0 && found.shut == 1);
    assert_true(point.position.z == 0.5f && point.intensity.g == 1.0f);
}

/* ---- what lights give ---- */

static void irradiance_at_distance_r_is_the_flux_over_4_pi_r_squared(void **state) {
    (void)state;
    const double flux = 100.0, r = 1.5;
    trace_mesh mesh = floor_mesh();
    mesh.lights[mesh.light_count++] = light_at(SL_LIGHT_POINT, (float)(flux / (4.0 * SL_PI)));
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_map_lights *lights = find(scene, 1);
    sl_rgb intensity = sl_map_light_intensity(&lights->light[0], sl_v3(0, 0, 1));
    assert_true(close_to((double)intensity.g / (r * r), flux / (4.0 * SL_PI * r * r), 1e-6));
    assert_true(close_to((double)lights->flux.g, flux, 1e-6));
    sl_map_lights_destroy(lights);
    sl_scene_destroy(scene);
}

/* The intensity's integral over the sphere, by the middles of 400 x 800 cells of equal solid angle. */
static double integral_over_sphere(const sl_map_light *light) {
    double sum = 0.0;
    for (int i = 0; i < 400; i++) {
        for (int k = 0; k < 800; k++) {
            double z = -1.0 + (i + 0.5) / 200.0, s = sqrt(1.0 - z * z), phi = 2.0 * SL_PI * (k + 0.5) / 800.0;
            sl_vec3 d = sl_v3((float)(s * sl_cos(phi)), (float)z, (float)(s * sl_sin(phi)));
            sum += (double)sl_map_light_intensity(light, d).g;
        }
    }
    return sum * 4.0 * SL_PI / (400.0 * 800.0);
}

static void every_kind_of_lights_intensity_adds_up_to_its_flux_over_the_sphere(void **state) {
    (void)state;
    trace_mesh mesh = floor_mesh();
    mesh.lights[mesh.light_count++] = light_at(SL_LIGHT_POINT, 3.0f);
    mesh.lights[mesh.light_count++] = light_at(SL_LIGHT_SPOT, 5.0f);
    add_panel(&mesh, 0, 3, 1, trace_mesh_material(&mesh, 0, 0, 0, 0, 7.0f));
    uint32_t both = trace_mesh_material(&mesh, 0, 0, 0, 0, 2.0f);
    mesh.materials[both].emission_two_sided = true;
    add_panel(&mesh, -3, 3, 1, both);
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_map_lights *lights = find(scene, 1);
    assert_int_equal(lights->count, 4);
    const double flux[4] = {4.0 * SL_PI * 3.0, 2.0 * SL_PI * 0.2 * 5.0, SL_PI * 7.0, 2.0 * SL_PI * 2.0};
    for (size_t i = 0; i < 4; i++) {
        assert_true(close_to((double)sl_map_light_flux(&lights->light[i]).g, flux[i], 1e-5));
        assert_true(close_to(integral_over_sphere(&lights->light[i]), flux[i], 1e-3));
    }
    assert_true(close_to((double)lights->flux.g, flux[0] + flux[1] + flux[2] + flux[3], 1e-5));
    sl_map_lights_destroy(lights);
    sl_scene_destroy(scene);
}

static void an_aimed_point_keeps_the_intensity_of_a_point_and_a_true_spot_has_its_flux_in_the_cone(
    void **state) {
    (void)state;
    sl_map_light spot = {.kind = SL_MAP_LIGHT_SPOT,
                         .direction = {0, -1, 0},
                         .intensity = {1, 1, 1},
                         .cos_inner = 0.5f,
                         .cos_outer = 0.5f};
    assert_true(close_to((double)sl_map_light_flux(&spot).g, 2.0 * SL_PI * 0.5, 1e-6));
    assert_true(sl_map_light_intensity(&spot, sl_v3(0, -1, 0)).g == 1.0f);
    assert_true(sl_map_light_intensity(&spot, sl_v3(1, 0, 0)).g == 0.0f);
    sl_map_light point = {.kind = SL_MAP_LIGHT_POINT, .direction = {0, -1, 0}, .intensity = {1, 1, 1}};
    assert_true(sl_map_light_intensity(&point, sl_v3(1, 0, 0)).g == 1.0f);
}

/* ---- (9) as an area light's point, against the exact irradiance ---- */

/* Irradiance from the square of side 1 and radiance 1 on a parallel plane at height d, offset x from the
 * axis, by the points' sum. */
static double by_points(const sl_map_lights *lights, sl_vec3 p) {
    double sum = 0.0;
    for (size_t i = 0; i < lights->point_count; i++) {
        const sl_map_light_point *point = &lights->point[i];
        sl_vec3d d = sl_subd(sl_to_double(point->position), sl_to_double(p));
        double squared = sl_dotd(d, d), up = d.y / sqrt(squared);
        sum += (double)point->intensity.g * up * up / squared;
    }
    return sum;
}

static double exactly(double x0, double x1, double d) { /* the square [x0,x1] x [-1/2,1/2], by its middles */
    double sum = 0.0;
    for (int i = 0; i < 1000; i++) {
        for (int k = 0; k < 1000; k++) {
            double x = x0 + (x1 - x0) * (i + 0.5) / 1000.0, z = -0.5 + (k + 0.5) / 1000.0,
                   s = x * x + z * z + d * d;
            sum += d * d / (s * s);
        }
    }
    return sum * (x1 - x0) / 1e6;
}

static void one_point_of_an_area_light_errs_as_the_paper_s_distant_light_must(void **state) {
    (void)state;
    static const double table[4][4] = {{0.5, 2.30, 0.951, 0.729},
                                       {1, 1.33, 0.943, 0.915},
                                       {2, 1.083, 0.981, 0.977},
                                       {5, 1.013, 0.997, 0.996}};
    trace_mesh mesh = floor_mesh();
    trace_mesh_quad(&mesh, sl_v3(-0.5f, 5, -0.5f), sl_v3(1, 0, 0), sl_v3(0, 0, 1),
                    trace_mesh_material(&mesh, 0, 0, 0, 0, 1));
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_map_lights *one = find(scene, 1), *many = find(scene, 8);
    assert_int_equal(one->point_count, 1);
    assert_int_equal(many->point_count, 64);
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 3; k++) {
            double d = table[i][0], x = d * k, exact = exactly(-0.5 - x, 0.5 - x, d);
            sl_vec3 p = sl_v3((float)x, (float)(5.0 - d), 0);
            assert_true(close_to(by_points(one, p) / exact, table[i][k + 1], 0.006));
            assert_true(close_to(by_points(many, p), exact, 0.01));
        }
    }
    sl_map_lights_destroy(one);
    sl_map_lights_destroy(many);
    sl_scene_destroy(scene);
}

static void the_back_of_a_one_sided_area_light_is_dark(void **state) {
    (void)state;
    sl_map_light light = {
        .kind = SL_MAP_LIGHT_AREA, .direction = {0, -1, 0}, .intensity = {2, 2, 2}, .area = 1};
    assert_true(sl_map_light_intensity(&light, sl_v3(0, 1, 0)).g == 0.0f);
    assert_true(sl_map_light_intensity(&light, sl_v3(0, -1, 0)).g == 2.0f);
    light.two_sided = true;
    assert_true(sl_map_light_intensity(&light, sl_v3(0, 1, 0)).g == 2.0f);
}

/* ---- lamps with holes ---- */

/* A panel of radiance 2 whose mask takes away its half beyond x = 1/2, or all of it. */
static sl_scene *panel_with_hole(bool whole) {
    const uint8_t left = whole ? 0 : 255;
    uint8_t texels[16] = {255, 255, 255, left, 255, 255, 255, 0, 255, 255, 255, left, 255, 255, 255, 0};
    trace_mesh mesh = floor_mesh();
    uint32_t lamp = trace_mesh_material(&mesh, 0, 0, 0, 0, 2);
    mesh.textures[0] = (sl_texture){NULL, 2, 2, true, texels};
    mesh.texture_count = 1;
    mesh.materials[lamp].alpha_texture = 0;
    trace_mesh_quad(&mesh, sl_v3(0, 3, 0), sl_v3(1, 0, 0), sl_v3(0, 0, 1), lamp);
    return trace_mesh_build(&mesh);
}

static void a_masked_lamp_gives_the_light_of_what_its_mask_leaves_from_where_that_is(void **state) {
    (void)state;
    sl_scene *scene = panel_with_hole(false);
    sl_map_lights *one = find(scene, 1), *many = find(scene, 4);
    assert_int_equal(one->count, 1);
    assert_true(close_to((double)one->flux.g, SL_PI * 2.0 * 0.5, 0.02));
    assert_true(fabsf(one->light[0].position.x - 0.25f) < 0.02f &&
                fabsf(one->light[0].position.z - 0.5f) < 0.02f);
    double sum = 0.0, beyond = 0.0;
    for (size_t i = 0; i < many->point_count; i++) {
        sum += (double)many->point[i].intensity.g;
        if (many->point[i].position.x > 0.5f) beyond += (double)many->point[i].intensity.g;
    }
    assert_true(close_to(sum, 1.0, 0.02) && beyond < 0.01);
    sl_map_lights_destroy(one);
    sl_map_lights_destroy(many);
    sl_scene_destroy(scene);
}

static void a_lamp_whose_mask_is_clear_all_over_is_no_light(void **state) {
    (void)state;
    sl_scene *scene = panel_with_hole(true);
    sl_map_lights *lights = find(scene, 2);
    assert_int_equal(lights->count, 0);
    sl_map_lights_destroy(lights);
    sl_scene_destroy(scene);
}

/* ---- which triangles make a light ---- */

static void a_tessellated_panel_is_one_light_and_panels_apart_are_several(void **state) {
    (void)state;
    trace_mesh mesh = floor_mesh();
    uint32_t glowing = trace_mesh_material(&mesh, 0, 0, 0, 0, 1),
             brighter = trace_mesh_material(&mesh, 0, 0, 0, 0, 3);
    add_panel(&mesh, 0, 3, 5, glowing);
    add_panel(&mesh, 1.5f, 3, 2, glowing);
    add_panel(&mesh, 2.5f, 3, 2, brighter); /* beside the second one, but of another material */
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_map_lights *lights = find(scene, 1);
    assert_int_equal(lights->count, 3);
    const float middle[3] = {0.5f, 2.0f, 3.0f}, intensity[3] = {1, 1, 3};
    const size_t count[3] = {50, 8, 8};
    for (size_t i = 0; i < 3; i++) {
        const sl_map_light *l = &lights->light[i];
        assert_int_equal(l->kind, SL_MAP_LIGHT_AREA);
        assert_int_equal(l->count, count[i]);
        assert_true(fabsf(l->position.x - middle[i]) < 1e-5f && fabsf(l->position.y - 3.0f) < 1e-5f &&
                    fabsf(l->position.z - 0.5f) < 1e-5f);
        assert_true(l->direction.y == -1.0f && close_to(l->area, 1.0, 1e-5) &&
                    close_to(l->intensity.g, intensity[i], 1e-5));
        assert_true(sl_map_light_clearance(scene, lights, i, l->position, false) < 1e-5f);
    }
    for (uint32_t t = 0; t < scene->triangle_count; t++)
        assert_int_equal(lights->light_of_triangle[t], t < 2 ? SL_NO_INDEX : t < 52 ? 0 : t < 60 ? 1 : 2);
    sl_map_lights_destroy(lights);
    sl_scene_destroy(scene);
}

static void the_faces_of_a_glowing_box_are_six_lights(void **state) {
    (void)state;
    trace_mesh mesh = floor_mesh();
    trace_mesh_box(&mesh, sl_v3(0, 1, 0), sl_v3(1, 2, 2), false, trace_mesh_material(&mesh, 0, 0, 0, 0, 1));
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_map_lights *lights = find(scene, 1);
    assert_int_equal(lights->count, 6);
    for (size_t i = 0; i < 6; i++) assert_int_equal(lights->light[i].count, 2);
    sl_map_lights_destroy(lights);
    sl_scene_destroy(scene);
}

static void a_lamp_of_many_triangles_becomes_at_most_64_lights_and_loses_no_flux(void **state) {
    (void)state;
    trace_mesh mesh = floor_mesh();
    trace_mesh_sphere(&mesh, sl_v3(0, 2, 0), 0.4f, 40, 0.0f, false,
                      trace_mesh_material(&mesh, 0, 0, 0, 0, 2));
    trace_mesh_quad(&mesh, sl_v3(3, 3, 3), sl_v3(1, 0, 0), sl_v3(0, 0, 1),
                    trace_mesh_material(&mesh, 0, 0, 0, 0, 50));
    mesh.lights[mesh.light_count++] = light_at(SL_LIGHT_POINT, 0.0f);
    mesh.lights[mesh.light_count++] = light_at(SL_LIGHT_DIRECTIONAL, 1.0f);
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_map_lights *lights = find(scene, 1);
    assert_true(lights->count <= SL_MAP_LIGHTS_MAX && lights->count > 32);
    double flux = 0.0;
    size_t emitters = 0;
    for (size_t i = 0; i < scene->emitter_count; i++)
        flux += SL_PI * (double)scene->emitters[i].radiance.g * (double)scene->emitters[i].area;
    for (size_t i = 0; i < lights->count; i++) {
        const sl_map_light *l = &lights->light[i];
        emitters += l->count;
        if (l->kind != SL_MAP_LIGHT_AREA) continue;
        assert_true(sl_map_light_clearance(scene, lights, i, l->position, false) < 1e-5f * scene->diagonal);
        assert_true(fabsf(sl_length(l->direction) - 1.0f) < 1e-5f);
    }
    assert_int_equal(emitters, scene->emitter_count);
    assert_true(close_to((double)lights->flux.g, flux, 1e-5));
    /* The strong panel stays alone. */
    const sl_map_light *last = &lights->light[lights->light_of_triangle[scene->triangle_count - 1]];
    assert_int_equal(last->count, 2);
    sl_map_lights_destroy(lights);
    sl_scene_destroy(scene);
}

static void what_is_merged_of_lamps_all_around_keeps_its_flux_however_normals_cancel(void **state) {
    (void)state;
    trace_mesh mesh = floor_mesh();
    uint32_t glowing = trace_mesh_material(&mesh, 0, 0, 0, 0, 1);
    for (int i = 0; i < 40; i++)
        trace_mesh_box(&mesh, sl_v3((float)i, 1, 0), sl_v3((float)i + 0.5f, 1.5f, 0.5f), false, glowing);
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_map_lights *lights = find(scene, 2);
    assert_true(lights->count <= SL_MAP_LIGHTS_MAX);
    assert_true(close_to((double)lights->flux.r, SL_PI * 40.0 * 1.5, 1e-5));
    for (size_t i = 0; i < lights->count; i++)
        assert_true(sl_is_finite(lights->light[i].position) &&
                    fabsf(sl_length(lights->light[i].direction) - 1.0f) < 1e-5f);
    sl_map_lights_destroy(lights);
    sl_scene_destroy(scene);
}

/* ---- points ---- */

static void the_points_of_a_light_share_its_intensity_and_lie_on_it(void **state) {
    (void)state;
    trace_mesh mesh = floor_mesh();
    uint32_t glowing = trace_mesh_material(&mesh, 0, 0, 0, 0, 2);
    add_panel(&mesh, 0, 3, 3, glowing);
    /* A disc of 24 triangles, and a lone triangle. */
    uint32_t centre = trace_mesh_vertex(&mesh, 5, 3, 5), first = 0;
    for (uint32_t i = 0; i < 24; i++) {
        double phi = 2.0 * SL_PI * i / 24.0;
        uint32_t v = trace_mesh_vertex(&mesh, 5 + (float)sl_cos(phi), 3, 5 + (float)sl_sin(phi));
        first = i ? first : v;
    }
    for (uint32_t i = 0; i < 24; i++)
        trace_mesh_triangle(&mesh, centre, first + i, first + (i + 1) % 24, glowing);
    trace_mesh_triangle(&mesh, trace_mesh_vertex(&mesh, 8, 3, 0), trace_mesh_vertex(&mesh, 9, 3, 0),
                        trace_mesh_vertex(&mesh, 8, 3, 1), glowing);
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_map_lights *lights = find(scene, 4);
    assert_int_equal(lights->count, 3);
    double sums[3] = {0};
    size_t counts[3] = {0};
    for (size_t i = 0; i < lights->point_count; i++) {
        const sl_map_light_point *p = &lights->point[i];
        sums[p->light] += (double)p->intensity.g;
        assert_true(fabsf(p->position.y - 3.0f) < 1e-5f);
        if (p->light == 0) {
            size_t k = counts[0];
            float along[2] = {p->position.x, p->position.z};
            for (int a = 0; a < 2; a++)
                assert_true(fabsf(along[a] * 4.0f - 0.5f - floorf(along[a] * 4.0f)) < 1e-4f);
            assert_true(close_to(p->intensity.g, 2.0 / 16.0, 1e-4) && k < 16);
        }
        if (p->light == 1) assert_true(sl_length(sl_sub(p->position, sl_v3(5, 3, 5))) < 1.0f);
        if (p->light == 2) assert_true(p->position.x - 8.0f + p->position.z < 1.0f);
        counts[p->light]++;
    }
    assert_int_equal(counts[0], 16);
    assert_true(counts[1] >= 12 && counts[2] >= 10 && counts[2] < 16);
    for (size_t i = 0; i < 3; i++) assert_true(close_to(sums[i], lights->light[i].intensity.g, 1e-5));
    sl_map_lights_destroy(lights);
    sl_scene_destroy(scene);
}

static void divisions_that_make_no_sense_are_refused(void **state) {
    (void)state;
    trace_mesh mesh = floor_mesh();
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_map_lights *lights;
    sl_error error;
    assert_int_equal(sl_map_lights_find(scene, 0, &lights, &error), SL_ERROR_USAGE);
    assert_null(lights);
    lights = find(scene, 1);
    assert_int_equal(lights->count, 0);
    assert_null(lights->light_of_triangle);
    sl_map_lights_destroy(lights);
    sl_scene_destroy(scene);
}

/* ---- footprint ---- */

static void solid_angles_of_a_picture_s_parts_add_up_to_the_picture_s(void **state) {
    (void)state;
    static const double fovs[] = {0.01, 0.7, SL_PI / 2, 2.0, 3.1};
    for (size_t f = 0; f < sizeof fovs / sizeof *fovs; f++) {
        double t = sl_tan(0.5 * fovs[f]), s = sl_sin(0.5 * fovs[f]), sum = 0.0;
        const int m = 7;
        for (int i = 0; i < m * m; i++) {
            double x = -t + 2.0 * t * (i % m) / m, y = -t + 2.0 * t * (i / m) / m, d = 2.0 * t / m;
            double part = sl_rectangle_solid_angle(x, y, x + d, y + d);
            assert_true(part > 0.0);
            sum += part;
        }
        assert_true(close_to(sum, 4.0 * sl_asin(s * s), 1e-12));
    }
    assert_true(close_to(6.0 * sl_rectangle_solid_angle(-1, -1, 1, 1), 4.0 * SL_PI, 1e-14));
}

static void the_printed_footprint_exceeds_the_true_one_as_the_specification_found(void **state) {
    (void)state;
    double printed = 16.0 * 16.0 * sl_printed_footprint(1.0, SL_PI / 2, 16),
           true_sum = sl_rectangle_solid_angle(-1, -1, 1, 1);
    double middle = sl_rectangle_solid_angle(0, 0, 0.125, 0.125),
           corner = sl_rectangle_solid_angle(0.875, 0.875, 1, 1);
    assert_true(close_to(printed / true_sum, 1.18, 0.01));
    assert_true(close_to(sl_printed_footprint(1.0, SL_PI / 2, 16) / middle, 0.63, 0.01));
    assert_true(close_to(sl_printed_footprint(1.0, SL_PI / 2, 16) / corner, 2.83, 0.01));
}

/* The true area on a plane at distance 1 tilted by 30 degrees, of the block straight ahead: planar distance
 * to the plane along (x, y, 1) is 1 / (1 + x tan 30), so the area is the integral of 1 / (cos 30 (1 + x tan
 * 30)^3). */
static void the_tilted_footprint_is_right_to_little_more_than_a_hundredth_at_30_degrees(void **state) {
    (void)state;
    double cosine = sqrt(0.75), tangent = sqrt(1.0 / 3.0), side = 0.125, sum = 0.0;
    for (int i = 0; i < 1000; i++) {
        double x = -0.5 * side + side * (i + 0.5) / 1000.0, q = 1.0 + x * tangent;
        sum += side * side / 1000.0 / (cosine * q * q * q);
    }
    double exact = sl_rectangle_solid_angle(-0.5 * side, -0.5 * side, 0.5 * side, 0.5 * side);
    assert_true(close_to(sl_printed_tilted_footprint(exact, cosine), sum, 0.02));
    assert_true(sl_printed_tilted_footprint(1.0, -0.5) == 0.0);
    assert_true(isinf(sl_printed_tilted_footprint(1.0, 0.0)));
    assert_true(sl_printed_tilted_footprint(0.0, 0.0) == 0.0 &&
                sl_printed_tilted_footprint(1.0, (double)NAN) == 0.0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_point_behind_a_bar_moves_to_where_the_light_gets_out),
        cmocka_unit_test(a_point_before_which_nothing_stands_close_stays_where_it_is),
        cmocka_unit_test(a_lamp_that_is_shut_in_is_told_of),
        cmocka_unit_test(irradiance_at_distance_r_is_the_flux_over_4_pi_r_squared),
        cmocka_unit_test(every_kind_of_lights_intensity_adds_up_to_its_flux_over_the_sphere),
        cmocka_unit_test(
            an_aimed_point_keeps_the_intensity_of_a_point_and_a_true_spot_has_its_flux_in_the_cone),
        cmocka_unit_test(one_point_of_an_area_light_errs_as_the_paper_s_distant_light_must),
        cmocka_unit_test(the_back_of_a_one_sided_area_light_is_dark),
        cmocka_unit_test(a_masked_lamp_gives_the_light_of_what_its_mask_leaves_from_where_that_is),
        cmocka_unit_test(a_lamp_whose_mask_is_clear_all_over_is_no_light),
        cmocka_unit_test(a_tessellated_panel_is_one_light_and_panels_apart_are_several),
        cmocka_unit_test(the_faces_of_a_glowing_box_are_six_lights),
        cmocka_unit_test(a_lamp_of_many_triangles_becomes_at_most_64_lights_and_loses_no_flux),
        cmocka_unit_test(what_is_merged_of_lamps_all_around_keeps_its_flux_however_normals_cancel),
        cmocka_unit_test(the_points_of_a_light_share_its_intensity_and_lie_on_it),
        cmocka_unit_test(divisions_that_make_no_sense_are_refused),
        cmocka_unit_test(solid_angles_of_a_picture_s_parts_add_up_to_the_picture_s),
        cmocka_unit_test(the_printed_footprint_exceeds_the_true_one_as_the_specification_found),
        cmocka_unit_test(the_tilted_footprint_is_right_to_little_more_than_a_hundredth_at_30_degrees),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
