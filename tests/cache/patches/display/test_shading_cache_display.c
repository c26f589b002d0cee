/* The display of the shading cache: Gouraud times texture, silhouettes, id map, hanging vertices, the two
 * copies, motion, memory. */
#include "shading_cache_support.h"

#include <math.h>
#include <stdio.h>

#include "base/math.h"
#include "base/random.h"
#include "cache/patches/display/display.h"
#include "cache/patches/display/leaf_lookup.h"

enum { W = 96, H = 80, PIXELS = W * H };

typedef struct picture {
    float plane[3][PIXELS];
} picture;

typedef struct id_picture {
    uint32_t patch[PIXELS], root[PIXELS];
    float u[PIXELS], v[PIXELS];
} id_picture;

static const sl_rgb guess = {0.25f, 0.5f, 0.75f};

static void draw(sl_display *display, unsigned threads, picture *out) {
    sl_counters counters = {0};
    float *planes[6] = {out->plane[0], out->plane[1], out->plane[2]};
    display->own.threads = threads;
    assert_int_equal(sl_window_draw(&display->own, planes, &counters, NULL), SL_OK);
}

static void map_ids(sl_display *display, unsigned threads, id_picture *out) {
    sl_counters counters = {0};
    sl_display_ids ids = {out->patch, out->root, out->u, out->v};
    display->own.threads = threads;
    assert_int_equal(sl_display_id_map(display, &ids, &counters, NULL), SL_OK);
}

static uint32_t below(uint64_t key, uint64_t index, size_t count) {
    return (uint32_t)((double)sl_random_unit(key, index) * (double)count);
}

/* ---- scenes and samples ---------------------------------------------------------------------- */

static void look(sl_scene *scene, sl_vec3 eye, sl_vec3 target) {
    assert_true(sl_camera_look_at(&scene->camera, eye, target, sl_v3(0, 1, 0), 0.9f));
}

/* A textured floor, a lamp, glossy and diffuse boxes, a bumpy ball of triangles; an open sky behind. */
static sl_scene *room(bool glossy) {
    static uint8_t texels[8 * 8 * 4];
    for (int i = 0; i < 8 * 8 * 4; i++) texels[i] = (uint8_t)(40 + 211 * i % 200);
    trace_mesh mesh = trace_mesh_begin();
    mesh.textures[0] = (sl_texture){.file = (char *)"checks", .width = 8, .height = 8, .texels = texels};
    mesh.texture_count = 1;
    uint32_t floor = trace_mesh_diffuse(&mesh, 0.8f), wall = trace_mesh_diffuse(&mesh, 0.5f);
    uint32_t lamp = trace_mesh_material(&mesh, 0.1f, 0, 0, 0, 7),
             shiny = trace_mesh_material(&mesh, 0.3f, glossy ? 0.4f : 0, 20, 0, 0);
    mesh.materials[floor].texture = 0;
    trace_mesh_quad(&mesh, sl_v3(-2, 0, 2), sl_v3(4, 0, 0), sl_v3(0, 0, -4), floor);
    trace_mesh_quad(&mesh, sl_v3(-2, 0, -2), sl_v3(4, 0, 0), sl_v3(0, 2, 0), wall);
    trace_mesh_quad(&mesh, sl_v3(-0.5f, 2, -0.5f), sl_v3(1, 0, 0), sl_v3(0, 0, 1), lamp);
    trace_mesh_box(&mesh, sl_v3(-1, 0, -1), sl_v3(-0.3f, 0.8f, -0.3f), false, shiny);
    trace_mesh_sphere(&mesh, sl_v3(0.7f, 0.6f, 0), 0.5f, 5, 0.1f, false, wall);
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        mesh.texture_coordinates[2 * v] = mesh.positions[3 * v] * 0.7f;
        mesh.texture_coordinates[2 * v + 1] = mesh.positions[3 * v + 2] * 0.9f;
    }
    sl_environment sky = {.present = true, .constant = {0.1f, 0.2f, 0.4f}};
    mesh.environment = &sky;
    sl_scene *scene = trace_mesh_build(&mesh);
    look(scene, sl_v3(0.5f, 1.4f, 3.5f), sl_v3(0, 0.6f, 0));
    return scene;
}

/* A smooth field with a step in it, by place: all that share a vertex would get the same. */
static void sample_field(hierarchy *h, uint32_t vertex, uint32_t update) {
    sl_patch_vertex *v = &h->patches->vertex[vertex];
    sl_vec3 p = sl_root_position(h->primitives, v->root, v->u, v->v);
    float step = p.x + 0.3f * p.z > 0.1f ? 2.0f : 0.5f;
    float *value = sl_vertex_value(h->patches, vertex);
    value[0] = 1.0f + p.x * p.x + (float)update * 0.01f;
    value[1] = step + 0.2f * p.y;
    value[2] = 0.3f + fabsf(p.z);
    sl_vertex_mark(v, update);
    float *lobe = sl_vertex_lobe(h->patches, vertex);
    for (int c = 0; lobe && c < 3; c++) lobe[c] = p.y + 0.1f * (float)c;
}

static bool is_alive(const sl_patches *p, uint32_t vertex) { return p->vertex[vertex].references > 0; }

static void sample_all(hierarchy *h, uint32_t update) {
    for (uint32_t v = 0; v < h->patches->vertex_count; v++) {
        if (is_alive(h->patches, v)) sample_field(h, v, update);
    }
}

static void want_all(hierarchy *h) {
    for (uint32_t r = 0; r < 2 * h->primitives->count; r++) want_root(h, r);
}

/* Any splits, drops and samples. */
static void change_at_random(hierarchy *h, uint64_t key, uint32_t update, int changes) {
    for (uint64_t i = 0; i < (uint64_t)changes; i++) {
        uint64_t at = 4 * i;
        uint32_t patch = below(key, at, h->patches->patch_count);
        float what = sl_random_unit(key, at + 1);
        if (what < 0.1f || !h->patches->patch_count)
            want_root(h, below(key, at + 2, 2 * h->primitives->count));
        else if (!sl_patch_is_alive(h->patches, patch)) continue;
        else if (what < 0.55f) split(h, patch);
        else if (what < 0.62f) sl_patch_drop_children(h->patches, patch);
        else {
            int corner = (int)below(key, at + 3, (size_t)sl_patch_corners(h->patches, patch));
            sample_field(h, sl_patch_corner(h->patches, patch, corner), update);
        }
    }
}

/* ---- what a pixel must show ------------------------------------------------------------------ */

/* The frame, evaluated pixel by pixel: the scene's triangles, its surfaces, sl_patch_value(). Where all that
 * is there has samples and nothing hangs. */
static void assert_equals_evaluation(const hierarchy *h, const picture *shown, const id_picture *ids) {
    const sl_scene *s = h->scene;
    sl_raster *raster;
    sl_gbuffer *g;
    sl_counters counters = {0};
    assert_int_equal(sl_raster_create(s, 1, &raster, NULL), SL_OK);
    assert_int_equal(sl_gbuffer_create(W, H, &g, NULL), SL_OK);
    sl_view view = sl_view_scene(s, W, H);
    assert_int_equal(sl_raster_gbuffer(raster, &view, 1, g, &counters, NULL), SL_OK);
    int covered = 0, textured = 0, shining = 0;
    for (uint32_t i = 0; i < PIXELS; i++) {
        sl_rgb expected = s->environment.constant;
        if (g->id[i] != SL_NO_INDEX) {
            float w1, w2;
            sl_raster_barycentrics(raster, &view, 1, &i, &g->id[i], &w1, &w2);
            sl_vec3 at = sl_v3(g->position_x[i], g->position_y[i], g->position_z[i]);
            sl_surface surface;
            sl_scene_surface(s, g->id[i], w1, w2, sl_sub(s->camera.eye, at), &surface);
            double u, v;
            sl_root_parameters(h->primitives, g->id[i], w1, w2, &u, &v);
            uint32_t root = 2 * h->primitives->of_triangle[g->id[i]] + (surface.front ? 0 : 1);
            sl_patch_place leaf = sl_patch_locate(h->patches, root, u, v);
            float e[6] = {0}, *l = e + 3;
            assert_true(sl_patch_value(h->patches, &leaf, u, v, e));
            if (!sl_material_has_lobe(surface.material)) l[0] = l[1] = l[2] = 0.0f;
            sl_rgb emission = sl_scene_emission(s, g->id[i], surface.geometric_normal);
            double pi = SL_PI;
            expected.r =
                (float)((double)emission.r + (double)surface.diffuse.r * (double)e[0] / pi + (double)l[0]);
            expected.g =
                (float)((double)emission.g + (double)surface.diffuse.g * (double)e[1] / pi + (double)l[1]);
            expected.b =
                (float)((double)emission.b + (double)surface.diffuse.b * (double)e[2] / pi + (double)l[2]);
            assert_int_equal(ids->root[i], root);
            assert_true(fabs((double)ids->u[i] - u) < 1e-5 && fabs((double)ids->v[i] - v) < 1e-5);
            covered++;
            textured += surface.material->texture != SL_NO_INDEX;
            shining += l[1] > 0.0f;
        } else {
            assert_int_equal(ids->root[i], SL_NO_INDEX);
        }
        const float want[3] = {expected.r, expected.g, expected.b};
        for (int c = 0; c < 3; c++) {
            if (fabsf(shown->plane[c][i] - want[c]) > 1e-5f * (1.0f + fabsf(want[c]))) {
                fail_msg("pixel %u, channel %d: %g instead of %g", i, c, (double)shown->plane[c][i],
                         (double)want[c]);
            }
        }
    }
    assert_true(covered > PIXELS / 3 && textured > 500 &&
                (shining > 50) == (h->patches->settings.channels > 3));
    sl_gbuffer_destroy(g);
    sl_raster_destroy(raster);
}

static void a_frame_is_what_evaluation_pixel_by_pixel_gives(void **state) {
    static picture shown;
    static id_picture ids;
    for (int glossy = 0; glossy < 2; glossy++) {
        for (int levels = 0; levels <= 3; levels += 3) {
            hierarchy h = hierarchy_of(room(glossy), glossy ? KEEP_LOBES : 0);
            for (uint32_t r = 0; r < 2 * h.primitives->count; r++) split_levels(&h, want_root(&h, r), levels);
            sample_all(&h, 1);
            sl_display *display = display_of(&h, W, H, guess);
            build_display(display, &h);
            draw(display, 1, &shown);
            map_ids(display, 1, &ids);
            assert_equals_evaluation(&h, &shown, &ids);
            display_discard(display, &h);
        }
    }
}

/* ---- before any sample ----------------------------------------------------------------------- */

static void silhouettes_are_exact_before_any_sample_and_surfaces_show_the_guess(void **state) {
    static picture shown;
    static id_picture ids;
    hierarchy h = hierarchy_of(room(false), 0);
    sl_display *display = display_of(&h, W, H, guess); /* not even built */
    sl_raster *raster;
    static uint32_t plain[PIXELS];
    sl_target target = {W, H, plain, NULL};
    sl_view view = sl_view_scene(h.scene, W, H);
    sl_counters counters = {0};
    assert_int_equal(sl_raster_create(h.scene, 1, &raster, NULL), SL_OK);
    assert_int_equal(sl_raster_id(raster, &view, 1, &target, &counters, NULL), SL_OK);
    for (int wanted = 0; wanted < 2; wanted++) {
        if (wanted) {
            want_all(&h);
            build_display(display, &h);
        }
        draw(display, 1, &shown);
        map_ids(display, 1, &ids);
        for (uint32_t i = 0; i < PIXELS; i++) {
            assert_int_equal(ids.root[i] == SL_NO_INDEX, plain[i] == SL_NO_INDEX);
            if (plain[i] == SL_NO_INDEX) continue;
            assert_int_equal(ids.root[i] / 2, h.primitives->of_triangle[plain[i]]);
            assert_int_equal(ids.patch[i],
                             wanted ? sl_patches_find_root(h.patches, ids.root[i]) : SL_NO_INDEX);
            const sl_material *material = sl_root_material(h.primitives, ids.root[i]);
            float emission = ids.root[i] % 2 ? 0.0f : material->emission.g;
            if (material->texture == SL_NO_INDEX) {
                assert_true(fabs((double)shown.plane[1][i] -
                                 (double)(emission + material->diffuse.g * guess.g * (float)(1 / SL_PI))) <
                            1e-6);
            }
        }
    }
    sl_raster_destroy(raster);
    display_discard(display, &h);
}

static void a_split_without_samples_is_not_seen(void **state) {
    static picture before, after;
    hierarchy h = hierarchy_of(room(false), 0);
    for (uint32_t r = 0; r < 2 * h.primitives->count; r++) split_levels(&h, want_root(&h, r), 1);
    sample_all(&h, 1);
    sl_display *display = display_of(&h, W, H, guess);
    build_display(display, &h);
    draw(display, 1, &before);
    for (uint32_t r = 0; r < 2 * h.primitives->count; r++) {
        uint32_t child = h.patches->patch[sl_patches_find_root(h.patches, r)].child;
        for (uint32_t k = 0; child != SL_NO_INDEX && k < 4; k++) split_levels(&h, child + k, 2);
    }
    build_display(display, &h);
    draw(display, 1, &after);
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < PIXELS; i++)
            assert_true(fabs((double)before.plane[c][i] - (double)after.plane[c][i]) < 1e-5);
    }
    display_discard(display, &h);
}

/* ---- hanging vertices ------------------------------------------------------------------------ */

/* Reads the value that the leaf at one side of a point shows there: (u, v) moved by next to nothing. */
static void value_beside(const sl_display *d, uint32_t root, double u, double v, float value[6]) {
    const sl_display_copy *copy = &d->copy[d->copies.shown];
    bool triangle = d->primitives->kind[root / 2] == SL_PRIMITIVE_TRIANGLE;
    sl_leaf leaf = sl_leaf_begin(&copy->wanted[copy->root[root]], triangle);
    sl_leaf_field field;
    sl_leaf_find(copy, &leaf, sl_place_of((float)u), sl_place_of((float)v));
    sl_leaf_field_of(copy, 1, &leaf, &field);
    sl_leaf_value(copy, 1, &leaf, &field, value);
}

static void colours_meet_along_edges_between_coarse_and_fine_leaves(void **state) {
    for (int kind = 0; kind < 2; kind++) {
        hierarchy h = hierarchy_of(kind ? triangle_scene() : square_scene(), 0);
        look(h.scene, sl_v3(0, 0, 4), sl_v3(0, 0, 0));
        sl_display *display = display_of(&h, W, H, guess);
        want_root(&h, 0);
        uint64_t key = sl_random_key(17, (uint64_t)kind);
        for (uint32_t update = 1; update < 12; update++) {
            change_at_random(&h, sl_random_key(17, 10 + update), update, 40);
            want_root(&h, 0);
            build_display(display, &h);
        }
        size_t fans = 0, tested = 0;
        for (uint32_t patch = 0; patch < h.patches->patch_count; patch++) {
            if (!sl_patch_is_alive(h.patches, patch) || !sl_patch_is_leaf(h.patches, patch) ||
                sl_patch_root(h.patches, patch) != 0)
                continue;
            sl_patch_place place = sl_patch_place_of(h.patches, patch);
            for (int e = 0; e < place.corners; e++) {
                uint32_t hanging[512];
                fans += hanging_on(h.patches, &place, e, hanging, NULL, 512) > 0;
                int next = (e + 1) % place.corners, last = (e + 2) % place.corners;
                /* points of the edge, a little inside and a little outside */
                for (uint64_t k = 0; k < 20; k++) {
                    double t = (double)sl_random_unit(key, tested++), side = SL_PATCH_DYADIC, nudge = 1e-7;
                    double u = ((double)place.u[e] + t * ((double)place.u[next] - (double)place.u[e])) / side;
                    double v = ((double)place.v[e] + t * ((double)place.v[next] - (double)place.v[e])) / side;
                    double inwards_u = ((double)place.u[last] - (double)place.u[e]) / side,
                           inwards_v = ((double)place.v[last] - (double)place.v[e]) / side;
                    double other_u = u - nudge * inwards_u, other_v = v - nudge * inwards_v;
                    if (other_u < 0 || other_v < 0 || other_u > 1 || other_v > 1 ||
                        (kind && other_u + other_v > 1))
                        continue;
                    float here[6], there[6];
                    value_beside(display, 0, u + nudge * inwards_u, v + nudge * inwards_v, here);
                    value_beside(display, 0, other_u, other_v, there);
                    for (int c = 0; c < 3; c++) assert_true(fabs((double)here[c] - (double)there[c]) < 1e-4);
                }
            }
        }
        assert_true(fans > 20 && tested > 1000);
        display_discard(display, &h);
    }
}

static void a_fan_may_have_hundreds_of_vertices_and_lose_them_again(void **state) {
    hierarchy h = hierarchy_of(square_scene(), 0);
    uint32_t root = want_root(&h, 0);
    split(&h, root);
    uint32_t child = h.patches->patch[root].child;
    for (int i = 0; i < 512; i++) { /* along the right edge of child 0 */
        for (sl_patch_place at;
             (at = sl_patch_locate(h.patches, 0, 0.5, 0.5 * (i + 0.5) / 512.0)).depth < 10;)
            split(&h, at.patch);
    }
    sample_all(&h, 2);
    sl_display *display = display_of(&h, W, H, guess);
    build_display(display, &h);
    sl_patch_place coarse = sl_patch_place_of(h.patches, child);
    static uint32_t hanging[1024];
    static uint16_t at[1024];
    assert_int_equal(hanging_on(h.patches, &coarse, 1, hanging, at, 1024), 511);
    float value[6];
    for (int k = 0; k < 511; k++) {
        value_beside(display, 0, 0.5 - 0x1p-24, 0.5 * at[k] / SL_PATCH_DYADIC, value);
        for (int c = 0; c < 3; c++)
            assert_true(fabs((double)value[c] - (double)sl_vertex_value(h.patches, hanging[k])[c]) < 1e-4);
    }
    for (int round = 0; round < 40; round++) { /* what is not used any more is thrown away */
        sl_patch_drop_children(h.patches, child + 1);
        build_display(display, &h);
        for (int i = 0; i < 512; i++) {
            for (sl_patch_place p;
                 (p = sl_patch_locate(h.patches, 0, 0.5, 0.5 * (i + 0.5) / 512.0)).depth < 10;)
                split(&h, p.patch);
        }
        build_display(display, &h);
        assert_true(display->copy[0].fans.used < 20000 && display->copy[1].fans.used < 20000);
    }
    display_discard(display, &h);
}

/* ---- two copies ------------------------------------------------------------------------------ */

static void what_a_copy_held_before_is_not_seen_of_a_build(void **state) {
    static picture one, other;
    static id_picture one_ids, other_ids;
    for (int glossy = 0; glossy < 2; glossy++) {
        hierarchy h = hierarchy_of(room(glossy), glossy ? KEEP_LOBES : 0);
        sl_display *display = display_of(&h, W, H, guess);
        for (uint32_t update = 1; update <= 40; update++) {
            change_at_random(&h, sl_random_key(29, update), update, update % 5 == 0 ? 2 : 150);
            build_display(display, &h);
            if (update % 3) continue;
            sl_display *fresh = display_of(&h, W, H, guess);
            build_display(fresh, &h);
            double turn = 0.7 * update;
            look(h.scene, sl_v3((float)(3.0 * sl_cos(turn)), 1.2f, (float)(3.0 * sl_sin(turn))),
                 sl_v3(0, 0.5f, 0));
            draw(display, 1, &one);
            draw(fresh, 1, &other);
            assert_memory_equal(&one, &other, sizeof one);
            map_ids(display, 1, &one_ids);
            map_ids(fresh, 1, &other_ids);
            assert_memory_equal(&one_ids, &other_ids, sizeof one_ids);
            sl_display_destroy(fresh);
        }
        assert_sound(h.patches);
        assert_true(h.patches->leaves_alive > 300);
        display_discard(display, &h);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame_is_what_evaluation_pixel_by_pixel_gives),
        cmocka_unit_test(silhouettes_are_exact_before_any_sample_and_surfaces_show_the_guess),
        cmocka_unit_test(a_split_without_samples_is_not_seen),
        cmocka_unit_test(colours_meet_along_edges_between_coarse_and_fine_leaves),
        cmocka_unit_test(a_fan_may_have_hundreds_of_vertices_and_lose_them_again),
        cmocka_unit_test(what_a_copy_held_before_is_not_seen_of_a_build),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
