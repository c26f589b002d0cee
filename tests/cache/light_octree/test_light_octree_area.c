/* Area of the surface within an ellipsoid, in closed form, by counting points, and where photons tell: at
 * edges and in corners. */
#include "light_octree_photons.h"

#include "cache/light_octree/photon_area.h"
#include "cache/light_octree/pixels.h"
#include "trace_scenes.h"

static double number(uint64_t stream, uint64_t i) {
    return (double)sl_random_unit(sl_random_key(31, stream), i);
}

static sl_vec3d point(uint64_t stream, uint64_t i, double size) {
    return sl_v3d(size * (number(stream, 3 * i) - 0.5), size * (number(stream, 3 * i + 1) - 0.5),
                  size * (number(stream, 3 * i + 2) - 0.5));
}

static sl_vec3d unit(sl_vec3d v) { return sl_scaled(v, 1.0 / sl_lengthd(v)); }

static sl_ellipsoid ellipsoid(uint64_t i) {
    return (sl_ellipsoid){point(1, i, 0.6), unit(point(2, i, 1.0)),
                          i % 4 == 0 ? 1.0 : 0.1 + 0.8 * number(3, i), 0.3 + 0.7 * number(4, i)};
}

static double whole(sl_vec3d a, sl_vec3d b, sl_vec3d c) {
    return 0.5 * sl_lengthd(sl_crossd(sl_subd(b, a), sl_subd(c, a)));
}

static bool inside(const sl_ellipsoid *e, sl_vec3d p) {
    sl_vec3d q = sl_subd(p, e->centre);
    double u = sl_dotd(q, e->normal), f = sl_dotd(e->normal, e->normal) > 0.0 ? e->flatness : 1.0;
    return sl_dotd(q, q) - u * u + u * u / (f * f) <= e->radius * e->radius;
}

/* Points in the middle of small triangles. */
static double by_counting(const sl_ellipsoid *e, sl_vec3d a, sl_vec3d b, sl_vec3d c) {
    enum { STEPS = 250 };
    size_t count = 0;
    for (int i = 0; i < STEPS; i++) {
        for (int j = 0; j < 2 * (STEPS - i) - 1; j++) {
            double w1 = (i + (j % 2 ? 2.0 : 1.0) / 3.0) / STEPS,
                   w2 = (j / 2 + (j % 2 ? 2.0 : 1.0) / 3.0) / STEPS;
            sl_vec3d p = sl_addd(a, sl_addd(sl_scaled(sl_subd(b, a), w1), sl_scaled(sl_subd(c, a), w2)));
            count += inside(e, p);
        }
    }
    return whole(a, b, c) * (double)count / ((double)STEPS * STEPS);
}

static void triangle_area_is_that_of_counted_points(void **state) {
    size_t partly = 0;
    for (uint64_t i = 0; i < 300; i++) {
        sl_ellipsoid e = ellipsoid(i);
        if (i % 10 == 9) e.normal = sl_v3d(0, 0, 0);
        sl_vec3d a = point(5, i, 2.0), b = point(6, i, 2.0), c = point(7, i, 2.0);
        double area = sl_triangle_in_ellipsoid(&e, a, b, c), counted = by_counting(&e, a, b, c),
               all = whole(a, b, c);
        assert_true(fabs(area - counted) < 4e-3 * all);
        partly += area > 0.05 * all && area < 0.95 * all;
    }
    assert_true(partly > 100);
}

/* A square that holds all of the plane inside the ellipsoid. */
static double plane_area(const sl_ellipsoid *e, sl_vec3d normal, double h, double size) {
    sl_vec3d side = fabs(normal.x) < 0.7 ? sl_v3d(1, 0, 0) : sl_v3d(0, 1, 0),
             u = unit(sl_crossd(normal, side)), v = sl_crossd(normal, u);
    sl_vec3d middle = sl_addd(e->centre, sl_scaled(normal, h));
    sl_vec3d p[4];
    for (int k = 0; k < 4; k++) {
        p[k] = sl_addd(middle, sl_addd(sl_scaled(u, k == 0 || k == 3 ? -size : size),
                                       sl_scaled(v, k < 2 ? -size : size)));
    }
    return sl_triangle_in_ellipsoid(e, p[0], p[1], p[2]) + sl_triangle_in_ellipsoid(e, p[0], p[2], p[3]);
}

static void section_of_a_tilted_plane_has_its_formulas_area(void **state) {
    size_t met = 0;
    for (uint64_t i = 0; i < 1000; i++) {
        sl_ellipsoid e = ellipsoid(i);
        sl_vec3d normal = unit(point(8, i, 1.0));
        double h = e.radius * (number(9, i) - 0.5), size = i % 2 ? 3.0 : 3e5;
        double section = sl_section_area(&e, normal, h);
        assert_true(fabs(plane_area(&e, normal, h, size) - section) < 1e-9);
        met += section > 0.0;
    }
    assert_true(met > 500 && met < 1000);
}

static void edges_and_corners_halve_and_quarter_the_disc(void **state) {
    sl_ellipsoid e = {{0, 0, 0}, {0, 0, 1}, 0.25, 1.0};
    sl_vec3d o = {0, 0, 0}, x = {10, 0, 0}, y = {0, 10, 0}, minus_x = {-10, 0, 0}, up = {0, 0, 10};
    assert_true(fabs(sl_triangle_in_ellipsoid(&e, o, x, y) - SL_PI / 4.0) < 1e-14);
    assert_true(fabs(sl_triangle_in_ellipsoid(&e, minus_x, x, y) - SL_PI / 2.0) < 1e-14);
    /* A wall on the floor's edge: a quarter of the ellipse with half axes 1 and 1/4. */
    assert_true(fabs(sl_triangle_in_ellipsoid(&e, o, x, up) - SL_PI / 16.0) < 1e-14);
    /* All inside, and outside. */
    sl_vec3d a = {0.1, 0.1, 0.01}, b = {0.3, 0.1, -0.02}, c = {0.1, 0.4, 0.05};
    assert_true(sl_triangle_in_ellipsoid(&e, a, b, c) == whole(a, b, c));
    sl_vec3d above = {0, 0, 0.26};
    assert_true(sl_triangle_in_ellipsoid(&e, sl_addd(above, minus_x), sl_addd(above, x), sl_addd(above, y)) ==
                0.0);
    sl_vec3d far = {20, 20, 0};
    assert_true(fabs(sl_triangle_in_ellipsoid(&e, far, sl_addd(far, x), sl_addd(far, y))) < 1e-12);
}

static void odd_triangles_have_no_area_and_never_nan(void **state) {
    sl_ellipsoid e = {{0, 0, 0}, {0, 0, 1}, 0.25, 1.0};
    const sl_vec3d odd[] = {{0, 0, 0},         {1, 0, 0},      {NAN, 0, 0},   {INFINITY, 1, 0},
                            {1e300, 1e300, 0}, {1e-300, 0, 0}, {0, 1e-200, 1}};
    for (int i = 0; i < 7 * 7 * 7; i++) {
        double area = sl_triangle_in_ellipsoid(&e, odd[i % 7], odd[i / 7 % 7], odd[i / 49]);
        assert_true(area >= 0.0 && area <= 4.0);
    }
    assert_true(sl_triangle_in_ellipsoid(&e, odd[1], odd[1], odd[1]) == 0.0);
    e.radius = 0.0;
    assert_true(sl_triangle_in_ellipsoid(&e, sl_v3d(-1, -1, 0), sl_v3d(1, -1, 0), sl_v3d(0, 1, 0)) == 0.0);
    e.radius = 1.0;
    e.flatness = 0.0;
    assert_true(sl_triangle_in_ellipsoid(&e, sl_v3d(-9, -9, 0), sl_v3d(9, -9, 0), sl_v3d(0, 9, 0)) > 3.1);
    assert_true(isfinite(sl_section_area(&e, sl_v3d(0, 0, 1), 0.1)));
}

/* Through the octree every triangle is found once: a ball over a floor, each triangle cut, makes the same. */
static void the_surface_in_an_ellipsoid_is_the_sum_of_its_triangles(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t white = trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_quad(&mesh, sl_v3(-2, -1.05f, -2), sl_v3(0, 0, 4), sl_v3(4, 0, 0), white);
    trace_mesh_sphere(&mesh, sl_v3(0, 0, 0), 1.0f, 40, 0.0f, false, white);
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_octree *octree = octree_of(scene, 5, 1);
    sl_triangle_marks marks = {calloc(scene->triangle_count, sizeof *marks.mark), UINT32_MAX - 20};
    for (uint64_t i = 0; i < 48; i++) {
        uint32_t triangle;
        sl_vec3 p = random_on(scene, sl_random_key(77, 0), i, &triangle);
        sl_ellipsoid e = {sl_to_double(p), sl_to_double(sl_scene_geometric_normal(scene, triangle)), 0.25,
                          0.2 + 0.5 * number(15, i)};
        double cut[2] = {0.0, 0.0};
        for (uint32_t t = 0; t < scene->triangle_count; t++) {
            sl_vec3d c[3];
            double cosine = sl_dotd(sl_to_double(sl_scene_geometric_normal(scene, t)), e.normal);
            for (int k = 0; k < 3; k++)
                c[k] = sl_to_double(sl_scene_position(scene, scene->vertex[k][t]));
            if (fabs(cosine) >= 0.5) cut[cosine < 0.0] += sl_triangle_in_ellipsoid(&e, c[0], c[1], c[2]);
        }
        sl_strewn_area found = sl_surface_in_ellipsoid(scene, octree, &e, 0.5, &marks);
        double truth = found.together ? cut[0] + cut[1] : cut[0], disc = sl_disc_area(&e);
        if (cut[0] + cut[1] < 0.9 * disc) assert_true(fabs(found.side[0] - truth) < 1e-9 * disc);
    }
    free(marks.mark);
    sl_octree_destroy(octree);
    sl_scene_destroy(scene);
}

/* ---- photons strewn over surfaces ------------------------------------------------------------ */

/* The floor z = 0 of a room's corner, x and y >= 0, and its walls; N photons a unit of area, each of flux
 * 1/N: irradiance 1. */
enum { PHOTONS_A_UNIT = 40000 };

static sl_photon_list *corner_photons(void) {
    sl_photon_list *list = sl_allocate(1, sizeof *list);
    list->count = 3 * PHOTONS_A_UNIT;
    list->photon = sl_allocate(list->count, sizeof *list->photon);
    for (uint64_t i = 0; i < list->count; i++) {
        int wall = (int)(i % 3);
        float p[3] = {(float)number(10, i), (float)number(11, i), (float)number(12, i)};
        p[2 - wall] = 0.0f;
        sl_vec3 n = {wall == 2 ? 1.0f : 0.0f, wall == 1 ? 1.0f : 0.0f, wall == 0 ? 1.0f : 0.0f};
        sl_photon *photon = &list->photon[i];
        *photon = (sl_photon){.position = {p[0], p[1], p[2]},
                              .flux = {1.0f / PHOTONS_A_UNIT, 2.0f / PHOTONS_A_UNIT, 0}};
        photon->normal = sl_octahedral_encode(n);
        photon->direction = sl_octahedral_encode(n);
    }
    return list;
}

/* The corner's three walls. */
static sl_scene *corner(void) {
    const float xyz[54] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 1, 0, 1,
                           0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1};
    return scene_of_triangles(xyz, 6);
}

static sl_voxel_lights *corner_lights(const sl_scene *scene, const sl_octree *octree,
                                      const sl_photon_tree *tree, sl_photon_area area) {
    sl_voxel_lights *lights = NULL;
    sl_light_octree_settings o = plain_options(4);
    o.radius = 0.5;
    o.area = area;
    assert_int_equal(sl_voxel_lights_create(scene, octree, tree, &o, 2, &lights, NULL), SL_OK);
    return lights;
}

static sl_surface surface_at(float x, float y, float z, const sl_material *material) {
    return (sl_surface){.position = {x, y, z},
                        .geometric_normal = {0, 0, 1},
                        .normal = {0, 0, 1},
                        .diffuse = material->diffuse,
                        .material = material,
                        .front = true};
}

/* Mean irradiance over points of the floor, all along its edge, in its corners or in the middle: of a Lambert
 * surface L = rho E / pi. */
static double mean_irradiance(sl_voxel_lights *lights, int where) {
    enum { POINTS = 1000 };
    const sl_material white = {
        .diffuse = {1, 0.5f, 0.25f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX};
    double sum = 0.0;
    for (uint64_t i = 0; i < POINTS; i++) {
        float x = 0.2f + 0.6f * (float)number(13, i), y = 0.2f + 0.6f * (float)number(14, i);
        if (where > 0) y = (float)(i % 2);
        if (where > 1) x = (float)(i / 2 % 2);
        sl_surface surface = surface_at(x, y, 0.0f, &white);
        sl_counters counters = {{0}};
        sl_rgb radiance = sl_photons_radiance(lights, 0, &surface, sl_v3(0, 0, 1), &counters);
        sum += (double)radiance.r * SL_PI / POINTS;
        /* twice the light, half the albedo */
        assert_true(fabs((double)radiance.g - (double)radiance.r) < 1e-5);
    }
    return sum;
}

static void clipped_area_is_right_at_edges_and_corners_where_the_disc_is_not(void **state) {
    sl_scene *scene = corner();
    sl_octree *octree = octree_of(scene, 3, 1);
    sl_photon_tree *tree;
    assert_int_equal(sl_photon_tree_create(corner_photons(), 2, &tree, NULL), SL_OK);
    sl_voxel_lights *disc = corner_lights(scene, octree, tree, SL_PHOTON_AREA_DISC),
                    *clip = corner_lights(scene, octree, tree, SL_PHOTON_AREA_CLIP);
    assert_true(fabs(mean_irradiance(disc, 0) - 1.0) < 0.02);
    assert_true(fabs(mean_irradiance(clip, 0) - 1.0) < 0.02);
    assert_true(fabs(mean_irradiance(clip, 1) - 1.0) < 0.04);
    assert_true(fabs(mean_irradiance(disc, 1) - 0.5) < 0.02);
    /* Four corners: each a sample of 50 photons, 14 % apart. */
    assert_true(fabs(mean_irradiance(clip, 2) - 1.0) < 0.21);
    assert_true(fabs(mean_irradiance(disc, 2) - 0.25) < 0.06);
    sl_voxel_lights_destroy(disc);
    sl_voxel_lights_destroy(clip);
    sl_photon_tree_destroy(tree);
    sl_octree_destroy(octree);
    sl_scene_destroy(scene);
}

static void mirrors_and_surfaces_without_photons_are_dark(void **state) {
    sl_scene *scene = corner();
    sl_octree *octree = octree_of(scene, 3, 1);
    sl_photon_tree *tree;
    assert_int_equal(sl_photon_tree_create(corner_photons(), 1, &tree, NULL), SL_OK);
    sl_voxel_lights *lights = corner_lights(scene, octree, tree, SL_PHOTON_AREA_CLIP);
    const sl_material mirror = {.mirror = {1, 1, 1}}, white = {.diffuse = {1, 1, 1}};
    sl_surface surfaces[2] = {surface_at(0.5f, 0.5f, 0, &mirror), surface_at(9, 9, 9, &white)};
    for (int i = 0; i < 2; i++) {
        sl_counters counters = {{0}};
        sl_rgb radiance = sl_photons_radiance(lights, 0, &surfaces[i], sl_v3(0, 0, 1), &counters);
        assert_true(radiance.r == 0.0f && radiance.g == 0.0f && radiance.b == 0.0f);
    }
    sl_voxel_lights_destroy(lights);
    sl_photon_tree_destroy(tree);
    sl_octree_destroy(octree);
    sl_scene_destroy(scene);
}

/* ---- what photons tell by themselves ---- */

/* Points of a disc or a square, of area 1: all of it, or one half. */
static double share_of(size_t count, bool disc, bool half, uint64_t seed) {
    sl_place_sums sums = {0};
    for (uint64_t i = 0; i < count; i++) {
        double u = number(2 * seed, i), v = number(2 * seed + 1, i),
               r = sqrt(u / SL_PI), angle = SL_PI * v * (half ? 1.0 : 2.0);
        sl_place_sums_add(&sums, disc ? r * sl_cos(angle) : u * (half ? 0.5 : 1.0),
                          disc ? r * sl_sin(angle) : v);
    }
    return sl_strewn_share(&sums, 1.0);
}

static void photons_tell_what_share_of_a_surface_they_met(void **state) {
    enum { RUNS = 500 };
    for (int disc = 0; disc < 2; disc++) {
        size_t less = 0;
        double half = 0.0;
        for (uint64_t run = 0; run < RUNS; run++) {
            less += share_of(50, disc, false, 2 * run) < 1.0;
            half += share_of(300, disc, true, 2 * run + 1) / RUNS;
        }
        if (less > RUNS / 100 || fabs(half - 0.5) > 0.05)
            fail_msg("%zu of %d are less, half is %g", less, RUNS, half);
    }
}

static void what_spans_no_area_says_little(void **state) {
    sl_place_sums line = {0}, few = {0};
    for (int i = 0; i < 100; i++) sl_place_sums_add(&line, i, 2.0 * i);
    for (int i = 0; i < 7; i++) sl_place_sums_add(&few, 1e-3 * i, 1e-3 * i * i);
    assert_true(sl_strewn_share(&line, 1.0) == 0.1); /* no more than tenfold */
    assert_true(sl_strewn_share(&few, 1.0) == 1.0 && sl_strewn_share(&line, 0.0) == 1.0);
    assert_true(sl_strewn_share(&line, (double)NAN) == 1.0);
}

/* A floor of which a box covers half: what is under the box no photon meets. Beside the box the floor is as
 * bright as elsewhere. */
static void floors_are_not_dark_beside_what_stands_on_them(void **state) {
    float xyz[9 * 8];
    add_quad(xyz, 0, sl_v3(0, 0, 0), sl_v3(0, 0, 4), sl_v3(4, 0, 0));
    add_quad(xyz, 2, sl_v3(2, 0, 0), sl_v3(0, 0, 4), sl_v3(0, 2, 0));
    add_quad(xyz, 4, sl_v3(2, 2, 0), sl_v3(0, 0, 4), sl_v3(2, 0, 0));
    add_quad(xyz, 6, sl_v3(4, 0, 0), sl_v3(0, 2, 0), sl_v3(0, 0, 4));
    sl_scene *scene = scene_of_triangles(xyz, 8);
    sl_photon_list *list = new_list(40000);
    strew_evenly(list, 40000, sl_v3(0, 0, 0), sl_v3(0, 0, 4), sl_v3(2, 0, 0), sl_v3(0, 1, 0), 3.0f, 7);
    sl_light_octree_settings o = plain_options(4);
    o.neighbours = 300;
    o.acceptance = 35.0 / 180.0 * SL_PI;
    o.whole_voxels = false;
    lit l = light_up(scene, 5, list, &o, 1);
    double count[2] = {0.0, 0.0}, sum[2] = {0.0, 0.0};
    for (size_t s = 0; s < l.lights->set_count; s++) {
        sl_vec3 c = l.lights->set[s].centroid;
        bool floor_set =
                 fabsf(l.lights->set[s].normal.y) > 0.9f && c.y < 0.01f && c.x<2.0f, near = c.x> 1.85f,
             middle = c.x > 0.5f && c.x < 1.5f;
        if (!floor_set || !(near || middle)) continue;
        sum[middle] += irradiance_on(l.lights, s, sl_v3(0, 1, 0));
        count[middle] += 1.0;
    }
    assert_true(count[0] > 20.0 && count[1] > 100.0);
    double beside = sum[0] / count[0] / 3.0, far = sum[1] / count[1] / 3.0;
    end_lit(&l);
    assert_true(fabs(far - 1.0) < 0.02 && fabs(beside - 1.0) < 0.05);
    sl_scene_destroy(scene);
}

/* A floor modelled twice, and once more the other way up, is no larger. */
static void a_floor_modelled_thrice_is_as_bright_as_one(void **state) {
    float xyz[9 * 6];
    for (size_t k = 0; k < 2; k++) add_quad(xyz, 2 * k, sl_v3(0, 0, 0), sl_v3(0, 0, 4), sl_v3(4, 0, 0));
    add_quad(xyz, 4, sl_v3(0, 0, 0), sl_v3(4, 0, 0), sl_v3(0, 0, 4));
    sl_scene *scene = scene_of_triangles(xyz, 6);
    sl_light_octree_settings o = plain_options(4);
    o.neighbours = 300;
    o.whole_voxels = false;
    lit l = light_up(scene, 4, even_floor(40000, 3.0f, 9), &o, 1);
    double count[2] = {0.0, 0.0}, sum[2] = {0.0, 0.0};
    for (size_t s = 0; s < l.lights->set_count; s++) {
        sl_vec3 c = l.lights->set[s].centroid;
        bool edge = c.x < 0.2f || c.z < 0.2f || c.x > 3.8f || c.z > 3.8f;
        if (l.lights->set[s].lights == 0) continue;
        sum[edge] += irradiance_on(l.lights, s, sl_v3(0, 1, 0)) / 3.0;
        count[edge] += 1.0;
    }
    end_lit(&l);
    assert_true(count[0] > 100.0 && count[1] > 40.0);
    assert_true(fabs(sum[0] / count[0] - 1.0) < 0.02 && fabs(sum[1] / count[1] - 1.0) < 0.1);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(triangle_area_is_that_of_counted_points),
        cmocka_unit_test(section_of_a_tilted_plane_has_its_formulas_area),
        cmocka_unit_test(edges_and_corners_halve_and_quarter_the_disc),
        cmocka_unit_test(odd_triangles_have_no_area_and_never_nan),
        cmocka_unit_test(the_surface_in_an_ellipsoid_is_the_sum_of_its_triangles),
        cmocka_unit_test(clipped_area_is_right_at_edges_and_corners_where_the_disc_is_not),
        cmocka_unit_test(mirrors_and_surfaces_without_photons_are_dark),
        cmocka_unit_test(photons_tell_what_share_of_a_surface_they_met),
        cmocka_unit_test(what_spans_no_area_says_little),
        cmocka_unit_test(floors_are_not_dark_beside_what_stands_on_them),
        cmocka_unit_test(a_floor_modelled_thrice_is_as_bright_as_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
