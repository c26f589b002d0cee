/* Bicubic surfaces: files, the surface, its triangles, transforms and keyframes. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "scene/bicubic.h"
#include "rendering.h"
#include "scene_files.h"

static double distance(sl_vec3 a, sl_vec3 b) { return sl_lengthd(sl_subd(sl_to_double(a), sl_to_double(b))); }

/* A surface over [0,1]^2 whose point (i/3, j/3) is lifted. */
static sl_bicubic hill(void) {
    static const float height[4][4] = {
        {0, 0.1f, 0.4f, 0}, {0.2f, 0.9f, -0.3f, 0.1f}, {0.5f, 0, 1.1f, 0.3f}, {0, 0.7f, 0.2f, 0.6f}};
    sl_bicubic b = {.steps = SL_BICUBIC_STEPS};
    for (int j = 0; j < 4; j++) {
        for (int i = 0; i < 4; i++) b.point[j][i] = sl_v3((float)i / 3.0f, (float)j / 3.0f, height[j][i]);
    }
    return b;
}

/* ---- the surface ---- */

static void a_surface_passes_through_its_corners_and_lies_within_its_control_points(void **state) {
    sl_bicubic b = hill();
    for (int c = 0; c < 4; c++) {
        sl_vec3 p, corner = b.point[c / 2 * 3][c % 2 * 3];
        sl_bicubic_at(&b, c % 2, c / 2, &p, NULL);
        assert_true(p.x == corner.x && p.y == corner.y && p.z == corner.z);
    }
    for (int k = 0; k < 400; k++) {
        sl_vec3 p;
        sl_bicubic_at(&b, (k % 20) / 19.0, (k / 20) / 19.0, &p, NULL);
        /* linear precision */
        assert_true(fabs((double)p.x - (k % 20) / 19.0) < 1e-6 && fabs((double)p.y - (k / 20) / 19.0) < 1e-6);
        assert_true(p.z > -0.3f && p.z < 1.1f);
    }
}

/* A cap of a bowl: its edge v = 0 is the point (0, 0, 0), where the surface is level. */
static sl_bicubic cap(bool cone) {
    sl_bicubic b = {.steps = SL_BICUBIC_STEPS};
    static const double circle[4][2] = {{1, 0}, {1, 0.552285}, {0.552285, 1}, {0, 1}};
    for (int j = 0; j < 4; j++) {
        for (int i = 0; i < 4; i++) {
            float r = (float)j / 3.0f, y = cone ? r : j == 2 ? 0.2f : j == 3 ? 0.6f : 0.0f;
            b.point[j][i] = sl_v3(r * (float)circle[i][0], y, -r * (float)circle[i][1]);
        }
    }
    return b;
}

static void the_normal_at_a_pole_is_the_limit(void **state) {
    sl_bicubic smooth = cap(false), tip = cap(true);
    for (int i = 0; i <= 16; i++) {
        sl_vec3 at_pole, near;
        sl_bicubic_at(&smooth, i / 16.0, 0.0, NULL, &at_pole);
        assert_true(distance(at_pole, sl_v3(0, -1, 0)) < 1e-6);
        /* The tip of a cone has one for every way down. */
        sl_bicubic_at(&tip, i / 16.0, 0.0, NULL, &at_pole);
        sl_bicubic_at(&tip, i / 16.0, 1e-3, NULL, &near);
        assert_true(distance(at_pole, near) < 1e-5);
        assert_true(fabs((double)at_pole.y + sqrt(0.5)) < 2e-2);
    }
}

static void a_normal_is_found_where_whole_derivatives_vanish(void **state) {
    sl_bicubic b = hill();
    for (int k = 0; k < 16; k++) b.point[k / 4][k % 4].z = 0.0f;
    /* no derivative at (0, 0), of first or second order */
    b.point[0][1] = b.point[1][0] = b.point[1][1] = b.point[0][0];
    sl_vec3 normal;
    sl_bicubic_at(&b, 0, 0, NULL, &normal);
    assert_true(distance(normal, sl_v3(0, 0, 1)) < 1e-6);
    for (int k = 0; k < 16; k++) b.point[k / 4][k % 4] = sl_v3(1, 2, 3); /* not a surface at all */
    sl_bicubic_at(&b, 0.3, 0.4, NULL, &normal);
    assert_true(fabs((double)sl_length(normal) - 1.0) < 1e-6);
    assert_false(sl_bicubic_has_area(&b));
}

/* ---- the scene's triangles ---- */

static uint32_t missing_triangles(const sl_scene *scene, const sl_bicubic *b) {
    uint32_t missing = 0, next = b->first_triangle;
    for (int k = 0; k < 2 * b->steps * b->steps; k++) {
        int column = k / 2 % b->steps, row = k / 2 / b->steps, half = k % 2;
        uint32_t t = sl_bicubic_triangle(scene, b, column, row, half);
        if (t == SL_NO_INDEX) {
            missing++;
            continue;
        }
        assert_int_equal(t, next++); /* row by row, half after half */
    }
    assert_int_equal(next, b->first_triangle + b->triangle_count);
    return missing;
}

static void the_scene_holds_each_surface_as_a_grid_less_what_has_no_area(void **state) {
    sl_scene *scene = load_scene("scenes/vase.json");
    assert_int_equal(scene->bicubic_count, 16);
    for (size_t i = 0; i < scene->bicubic_count; i++) {
        const sl_bicubic *b = &scene->bicubics[i];
        assert_int_equal(b->steps, SL_BICUBIC_STEPS);
        assert_int_equal(missing_triangles(scene, b), i < 4 ? 16 : 0); /* the foot's pole */
        for (uint32_t k = 0; k < 17 * 17; k++) {
            sl_vec3 p, n;
            sl_bicubic_at(b, (double)(k % 17) / 16.0, (double)(k / 17) / 16.0, &p, &n);
            assert_true(distance(p, sl_scene_position(scene, b->first_vertex + k)) == 0.0);
            assert_true(distance(n, sl_scene_normal(scene, b->first_vertex + k)) < 1e-6);
            assert_true(scene->texture_u[b->first_vertex + k] == (float)(k % 17) / 16.0f);
        }
        for (uint32_t t = b->first_triangle; t < b->first_triangle + b->triangle_count; t++) {
            assert_string_equal(scene->materials[scene->material_index[t]].name, "glaze");
            sl_vec3 normal = sl_scene_normal(scene, scene->vertex[1][t]);
            assert_true(sl_dot(normal, sl_scene_geometric_normal(scene, t)) > 0.9f);
        }
    }
    assert_int_equal(sl_scene_warning_count(scene), 0);
    sl_scene_destroy(scene);
}

/* ---- files ---- */

static const char flat[] = "0 0 0  1 0 0  2 0 0  3 0 0\n0 1 0  1 1 0  2 1 0  3 1 0\n0 2 0  1 2 0  2 2 0  3 2 "
                           "0\n0 3 0  1 3 0  2 3 0  3 3 0\n";

static const char *bpt(const char *text, const char *points) {
    char whole[4096];
    snprintf(whole, sizeof whole, "%s%s", text, points);
    return scene_file_text("surface.bpt", whole);
}

static void a_file_of_surfaces_alone_is_a_scene(void **state) {
    sl_scene *scene = load_scene(bpt("# one\r\n1\r\n3 3\r\n", flat));
    assert_int_equal(scene->bicubic_count, 1);
    assert_int_equal(scene->triangle_count, 512);
    assert_int_equal(scene->vertex_count, 289);
    assert_string_equal(scene->object_names[0], "surface.bpt");
    assert_string_equal(scene->materials[scene->material_index[0]].name, "surface.bpt");
    sl_scene_destroy(scene);
    scene_files_remove();
}

static void assert_refused(const char *path, const char *where, const char *why) {
    const char *message = load_refused(path);
    if (!strstr(message, where) || !strstr(message, why))
        fail_msg("'%s' has no '%s' or no '%s'", message, where, why);
}

static void every_mistake_is_reported_with_its_line(void **state) {
    assert_refused(bpt("", ""), "surface.bpt:1:", "number of surfaces, got the end");
    assert_refused(bpt("# nothing\n\n", ""), "surface.bpt:3:", "number of surfaces");
    assert_refused(bpt("1.5\n3 3\n", flat), "surface.bpt:1:", "number of surfaces, got '1.5'");
    assert_refused(bpt("0\n3 3\n", flat), "surface.bpt:1:", "number of surfaces");
    assert_refused(bpt("-1\n3 3\n", flat), "surface.bpt:1:", "number of surfaces");
    assert_refused(bpt("1e99\n3 3\n", flat), "surface.bpt:1:", "number of surfaces");
    assert_refused(bpt("1\n2 3\n", flat), "surface.bpt:2:", "degrees '3 3'");
    assert_refused(bpt("1\n3\n\n4\n", flat), "surface.bpt:4:", "degrees '3 3' of a bicubic surface, got '4'");
    assert_refused(bpt("2\n3 3\n", flat), "surface.bpt:7:", "got the end of the file");
    assert_refused(bpt("1\n3 3\n0 0 zero\n", flat), "surface.bpt:3:", "got 'zero'");
    assert_refused(bpt("1\n3 3\n1 nan 0\n", flat), "surface.bpt:3:", "got 'nan'");
    assert_refused(bpt("1\n3 3\n1 0x10 0\n", flat), "surface.bpt:3:", "got '0x10'");
    assert_refused(bpt("1\n3 3\n1 1e999 0\n", flat), "surface.bpt:3:", "got '1e999'");
    assert_refused(bpt("1\n3 3\n1 1e39 0\n", flat), "surface.bpt:3:", "floats");
    assert_refused(bpt("1\n3 3\n", "0 0 0 1 1 1 2 2\n"), "surface.bpt:4:", "16 control points");
    char more[2048];
    snprintf(more, sizeof more, "1\n3 3\n%sand more\n", flat);
    assert_refused(bpt(more, ""), "surface.bpt:7:", "the end of the file after the last surface, got 'and'");
    char point[512] = "";
    for (int i = 0; i < 16; i++) strcat(point, "1 2 3\n");
    assert_refused(bpt("1\n3 3\n", point), "surface.bpt:2:", "has an area");
    assert_refused("/nowhere/surface.bpt", "/nowhere/surface.bpt", "opened");
    bpt("1\n3 3\n1 2 x\n", "");
    assert_refused(
        scene_file_text("a.json", "{\"softlux\": 1,\n \"meshes\": [\n  {\"file\": \"surface.bpt\"}]}"),
        "a.json:3:", "surface.bpt:3:");
    bpt("1\n3 3\n", flat);
    assert_refused(
        scene_file_text(
            "a.json",
            "{\"softlux\": 1,\n \"meshes\": [\n  {\"file\": \"surface.bpt\", \"normals\": \"faceted\"}]}"),
        "a.json:3:", "faceted");
    scene_files_remove();
}

/* ---- transforms, motion, hash ---- */

static void fronts_stay_fronts_where_a_transform_mirrors(void **state) {
    bpt("1\n3 3\n", flat);
    for (int mirrored = 0; mirrored < 2; mirrored++) {
        char text[256];
        snprintf(text, sizeof text,
                 "{\"softlux\": 1, \"meshes\": [{\"file\": \"surface.bpt\", \"transform\": {\"translate\": "
                 "[0, 0, 5], \"scale\": [%d, 1, 1]}}]}",
                 mirrored ? -2 : 2);
        sl_scene *scene = load_scene(scene_file_text("a.json", text));
        const sl_bicubic *b = &scene->bicubics[0];
        for (uint32_t t = 0; t < scene->triangle_count; t++) {
            assert_true(sl_scene_geometric_normal(scene, t).z > 0.99f &&
                        sl_scene_normal(scene, scene->vertex[0][t]).z > 0.99f);
        }
        sl_vec3 p, n;
        sl_bicubic_at(b, 0.5, 0.5, &p, &n);
        assert_true(distance(p, sl_v3(mirrored ? -3.0f : 3.0f, 1.5f, 5)) < 1e-6 && n.z > 0.99f);
        sl_scene_destroy(scene);
    }
    scene_files_remove();
}

static void control_points_move_with_their_object(void **state) {
    bpt("1\n3 3\n", flat);
    sl_scene *scene = load_scene(
        scene_file_text("a.json", "{\"softlux\": 1, \"up\": \"z\", \"meshes\": [{\"file\": \"surface.bpt\"}, "
                                  "{\"file\": \"surface.bpt\", \"transform\": {\"translate\": [9, 0, 0]}, "
                                  "\"keyframes\": [{\"time\": 1}, {\"time\": 3, \"translate\": [0, 0, 4], "
                                  "\"rotate_deg\": [0, 90, 0]}]}]}"));
    assert_int_equal(scene->bicubic_count, 2);
    sl_bicubic before[2] = {scene->bicubics[0], scene->bicubics[1]};
    uint64_t hash = sl_scene_hash(scene);
    unsigned changes;
    assert_int_equal(sl_scene_set_time(scene, 2.0, &changes, NULL), SL_OK);
    assert_true(changes & SL_CHANGED_OBJECTS);
    assert_true(sl_scene_hash(scene) != hash);
    assert_memory_equal(before[0].point, scene->bicubics[0].point, sizeof before[0].point);
    for (uint32_t i = 0; i < 2; i++) {
        const sl_bicubic *b = &scene->bicubics[i];
        for (uint32_t k = 0; k < 17 * 17; k++) { /* the grid is still on the surface */
            sl_vec3 p, n;
            sl_bicubic_at(b, (double)(k % 17) / 16.0, (double)(k / 17) / 16.0, &p, &n);
            assert_true(distance(p, sl_scene_position(scene, b->first_vertex + k)) < 1e-5);
            assert_true(distance(n, sl_scene_normal(scene, b->first_vertex + k)) < 1e-5);
        }
    }
    /* Half way: turned by 45 degrees about the file's y, lifted by 2 along its z, which is our y. */
    sl_vec3 corner = scene->bicubics[1].point[0][0];
    assert_true(distance(corner, sl_v3(9.0f * (float)sqrt(0.5), 2.0f - 9.0f * (float)sqrt(0.5), 0)) < 1e-4);
    assert_int_equal(sl_scene_set_time(scene, 0.0, &changes, NULL), SL_OK);
    assert_memory_equal(before, scene->bicubics, sizeof before);
    assert_true(sl_scene_hash(scene) == hash);
    sl_scene_destroy(scene);
    scene_files_remove();
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_surface_passes_through_its_corners_and_lies_within_its_control_points),
        cmocka_unit_test(the_normal_at_a_pole_is_the_limit),
        cmocka_unit_test(a_normal_is_found_where_whole_derivatives_vanish),
        cmocka_unit_test(the_scene_holds_each_surface_as_a_grid_less_what_has_no_area),
        cmocka_unit_test(a_file_of_surfaces_alone_is_a_scene),
        cmocka_unit_test(every_mistake_is_reported_with_its_line),
        cmocka_unit_test(fronts_stay_fronts_where_a_transform_mirrors),
        cmocka_unit_test(control_points_move_with_their_object),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
