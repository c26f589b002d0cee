/* Receivers of Direct Radiance Mapping: the camera's G-buffer, what planar mirrors show in it, and the light
 * that is seen directly. */
#include "cache/direct_radiance/direct_radiance.h"
#include "raster_support.h"
#include "receiver_support.h"
#include "scene/ambient.h"

enum { W = 96, H = 72, PIXELS = W * H, MAX = 4096 };

/* ---- scenes ---- */

enum { GREY, MIRROR, OTHER_MIRROR, LAMP, MATERIALS };

typedef struct {
    float xyz[9 * MAX];
    uint32_t material[MAX];
    size_t count;
} mesh;

static void add_quad(mesh *m, uint32_t material, sl_vec3 centre, sl_vec3 a, sl_vec3 b) {
    sl_vec3 p[4] = {sl_sub(sl_sub(centre, a), b), sl_sub(sl_add(centre, a), b), sl_add(sl_add(centre, a), b),
                    sl_add(sl_sub(centre, a), b)};
    sl_vec3 two[6] = {p[0], p[1], p[2], p[0], p[2], p[3]};
    memcpy(m->xyz + 9 * m->count, two, sizeof two);
    m->material[m->count] = m->material[m->count + 1] = material;
    m->count += 2;
}

/* Coordinates in multiples of 2^-10: mirroring them in x = 0 rounds nothing. */
static void add_triangles(mesh *m, uint64_t key, size_t count, sl_vec3 low, sl_vec3 high) {
    const float l[3] = {low.x, low.y, low.z}, h[3] = {high.x, high.y, high.z};
    for (size_t t = 0; t < count; t++, m->count++) {
        for (size_t i = 0; i < 9; i++) {
            float centre = random_between(key, 16 * t + i % 3, l[i % 3], h[i % 3]),
                  off = random_between(key, 16 * t + 3 + i, -0.3f, 0.3f);
            m->xyz[9 * m->count + i] = floorf((centre + off) * 1024.0f) / 1024.0f;
        }
        m->material[m->count] = t % 5 == 0 ? LAMP : GREY;
    }
}

static sl_scene *scene_of(const mesh *m, const sl_environment *environment) {
    static uint32_t indices[3 * MAX];
    for (uint32_t i = 0; i < 3 * m->count; i++) indices[i] = i;
    sl_material materials[MATERIALS] = {
        [GREY] = {.diffuse = {0.5f, 0.25f, 0.125f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX},
        [MIRROR] = {.mirror = {0.75f, 0.5f, 0.25f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX},
        [OTHER_MIRROR] = {.mirror = {0.5f, 0.5f, 1.0f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX},
        [LAMP] = {.emission = {3.0f, 2.0f, 1.0f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX},
    };
    sl_scene_parts parts = {.vertex_count = 3 * m->count,
                            .positions = m->xyz,
                            .triangle_count = m->count,
                            .indices = indices,
                            .material_index = m->material,
                            .material_count = MATERIALS,
                            .materials = materials,
                            .environment = environment};
    sl_scene *scene = NULL;
    sl_error error;
    if (sl_scene_build(&parts, &scene, &error) != SL_OK) fail_msg("%s", error.message);
    assert_int_equal(scene->triangle_count, m->count);
    return scene;
}

/* The views of the tests: a camera, a pyramid that looks aside, and a cube's faces. */
enum { VIEWS = 8 };
static sl_view view_number(int n, sl_vec3 eye, sl_vec3 target) {
    sl_camera camera;
    assert_true(sl_camera_look_at(&camera, eye, target, sl_v3(0, 1, 0), 1.2f));
    sl_frame frame = {camera.right, camera.up, sl_neg(camera.back)};
    if (n == 0) return sl_view_camera(&camera, W, H, 1e-3f, 100.0f);
    if (n == 1) return sl_view_pyramid(&frame, eye, -0.5f, 1.5f, -1.0f, 0.75f, W, H, 1e-3f);
    return sl_view_cube_face(eye, n - 2, H, 1e-3f);
}

static sl_mirrors *mirrors_of(const sl_scene *scene, size_t expected) {
    sl_mirrors *mirrors = NULL;
    assert_int_equal(sl_mirrors_find(scene, 8, &mirrors, NULL), SL_OK);
    assert_int_equal(mirrors->count, expected);
    return mirrors;
}

static sl_receivers *receivers_of(const sl_scene *scene, const sl_raster *raster, const sl_view *view,
                                  const sl_mirrors *mirrors, int reflections, unsigned threads) {
    sl_receivers *receivers = NULL;
    sl_counters counters = {{0}};
    assert_int_equal(
        sl_receivers_render(scene, raster, view, mirrors, reflections, threads, &receivers, &counters, NULL),
        SL_OK);
    assert_int_equal(counters.value[SL_COUNT_RASTER_PASSES], receivers->path_count);
    assert_true(sl_receivers_bytes(receivers) > 60 * (size_t)view->width * (size_t)view->height);
    return receivers;
}

static sl_vec3 vector_at(const float *x, const float *y, const float *z, int i) {
    return sl_v3(x[i], y[i], z[i]);
}
#define AT(gbuffer, what, i) vector_at((gbuffer)->what##_x, (gbuffer)->what##_y, (gbuffer)->what##_z, i)

/* ---- geometry ---- */

static void assert_same_gbuffer(const sl_gbuffer *a, const sl_gbuffer *b, size_t pixels) {
    const void *of_a[15] = {a->id,          a->depth,     a->position_x, a->position_y,  a->position_z,
                            a->normal_x,    a->normal_y,  a->normal_z,   a->geometric_x, a->geometric_y,
                            a->geometric_z, a->diffuse_r, a->diffuse_g,  a->diffuse_b,   a->material};
    const void *of_b[15] = {b->id,          b->depth,     b->position_x, b->position_y,  b->position_z,
                            b->normal_x,    b->normal_y,  b->normal_z,   b->geometric_x, b->geometric_y,
                            b->geometric_z, b->diffuse_r, b->diffuse_g,  b->diffuse_b,   b->material};
    for (int k = 0; k < 15; k++) assert_memory_equal(of_a[k], of_b[k], 4 * pixels);
}

static void without_a_mirror_in_view_receivers_are_the_gbuffer_and_cost_the_same(void **state) {
    (void)state;
    static mesh m;
    m.count = 0;
    add_quad(&m, MIRROR, sl_v3(0, 0, 8), sl_v3(1, 0, 0), sl_v3(0, 1, 0)); /* behind the eye */
    add_triangles(&m, sl_random_key(81, 0), 200, sl_v3(-2, -2, -2), sl_v3(2, 2, 2));
    sl_scene *scene = scene_of(&m, NULL);
    sl_raster *raster = raster_of(scene);
    sl_mirrors *mirrors = mirrors_of(scene, 1);
    sl_view view = view_number(0, sl_v3(0.3f, 0.2f, 5), sl_v3(0, 0, 0));
    sl_gbuffer *g = NULL;
    sl_counters plain = {{0}};
    assert_int_equal(sl_gbuffer_create(W, H, &g, NULL), SL_OK);
    assert_int_equal(sl_raster_gbuffer(raster, &view, 1, g, &plain, NULL), SL_OK);
    for (int n = 0; n < 3; n++) { /* no mirrors, none followed, and none in view */
        sl_receivers *r = NULL;
        sl_counters counters = {{0}};
        assert_int_equal(sl_receivers_render(scene, raster, &view, n == 0 ? NULL : mirrors, n == 1 ? 0 : 2, 1,
                                             &r, &counters, NULL),
                         SL_OK);
        assert_same_gbuffer(r->gbuffer, g, PIXELS);
        assert_null(r->throughput[0]);
        assert_null(r->path);
        assert_int_equal(r->path_count, 1);
        assert_memory_equal(&r->eye[0], &view.origin, sizeof view.origin);
        assert_memory_equal(&counters, &plain, sizeof plain);
        sl_receivers_destroy(r);
    }
    sl_gbuffer_destroy(g);
    sl_mirrors_destroy(mirrors);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

/* The wall x = 0 with a square hole, and what stands before it, walls that reach behind the eye among it; in
 * the hole a mirror, or behind it the copy. */
enum { WALL = 8, BEFORE = 310 };
static sl_scene *wall_and_hole(bool copy, mesh *m) {
    m->count = 0;
    add_quad(m, GREY, sl_v3(0, 2, 0), sl_v3(0, 1, 0), sl_v3(0, 0, 3));
    add_quad(m, GREY, sl_v3(0, -2, 0), sl_v3(0, 1, 0), sl_v3(0, 0, 3));
    add_quad(m, GREY, sl_v3(0, 0, 2), sl_v3(0, 1, 0), sl_v3(0, 0, 1));
    add_quad(m, GREY, sl_v3(0, 0, -2), sl_v3(0, 1, 0), sl_v3(0, 0, 1));
    size_t first = m->count;
    add_triangles(m, sl_random_key(82, 0), 300, sl_v3(0.5f, -2, -2), sl_v3(4, 2, 2));
    add_quad(m, GREY, sl_v3(2.5f, -3, 0), sl_v3(2.5f, 0, 0), sl_v3(0, 0, 3));
    add_quad(m, GREY, sl_v3(2.5f, 3, 0), sl_v3(2.5f, 0, 0), sl_v3(0, 0, 3));
    add_quad(m, GREY, sl_v3(2.5f, 0, -3), sl_v3(2.5f, 0, 0), sl_v3(0, 3, 0));
    add_quad(m, GREY, sl_v3(2.5f, 0, 3), sl_v3(2.5f, 0, 0), sl_v3(0, 3, 0));
    add_quad(m, GREY, sl_v3(5, 0, 0), sl_v3(0, 3, 0), sl_v3(0, 0, 3));
    size_t count = m->count - first;
    assert_true(first == WALL && count == BEFORE);
    if (!copy) add_quad(m, MIRROR, sl_v3(0, 0, 0), sl_v3(0, 1, 0), sl_v3(0, 0, 1));
    for (size_t t = 0; copy && t < count; t++, m->count++) {
        for (size_t k = 0; k < 9; k++)
            m->xyz[9 * m->count + k] = (k % 3 ? 1.0f : -1.0f) * m->xyz[9 * (first + t) + k];
        m->material[m->count] = m->material[first + t];
    }
    return scene_of(m, NULL);
}

/* Mirrored in x = 0. */
static sl_vec3 flipped(sl_vec3 v) { return sl_v3(-v.x, v.y, v.z); }
static bool close_to(sl_vec3 a, sl_vec3 b, float tolerance) {
    return fabsf(a.x - b.x) <= tolerance && fabsf(a.y - b.y) <= tolerance && fabsf(a.z - b.z) <= tolerance;
}

static void a_mirror_shows_what_a_hole_onto_a_copy_of_the_scene_shows(void **state) {
    (void)state;
    static mesh m;
    sl_scene *scene = wall_and_hole(false, &m), *copy = wall_and_hole(true, &m);
    sl_raster *raster = raster_of(scene), *copy_raster = raster_of(copy);
    sl_mirrors *mirrors = mirrors_of(scene, 1);
    size_t mirrored = 0, surfaces = 0, differing = 0;
    for (int n = 0; n < VIEWS; n++) {
        sl_view view = view_number(n, sl_v3(0.5f, 0.25f, 0.375f), sl_v3(-1, 0.1f, 0));
        sl_receivers *r = receivers_of(scene, raster, &view, mirrors, 1, 2),
                     *hole = receivers_of(copy, copy_raster, &view, NULL, 0, 2);
        const sl_gbuffer *a = r->gbuffer, *b = hole->gbuffer;
        for (int i = 0; i < view.width * view.height; i++) {
            if (!r->path || !r->path[i]) continue;
            mirrored++;
            assert_true(r->throughput[0][i] == 0.75f && r->throughput[1][i] == 0.5f &&
                        r->throughput[2][i] == 0.25f);
            assert_true(close_to(sl_receiver_eye(r, (size_t)i), flipped(view.origin), 1e-6f));
            uint32_t expected = b->id[i] == SL_NO_INDEX ? SL_NO_INDEX : b->id[i] - BEFORE;
            differing += a->id[i] != expected;
            if (a->id[i] != expected || expected == SL_NO_INDEX) continue;
            surfaces++;
            assert_int_equal(a->material[i], b->material[i]);
            assert_true(a->diffuse_r[i] == b->diffuse_r[i]);
            differing += !close_to(AT(a, position, i), flipped(AT(b, position, i)), 2e-5f);
            assert_true(close_to(AT(a, normal, i), flipped(AT(b, normal, i)), 1e-6f));
            assert_true(close_to(AT(a, geometric, i), flipped(AT(b, geometric, i)), 1e-6f));
        }
        sl_receivers_destroy(r);
        sl_receivers_destroy(hole);
    }
    assert_true(mirrored > 12000 && surfaces > 12000);
    assert_true(differing <= mirrored / 500); /* rounding at edges */
    sl_mirrors_destroy(mirrors);
    sl_raster_destroy(raster);
    sl_raster_destroy(copy_raster);
    sl_scene_destroy(scene);
    sl_scene_destroy(copy);
}

/* Two mirrors face to face at z = -2 and z = 2, things between them. */
static sl_scene *face_to_face(mesh *m, const sl_environment *environment) {
    m->count = 0;
    add_quad(m, MIRROR, sl_v3(0, 0, -2), sl_v3(1.5f, 0, 0), sl_v3(0, 1.5f, 0));
    add_quad(m, OTHER_MIRROR, sl_v3(0, 0, 2), sl_v3(1.5f, 0, 0), sl_v3(0, 1.5f, 0));
    add_triangles(m, sl_random_key(83, 0), 12, sl_v3(-1, -1, -1), sl_v3(1, 1, 1));
    return scene_of(m, environment);
}

static void two_mirrors_face_to_face_end_at_the_nesting_limit(void **state) {
    (void)state;
    static mesh m;
    sl_environment environment = {.present = true, .constant = {0.5f, 1.0f, 2.0f}};
    sl_scene *scene = face_to_face(&m, &environment);
    sl_raster *raster = raster_of(scene);
    sl_mirrors *mirrors = mirrors_of(scene, 2);
    sl_view view = view_number(0, sl_v3(0.2f, 0.1f, 1.5f), sl_v3(0, 0, -2));
    static float red[PIXELS], green[PIXELS], blue[PIXELS];
    for (int reflections = 0; reflections <= 3; reflections++) {
        sl_receivers *r = receivers_of(scene, raster, &view, mirrors, reflections, 1);
        int left = 0;
        memset(red, 0, sizeof red);
        memset(green, 0, sizeof green);
        memset(blue, 0, sizeof blue);
        add_emission(scene, r, (float *const[3]){red, green, blue});
        for (int i = 0; i < PIXELS; i++) {
            assert_true(isfinite(red[i]) && isfinite(AT(r->gbuffer, normal, i).x));
            uint32_t id = r->gbuffer->id[i];
            if (id == SL_NO_INDEX || mirrors->of_triangle[id] == SL_NO_INDEX) continue;
            left++;
            const sl_rgb ks = scene->materials[r->gbuffer->material[i]].mirror;
            assert_true(red[i] == ks.r * 0.5f && green[i] == ks.g && blue[i] == ks.b * 2.0f);
        }
        assert_true(left > 50);
        assert_int_equal(r->path_count, 1 + (size_t)reflections);
        sl_receivers_destroy(r);
    }
    sl_mirrors_destroy(mirrors);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

static void reflectances_multiply_along_a_path(void **state) {
    (void)state;
    static mesh m;
    sl_scene *scene = face_to_face(&m, NULL);
    sl_raster *raster = raster_of(scene);
    sl_mirrors *mirrors = mirrors_of(scene, 2);
    sl_view view = view_number(0, sl_v3(0.2f, 0.1f, 1.5f), sl_v3(0, 0, -2));
    sl_receivers *r = receivers_of(scene, raster, &view, mirrors, 3, 1);
    /* The far mirror, then the near one, then the far one again. */
    const sl_rgb expected[4] = {
        {1.0f, 1.0f, 1.0f}, {0.75f, 0.5f, 0.25f}, {0.375f, 0.25f, 0.25f}, {0.28125f, 0.125f, 0.0625f}};
    const float eye_z[4] = {1.5f, -5.5f, 9.5f, -13.5f};
    size_t seen[4] = {0};
    for (int i = 0; i < PIXELS; i++) {
        const sl_rgb e = expected[r->path[i]];
        assert_true(r->throughput[0][i] == e.r && r->throughput[1][i] == e.g && r->throughput[2][i] == e.b);
        assert_true(fabsf(sl_receiver_eye(r, (size_t)i).z - eye_z[r->path[i]]) < 1e-5f);
        seen[r->path[i]]++;
    }
    for (int p = 0; p < 4; p++) assert_true(seen[p] > 50);
    sl_receivers_destroy(r);
    sl_mirrors_destroy(mirrors);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

/* ---- emission ---- */

static void emitters_shine_from_their_front_in_mirrors_too(void **state) {
    (void)state;
    static mesh m;
    m.count = 0;
    /* shines towards -x: the mirror shows its front */
    add_quad(&m, LAMP, sl_v3(2, 0, -1), sl_v3(0, 0, 0.5f), sl_v3(0, 0.5f, 0));
    add_quad(&m, MIRROR, sl_v3(0, 0, 0), sl_v3(0, 3, 0), sl_v3(0, 0, 3));
    sl_scene *scene = scene_of(&m, NULL);
    sl_raster *raster = raster_of(scene);
    sl_mirrors *mirrors = mirrors_of(scene, 1);
    sl_view view = view_number(0, sl_v3(4, 0.25f, 1.5f), sl_v3(0, 0, -1));
    sl_receivers *r = receivers_of(scene, raster, &view, mirrors, 1, 1);
    static float red[PIXELS], green[PIXELS], blue[PIXELS];
    for (int i = 0; i < PIXELS; i++) red[i] = 0.5f; /* added to */
    add_emission(scene, r, (float *const[3]){red, green, blue});
    int back = 0, front = 0;
    bool turned = scene->geometric_normal_x[0] > 0.0f;
    for (int i = 0; i < PIXELS; i++) {
        uint32_t id = r->gbuffer->id[i];
        bool lamp = id == 0 || id == 1, shines = lamp && (r->path[i] != 0) != turned;
        assert_true(red[i] == (shines ? 3.5f : 0.5f) && green[i] == (shines ? 2.0f : 0.0f) &&
                    blue[i] == (shines ? 1.0f : 0.0f));
        front += shines;
        back += lamp && !shines;
    }
    assert_true(front > 20 && back > 20);
    sl_receivers_destroy(r);
    sl_mirrors_destroy(mirrors);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

/* Every texel of its own colour. */
static void paint(sl_environment *e, float *texels, int width, int height) {
    for (int i = 0; i < width * height; i++) {
        texels[3 * i] = (float)(i % width);
        texels[3 * i + 1] = (float)(i / width);
        texels[3 * i + 2] = 1.0f;
    }
    *e = (sl_environment){.present = true, .width = width, .height = height, .texels = texels};
}

static sl_vec3 direction_of_pixel(const sl_view *view, int i) { /* of a cube's face */
    sl_vec3 x = sl_v3(view->clip[0][0], view->clip[0][1], view->clip[0][2]),
            y = sl_v3(view->clip[1][0], view->clip[1][1], view->clip[1][2]);
    sl_vec3 z = sl_v3(view->clip[3][0], view->clip[3][1], view->clip[3][2]);
    float u = (2.0f * (float)(i % view->width) + 1.0f) / (float)view->width - 1.0f;
    float v = (2.0f * (float)(i / view->width) + 1.0f) / (float)view->height - 1.0f;
    return sl_normalize_or(sl_mad(sl_mad(z, u, x), v, y), z);
}

static void the_environment_is_seen_in_the_direction_that_the_mirror_sends_the_eye(void **state) {
    (void)state;
    static mesh m;
    static float texels[3 * 64 * 32], red[PIXELS], green[PIXELS], blue[PIXELS];
    sl_environment environment;
    paint(&environment, texels, 64, 32);
    m.count = 0;
    add_quad(&m, MIRROR, sl_v3(0, 0, 0), sl_v3(0, 1, 0), sl_v3(0, 0, 1));
    sl_scene *scene = scene_of(&m, &environment);
    sl_raster *raster = raster_of(scene);
    sl_mirrors *mirrors = mirrors_of(scene, 1);
    size_t mirrored = 0, direct = 0, differing = 0;
    for (int face = 0; face < 6; face++) {
        sl_view view = view_number(2 + face, sl_v3(0.7f, 0.2f, 0.1f), sl_v3(0, 0, 0));
        sl_receivers *r = receivers_of(scene, raster, &view, mirrors, 1, 1);
        memset(red, 0, sizeof red);
        memset(green, 0, sizeof green);
        memset(blue, 0, sizeof blue);
        add_emission(scene, r, (float *const[3]){red, green, blue});
        for (int i = 0; i < view.width * view.height; i++) {
            bool reflected = r->path && r->path[i];
            sl_vec3 d = direction_of_pixel(&view, i);
            sl_rgb expected = sl_environment_radiance(&scene->environment, reflected ? flipped(d) : d);
            differing += red[i] != expected.r || green[i] != expected.g || blue[i] != expected.b;
            mirrored += reflected;
            direct += !reflected;
        }
        sl_receivers_destroy(r);
    }
    assert_true(mirrored > 3000 && direct > 10000);
    assert_true(differing < (mirrored + direct) / 1000); /* rounding at texels' edges */
    sl_mirrors_destroy(mirrors);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

static void the_mean_of_an_environment_is_taken_by_solid_angle(void **state) {
    (void)state;
    static mesh m;
    static float texels[3 * 8 * 64];
    for (int i = 0; i < 8 * 64; i++)
        texels[3 * i] = i < 8 * 32 ? 1.0f : 0.0f, texels[3 * i + 1] = 2.0f,
                   texels[3 * i + 2] = i < 8 * 16 ? 1.0f : 0.0f;
    sl_environment environment = {.present = true, .width = 8, .height = 64, .texels = texels};
    m.count = 0;
    add_quad(&m, GREY, sl_v3(0, 0, 0), sl_v3(0, 1, 0), sl_v3(0, 0, 1));
    sl_scene *scene = scene_of(&m, &environment);
    sl_rgb mean = sl_environment_mean(&scene->environment);
    assert_true(fabsf(mean.r - 0.5f) < 1e-6f && fabsf(mean.g - 2.0f) < 1e-6f);
    assert_true(fabs((double)mean.b - 0.5 * (1.0 - sqrt(0.5))) < 1e-6); /* a cap of 45 degrees */
    sl_scene_destroy(scene);
    sl_environment constant = {.present = true, .constant = {1.0f, 2.0f, 3.0f}}, none = {.present = false};
    assert_true(sl_environment_mean(&constant).b == 3.0f && sl_environment_mean(&none).r == 0.0f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_a_mirror_in_view_receivers_are_the_gbuffer_and_cost_the_same),
        cmocka_unit_test(a_mirror_shows_what_a_hole_onto_a_copy_of_the_scene_shows),
        cmocka_unit_test(two_mirrors_face_to_face_end_at_the_nesting_limit),
        cmocka_unit_test(reflectances_multiply_along_a_path),
        cmocka_unit_test(emitters_shine_from_their_front_in_mirrors_too),
        cmocka_unit_test(the_environment_is_seen_in_the_direction_that_the_mirror_sends_the_eye),
        cmocka_unit_test(the_mean_of_an_environment_is_taken_by_solid_angle),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
