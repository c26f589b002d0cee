/* A displayed mesh refines where an eye can tell, and only there; what was split in vain is undone; it always
 * ends. */
#include <stdio.h>

#include "multi_mesh_field.h"

/* ---- fields ---- */

static sl_rgb uniform(const void *context, sl_vec3 p) {
    return (sl_rgb){0.4f, 0.5f, 0.6f};
}

static sl_rgb linear(const void *context, sl_vec3 p) {
    return (sl_rgb){1.0f + 0.3f * p.x + 0.1f * p.y, 0.9f - 0.25f * p.y, 0.5f + 0.2f * p.x};
}

/* A round shadow. */
typedef struct disc {
    float x, y, radius;
} disc;
static sl_rgb shadow(const void *context, sl_vec3 p) {
    const disc *s = context;
    float dx = p.x - s->x, dy = p.y - s->y;
    return sl_grey(dx * dx + dy * dy < s->radius * s->radius ? 0.05f : 1.0f);
}

/* The same far below what an eye can tell from black: D < 10. */
static sl_rgb dark_shadow(const void *context, sl_vec3 p) {
    return sl_rgb_scale(shadow(context, p), 0.0005f);
}

static sl_rgb noise(const void *context, sl_vec3 p) {
    uint64_t seed = *(const uint64_t *)context;
    uint32_t bits[3];
    memcpy(bits, &p, sizeof bits);
    uint64_t key = sl_random_key(seed, (uint64_t)bits[0] << 32 | bits[1]);
    return (sl_rgb){sl_random_unit(key, bits[2]), sl_random_unit(key, bits[2] + 1u),
                    sl_random_unit(key, bits[2] + 2u)};
}

static sl_rgb noise_with_holes(const void *context, sl_vec3 p) {
    sl_rgb value = noise(context, p);
    return value.r < 0.2f ? sl_grey(NAN) : value;
}

/* ---- leaves and their pixels ---- */

typedef struct check {
    const rig *r;
    size_t leaves, pixels;
    int deepest;
    float largest;     /* priority, computed anew */
    double error;      /* of pixels outside their leaf, in the leaf's weights */
} check;

static void check_leaf(void *context, const sl_patch_place *leaf) {
    check *c = context;
    const sl_displayed *d = c->r->mesh;
    const sl_patch *node = &d->mesh->patch[leaf->patch];
    c->leaves++;
    c->pixels += node->pixels;
    c->deepest = leaf->depth > c->deepest ? leaf->depth : c->deepest;
    for (uint32_t n = 0; n < node->pixels; n++) {
        uint32_t i = sl_displayed_pixel(d, leaf->patch, n);
        assert_int_equal(d->pixels->face[d->pixels->entry_of_face[leaf->root]].face, leaf->root);
        float a, b;
        sl_mesh_weights_within(leaf, d->pixels->w1[i], d->pixels->w2[i], &a, &b);
        double out = fmax(fmax(-(double)a, -(double)b), (double)a + (double)b - 1.0);
        c->error = fmax(c->error, out);
    }
}

static check check_all(const rig *r) {
    check c = {.r = r};
    visit_leaves(r->mesh, check_leaf, &c);
    return c;
}

static void each_pixel_belongs_to_the_leaf_in_which_it_lies(void **state) {
    rig r = rig_in_view(striped_room(), (field){stripes, NULL}, 160, 120);
    for (int round = 0; round < 3; round++) {
        check c = check_all(&r);
        assert_int_equal(c.pixels, r.pixels->count);
        assert_true(c.error < 2e-3); /* a 2^-24th of the face at depth 12 */
        for (int i = 0; i < 20; i++) rig_step(&r, 32);
        if (round == 1) rig_look(&r, NULL, 1); /* handed down from the roots again */
    }
    rig_discard(&r);
}

static void the_first_image_samples_the_corners_of_faces_in_view_and_no_more(void **state) {
    rig r = rig_in_view(striped_room(), (field){stripes, NULL}, 160, 120);
    size_t corners = 0;
    uint8_t *is_corner = calloc(r.mesh->mesh->vertex_count, 1);
    assert_non_null(is_corner);
    for (size_t e = 0; e < r.pixels->face_count; e++) {
        for (int c = 0; c < 3; c++) {
            uint8_t *corner = &is_corner[sl_patch_corner(r.mesh->mesh, r.mesh->root[e], c)];
            corners += !*corner;
            *corner = 1;
        }
    }
    free(is_corner);
    assert_int_equal(r.samples, corners);
    assert_int_equal(r.mesh->mesh->leaves_alive, roots_in_view(r.mesh));
    assert_int_equal(r.counters.value[SL_COUNT_SPLITS], 0);
    uint32_t vertex;
    assert_int_equal(sl_displayed_missing(r.mesh, &vertex, 1), 0);
    rig_discard(&r);
}

/* ---- what is split and what is undone ---- */

/* Runs a field over a square; all is undone but for the two roots. */
static void assert_all_undone(field f, float threshold_scale) {
    sl_displayed_settings settings = usual_settings();
    settings.perception.threshold_scale = threshold_scale;
    rig r = rig_of(square_scene(), f, &settings, 128, 128);
    rig_look(&r, NULL, 1);
    int wanted = 0;
    for (uint32_t face = 0; face < 4; face += 2) {
        sl_patch_place root = sl_patch_root_place(r.mesh->mesh, face);
        int depth = sl_displayed_wanted_depth(r.mesh, &root);
        wanted = depth > wanted ? depth : wanted;
    }
    assert_int_equal(wanted, 5); /* 181 pixels along the hypotenuse to at most 8 */
    for (size_t n = 1; n > 0;) {
        n = rig_step(&r, 7);
        assert_true(check_all(&r).deepest <= wanted);
    }
    assert_int_equal(r.mesh->mesh->leaves_alive, 2);
    assert_int_equal(r.counters.value[SL_COUNT_SPLITS], r.counters.value[SL_COUNT_COLLAPSES]);
    /* each node down to the criterion was looked at */
    assert_true(r.counters.value[SL_COUNT_SPLITS] >= 2 * (1 + 4 + 16 + 64 + 256));

    /* And so it stays: in this view, in itself anew, and from nearer but not twice as near. */
    uint64_t samples = r.samples, splits = r.counters.value[SL_COUNT_SPLITS];
    assert_int_equal(rig_step(&r, 1), 0);
    rig_look(&r, NULL, 1);
    assert_int_equal(rig_finish(&r), 0);
    sl_camera nearer = r.scene->camera, twice = r.scene->camera;
    nearer.eye.z = 1.3f;
    twice.eye.z = 0.05f;
    twice.eye.x = twice.eye.y = -0.98f;
    rig_look(&r, &nearer, 1);
    assert_int_equal(rig_finish(&r), 0);
    assert_int_equal(r.samples, samples);
    assert_int_equal(r.counters.value[SL_COUNT_SPLITS], splits);
    /* Cut to the picture the square is no larger from nearby, but back in the first view nothing must have
     * changed. */
    rig_look(&r, &twice, 1);
    rig_finish(&r);
    rig_look(&r, NULL, 1);
    samples = r.samples;
    rig_finish(&r);
    assert_int_equal(r.samples, samples);
    rig_discard(&r);
}

static void a_uniform_field_is_split_for_its_size_and_all_undone(void **state) {
    assert_all_undone((field){uniform, NULL}, 1.0f);
}

static void a_linear_field_is_all_undone(void **state) {
    assert_all_undone((field){linear, NULL}, 1.0f);
}

static void a_shadow_in_the_dark_is_not_split_at(void **state) {
    disc s = {0.1f, 0.2f, 0.5f};
        assert_true(sl_display_level(1.0f, 0.0005f) < 10.0f);
    assert_all_undone((field){dark_shadow, &s}, 1.0f);
}

/* ---- it ends ---- */

static void noise_is_refined_down_to_pixels_and_ends(void **state) {
    uint64_t seed = 9;
    field_value *fields[] = {noise, noise_with_holes};
    for (int f = 0; f < 2; f++) {
        rig r = rig_in_view(striped_room(), (field){fields[f], &seed}, 96, 72);
        size_t served = rig_finish(&r);
        check c = check_all(&r);
        assert_true(c.deepest <= SL_MESH_DEPTH_MAX);
        /* Each served leaf had more than one pixel, and is one of at most twelve on the way to any of them.
         */
        assert_true(served < 2 * SL_MESH_DEPTH_MAX * r.pixels->count);
        assert_true(c.leaves > r.pixels->count / 2);
        double bytes = (double)sl_displayed_memory_bytes(r.mesh) / (double)c.leaves;
        print_message("%zu leaves, %.0f bytes each, all told\n", (size_t)c.leaves, bytes);
        assert_true(bytes < 150.0);
        rig_draw(&r, 1);
        for (size_t i = 0; i < 96 * 72; i++) {
            if (r.id[i] != SL_NO_INDEX) assert_true(r.plane[0][i] >= 0.0f && r.plane[0][i] <= 1.0f);
        }
        rig_discard(&r);
    }
}

/* Cut leaves that show two or three pixels. */
static size_t cut_minor_leaves(const rig *r) {
    const sl_patches *mesh = r->mesh->mesh;
    size_t count = 0;
    for (uint32_t n = 0; n < mesh->patch_count; n++)
        count += sl_patch_is_alive(mesh, n) && !sl_patch_is_leaf(mesh, n) &&
                 (mesh->patch[n].pixels == 2 || mesh->patch[n].pixels == 3);
    return count;
}

/* About a middle grey, by up to 20 levels: thresholds are 3 of them. */
static sl_rgb faint_noise(const void *context, sl_vec3 p) {
    sl_rgb value = noise(context, p);
    return (sl_rgb){0.4f + 0.1f * value.r, 0.4f + 0.1f * value.g, 0.4f + 0.1f * value.b};
}

static void minor_leaves_are_looked_into_only_where_their_corners_differ_by_much(void **state) {
    uint64_t seed = 9;
    static field_value *const fields[3] = {faint_noise, faint_noise, noise};
    size_t cut[3];
    uint64_t samples[3];
    for (int k = 0; k < 3; k++) {
        sl_displayed_settings settings = usual_settings();
        settings.minor_pixels = k ? 4 : 0;
        settings.minor_contrast = 30.0f;
        rig r = rig_of(square_scene(), (field){fields[k], &seed}, &settings, 64, 64);
        rig_look(&r, NULL, 1);
        rig_finish(&r);
        cut[k] = cut_minor_leaves(&r);
        samples[k] = r.samples;
        rig_discard(&r);
    }
    assert_true(cut[0] > 200);
    assert_int_equal(cut[1], 0);
    assert_true(3 * samples[1] < 2 * samples[0]);
    assert_true(cut[2] > 200);
}

/* ---- views ---- */

static sl_rgb curved(const void *context, sl_vec3 p) {
    return (sl_rgb){0.1f + 0.2f * p.x * p.x, 0.2f + 0.1f * p.y * p.z, 0.3f + 0.05f * p.z * p.z * p.y};
}

/* Samples asked for by the first view and, together, by returns to it. */
static void come_and_go(field f, uint64_t *first, uint64_t *again) {
    sl_displayed_settings settings = usual_settings();
    rig r = rig_of(striped_room(), f, &settings, 160, 120);
    sl_camera other[3] = {room_camera(sl_v3(2.1f, 1.6f, 4.5f), sl_v3(1.8f, 1.0f, 0)),
                          room_camera(sl_v3(0.5f, 1.0f, 3), sl_v3(4, 1.2f, 2)),
                          room_camera(sl_v3(2.2f, 1.2f, 1.2f), sl_v3(2.2f, 1.2f, 0))};
    rig_look(&r, NULL, 1);
    rig_finish(&r);
    *first = r.samples;
    *again = 0;
    for (int i = 0; i < 3; i++) {
        uint64_t before = r.samples;
        rig_look(&r, &other[i], 1);
        rig_finish(&r);
        assert_true(r.samples - before < *first); /* much is known */
        before = r.samples;
        rig_look(&r, NULL, 1);
        rig_finish(&r);
        *again += r.samples - before;
    }
    rig_discard(&r);
}

static void a_view_seen_again_asks_for_hardly_anything(void **state) {
    static field_value *const fields[3] = {curved, linear, stripes};
    for (int k = 0; k < 3; k++) {
        uint64_t first, again;
        come_and_go((field){fields[k], NULL}, &first, &again);
        assert_true(again < first / 500);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_pixel_belongs_to_the_leaf_in_which_it_lies),
        cmocka_unit_test(the_first_image_samples_the_corners_of_faces_in_view_and_no_more),
        cmocka_unit_test(a_uniform_field_is_split_for_its_size_and_all_undone),
        cmocka_unit_test(a_linear_field_is_all_undone),
        cmocka_unit_test(a_shadow_in_the_dark_is_not_split_at),
        cmocka_unit_test(noise_is_refined_down_to_pixels_and_ends),
        cmocka_unit_test(minor_leaves_are_looked_into_only_where_their_corners_differ_by_much),
        cmocka_unit_test(a_view_seen_again_asks_for_hardly_anything),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
