/* Planar mirrors: the mirrored view against the mirrored scene and against reflected rays; the stencil; paths
 * over several mirrors. */
#include "base/math.h"
#include "raster/views/mirror.h"
#include "raster_support.h"

enum { W = 160, H = 120, PIXELS = W * H };

static sl_camera camera_at(sl_vec3 eye, sl_vec3 target, float fov) {
    sl_camera camera;
    assert_true(sl_camera_look_at(&camera, eye, target, sl_v3(0, 1, 0), fov));
    return camera;
}

/* ---- scenes ---- */

/* Random triangles with coordinates in multiples of 2^-10, so that mirroring them rounds nothing. */
static void dyadic_triangles(float *xyz, size_t count, uint64_t key, sl_vec3 low, sl_vec3 high) {
    const float l[3] = {low.x, low.y, low.z}, h[3] = {high.x, high.y, high.z};
    for (size_t t = 0; t < count; t++) {
        for (size_t i = 0; i < 9; i++) {
            float centre = random_between(key, 16 * t + i % 3, l[i % 3], h[i % 3]),
                  off = random_between(key, 16 * t + 3 + i, -0.4f, 0.4f);
            xyz[9 * t + i] = floorf((centre + off) * 1024.0f) / 1024.0f;
        }
    }
}

static sl_scene *mirrored_copy(const float *xyz, size_t count, const sl_plane *plane) {
    float *copy = malloc(9 * count * sizeof *copy);
    assert_non_null(copy);
    for (size_t i = 0; i < 3 * count; i++) {
        sl_vec3 p = sl_to_float(sl_plane_reflect(
            plane, sl_v3d((double)xyz[3 * i], (double)xyz[3 * i + 1], (double)xyz[3 * i + 2])));
        memcpy(copy + 3 * i, &p, sizeof p);
    }
    sl_scene *scene = scene_of_triangles(copy, count);
    assert_int_equal(scene->triangle_count, count);
    free(copy);
    return scene;
}

/* The view of the mirrored copy: as it is, but for 1/w depth and the mirror as near plane. */
static sl_view view_behind(const sl_view *view, const sl_plane *plane, double offset) {
    sl_view v = *view;
    double height = sl_dotd(plane->normal, sl_to_double(view->origin)) - plane->distance,
           side = height > 0.0 ? -1.0 : 1.0;
    v.depth = SL_DEPTH_INVERSE_W;
    v.clip[2][0] = (float)(side * plane->normal.x);
    v.clip[2][1] = (float)(side * plane->normal.y);
    v.clip[2][2] = (float)(side * plane->normal.z);
    v.clip[2][3] = (float)(-fabs(height) - offset);
    return v;
}

/* ---- the view ---- */

static uint32_t id[PIXELS], other_id[PIXELS];
static float depth[PIXELS], other_depth[PIXELS];

/* Returns how many pixels differ; in_sight: how many show something. */
static int compare_with_copy(const float *xyz, size_t count, const sl_view *view, const sl_plane *plane,
                             int *in_sight) {
    sl_scene *scene = scene_of_triangles(xyz, count), *copy = mirrored_copy(xyz, count, plane);
    assert_int_equal(scene->triangle_count, count);
    sl_raster *raster = raster_of(scene), *copy_raster = raster_of(copy);
    sl_view mirrored, behind = view_behind(view, plane, 1e-4);
    assert_true(sl_view_mirrored(view, plane, 1e-4, &mirrored));
    render(raster, &mirrored, 1, id, depth);
    render(copy_raster, &behind, 1, other_id, other_depth);
    int differing = 0;
    *in_sight = 0;
    for (int i = 0; i < PIXELS; i++) {
        differing += id[i] != other_id[i];
        *in_sight += id[i] != SL_NO_INDEX;
        if (id[i] == other_id[i])
            assert_true(fabsf(depth[i] - other_depth[i]) <= 1e-5f * fabsf(depth[i]) + 1e-7f);
    }
    sl_raster_destroy(raster);
    sl_raster_destroy(copy_raster);
    sl_scene_destroy(scene);
    sl_scene_destroy(copy);
    return differing;
}

static void a_view_in_an_axis_aligned_mirror_is_that_of_the_mirrored_scene_pixel_by_pixel(void **state) {
    (void)state;
    enum { COUNT = 150 };
    static float xyz[9 * COUNT];
    uint64_t key = sl_random_key(61, 0);
    for (uint64_t n = 0; n < 30; n++) {
        dyadic_triangles(xyz, COUNT, key + n, sl_v3(-2, -2, -2), sl_v3(2, 2, 2));
        sl_plane plane = {{0, 0, 0}, 0.25 * (double)(n % 5) - 3.0};
        double sign = n % 2 ? 1.0 : -1.0;
        if (n % 3 == 0) plane.normal.x = sign;
        if (n % 3 == 1) plane.normal.y = sign;
        if (n % 3 == 2) plane.normal.z = sign;
        plane.distance *= sign;
        sl_camera camera = camera_at(sl_v3(1.5f, 1.25f, 2.5f),
                                     n % 3 == 0   ? sl_v3(-5, 0.5f, 0)
                                     : n % 3 == 1 ? sl_v3(0, -5, 0.5f)
                                                  : sl_v3(0.5f, 0, -5),
                                     1.2f);
        sl_view view = sl_view_camera(&camera, W, H, 0.01f, 100.0f);
        int in_sight;
        assert_int_equal(compare_with_copy(xyz, COUNT, &view, &plane, &in_sight), 0);
        assert_true(in_sight > 500);
        for (int i = 0; i < PIXELS; i++) assert_true(depth[i] == other_depth[i]);
    }
}

static void mirrors_that_show_nothing_are_said_so(void **state) {
    (void)state;
    sl_camera camera = camera_at(sl_v3(0, 0, 0), sl_v3(0, 0, -1), 1.0f);
    sl_view view = sl_view_camera(&camera, W, H, 0.01f, 100.0f), out;
    sl_plane plane;
    assert_false(sl_plane_through(sl_v3(0, 0, 0), sl_v3(1, 1, 1), sl_v3(2, 2, 2), &plane));
    assert_false(sl_plane_through(sl_v3(0, 0, 0), sl_v3(0, 0, 0), sl_v3(0, 0, 0), &plane));
    assert_false(sl_plane_through(sl_v3(0, 0, NAN), sl_v3(1, 0, 0), sl_v3(0, 1, 0), &plane));
    const sl_plane none[] = {
        {{0, 0, 0}, 1}, {{NAN, 0, 0}, 1}, {{0, 0, 1}, NAN}, {{0, 0, 1}, INFINITY},
        {{0, 2, 0}, 1}, {{0, 1, 0}, 0},   {{0, 0, 1}, 1e-7}}; /* the last two: at the eye's plane */
    for (size_t i = 0; i < sizeof none / sizeof none[0]; i++)
        assert_false(sl_view_mirrored(&view, &none[i], 1e-6, &out));
    plane = (sl_plane){{0, 1, 0}, -1e-3}; /* a thousandth below the eye: seen nearly edge-on, but seen */
    assert_true(sl_view_mirrored(&view, &plane, 1e-6, &out));
    for (int r = 0; r < 4; r++) {
        for (int k = 0; k < 4; k++) assert_true(isfinite(out.clip[r][k]));
    }
}

/* ---- whole pictures, against reflected rays ---- */

static sl_scene *scene_with_materials(const float *xyz, size_t count, const uint32_t *material) {
    uint32_t *indices = malloc((3 * count) * sizeof *indices);
    assert_non_null(indices);
    for (uint32_t i = 0; i < 3 * count; i++) indices[i] = i;
    sl_material materials[3] = {
        {.diffuse = {0.5f, 0.5f, 0.5f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX},
        {.mirror = {0.9f, 0.9f, 0.9f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX},
        {.mirror = {0.5f, 0.9f, 0.9f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX},
    };
    sl_scene_parts parts = {.vertex_count = 3 * count,
                            .positions = xyz,
                            .triangle_count = count,
                            .indices = indices,
                            .material_index = material,
                            .material_count = 3,
                            .materials = materials};
    sl_scene *scene = NULL;
    assert_int_equal(sl_scene_build(&parts, &scene, NULL), SL_OK);
    free(indices);
    return scene;
}

static size_t add_quad(float *xyz, size_t at, sl_vec3 centre, sl_vec3 a, sl_vec3 b) {
    sl_vec3 p[4] = {sl_sub(sl_sub(centre, a), b), sl_sub(sl_add(centre, a), b), sl_add(sl_add(centre, a), b),
                    sl_add(sl_sub(centre, a), b)};
    sl_vec3 two[6] = {p[0], p[1], p[2], p[0], p[2], p[3]};
    memcpy(xyz + 9 * at, two, sizeof two);
    return 2;
}

/* A room, six balls, a mirror hung on the back wall, another slanted on the left. 0, 1: first mirror, 2, 3:
 * second. */
static sl_scene *room_with_mirrors(void) {
    enum { N = 4, BALLS = 6, MAX = 4 + 12 * N * N * (BALLS + 1) };
    static float xyz[9 * MAX];
    static uint32_t material[MAX];
    size_t at = add_quad(xyz, 0, sl_v3(2.1f, 1.6f, 0.05f), sl_v3(1.2f, 0, 0), sl_v3(0, 1.0f, 0));
    at += add_quad(xyz, at, sl_v3(0.5f, 1.4f, 2.4f), sl_v3(0.3f, 0.1f, 1.1f), sl_v3(-0.05f, 0.9f, 0));
    at += add_box(xyz, at, sl_v3(0, 0, 0), sl_v3(4, 3, 5), N, NULL, NULL);
    uint64_t key = sl_random_key(77, 1);
    for (uint64_t b = 0; b < BALLS; b++) {
        ball shape = {sl_v3(random_between(key, 4 * b, 1.3f, 3.6f),
                            random_between(key, 4 * b + 1, 0.3f, 2.7f),
                            random_between(key, 4 * b + 2, 0.5f, 4.5f)),
                      random_between(key, 4 * b + 3, 0.1f, 0.35f)};
        sl_vec3 half = sl_v3(0.1f, 0.1f, 0.1f);
        at += add_box(xyz, at, sl_sub(shape.centre, half), sl_add(shape.centre, half), N, onto_ball, &shape);
    }
    for (size_t t = 0; t < at; t++) material[t] = t < 2 ? 1 : t < 4 ? 2 : 0;
    sl_scene *scene = scene_with_materials(xyz, at, material);
    assert_int_equal(scene->triangle_count, at);
    return scene;
}

/* Nearest triangle along d, but not one of mirror `left`; Moeller and Trumbore 1997. */
static uint32_t nearest_hit(const sl_scene *s, const sl_mirrors *mirrors, sl_vec3d o, sl_vec3d d,
                            uint32_t left, double *distance) {
    uint32_t hit = SL_NO_INDEX;
    *distance = INFINITY;
    for (uint32_t t = 0; t < s->triangle_count; t++) {
        if (left != SL_NO_INDEX && mirrors->of_triangle[t] == left) continue;
        sl_vec3d p[3];
        for (int k = 0; k < 3; k++) p[k] = sl_to_double(sl_scene_position(s, s->vertex[k][t]));
        sl_vec3d e1 = sl_subd(p[1], p[0]), e2 = sl_subd(p[2], p[0]), h = sl_crossd(d, e2),
                 from = sl_subd(o, p[0]);
        double det = sl_dotd(e1, h);
        if (det == 0.0) continue;
        double u = sl_dotd(from, h) / det;
        sl_vec3d q = sl_crossd(from, e1);
        double v = sl_dotd(d, q) / det, at = sl_dotd(e2, q) / det;
        if (u < 0.0 || v < 0.0 || u + v > 1.0 || !(at > 1e-9) || !(at < *distance)) continue;
        *distance = at;
        hit = t;
    }
    return hit;
}

/* What the pixel shows after at most `reflections`, and over which mirrors (as digits to base 4, the first
 * lowest). */
static uint32_t follow_ray(const sl_scene *s, const sl_mirrors *mirrors, const sl_camera *camera, int pixel,
                           int reflections, int *way) {
    double tangent = sl_tan(0.5 * (double)camera->vertical_fov), aspect = (double)W / H;
    double x = ((double)(pixel % W) + 0.5) * (2.0 / W) - 1.0,
           y = ((double)(pixel / W) + 0.5) * (2.0 / H) - 1.0;
    sl_vec3d d =
        sl_addd(sl_scaled(sl_to_double(camera->right), x * tangent * aspect),
                sl_subd(sl_scaled(sl_to_double(camera->up), y * tangent), sl_to_double(camera->back)));
    sl_vec3d o = sl_to_double(camera->eye);
    uint32_t left = SL_NO_INDEX;
    *way = 0;
    for (int n = 0, digit = 1;; n++, digit *= 4) {
        double distance;
        uint32_t hit = nearest_hit(s, mirrors, o, d, left, &distance);
        if (hit == SL_NO_INDEX || mirrors->of_triangle[hit] == SL_NO_INDEX || n == reflections) return hit;
        left = mirrors->of_triangle[hit];
        *way += digit * ((int)left + 1);
        sl_vec3d normal = mirrors->plane[left].normal;
        o = sl_addd(o, sl_scaled(d, distance));
        d = sl_subd(d, sl_scaled(normal, 2.0 * sl_dotd(d, normal)));
    }
}

static int way_of(const sl_mirrored_image *image, uint8_t path) {
    if (path == 0) return 0;
    int digit = 1;
    for (int n = 1; n < image->paths[path].reflections; n++) digit *= 4;
    return way_of(image, image->paths[path].before) + digit * ((int)image->paths[path].mirror + 1);
}

static uint8_t path_of(const sl_mirrored_image *image, int pixel) {
    return image->path ? image->path[pixel] : 0;
}

static void a_picture_with_mirrors_is_that_of_reflected_rays(void **state) {
    (void)state;
    sl_scene *scene = room_with_mirrors();
    sl_raster *raster = raster_of(scene);
    sl_mirrors *mirrors = NULL;
    assert_int_equal(sl_mirrors_find(scene, 8, &mirrors, NULL), SL_OK);
    assert_int_equal(mirrors->count, 2);
    sl_camera camera = camera_at(sl_v3(3.2f, 1.7f, 3.9f), sl_v3(1.0f, 1.3f, 0.8f), 1.1f);
    sl_view view = sl_view_camera(&camera, W, H, 0.01f, 100.0f);
    for (int reflections = 0; reflections <= 2; reflections++) {
        sl_mirrored_image *image = NULL;
        sl_counters counters = {{0}};
        assert_int_equal(
            sl_raster_mirrored(raster, &view, mirrors, reflections, 2, id, depth, &image, &counters, NULL),
            SL_OK);
        assert_int_equal(counters.value[SL_COUNT_RASTER_PASSES], image->path_count);
        assert_true(reflections == 0 ? image->path_count == 1
                                     : image->path_count > 2 + (size_t)(reflections - 1));
        int differing = 0, deepest = 0;
        for (int i = 0; i < PIXELS; i += 3) {
            int way;
            uint32_t expected = follow_ray(scene, mirrors, &camera, i, reflections, &way);
            differing += expected != image->id[i] || way != way_of(image, path_of(image, i));
            deepest += image->paths[path_of(image, i)].reflections == reflections;
        }
        assert_true(deepest > 20);
        assert_true(differing <= PIXELS / 3 / 300); /* rays and snapped vertices at edges */
        sl_mirrored_image_destroy(image);
    }
    sl_mirrors_destroy(mirrors);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

/* Facing mirrors fill the stencil's 255 paths and stop there; a mirror seen exactly edge-on covers no pixel;
 * out of sight, no pass. */
static void endless_reflections_end_and_unseen_mirrors_cost_nothing(void **state) {
    (void)state;
    float xyz[9 * 6];
    size_t at = add_quad(xyz, 0, sl_v3(0, 0, -2), sl_v3(1, 0, 0), sl_v3(0, 1, 0));
    at += add_quad(xyz, at, sl_v3(0, 0, 2), sl_v3(1, 0, 0), sl_v3(0, 1, 0));
    at += add_quad(xyz, at, sl_v3(0.3f, 0, 0), sl_v3(0, 0.1f, 0), sl_v3(0, 0, 0.1f));
    const uint32_t material[6] = {1, 1, 1, 1, 0, 0};
    sl_scene *scene = scene_with_materials(xyz, at, material);
    sl_raster *raster = raster_of(scene);
    sl_mirrors *mirrors = NULL;
    assert_int_equal(sl_mirrors_find(scene, 8, &mirrors, NULL), SL_OK);
    assert_int_equal(mirrors->count, 2);
    sl_camera camera = camera_at(sl_v3(0, 0, 0), sl_v3(0, 0, -1), 1.0f);
    sl_view view = sl_view_camera(&camera, W, H, 0.01f, 100.0f);
    sl_mirrored_image *image = NULL;
    sl_counters counters = {{0}};
    assert_int_equal(
        sl_raster_mirrored(raster, &view, mirrors, 1000, 1, other_id, other_depth, &image, &counters, NULL),
        SL_OK);
    assert_true(image->path_count > 10 && image->path_count <= SL_MIRROR_PATHS);
    for (int i = 0; i < PIXELS; i++) assert_true(path_of(image, i) < image->path_count);
    sl_mirrored_image_destroy(image);
    /* in the second mirror's plane, the first's edge far off */
    camera = camera_at(sl_v3(5, 0, 2), sl_v3(4, 0, 2), 1.0f);
    view = sl_view_camera(&camera, W, H, 0.01f, 100.0f);
    assert_int_equal(
        sl_raster_mirrored(raster, &view, mirrors, 4, 1, other_id, other_depth, &image, &counters, NULL),
        SL_OK);
    render(raster, &view, 1, id, depth);
    for (int i = 0; i < PIXELS; i++) assert_int_equal(path_of(image, i) == 0 ? image->id[i] : id[i], id[i]);
    sl_mirrored_image_destroy(image);
    camera = camera_at(sl_v3(5, 0, 0), sl_v3(6, 0, 0), 1.0f); /* looking away */
    view = sl_view_camera(&camera, W, H, 0.01f, 100.0f);
    assert_int_equal(
        sl_raster_mirrored(raster, &view, mirrors, 4, 1, other_id, other_depth, &image, &counters, NULL),
        SL_OK);
    assert_int_equal(image->path_count, 1);
    sl_mirrored_image_destroy(image);
    sl_mirrors_destroy(mirrors);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

static void planar_mirrors_are_found_by_plane_and_material(void **state) {
    (void)state;
    float xyz[9 * 8];
    size_t at = add_quad(xyz, 0, sl_v3(0, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0));
    at += add_quad(xyz, at, sl_v3(3, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0)); /* the same plane */
    /* the same, facing the other way */
    at += add_quad(xyz, at, sl_v3(6, 0, 0), sl_v3(0, 1, 0), sl_v3(1, 0, 0));
    at += add_quad(xyz, at, sl_v3(0, 5, 3), sl_v3(0.5f, 0, 0.5f), sl_v3(0, 0.5f, 0));
    const uint32_t material[8] = {1, 1, 2, 2, 1, 1, 1, 1};
    sl_scene *scene = scene_with_materials(xyz, at, material);
    sl_mirrors *mirrors = NULL;
    assert_int_equal(sl_mirrors_find(scene, 8, &mirrors, NULL), SL_OK);
    assert_int_equal(mirrors->count, 3);
    const uint32_t expected[8] = {0, 0, 1, 1, 0, 0, 2, 2};
    for (int t = 0; t < 8; t++) assert_int_equal(mirrors->of_triangle[t], expected[t]);
    assert_true(fabs(fabs(mirrors->plane[0].normal.z) - 1.0) < 1e-12 &&
                fabs(mirrors->plane[0].distance) < 1e-12);
    sl_mirrors_destroy(mirrors);
    assert_int_equal(sl_mirrors_find(scene, 1, &mirrors, NULL), SL_OK); /* the largest alone */
    assert_int_equal(mirrors->count, 1);
    assert_int_equal(mirrors->of_triangle[6], SL_NO_INDEX);
    sl_mirrors_destroy(mirrors);
    assert_int_equal(sl_mirrors_find(scene, 0, &mirrors, NULL), SL_OK);
    assert_int_equal(mirrors->count, 0);
    sl_mirrors_destroy(mirrors);
    for (uint32_t i = 0; i < scene->vertex_count; i++) { /* shading normals of a bulge: a curved mirror */
        sl_vec3 n = sl_normalize_or(sl_v3(0.1f * (float)(i % 3), 0.1f, 1), sl_v3(0, 0, 1));
        scene->normal_x[i] = n.x;
        scene->normal_y[i] = n.y;
        scene->normal_z[i] = n.z;
    }
    assert_int_equal(sl_mirrors_find(scene, 8, &mirrors, NULL), SL_OK);
    assert_int_equal(mirrors->count, 0);
    sl_mirrors_destroy(mirrors);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_view_in_an_axis_aligned_mirror_is_that_of_the_mirrored_scene_pixel_by_pixel),
        cmocka_unit_test(mirrors_that_show_nothing_are_said_so),
        cmocka_unit_test(a_picture_with_mirrors_is_that_of_reflected_rays),
        cmocka_unit_test(endless_reflections_end_and_unseen_mirrors_cost_nothing),
        cmocka_unit_test(planar_mirrors_are_found_by_plane_and_material),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
