/* The resolution of visible pixels: the lanes against the plain forms bit by bit, and those against long
 * double. */
#include "raster_support.h"

#include "raster/resolve/barycentrics.h"
#include "scene/surface_rules.h"
#include "scene_parts.h"

static const char *const isas[] = {"baseline", "avx2", "avx512"};

static sl_raster *raster_for(const sl_scene *scene, const char *isa) {
    assert_int_equal(setenv("SOFTLUX_ISA", isa, 1), 0);
    sl_raster *raster = raster_of(scene);
    unsetenv("SOFTLUX_ISA");
    return raster;
}

static bool same_bits(float a, float b) { return memcmp(&a, &b, sizeof a) == 0; }

/* ---- random triangles of every kind ---- */

typedef enum { BIG, SMALL, SLIVER, NEAR, BEHIND, KINDS } kind;
static const char *const kind_names[KINDS] = {"big", "small", "slivers", "near", "behind the eye"};

enum { SIZE = 96, PIXELS = SIZE * SIZE, TRIANGLES = 2000 };

static sl_view forward_view(int width, int height) {
    sl_frame frame = {sl_v3(1, 0, 0), sl_v3(0, 1, 0), sl_v3(0, 0, 1)};
    return sl_view_pyramid(&frame, sl_v3(0, 0, 0), -1, 1, -1, 1, width, height, 1e-3f);
}

static sl_vec3 seen_point(uint64_t key, uint64_t i) {
    float z = random_between(key, 4 * i + 2, 0.5f, 20.0f);
    return sl_v3(z * random_between(key, 4 * i, -1.2f, 1.2f), z * random_between(key, 4 * i + 1, -1.2f, 1.2f),
                 z);
}

static sl_vec3 nearby(uint64_t key, uint64_t i, sl_vec3 p, float distance) {
    return sl_mad(p, distance * p.z, random_direction(key, i));
}

static void make_triangle(kind k, uint64_t i, sl_vec3 p[3]) {
    uint64_t key = sl_random_key(300 + (uint64_t)k, i);
    const float pixel = 2.0f / SIZE;
    for (uint64_t c = 0; c < 3; c++) p[c] = seen_point(key, 100 + c);
    if (k == SMALL) {
        for (uint64_t c = 1; c < 3; c++)
            p[c] = nearby(key, c, p[0], pixel * random_between(key, 50, 0.3f, 8.0f));
    } else if (k == SLIVER) {
        p[2] = nearby(key, 2, sl_mad(p[0], 0.5f, sl_sub(p[1], p[0])),
                      pixel * random_between(key, 50, 0.001f, 0.3f));
    } else if (k == NEAR) {
        p[0].z = random_between(key, 51, 1e-3f, 5e-3f);
    } else if (k == BEHIND) {
        p[i % 3].z = -p[i % 3].z;
        if (i % 2) p[(i + 1) % 3].z *= -0.5f;
    }
}

static sl_scene *scene_of_kind(kind k) {
    float *xyz = malloc((size_t)TRIANGLES * 9 * sizeof *xyz);
    assert_non_null(xyz);
    for (uint64_t i = 0; i < TRIANGLES; i++) {
        sl_vec3 p[3];
        make_triangle(k, i, p);
        memcpy(xyz + 9 * i, p, sizeof p);
    }
    sl_scene *scene = scene_of_triangles(xyz, TRIANGLES);
    free(xyz);
    return scene;
}

static sl_scene *scene_of_one(const sl_scene *all, uint32_t triangle) {
    float xyz[9];
    for (int k = 0; k < 3; k++) {
        sl_vec3 p = sl_scene_position(all, all->vertex[k][triangle]);
        memcpy(xyz + 3 * k, &p, sizeof p);
    }
    return scene_of_triangles(xyz, 1);
}

/* ---- accuracy ---- */

/* Weights of all corners; false where the pixel is outside the triangle as it stands, before snapping. */
static bool exact_weights(const sl_view *view, const sl_vec3 q[3], int i, int j, long double b[3]) {
    long double x[3], y[3], w[3], e[3], sum = 0;
    for (int k = 0; k < 3; k++) {
        long double clip[4];
        for (int r = 0; r < 4; r++) {
            clip[r] = (long double)view->clip[r][0] * (long double)q[k].x +
                      (long double)view->clip[r][1] * (long double)q[k].y +
                      (long double)view->clip[r][2] * (long double)q[k].z + (long double)view->clip[r][3];
        }
        w[k] = clip[3];
        x[k] = clip[0] - w[k] * ((2.0L * i + 1.0L) / view->width - 1.0L);
        y[k] = clip[1] - w[k] * ((2.0L * j + 1.0L) / view->height - 1.0L);
    }
    for (int k = 0; k < 3; k++) e[k] = x[(k + 1) % 3] * y[(k + 2) % 3] - x[(k + 2) % 3] * y[(k + 1) % 3];
    for (int k = 0; k < 3; k++) sum += e[k];
    bool inside = sum != 0.0L;
    for (int k = 0; k < 3; k++) {
        b[k] = inside ? e[k] / sum : 0.0L;
        inside = inside && b[k] >= 0.0L;
    }
    return inside;
}

typedef struct {
    double worst, sum;
    size_t pixels;
} errors;

static void add_error(errors *e, double error) {
    assert_true(error >= 0.0); /* not NaN */
    e->worst = fmax(e->worst, error);
    e->sum += error;
    e->pixels++;
}

/* Errors of a perspective-correct attribute in [0,1], at the pixels that the triangle covers when it is
 * alone. */
static errors errors_of_triangle(const sl_scene *one, const sl_view *view, uint64_t key, errors total) {
    static uint32_t id[PIXELS];
    static float out[PIXELS];
    sl_raster *raster = raster_of(one);
    float attribute[3];
    sl_vec3 q[3];
    for (uint64_t k = 0; k < 3; k++) attribute[one->vertex[k][0]] = random_between(key, k, 0.0f, 1.0f);
    for (int k = 0; k < 3; k++) q[k] = sl_sub(sl_scene_position(one, one->vertex[k][0]), view->origin);
    sl_counters counters = {{0}};
    render(raster, view, 1, id, NULL);
    sl_raster_gouraud(raster, view, 1, id, &(sl_gouraud_pass){.channels = 1, .vertex = attribute, .out = out},
                      &counters);
    for (int i = 0; i < PIXELS; i++) {
        long double b[3], exact = 0;
        if (id[i] != 0 || !exact_weights(view, q, i % SIZE, i / SIZE, b)) continue;
        for (int k = 0; k < 3; k++) exact += b[k] * (long double)attribute[one->vertex[k][0]];
        add_error(&total, (double)fabsl((long double)out[i] - exact));
    }
    sl_raster_destroy(raster);
    return total;
}

static void attributes_are_as_accurate_as_floats_allow(void **state) {
    const sl_scene *const *scenes = *state;
    sl_view view = forward_view(SIZE, SIZE);
    for (int k = 0; k < KINDS; k++) {
        errors total = {0};
        for (uint32_t t = 0; t < 400 && t < scenes[k]->triangle_count; t++) {
            sl_scene *one = scene_of_one(scenes[k], t);
            total = errors_of_triangle(one, &view, sl_random_key(77, t), total);
            sl_scene_destroy(one);
        }
        if (total.pixels < 50 || total.worst > 1.2e-7 || total.sum > 2e-8 * (double)total.pixels) {
            fail_msg("%s: %zu pixels, worst error %g, mean %g", kind_names[k], total.pixels, total.worst,
                     total.sum / (double)total.pixels);
        }
    }
}

/* A pixel that the snapping draws beside a right triangle: half a pixel beyond its slanted edge the nearest
 * point is half way between the legs' ends, moved by the pixel's place along the edge. */
static void a_pixel_beside_its_triangle_takes_the_nearest_point_of_the_edge(void **state) {
    sl_view view = flat_view(64, 32); /* pixels are not square in clip space */
    const float xyz[9] = {-0.5f, -0.5f, 0, 0.5f, -0.5f, 0, -0.5f, 0.5f, 0}; /* legs of 32 and 16 pixels */
    sl_scene *scene = scene_of_triangles(xyz, 1);
    sl_raster *raster = raster_of(scene);
    for (uint32_t j = 8; j < 24; j++) {
        /* In pixels from the right angle's corner: the edge is x / 32 + y / 16 = 1. */
        uint32_t i = 48 - 2 * (j - 8) + 1, pixel = j * 64 + i, zero = 0;
        double x = i + 0.5 - 16.0, y = j + 0.5 - 8.0, beyond = (x + 2 * y - 32.0) / 5.0;
        float w1, w2;
        sl_raster_barycentrics(raster, &view, 1, &pixel, &zero, &w1, &w2);
        assert_true(beyond > 0.0);
        assert_true(fabs((double)w1 - fmax(fmin((x - beyond) / 32.0, 1.0), 0.0)) < 1e-6);
        assert_true(fabs((double)w2 - fmax(fmin((y - 2 * beyond) / 16.0, 1.0), 0.0)) < 1e-6);
    }
    destroy_raster(raster, scene);
}

static void weights_of_a_triangle_that_is_not_finite_are_weights(void **state) {
    const float bad[3] = {NAN, INFINITY, -3e38f};
    const uint32_t corner[3] = {0, 1, 2}, zero = 0, pixel = 40;
    sl_view view = forward_view(9, 9);
    for (int c = 0; c < 9; c++) {
        float x[3] = {-1, 1, 0}, y[3] = {-1, -1, 1}, z[3] = {3, 3, 3}, w1, w2;
        (c % 3 == 0 ? x : c % 3 == 1 ? y : z)[c / 3] = bad[c / 3];
        sl_raster_mesh mesh = {3, 1, x, y, z, {&corner[0], &corner[1], &corner[2]}};
        sl_raster *raster = NULL;
        assert_int_equal(sl_raster_create_mesh(&mesh, 1, &raster, NULL), SL_OK);
        sl_raster_barycentrics(raster, &view, 1, &pixel, &zero, &w1, &w2);
        assert_true(w1 >= 0.0f && w2 >= 0.0f && w1 + w2 <= 1.0000002f);
        sl_raster_destroy(raster);
    }
}

static void triangle_seen_edge_on_has_finite_weights(void **state) {
    const float xyz[9] = {0, 0, 1, 0, 0, 2, 0, 0.0f, 3.5f};
    const float flat[9] = {-1, 0, 1, 1, 0, 1, 0, 0, 3};
    sl_frame frame = {sl_v3(1, 0, 0), sl_v3(0, 1, 0), sl_v3(0, 0, 1)};
    sl_view view = sl_view_pyramid(&frame, sl_v3(0, 0, 0), -1, 1, -1, 1, 9, 9, 1e-3f);
    const float *cases[2] = {xyz, flat};
    for (int c = 0; c < 2; c++) {
        sl_scene *scene = scene_of_triangles(flat, 1);
        memcpy(scene->position_x, (const float[3]){cases[c][0], cases[c][3], cases[c][6]}, 12);
        memcpy(scene->position_y, (const float[3]){cases[c][1], cases[c][4], cases[c][7]}, 12);
        memcpy(scene->position_z, (const float[3]){cases[c][2], cases[c][5], cases[c][8]}, 12);
        sl_raster *raster = raster_of(scene);
        for (uint32_t i = 0; i < 81; i++) {
            float w1, w2;
            uint32_t zero = 0;
            sl_raster_barycentrics(raster, &view, 1, &i, &zero, &w1, &w2);
            assert_true(w1 >= 0.0f && w2 >= 0.0f && w1 + w2 <= 1.0000002f);
        }
        destroy_raster(raster, scene);
    }
}

static void flip_turns_rows_over(void **state) {
    const float plane[6] = {0, 1, 2, 3, 4, 5};
    float image[6];
    sl_raster_flip(plane, 2, 3, image);
    const float expected[6] = {4, 5, 2, 3, 0, 1};
    assert_memory_equal(image, expected, sizeof image);
}

/* ---- lanes against the plain form ---- */

static void plain_weights(const sl_scene *scene, const sl_view *view, uint32_t pixel, uint32_t id, float *w1,
                          float *w2) {
    sl_pass_view pass = sl_pass_view_make(view, view->width, view->height);
    sl_vec3 q[3];
    *w1 = *w2 = 0.0f;
    if (id == SL_NO_INDEX) return;
    for (int k = 0; k < 3; k++) q[k] = sl_sub(sl_scene_position(scene, scene->vertex[k][id]), view->origin);
    const sl_edge_lines lines = sl_edge_lines_make(&pass, q[0], q[1], q[2]);
    sl_weights_at(&lines, pixel % (uint32_t)view->width, pixel / (uint32_t)view->width, w1, w2);
}

static void expect_plain_weights(const sl_raster *raster, const sl_scene *scene, const sl_view *view,
                                 size_t count, const uint32_t *pixel, const uint32_t *id) {
    float *w1 = malloc((count + 1) * sizeof *w1), *w2 = malloc((count + 1) * sizeof *w2);
    assert_true(w1 && w2);
    w1[count] = w2[count] = -7.0f;
    sl_raster_barycentrics(raster, view, count, pixel, id, w1, w2);
    for (size_t n = 0; n < count; n++) {
        float expected1, expected2;
        plain_weights(scene, view, pixel[n], id[n], &expected1, &expected2);
        assert_true(same_bits(w1[n], expected1) && same_bits(w2[n], expected2));
    }
    assert_true(w1[count] == -7.0f && w2[count] == -7.0f); /* nothing beyond the end */
    free(w1);
    free(w2);
}

static void weights_are_those_of_the_plain_form_bit_by_bit(void **state) {
    const sl_scene *const *scenes = *state;
    static uint32_t id[PIXELS], pixel[PIXELS];
    const int widths[] = {SIZE, 61, 1}, heights[] = {SIZE, 37, 300};
    for (int k = 0; k < KINDS; k++) {
        for (size_t isa = 0; isa < sizeof isas / sizeof *isas; isa++) {
            sl_raster *raster = raster_for(scenes[k], isas[isa]);
            for (int size = 0; size < 3; size++) {
                sl_view view = forward_view(widths[size], heights[size]);
                size_t count = (size_t)widths[size] * (size_t)heights[size];
                for (uint32_t i = 0; i < count; i++) pixel[i] = i;
                render(raster, &view, 1, id, NULL);
                expect_plain_weights(raster, scenes[k], &view, count, pixel, id);
                expect_plain_weights(raster, scenes[k], &view, count / 2 + 5, pixel + 3, id + 3);
            }
            sl_raster_destroy(raster);
        }
    }
}

/* ---- surfaces against the scene ---- */

typedef enum { FACETS, SMOOTH, MIXED, LOOKS } look;

/* The furnished room with two materials, one of them textured; and shading normals, some of them none, at
 * right angles to the geometric one, or zero with a sign. */
static sl_scene *dressed_room(look l) {
    sl_scene *room = furnished_room(20, 5);
    static uint8_t texels[8 * 8 * 4];
    for (uint32_t i = 0; i < sizeof texels; i++) texels[i] = (uint8_t)sl_random_bits(9, i);
    sl_texture texture = {.file = "noise", .width = 8, .height = 8, .texels = texels};
    sl_material materials[2] = {
        {.diffuse = {0.5f, 0.25f, 0.75f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX},
        {.diffuse = {0.9f, 0.8f, 0.7f}, .texture = 0, .alpha_texture = SL_NO_INDEX}};
    size_t count = room->triangle_count;
    float *positions = malloc(count * 9 * sizeof *positions), *uv = malloc(count * 6 * sizeof *uv);
    uint32_t *indices = malloc(count * 3 * sizeof *indices), *material = malloc(count * sizeof *material);
    assert_true(positions && uv && indices && material);
    for (uint32_t t = 0; t < count; t++) {
        material[t] = t % 3 == 0;
        for (uint32_t k = 0; k < 3; k++) {
            sl_vec3 p = sl_scene_position(room, room->vertex[k][t]);
            memcpy(positions + 9 * t + 3 * k, &p, sizeof p);
            indices[3 * t + k] = 3 * t + k;
            uv[6 * t + 2 * k] = random_between(3, 6 * t + 2 * k, -3.0f, 3.0f);
            uv[6 * t + 2 * k + 1] = sl_random_unit(3, 6 * t + 2 * k + 1);
        }
    }
    sl_scene_parts parts = {.vertex_count = 3 * count,
                            .positions = positions,
                            .texture_coordinates = uv,
                            .triangle_count = count,
                            .indices = indices,
                            .material_index = material,
                            .material_count = 2,
                            .materials = materials,
                            .texture_count = 1,
                            .textures = &texture};
    sl_scene *scene = scene_built(&parts);
    for (uint32_t t = 0; t < scene->triangle_count; t++) {
        const float odd[4] = {1e30f, NAN, -1e-9f, INFINITY};
        if (t % 30 == 0) scene->texture_u[scene->vertex[t / 30 % 3][t]] = odd[t / 90 % 4];
        if (l == FACETS || (l == MIXED && t % 4 == 0)) continue;
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t v = scene->vertex[k][t], n = 3 * t + k;
            sl_vec3 d = random_direction(sl_random_key(8, 0), n), g = sl_scene_geometric_normal(scene, t);
            if (t % 50 == 1) d = sl_v3(0, -0.0f, 0);
            if (t % 50 == 2) d = sl_v3(g.y, -g.x, 0);
            if (t % 50 == 3) d = sl_v3(-0.0f, -1, -0.0f);
            scene->normal_x[v] = d.x, scene->normal_y[v] = d.y, scene->normal_z[v] = d.z;
        }
    }
    free(positions);
    free(uv);
    free(indices);
    free(material);
    sl_scene_destroy(room);
    return scene;
}

enum { WIDTH = 233, HEIGHT = 97 };

static sl_view room_view(int n) {
    sl_camera camera;
    if (n == 0) {
        assert_true(
            sl_camera_look_at(&camera, sl_v3(0.5f, 1.6f, 0.4f), sl_v3(2, 1, 2.5f), sl_v3(0, 1, 0), 1.0f));
        return camera_view(&camera, WIDTH, HEIGHT, 0.01f, 20.0f);
    }
    assert_true(sl_camera_look_at(&camera, sl_v3(2, 1.5f, 7), sl_v3(2, 1, 2.5f), sl_v3(0, 1, 0), 1.4f));
    /* near plane inside the room, background around */
    return camera_view(&camera, WIDTH, HEIGHT, 2.5f, 100.0f);
}

static void expect_vector(const float *x, const float *y, const float *z, size_t i, sl_vec3 expected) {
    assert_true(same_bits(x[i], expected.x) && same_bits(y[i], expected.y) && same_bits(z[i], expected.z));
}

static void expect_surfaces(const sl_scene *scene, const sl_view *view, const sl_gbuffer *g) {
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        sl_surface s = {0}, first;
        uint32_t material = SL_NO_INDEX;
        if (g->id[i] != SL_NO_INDEX) {
            float w1, w2;
            plain_weights(scene, view, i, g->id[i], &w1, &w2);
            sl_scene_surface(scene, g->id[i], w1, w2, sl_v3(0, 0, 0), &first); /* for the position */
            sl_scene_surface(scene, g->id[i], w1, w2, sl_sub(view->origin, first.position), &s);
            material = scene->material_index[g->id[i]];
        }
        expect_vector(g->position_x, g->position_y, g->position_z, i, s.position);
        expect_vector(g->normal_x, g->normal_y, g->normal_z, i, s.normal);
        expect_vector(g->geometric_x, g->geometric_y, g->geometric_z, i, s.geometric_normal);
        expect_vector(g->diffuse_r, g->diffuse_g, g->diffuse_b, i,
                      sl_v3(s.diffuse.r, s.diffuse.g, s.diffuse.b));
        assert_int_equal(g->material[i], material);
    }
}

static void surfaces_are_those_of_the_scene_bit_by_bit(void **state) {
    for (int l = 0; l < LOOKS; l++) {
        sl_scene *scene = dressed_room((look)l);
        for (size_t isa = 0; isa < sizeof isas / sizeof *isas; isa++) {
            sl_raster *raster = raster_for(scene, isas[isa]);
            for (int n = 0; n < 2; n++) {
                sl_view view = room_view(n);
                sl_gbuffer *g = NULL;
                uint64_t shaded = 0;
                assert_int_equal(sl_gbuffer_create(WIDTH, HEIGHT, &g, NULL), SL_OK);
                for (unsigned threads = 1; threads <= 5; threads += 2) {
                    sl_counters counters = {{0}};
                    assert_int_equal(sl_raster_gbuffer(raster, &view, threads, g, &counters, NULL), SL_OK);
                    if (threads == 1) shaded = counters.value[SL_COUNT_FRAGMENTS_SHADED];
                    assert_true(shaded > WIDTH * HEIGHT / 8 &&
                                counters.value[SL_COUNT_FRAGMENTS_SHADED] == shaded);
                    expect_surfaces(scene, &view, g);
                }
                sl_gbuffer_destroy(g);
            }
            sl_raster_destroy(raster);
        }
        sl_scene_destroy(scene);
    }
}

/* ---- triangles without a scene ---- */

static int build_scenes(void **state) {
    static sl_scene *scenes[KINDS];
    for (int k = 0; k < KINDS; k++) scenes[k] = scene_of_kind((kind)k);
    *state = scenes;
    return 0;
}

static int destroy_scenes(void **state) {
    sl_scene **scenes = *state;
    for (int k = 0; k < KINDS; k++) sl_scene_destroy(scenes[k]);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(attributes_are_as_accurate_as_floats_allow),
        cmocka_unit_test(a_pixel_beside_its_triangle_takes_the_nearest_point_of_the_edge),
        cmocka_unit_test(weights_of_a_triangle_that_is_not_finite_are_weights),
        cmocka_unit_test(triangle_seen_edge_on_has_finite_weights),
        cmocka_unit_test(flip_turns_rows_over),
        cmocka_unit_test(weights_are_those_of_the_plain_form_bit_by_bit),
        cmocka_unit_test(surfaces_are_those_of_the_scene_bit_by_bit),
    };
    return cmocka_run_group_tests(tests, build_scenes, destroy_scenes);
}
