/* The texture atlas of the light octree: what every atlas must be (each triangle mapped once, none
 * overlapping, gutters kept), on surfaces that are closed, torn, doubled, thin or flat. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/light_octree/atlas/parts.h"
#include "trace_scenes.h"

#define BEND (60.0 * SL_PI / 180.0)

static sl_atlas *atlas_of(const sl_scene *scene, int size) {
    sl_atlas *atlas = NULL;
    sl_error error = {.message = ""};
    sl_status status = sl_atlas_create(scene, size, &atlas, &error);
    if (status != SL_OK) print_error("%s\n", error.message);
    assert_int_equal(status, SL_OK);
    return atlas;
}

/* ---- surfaces ---- */

typedef void surface(float u, float v, float p[3]);

/* A grid of columns x rows quads over u, v in [0,1]; corners that meet in space share no vertex if `torn`. */
static void add_grid(trace_mesh *mesh, surface *at, unsigned columns, unsigned rows, bool torn) {
    for (unsigned j = 0; j < rows; j++)
        for (unsigned i = 0; i < columns; i++) {
            uint32_t v[6];
            static const unsigned quad[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
            for (int k = 0; k < 6; k++) {
                float p[3];
                at((float)(i + quad[k][0]) / (float)columns, (float)(j + quad[k][1]) / (float)rows, p);
                v[k] = !torn && k == 3   ? v[0]
                       : !torn && k == 4 ? v[2]
                                         : trace_mesh_vertex(mesh, p[0], p[1], p[2]);
            }
            trace_mesh_triangle(mesh, v[0], v[1], v[2], 0);
            trace_mesh_triangle(mesh, v[3], v[4], v[5], 0);
        }
}

static void tilted_plane(float u, float v, float p[3]) {
    p[0] = 3.0f * u - 0.5f * v;
    p[1] = 2.0f * v + 0.25f * u;
    p[2] = 0.5f * u - 1.5f * v;
}

static void torus(float u, float v, float p[3]) { /* u = 0 and u = 1 are the same points, bit by bit */
    float s, c, t, d;
    sl_sincos_turnf(u < 1.0f ? u : 0.0f, &s, &c);
    sl_sincos_turnf(v < 1.0f ? v : 0.0f, &t, &d);
    p[0] = (2.0f + 0.7f * d) * c;
    p[1] = (2.0f + 0.7f * d) * s;
    p[2] = 0.7f * t;
}

static void rough(float u, float v, float p[3]) {
    uint32_t i = (uint32_t)(u * 40.0f + 0.5f), j = (uint32_t)(v * 40.0f + 0.5f);
    p[0] = 4.0f * u;
    p[1] = 4.0f * v;
    p[2] = 0.25f * sl_random_unit(7, 41 * i + j);
}

static void bell(float u, float v, float p[3]) {
    double x = 2.0 * (double)u - 1.0, y = 2.0 * (double)v - 1.0;
    p[0] = (float)x;
    p[1] = (float)y;
    p[2] = (float)(0.6 * sl_exp(-4.0 * (x * x + y * y)));
}

static sl_scene *scene_of(surface *at, unsigned columns, unsigned rows) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    add_grid(&mesh, at, columns, rows, true);
    return trace_mesh_build(&mesh);
}

/* ---- what every atlas must be ---- */

/* The area that two triangles share, by cutting one with the sides of the other: nothing of the atlas's own
 * predicates. */
static double shared_area(const float *a, const float *b) {
    double p[16][2], q[16][2], area = 0.0;
    size_t n = 3;
    for (size_t k = 0; k < 3; k++) p[k][0] = (double)a[2 * k], p[k][1] = (double)a[2 * k + 1];
    for (size_t k = 0; k < 3; k++) {
        const float *s = b + 2 * k, *e = b + 2 * ((k + 1) % 3);
        size_t kept = 0;
        for (size_t i = 0; i < n; i++) {
            const double *x = p[i], *y = p[(i + 1) % n], dx = (double)e[0] - (double)s[0],
                         dy = (double)e[1] - (double)s[1];
            double f = dx * (x[1] - (double)s[1]) - dy * (x[0] - (double)s[0]),
                   g = dx * (y[1] - (double)s[1]) - dy * (y[0] - (double)s[0]);
            if (f >= 0.0) q[kept][0] = x[0], q[kept++][1] = x[1];
            if ((f > 0.0 && g < 0.0) || (f < 0.0 && g > 0.0)) {
                q[kept][0] = x[0] + (y[0] - x[0]) * (f / (f - g));
                q[kept++][1] = x[1] + (y[1] - x[1]) * (f / (f - g));
            }
        }
        n = kept;
        memcpy(p, q, sizeof p);
    }
    for (size_t i = 2; i < n; i++)
        area += (p[i - 1][0] - p[0][0]) * (p[i][1] - p[0][1]) - (p[i - 1][1] - p[0][1]) * (p[i][0] - p[0][0]);
    return 0.5 * area;
}

static bool boxes_meet(const float *a, const float *b) {
    for (size_t d = 0; d < 2; d++) {
        if (fmaxf(fmaxf(a[d], a[d + 2]), a[d + 4]) <= fminf(fminf(b[d], b[d + 2]), b[d + 4])) return false;
        if (fmaxf(fmaxf(b[d], b[d + 2]), b[d + 4]) <= fminf(fminf(a[d], a[d + 2]), a[d + 4])) return false;
    }
    return true;
}

/* s, t of a triangle's corners. */
static void corners_of(const sl_atlas *atlas, const sl_scene *scene, size_t triangle, float st[6]) {
    const sl_atlas_chart *chart = &atlas->chart[atlas->chart_of[triangle]];
    for (int k = 0; k < 3; k++)
        sl_atlas_point(chart, sl_scene_position(scene, scene->vertex[k][triangle]), &st[2 * k],
                       &st[2 * k + 1]);
}

static float *all_corners(const sl_atlas *atlas, const sl_scene *scene) {
    float *st = sl_allocate(scene->triangle_count, 6 * sizeof *st);
    for (size_t t = 0; t < scene->triangle_count; t++) corners_of(atlas, scene, t, st + 6 * t);
    return st;
}

/* Of all triangles' area no more than a thousandth is shared, and none with another chart. */
static void assert_one_to_one(const sl_atlas *atlas, const sl_scene *scene) {
    float *s = all_corners(atlas, scene);
    double shared = 0.0, all = 0.0;
    for (size_t i = 0; i < scene->triangle_count; i++) {
        assert_true(atlas->chart_of[i] < atlas->chart_count);
        for (size_t k = 0; k < 6; k++) assert_true(s[6 * i + k] >= 0.0f && s[6 * i + k] <= 1.0f);
        all += shared_area(s + 6 * i, s + 6 * i);
        for (size_t j = 0; j < i; j++) {
            double here = boxes_meet(s + 6 * i, s + 6 * j) ? shared_area(s + 6 * i, s + 6 * j) : 0.0;
            assert_true(here < 1e-8 || atlas->chart_of[i] == atlas->chart_of[j]);
            shared += here;
        }
    }
    assert_true(shared <= 1e-3 * all);
    sl_free(s);
}

/* No normal of a chart is farther from its plane's than the limit; slivers, whose normals are noise, aside.
 */
static void assert_bends_within(const sl_atlas *atlas, const sl_scene *scene, double bend) {
    sl_atlas_faces faces;
    double limit = sl_cos(bend + 1e-6);
    assert_int_equal(sl_atlas_faces_create(scene, &faces, NULL), SL_OK);
    for (size_t f = 0; f < faces.count; f++) {
        const sl_atlas_chart *chart = &atlas->chart[atlas->chart_of[f]];
        sl_vec3 front = sl_normalize_or(sl_cross(chart->along[0], chart->along[1]), sl_v3(0.0f, 0.0f, 0.0f));
        if (sl_dotd(faces.normal[f], faces.normal[f]) > 0.0)
            assert_true(sl_dotd(faces.normal[f], sl_to_double(front)) >= limit);
    }
    sl_atlas_faces_release(&faces);
}

typedef struct texels {
    uint32_t *triangle;
    float *w1, *w2;
} texels;

static texels texels_of(const sl_atlas *atlas, const sl_scene *scene) {
    size_t count = (size_t)atlas->size * (size_t)atlas->size;
    texels t = {sl_allocate(count, sizeof *t.triangle), sl_allocate(count, sizeof *t.w1),
                sl_allocate(count, sizeof *t.w2)};
    assert_int_equal(sl_atlas_texels(atlas, scene, 2, t.triangle, t.w1, t.w2, NULL), SL_OK);
    return t;
}

static void free_texels(texels *t) {
    sl_free(t->triangle);
    sl_free(t->w1);
    sl_free(t->w2);
}

static void atlas_point(const sl_atlas *atlas, const sl_scene *scene, size_t triangle, double w1, double w2,
                        double at[2]) {
    float s[6];
    corners_of(atlas, scene, triangle, s);
    for (size_t d = 0; d < 2; d++)
        at[d] =
            atlas->size * ((1.0 - w1 - w2) * (double)s[d] + w1 * (double)s[2 + d] + w2 * (double)s[4 + d]);
}

/* A bilinear look-up at any point of a triangle reads, with any weight at all, only texels that hold points
 * of the triangle's own chart. */
static void assert_nothing_bleeds(const sl_atlas *atlas, const sl_scene *scene) {
    texels map = texels_of(atlas, scene);
    for (uint32_t t = 0; t < scene->triangle_count; t++)
        for (uint32_t n = 0; n < 12; n++) {
            double w1 = n < 3 ? n == 1 : (double)sl_random_unit(1, 12 * (uint64_t)t + n),
                   w2 = n < 3 ? n == 2 : (double)sl_random_unit(2, 12 * (uint64_t)t + n), at[2];
            if (w1 + w2 > 1.0) w1 = 1.0 - w1, w2 = 1.0 - w2;
            atlas_point(atlas, scene, t, w1, w2, at);
            int x = (int)floor(at[0] - 0.5), y = (int)floor(at[1] - 0.5);
            for (int k = 0; k < 4; k++) {
                int i = x + (k & 1), j = y + (k >> 1);
                double weight = (1.0 - fabs(at[0] - 0.5 - i)) * (1.0 - fabs(at[1] - 0.5 - j));
                if (weight < 1e-4) continue;
                assert_true(i >= 0 && j >= 0 && i < atlas->size && j < atlas->size);
                uint32_t owner = map.triangle[(size_t)j * (size_t)atlas->size + (size_t)i];
                assert_true(owner != SL_NO_INDEX && atlas->chart_of[owner] == atlas->chart_of[t]);
            }
        }
    free_texels(&map);
}

static void assert_sound(const sl_atlas *atlas, const sl_scene *scene) {
    assert_one_to_one(atlas, scene);
    assert_bends_within(atlas, scene, BEND);
    assert_nothing_bleeds(atlas, scene);
    assert_true(atlas->texels_per_unit > 0.0);
}

/* Builds, checks, and frees; returns the count of charts. */
static size_t charts_of_sound_atlas(sl_scene *scene, int size) {
    assert_non_null(scene);
    sl_atlas *atlas = atlas_of(scene, size);
    size_t charts = atlas->chart_count;
    assert_sound(atlas, scene);
    sl_atlas_destroy(atlas);
    sl_scene_destroy(scene);
    return charts;
}

/* ---- flattening ---- */

/* On the grid of whole numbers a plane is exact: so is its map, but for rounding to float. */
static void exact_plane(float u, float v, float p[3]) {
    p[0] = 16.0f * u;
    p[1] = 16.0f * v;
    p[2] = 32.0f * u + 32.0f * v;
}

static void a_planar_chart_is_a_similarity(void **state) {
    surface *planes[] = {tilted_plane, exact_plane};
    for (int n = 0; n < 2; n++) {
        sl_scene *scene = scene_of(planes[n], 16, 16);
        sl_atlas_faces faces;
        sl_atlas_charts charts;
        assert_int_equal(sl_atlas_faces_create(scene, &faces, NULL), SL_OK);
        assert_int_equal(sl_atlas_charts_create(&faces, BEND, &charts, NULL), SL_OK);
        assert_int_equal(charts.count, 1);
        for (uint32_t h = 0; h < 3 * faces.count; h++) {
            sl_vec3d e = sl_subd(sl_atlas_corner(&faces, sl_atlas_next(h)), sl_atlas_corner(&faces, h));
            double x = sl_dotd(e, charts.plane[0].right), y = sl_dotd(e, charts.plane[0].up);
            assert_true(fabs(sqrt(x * x + y * y) / sl_lengthd(e) - 1.0) < (n ? 1e-8 : 2e-6));
        }
        sl_atlas_charts_release(&charts);
        sl_atlas_faces_release(&faces);
        sl_scene_destroy(scene);
    }
}

/* Round and round, and up: a turn lies above the one before. */
static void ramp(float u, float v, float p[3]) {
    float s, c;
    sl_sincos_turnf(3.0f * u - floorf(3.0f * u), &s, &c);
    p[0] = (1.0f + v) * c;
    p[1] = (1.0f + v) * s;
    p[2] = 1.5f * u;
}

static void what_would_lie_on_its_own_chart_leaves_it(void **state) {
    sl_scene *scene = scene_of(ramp, 90, 6);
    sl_atlas *atlas = atlas_of(scene, 256);
    assert_sound(atlas, scene);
    assert_in_range(atlas->chart_count, 3, 8);
    sl_atlas_destroy(atlas);
    sl_scene_destroy(scene);
}

/* ---- surfaces of all kinds ---- */

static void a_sphere_is_cut_into_few_charts(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_sphere(&mesh, sl_v3(0.0f, 0.0f, 0.0f), 1.0f, 24, 0.0f, false, 0);
    size_t charts = charts_of_sound_atlas(trace_mesh_build(&mesh), 256);
    assert_in_range(charts, 4, 16);
}

static void a_box_has_a_chart_a_side(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_box(&mesh, sl_v3(-1.0f, -2.0f, -0.5f), sl_v3(1.0f, 2.0f, 0.5f), true, 0);
    assert_in_range(charts_of_sound_atlas(trace_mesh_build(&mesh), 128), 6, 6);
}

static void a_rough_surface_keeps_all_promises(void **state) {
    charts_of_sound_atlas(scene_of(rough, 40, 40), 256);
}

static void many_pages_at_one_edge_and_a_moebius_strip(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    for (int i = 0; i < 9; i++) { /* a book */
        float s, c;
        sl_sincos_turnf((float)i / 9.0f, &s, &c);
        trace_mesh_quad(&mesh, sl_v3(0.0f, 0.0f, 0.0f), sl_v3(0.0f, 0.0f, 1.0f), sl_v3(c, s, 0.0f), 0);
    }
    uint32_t v[24];
    for (int i = 0; i < 12; i++) { /* half a turn of the strip in a whole turn */
        float s, c, t, d;
        sl_sincos_turnf((float)i / 12.0f, &s, &c);
        sl_sincos_turnf((float)i / 24.0f, &t, &d);
        for (int e = 0; e < 2; e++) {
            float r = 2.0f + (e ? 0.5f : -0.5f) * d;
            v[2 * i + e] = trace_mesh_vertex(&mesh, 5.0f + r * c, r * s, (e ? 0.5f : -0.5f) * t);
        }
    }
    for (int i = 0; i < 12; i++) {
        uint32_t a = v[2 * i], b = v[2 * i + 1], c = i < 11 ? v[2 * i + 2] : v[1],
                 d = i < 11 ? v[2 * i + 3] : v[0];
        trace_mesh_triangle(&mesh, a, c, d, 0);
        trace_mesh_triangle(&mesh, a, d, b, 0);
    }
    charts_of_sound_atlas(trace_mesh_build(&mesh), 256);
}

static void doubled_faces_lie_in_different_charts(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    add_grid(&mesh, bell, 8, 8, true);
    add_grid(&mesh, bell, 8, 8, true);
    size_t first = mesh.triangle_count;
    for (size_t t = 0; t < first / 2; t++) /* and once more from behind */
        trace_mesh_triangle(&mesh, mesh.indices[3 * t], mesh.indices[3 * t + 2], mesh.indices[3 * t + 1], 0);
    assert_int_equal(charts_of_sound_atlas(trace_mesh_build(&mesh), 256), 3);
}

static void slivers_t_junctions_and_lone_triangles(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_quad(&mesh, sl_v3(0.0f, 0.0f, 0.0f), sl_v3(1.0f, 0.0f, 0.0f), sl_v3(0.0f, 1.0f, 0.0f), 0);
    /* beside it quads that meet its edge in between, and fans of thin faces that fill the seam */
    for (int i = 0; i < 7; i++) {
        float low = (float)i / 7.0f, high = (float)(i + 1) / 7.0f, off = (i % 2 ? 1e-7f : 0.0f);
        uint32_t a = trace_mesh_vertex(&mesh, 1.0f, low, 0.0f), b = trace_mesh_vertex(&mesh, 2.0f, low, 0.0f);
        uint32_t c = trace_mesh_vertex(&mesh, 2.0f, high, 0.0f),
                 d = trace_mesh_vertex(&mesh, 1.0f, high, off);
        trace_mesh_triangle(&mesh, a, b, c, 0);
        trace_mesh_triangle(&mesh, a, c, d, 0);
        /* some of no area at all: the scene drops them */
        trace_mesh_triangle(&mesh, trace_mesh_vertex(&mesh, 1.0f, 0.0f, 0.0f), a, d, 0);
    }
    for (int i = 0; i < 40; i++) { /* triangles alone, ever thinner */
        float thin = ldexpf(1.0f, -i), x = 3.0f + (float)i;
        trace_mesh_triangle(&mesh, trace_mesh_vertex(&mesh, x, 0.0f, 0.0f),
                            trace_mesh_vertex(&mesh, x + 0.5f, 0.0f, 0.0f),
                            trace_mesh_vertex(&mesh, x + 0.3f, thin, 0.0f), 0);
    }
    charts_of_sound_atlas(trace_mesh_build(&mesh), 256);
}

static void numbers_far_from_one(void **state) {
    static const float scales[] = {1e-12f, 1e12f};
    for (size_t n = 0; n < 2; n++) {
        trace_mesh mesh = trace_mesh_begin();
        trace_mesh_diffuse(&mesh, 0.5f);
        add_grid(&mesh, torus, 12, 8, true);
        for (size_t i = 0; i < 3 * mesh.vertex_count; i++) mesh.positions[i] *= scales[n];
        charts_of_sound_atlas(trace_mesh_build(&mesh), 128);
    }
}

/* ---- texels ---- */

static void texels_name_the_point_that_lies_there(void **state) {
    sl_scene *scene = scene_of(torus, 24, 12);
    for (int size = 100; size <= 256; size += 156) {
        sl_atlas *atlas = atlas_of(scene, size);
        texels map = texels_of(atlas, scene);
        size_t inside = 0, around = 0;
        for (size_t t = 0; t < (size_t)size * (size_t)size; t++) {
            double at[2], x = (double)(t % (size_t)size) + 0.5, y = (double)(t / (size_t)size) + 0.5;
            if (map.triangle[t] == SL_NO_INDEX) continue;
            assert_true(map.w1[t] >= 0.0f && map.w2[t] >= 0.0f && map.w1[t] + map.w2[t] <= 1.0f);
            atlas_point(atlas, scene, map.triangle[t], (double)map.w1[t], (double)map.w2[t], at);
            double off = fmax(fabs(at[0] - x), fabs(at[1] - y));
            inside += off < 1e-3;
            around += off >= 1e-3;
            assert_true(off < 1.4143);
        }
        assert_true(inside > around && around > 0);
        free_texels(&map);
        sl_atlas_destroy(atlas);
    }
    sl_scene_destroy(scene);
}

/* ---- limits ---- */

static void more_charts_than_texels_is_an_error_that_says_which_size_would_do(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    for (int i = 0; i < 500; i++)
        trace_mesh_quad(&mesh, sl_v3((float)i, 0.0f, 0.0f), sl_v3(0.0f, 0.5f, 0.0f), sl_v3(0.0f, 0.0f, 0.25f),
                        0);
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_atlas *atlas = NULL;
    sl_error error = {.message = ""};
    assert_int_equal(sl_atlas_create(scene, 16, &atlas, &error), SL_ERROR_RESOURCES);
    assert_null(atlas);
    const char *told = strstr(error.message, "a size of ");
    assert_non_null(told);
    const int size = atoi(told + strlen("a size of "));
    assert_in_range(size, 17, 250);
    assert_int_equal(sl_atlas_create(scene, size, &atlas, &error), SL_OK);
    assert_sound(atlas, scene);
    assert_int_equal(atlas->chart_count, 500);
    sl_atlas_destroy(atlas);
    sl_scene_destroy(scene);
}

/* ---- scenes ---- */

static void assert_scene_fits(const char *path, size_t charts_max, double coverage_min) {
    sl_scene *scene = NULL;
    if (sl_scene_load(path, &scene, NULL) != SL_OK) {
        print_message("%s is not there: skipped\n", path);
        return;
    }
    sl_atlas *atlas = atlas_of(scene, 1024);
    texels map = texels_of(atlas, scene);
    assert_bends_within(atlas, scene, BEND);
    assert_nothing_bleeds(atlas, scene);
    assert_in_range(atlas->chart_count, 1, charts_max);
    double held = 0.0;
    for (size_t i = 0; i < 1024 * 1024; i++) held += map.triangle[i] != SL_NO_INDEX;
    assert_true(held >= coverage_min * 1024.0 * 1024.0);
    free_texels(&map);
    sl_atlas_destroy(atlas);
    sl_scene_destroy(scene);
}

static void whole_scenes_fill_most_of_a_texture(void **state) {
    assert_scene_fits("scenes/generated/room.json", 1700, 0.6);
    assert_scene_fits("scenes/generated/cave.json", 1300, 0.5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_planar_chart_is_a_similarity),
        cmocka_unit_test(what_would_lie_on_its_own_chart_leaves_it),
        cmocka_unit_test(a_sphere_is_cut_into_few_charts),
        cmocka_unit_test(a_box_has_a_chart_a_side),
        cmocka_unit_test(a_rough_surface_keeps_all_promises),
        cmocka_unit_test(many_pages_at_one_edge_and_a_moebius_strip),
        cmocka_unit_test(doubled_faces_lie_in_different_charts),
        cmocka_unit_test(slivers_t_junctions_and_lone_triangles),
        cmocka_unit_test(numbers_far_from_one),
        cmocka_unit_test(texels_name_the_point_that_lies_there),
        cmocka_unit_test(more_charts_than_texels_is_an_error_that_says_which_size_would_do),
        cmocka_unit_test(whole_scenes_fill_most_of_a_texture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
