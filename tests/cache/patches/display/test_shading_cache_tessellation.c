/* Curved surfaces on the display: cut for the view, never torn, never shaded; poles, motion, eyes inside. */
#include "shading_cache_support.h"

#include <math.h>
#include <stdio.h>

#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/patches/display/display.h"
#include "scene/bicubic.h"

enum { W = 160, H = 160, PIXELS = W * H };

static const sl_rgb guess = {0.5f, 0.5f, 0.5f};

/* A vase of sixteen surfaces, standing on a pole, in a room. */
static hierarchy vase(void) {
    sl_scene *scene;
    sl_error error = {0};
    if (sl_scene_load("scenes/vase.json", &scene, &error) != SL_OK) fail_msg("%s", error.message);
    return hierarchy_of(scene, 0);
}

static const sl_tessellation *shown(const sl_display *d) { return &d->own.tessellation; }

/* Views around the vase, near and far, and from above. It is 330 high and stands at (260, 0, 270). */
enum { VIEWS = 10 };
static void look_from(sl_scene *scene, int view) {
    double turn = 0.9 * view + 0.1,
           distance = view % 3 == 0   ? 900.0
                      : view % 3 == 1 ? 450.0
                                      : 260.0,
           height = 60.0 + 70.0 * (view % 6);
    sl_vec3 eye = sl_v3((float)(260.0 + distance * sl_cos(turn)), (float)height,
                        (float)(270.0 + distance * sl_sin(turn)));
    assert_true(sl_camera_look_at(&scene->camera, eye, sl_v3(260, 150, 270), sl_v3(0, 1, 0), 0.8f));
}

static sl_vec3 vertex_at(const sl_tessellation *t, uint32_t v) { return sl_scene_position(t->scene, v); }

/* ---- close to the surface -------------------------------------------------------------------- */

static bool window_of(const sl_view *view, sl_vec3d p, double out[2]) {
    double q[3] = {p.x - (double)view->origin.x, p.y - (double)view->origin.y, p.z - (double)view->origin.z},
           clip[4];
    for (int i = 0; i < 4; i++) {
        const float *row = view->clip[i];
        clip[i] = (double)row[0] * q[0] + (double)row[1] * q[1] + (double)row[2] * q[2] + (double)row[3];
    }
    if (clip[3] <= 0.0 || fabs(clip[0]) > clip[3] || fabs(clip[1]) > clip[3]) return false;
    out[0] = (clip[0] / clip[3] * 0.5 + 0.5) * view->width;
    out[1] = (clip[1] / clip[3] * 0.5 + 0.5) * view->height;
    return true;
}

static void no_triangle_is_further_than_half_a_pixel_from_its_surface(void **state) {
    hierarchy h = vase();
    sl_display *display = display_of(&h, W, H, guess);
    double worst = 0.0;
    size_t tested = 0;
    for (int k = 0; k < VIEWS; k++) {
        look_from(h.scene, k);
        build_display(display, &h);
        const sl_tessellation *t = shown(display);
        sl_view view = sl_view_scene(h.scene, W, H);
        uint64_t key = sl_random_key(11, (uint64_t)k);
        for (uint32_t i = 0; i < t->scene->triangle_count; i++) {
            double w1 = (double)sl_random_unit(key, 2 * i), w2 = (double)sl_random_unit(key, 2 * i + 1), w[3],
                   u = 0, v = 0, flat[2], round[2];
            if (w1 + w2 > 1.0) w1 = 1.0 - w1, w2 = 1.0 - w2;
            w[0] = 1.0 - w1 - w2, w[1] = w1, w[2] = w2;
            sl_vec3d p = {0, 0, 0};
            for (int c = 0; c < 3; c++) {
                uint32_t corner = t->scene->vertex[c][i];
                p = sl_addd(p, sl_scaled(sl_to_double(vertex_at(t, corner)), w[c]));
                u += w[c] * (double)t->scene->texture_u[corner];
                v += w[c] * (double)t->scene->texture_v[corner];
            }
            sl_vec3 surface;
            sl_bicubic_at(&h.scene->bicubics[h.primitives->bicubic[t->primitive[i]]], u, v, &surface, NULL);
            if (!window_of(&view, p, flat) || !window_of(&view, sl_to_double(surface), round)) continue;
            worst = fmax(worst, sqrt((flat[0] - round[0]) * (flat[0] - round[0]) +
                                     (flat[1] - round[1]) * (flat[1] - round[1])));
            tested++;
        }
    }
    assert_true(tested > 5000);
    assert_true(worst < 0.5 && worst > 0.05);
    display_discard(display, &h);
}

static void nearer_surfaces_are_cut_finer_and_what_is_out_of_sight_is_not(void **state) {
    hierarchy h = vase();
    sl_display *display = display_of(&h, W, H, guess);
    size_t count[3];
    const float distance[3] = {4000, 800, 330};
    for (int k = 0; k < 3; k++) {
        assert_true(sl_camera_look_at(&h.scene->camera, sl_v3(260, 150, 270 - distance[k]),
                                      sl_v3(260, 150, 270), sl_v3(0, 1, 0), 0.8f));
        build_display(display, &h);
        count[k] = shown(display)->scene->triangle_count;
    }
    assert_true(count[0] < count[1] && count[1] < count[2]);
    assert_true(sl_camera_look_at(&h.scene->camera, sl_v3(260, 150, -60), sl_v3(260, 150, -900),
                                  sl_v3(0, 1, 0), 0.8f));
    build_display(display, &h);
    assert_true(shown(display)->scene->triangle_count < count[2]);
    display_discard(display, &h);
}

/* ---- no tears -------------------------------------------------------------------------------- */

typedef struct directed_edge {
    sl_vec3 end[2];
    int forth;
} directed_edge;

static int compare_ends(const void *a, const void *b) { return memcmp(a, b, offsetof(directed_edge, forth)); }

/* The vase is closed but for its mouth, at height 330: every other edge of a triangle is that of one more,
 * the other way round, to the bit. */
static void triangles_meet_along_whole_edges(void **state) {
    hierarchy h = vase();
    sl_display *display = display_of(&h, W, H, guess);
    for (int k = 0; k < VIEWS; k++) {
        look_from(h.scene, k);
        build_display(display, &h);
        const sl_tessellation *t = shown(display);
        directed_edge *edge = calloc(3 * t->scene->triangle_count, sizeof *edge);
        size_t alone = 0;
        for (size_t i = 0; i < 3 * t->scene->triangle_count; i++) {
            sl_vec3 a = vertex_at(t, t->scene->vertex[i % 3][i / 3]),
                    b = vertex_at(t, t->scene->vertex[(i + 1) % 3][i / 3]);
            bool forth = memcmp(&a, &b, sizeof a) < 0;
            edge[i] = (directed_edge){{forth ? a : b, forth ? b : a}, forth};
        }
        qsort(edge, 3 * t->scene->triangle_count, sizeof *edge, compare_ends);
        for (size_t i = 0; i < 3 * t->scene->triangle_count;) {
            bool pair = i + 1 < 3 * t->scene->triangle_count && compare_ends(&edge[i], &edge[i + 1]) == 0;
            if (pair) {
                assert_int_not_equal(edge[i].forth, edge[i + 1].forth);
            } else {
                assert_true(edge[i].end[0].y > 329.0f && edge[i].end[1].y > 329.0f);
                alone++;
            }
            i += pair ? 2 : 1;
        }
        assert_true(alone > 0);
        free(edge);
        sl_display_destroy(display);
        display = display_of(&h, W, H, guess);
    }
    display_discard(display, &h);
}

/* ---- alpha masks ----------------------------------------------------------------------------- */

/* Half of the vase is holes: each surface has one of half its width and height, in its middle, and another
 * one around its corner. */
static void pierce(sl_scene *scene) {
    sl_texture *mask = sl_allocate(1, sizeof *mask);
    mask->width = mask->height = 2;
    mask->has_alpha = true;
    mask->file = sl_allocate(8, 1);
    mask->texels = sl_allocate(16, 1);
    for (int i = 0; i < 4; i++) mask->texels[4 * i + 3] = i == 0 || i == 3 ? 255 : 0;
    sl_free(scene->textures);
    scene->textures = mask;
    scene->texture_count = 1;
    scene->materials[scene->material_index[scene->bicubics[0].first_triangle]].alpha_texture = 0;
}

/* The scene's own triangles of the surfaces have masks of their own; where these show what is behind, or the
 * vase, all around a pixel, so must the display. */
static void holes_in_surfaces_are_holes_in_what_they_are_cut_into(void **state) {
    sl_scene *scene;
    assert_int_equal(sl_scene_load("scenes/vase.json", &scene, NULL), SL_OK);
    pierce(scene);
    hierarchy h = hierarchy_of(scene, false);
    sl_display *display = display_of(&h, W, H, guess);
    sl_raster *raster;
    assert_int_equal(sl_raster_create(h.scene, 1, &raster, NULL), SL_OK);
    static uint32_t id[PIXELS], root[PIXELS];
    static bool on_it[PIXELS];
    size_t holes = 0, walls = 0;
    for (int k = 0; k < VIEWS; k++) {
        look_from(h.scene, k);
        build_display(display, &h);
        sl_view view = sl_view_scene(h.scene, W, H), own = view;
        sl_target target = {W, H, id, NULL}, cut = {W, H, root, NULL};
        sl_counters counters = {0};
        assert_int_equal(sl_raster_id(raster, &view, 1, &target, &counters, NULL), SL_OK);
        const sl_tessellation *t = shown(display);
        sl_raster *whole; /* the same triangles, without holes: whether the vase is here at all */
        sl_raster_mesh mesh = {
            t->scene->vertex_count, t->scene->triangle_count, t->scene->position_x, t->scene->position_y,
            t->scene->position_z, {t->scene->vertex[0], t->scene->vertex[1], t->scene->vertex[2]}};
        assert_int_equal(sl_raster_create_mesh(&mesh, 1, &whole, NULL), SL_OK);
        assert_int_equal(sl_raster_id(whole, &own, 1, &cut, &counters, NULL), SL_OK);
        static bool covered[PIXELS];
        for (int i = 0; i < PIXELS; i++) covered[i] = root[i] != SL_NO_INDEX;
        sl_display_ids ids = {.root = root};
        assert_int_equal(sl_display_id_map(display, &ids, &counters, NULL), SL_OK);
        for (int i = 0; i < PIXELS; i++) {
            on_it[i] = id[i] != SL_NO_INDEX &&
                       h.primitives->kind[h.primitives->of_triangle[id[i]]] == SL_PRIMITIVE_BICUBIC;
        }
        for (int y = 2; y < H - 2; y++) {
            for (int x = 2; x < W - 2; x++) {
                int around = 0;
                for (int d = 0; d < 25; d++) around += on_it[(y + d / 5 - 2) * W + x + d % 5 - 2];
                uint32_t here = root[y * W + x];
                bool curved = here != SL_NO_INDEX && h.primitives->kind[here / 2] == SL_PRIMITIVE_BICUBIC;
                if (around == 25) assert_true(curved), walls++;
                if (around == 0 && covered[y * W + x]) assert_false(curved), holes++;
            }
        }
        sl_raster_destroy(whole);
    }
    printf("%zu pixels of walls, %zu seen through holes\n", walls, holes);
    assert_true(walls > 5000 && holes > 1000);
    sl_raster_destroy(raster);
    display_discard(display, &h);
}

/* ---- the cache between its vertices ---------------------------------------------------------- */

static void tessellated_pixels_show_the_cache_at_their_parameters_and_ask_for_no_sample(void **state) {
    hierarchy h = vase();
    for (uint32_t r = 0; r < 2 * h.primitives->count; r++) split_levels(&h, want_root(&h, r), 2);
    for (uint32_t v = 0; v < h.patches->vertex_count; v++) {
        for (int c = 0; c < 3; c++)
            sl_vertex_value(h.patches, v)[c] =
                1.0f + 0.5f * (float)(sl_hash64(v * 3 + (uint64_t)c) % 1000) / 1000.0f;
        h.patches->vertex[v].evaluated = 7;
    }
    sl_display *display = display_of(&h, W, H, guess);
    size_t patches = h.patches->patches_alive, vertices = h.patches->vertices_alive, curved = 0;
    static uint32_t root[PIXELS];
    static float u[PIXELS], v[PIXELS], plane[3][PIXELS];
    float *planes[6] = {plane[0], plane[1], plane[2]};
    for (int k = 0; k < 3; k++) {
        look_from(h.scene, k);
        build_display(display, &h);
        sl_counters counters = {0};
        sl_display_ids ids = {.root = root, .u = u, .v = v};
        assert_int_equal(sl_display_id_map(display, &ids, &counters, NULL), SL_OK);
        assert_int_equal(sl_window_draw(&display->own, planes, &counters, NULL), SL_OK);
        for (int i = 0; i < PIXELS; i++) {
            if (root[i] == SL_NO_INDEX || h.primitives->kind[root[i] / 2] != SL_PRIMITIVE_BICUBIC) continue;
            sl_patch_place leaf = sl_patch_locate(h.patches, root[i], (double)u[i], (double)v[i]);
            float e[3];
            assert_true(sl_patch_value(h.patches, &leaf, (double)u[i], (double)v[i], e));
            sl_rgb kd = sl_root_material(h.primitives, root[i])->diffuse;
            const float want[3] = {kd.r * e[0], kd.g * e[1], kd.b * e[2]};
            for (int c = 0; c < 3; c++)
                assert_true(fabs((double)plane[c][i] - (double)want[c] / SL_PI) < 1e-5);
            curved++;
        }
    }
    assert_true(curved > 1000);
    assert_int_equal(h.patches->patches_alive, patches);
    assert_int_equal(h.patches->vertices_alive, vertices);
    for (size_t i = 0; i < h.patches->vertex_count; i++) assert_int_equal(h.patches->vertex[i].evaluated, 7);
    display_discard(display, &h);
}

/* ---- hard cases ------------------------------------------------------------------------------ */

static void an_eye_within_or_on_a_surface_is_no_trouble(void **state) {
    hierarchy h = vase();
    sl_display *display = display_of(&h, W, H, guess);
    sl_vec3 on_it;
    sl_bicubic_at(&h.scene->bicubics[9], 0.5, 0.5, &on_it, NULL);
    const sl_vec3 eye[3] = {{260, 150, 270}, on_it, {260, 0, 270}}; /* inside, on it, at the pole */
    static float plane[3][PIXELS];
    float *planes[6] = {plane[0], plane[1], plane[2]};
    for (int k = 0; k < 3; k++) {
        assert_true(sl_camera_look_at(&h.scene->camera, eye[k], sl_v3(100, 200, 300), sl_v3(0, 1, 0), 1.2f));
        build_display(display, &h);
        assert_true(shown(display)->scene->triangle_count <= 2 * 64 * 64 * h.primitives->curved);
        sl_counters counters = {0};
        assert_int_equal(sl_window_draw(&display->own, planes, &counters, NULL), SL_OK);
        for (int c = 0; c < 3; c++) {
            for (int i = 0; i < PIXELS; i++) assert_true(isfinite(plane[c][i]) && plane[c][i] >= 0.0f);
        }
    }
    display_discard(display, &h);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_triangle_is_further_than_half_a_pixel_from_its_surface),
        cmocka_unit_test(nearer_surfaces_are_cut_finer_and_what_is_out_of_sight_is_not),
        cmocka_unit_test(triangles_meet_along_whole_edges),
        cmocka_unit_test(holes_in_surfaces_are_holes_in_what_they_are_cut_into),
        cmocka_unit_test(tessellated_pixels_show_the_cache_at_their_parameters_and_ask_for_no_sample),
        cmocka_unit_test(an_eye_within_or_on_a_surface_is_no_trouble),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
