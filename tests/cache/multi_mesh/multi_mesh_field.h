/* Shared by tests of displayed meshes: a mesh over a scene, seen by a camera, whose samples come from a
 * field, a function of position and nothing else. Every function fails the test where anything fails. */
#pragma once

#include <math.h>

#include "cache/multi_mesh/displayed.h"
#include "raster_support.h"

typedef sl_rgb field_value(const void *context, sl_vec3 p);
typedef struct field {
    field_value *value;
    const void *context;
} field;

typedef struct rig {
    sl_scene *scene;         /* its own */
    sl_raster *raster;
    sl_primitives *primitives;
    sl_displayed *mesh;
    sl_visible_pixels *pixels;
    field field;
    int width, height;
    uint32_t *id;
    float *plane[3];
    uint64_t samples;        /* asked for */
    double chosen;           /* priorities of the leaves taken, together */
    sl_counters counters;
} rig;

static inline sl_rgb shown_as_it_is(const void *context, sl_component component, uint32_t face, float w1,
                                    float w2, sl_rgb value) {
    return value;
}

static inline bool want_all(const void *context, uint32_t face) {
    return true;
}

static inline sl_displayed_settings usual_settings(void) {
    return (sl_displayed_settings){.component = SL_DIRECT_DIFFUSE,
                                   .leaf_area = 16.0f,
                                   .leaf_edge = 8.0f,
                                   .max_depth = SL_MESH_DEPTH_MAX,
                                   .selection = SL_SELECT_HEAP,
                                   .seed = 1,
                                   .hanging = true,
                                   .perception = {1.0f, 1.0f},
                                   .shown = {NULL, shown_as_it_is},
                                   .threads = 1};
}

/* Takes the scene. */
static inline rig rig_of(sl_scene *scene, field f, const sl_displayed_settings *settings, int width,
                         int height) {
    rig r = {.scene = scene, .raster = raster_of(scene), .field = f, .width = width, .height = height};
    size_t pixels = (size_t)width * (size_t)height;
    assert_int_equal(sl_primitives_of_triangles(scene, &r.primitives, NULL), SL_OK);
    assert_int_equal(sl_displayed_create(r.primitives, settings, &r.mesh, NULL), SL_OK);
    r.id = malloc(pixels * sizeof *r.id);
    assert_non_null(r.id);
    for (int c = 0; c < 3; c++) {
        r.plane[c] = malloc(pixels * sizeof(float));
        assert_non_null(r.plane[c]);
        for (size_t i = 0; i < pixels; i++) r.plane[c][i] = -1.0f;
    }
    return r;
}

static inline void rig_discard(rig *r) {
    sl_displayed_destroy(r->mesh);
    sl_visible_pixels_destroy(r->pixels);
    sl_primitives_destroy(r->primitives);
    sl_raster_destroy(r->raster);
    sl_scene_destroy(r->scene);
    free(r->id);
    for (int c = 0; c < 3; c++) free(r->plane[c]);
}

static inline void rig_sample(rig *r, const uint32_t *vertex, size_t count) {
    sl_patches *mesh = r->mesh->mesh;
    for (size_t i = 0; i < count; i++) {
        sl_mesh_point point;
        point = sl_mesh_point_of(mesh, vertex[i]);
        sl_rgb value = r->field.value(r->field.context, point.lit.position);
        float *to = sl_vertex_value(mesh, vertex[i]);
        to[0] = value.r;
        to[1] = value.g;
        to[2] = value.b;
        sl_mesh_set_state(mesh, vertex[i], sl_rgb_is_finite(value) ? SL_VERTEX_KNOWN : SL_VERTEX_INVALID);
    }
    r->samples += count;
}

static inline void rig_fill_missing(rig *r) {
    uint32_t vertex[256];
    for (size_t count; (count = sl_displayed_missing(r->mesh, vertex, 256)) > 0;)
        rig_sample(r, vertex, count);
    sl_displayed_prioritise(r->mesh);
}

/* Looks at the scene from where its camera, or another one, stands; roots' corners are sampled. */
static inline void rig_look(rig *r, const sl_camera *camera, unsigned threads) {
    sl_view view = sl_view_scene(r->scene, r->width, r->height);
    if (camera) {
        sl_camera own = r->scene->camera;
        r->scene->camera = *camera;
        view = sl_view_scene(r->scene, r->width, r->height);
        r->scene->camera = own;
    }
    sl_target target = {r->width, r->height, r->id, NULL};
    assert_int_equal(sl_raster_id(r->raster, &view, 1, &target, &r->counters, NULL), SL_OK);
    sl_visible_pixels *old = r->pixels;
    assert_int_equal(
        sl_visible_pixels_sort(r->primitives, r->raster, &view, r->id, threads, &r->pixels, &r->counters, NULL),
        SL_OK);
    assert_int_equal(sl_displayed_see(r->mesh, r->pixels, want_all, NULL, NULL), SL_OK);
    sl_visible_pixels_destroy(old);
    rig_fill_missing(r);
}

/* With the usual settings, seen from the scene's camera. Takes the scene. */
static inline rig rig_in_view(sl_scene *scene, field f, int width, int height) {
    const sl_displayed_settings settings = usual_settings();
    rig r = rig_of(scene, f, &settings, width, height);
    rig_look(&r, NULL, 1);
    return r;
}

/* A batch of up to 32 leaves; how many there were. */
static inline size_t rig_step(rig *r, size_t batch) {
    sl_patch_place leaf[32];
    size_t taken = 0;
    uint32_t vertex[6 * 32];
    size_t asked = 0;
    for (; taken < batch && taken < 32; taken++) {
        float priority = sl_displayed_priority(r->mesh);
        leaf[taken] = sl_displayed_take(r->mesh);
        if (leaf[taken].patch == SL_NO_INDEX) break;
        if (r->mesh->settings.selection == SL_SELECT_HEAP) r->chosen += (double)priority;
    }
    for (size_t i = 0; i < taken; i++) {
        size_t count;
        assert_int_equal(sl_displayed_request(r->mesh, &leaf[i], vertex + asked, &count, NULL), SL_OK);
        asked += count;
    }
    rig_sample(r, vertex, asked);
    for (size_t i = 0; i < taken; i++)
        assert_int_equal(sl_displayed_commit(r->mesh, &leaf[i], &r->counters, NULL), SL_OK);
    return taken;
}

/* Until nothing is left; how many leaves were served. */
static inline size_t rig_finish(rig *r) {
    size_t served = 0;
    for (size_t n; (n = rig_step(r, 32)) > 0; served += n) {
        if (served > 4000000) fail_msg("refinement does not end");
    }
    return served;
}

static inline void rig_draw(rig *r, unsigned threads) {
    sl_displayed_draw(r->mesh, threads, sl_grey(0.25f), r->plane, &r->counters);
}

/* A square of 2 x 2 in the plane z = 0, seen head on so that it just fills a square picture. */
static inline sl_scene *square_scene(void) {
    static const float xyz[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, -1, 0, 1, 1, 0, -1, 1, 0};
    sl_scene *scene = scene_of_triangles(xyz, 2);
    assert_true(sl_camera_look_at(&scene->camera, sl_v3(0, 0, 2), sl_v3(0, 0, 0), sl_v3(0, 1, 0),
                                  2.0f * 0.463647609f /* atan(1/2) */));
    return scene;
}

static inline sl_camera room_camera(sl_vec3 eye, sl_vec3 target) {
    sl_camera camera;
    assert_true(sl_camera_look_at(&camera, eye, target, sl_v3(0, 1, 0), 1.0f));
    return camera;
}

/* ---- leaves ---- */

typedef void visit_leaf(void *context, const sl_patch_place *leaf);
static inline void visit_below(const sl_patches *mesh, const sl_patch_place *place, visit_leaf *visit,
                               void *context) {
    if (sl_patch_is_leaf(mesh, place->patch)) {
        visit(context, place);
        return;
    }
    for (int c = 0; c < 4; c++) {
        sl_patch_place child = sl_patch_child_place(mesh, place, c);
        visit_below(mesh, &child, visit, context);
    }
}

/* All leaves of faces in view. */
static inline void visit_leaves(const sl_displayed *d, visit_leaf *visit, void *context) {
    for (size_t e = 0; e < d->pixels->face_count; e++) {
        sl_patch_place root = sl_patch_root_place(d->mesh, d->pixels->face[e].face);
        visit_below(d->mesh, &root, visit, context);
    }
}

static inline size_t roots_in_view(const sl_displayed *d) { return d->pixels->face_count; }

/* Shadow borders across a room. */
static inline sl_rgb stripes(const void *context, sl_vec3 p) {
    float s = p.x * 1.7f + p.y * 2.3f + p.z * 1.1f;
    return s - floorf(s) < 0.3f ? (sl_rgb){0.1f, 0.12f, 0.15f} : (sl_rgb){0.9f, 0.8f, 0.6f};
}

static inline sl_scene *striped_room(void) {
    sl_scene *scene = furnished_room(6, 6);
    scene->camera = room_camera(sl_v3(2, 1.5f, 4.9f), sl_v3(2.2f, 1.2f, 0));
    return scene;
}
