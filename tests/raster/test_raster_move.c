/* Moved vertices: what is drawn afterwards is what a rasterizer made anew draws, and what the plain pipeline
 * draws, bit by bit. */
#include "raster/pipeline.h"
#include "tests/raster/plain.h"
#include "raster_support.h"
#include "scene/derive.h"

enum { W = 200, H = 150, PIXELS = W * H, VIEWS = 6 };

static uint32_t moved_id[PIXELS], fresh_id[PIXELS];
static float moved_depth[PIXELS], fresh_depth[PIXELS];

static sl_view view_number(uint64_t n) {
    uint64_t key = sl_random_key(91, n);
    sl_frame frame = sl_frame_from_normal(random_direction(key, 0));
    sl_vec3 eye = sl_v3(random_between(key, 100, 0.5f, 3.5f), random_between(key, 101, 0.5f, 2.5f),
                        random_between(key, 102, 0.5f, 4.5f));
    if (n % 2) return sl_view_pyramid(&frame, eye, -1.5f, 2.0f, -1.0f, 1.0f, W, H, 1e-3f);
    sl_camera camera = {eye, frame.x, frame.y, sl_neg(frame.z), 1.3f};
    return camera_view(&camera, W, H, 0.05f, 50.0f);
}

static void assert_same_picture(const uint32_t *id, const float *depth, const uint32_t *other_id,
                                const float *other_depth) {
    for (int i = 0; i < PIXELS; i++) {
        if (id[i] == other_id[i] && memcmp(&depth[i], &other_depth[i], 4) == 0) continue;
        fail_msg("pixel %d,%d: %u at %.9g, not %u at %.9g", i % W, i / W, id[i], (double)depth[i],
                 other_id[i], (double)other_depth[i]);
    }
}

/* Pictures of the moved rasterizer against one made anew. Returns triangles submitted, over those of the
 * other. */
static double compare_with_fresh(const sl_raster *moved, const sl_scene *scene, const sl_raster_mesh *mesh) {
    sl_raster *fresh = NULL;
    assert_int_equal(scene ? sl_raster_create(scene, 1, &fresh, NULL)
                           : sl_raster_create_mesh(mesh, 1, &fresh, NULL),
                     SL_OK);
    uint64_t submitted = 0, by_fresh = 0;
    for (uint64_t n = 0; n < VIEWS; n++) {
        sl_view view = view_number(n);
        submitted += render(moved, &view, 2, moved_id, moved_depth).value[SL_COUNT_TRIANGLES_SUBMITTED];
        by_fresh += render(fresh, &view, 1, fresh_id, fresh_depth).value[SL_COUNT_TRIANGLES_SUBMITTED];
        assert_same_picture(moved_id, moved_depth, fresh_id, fresh_depth);
    }
    sl_view view = view_number(1);
    sl_target target = {W, H, fresh_id, fresh_depth};
    sl_plain_id(&fresh->mesh, scene, &view, &target);
    render(moved, &view, 1, moved_id, moved_depth);
    assert_same_picture(moved_id, moved_depth, fresh_id, fresh_depth);
    sl_raster_destroy(fresh);
    return by_fresh ? (double)submitted / (double)by_fresh : 1.0;
}

/* ---- motion ---- */

/* Vertices of triangles [first, end), each once. */
static void shift_vertices(sl_scene *scene, size_t first, size_t end, sl_vec3 by) {
    bool *done = calloc(scene->vertex_count, sizeof *done);
    assert_non_null(done);
    for (size_t t = first; t < end; t++) {
        for (int k = 0; k < 3; k++) {
            uint32_t v = scene->vertex[k][t];
            if (done[v]) continue;
            done[v] = true;
            scene->position_x[v] += by.x;
            scene->position_y[v] += by.y;
            scene->position_z[v] += by.z;
        }
    }
    free(done);
    sl_scene_derive(scene);
}

static void an_object_that_moved_is_drawn_as_if_it_had_always_been_there(void **state) {
    enum { BALLS = 10, N = 6, ROOM = 12 * 8 * 8 };
    sl_scene *scene = furnished_room(BALLS, N);
    sl_raster *raster = raster_of(scene);
    size_t each = 12 * (size_t)N * N;
    for (uint64_t frame = 0; frame < 8; frame++) {
        for (size_t b = 0; b < BALLS; b += 2) {
            sl_vec3 by = sl_scale(random_direction(sl_random_key(92, frame), b), 0.2f);
            shift_vertices(scene, ROOM + b * each, ROOM + (b + 1) * each, by);
        }
        assert_int_equal(sl_raster_move(raster, 1 + (unsigned)frame % 3, NULL), SL_OK);
        double price = compare_with_fresh(raster, scene, NULL);
        if (!(price < 1.3)) fail_msg("%g times the triangles", price);
    }
    sl_gbuffer *a = NULL, *b = NULL; /* what is resolved afterwards follows, too */
    sl_raster *fresh = raster_of(scene);
    sl_counters counters = {{0}};
    sl_view view = view_number(0);
    assert_int_equal(sl_gbuffer_create(W, H, &a, NULL), SL_OK);
    assert_int_equal(sl_gbuffer_create(W, H, &b, NULL), SL_OK);
    assert_int_equal(sl_raster_gbuffer(raster, &view, 2, a, &counters, NULL), SL_OK);
    assert_int_equal(sl_raster_gbuffer(fresh, &view, 1, b, &counters, NULL), SL_OK);
    assert_memory_equal(a->position_x, b->position_x, 4 * PIXELS);
    assert_memory_equal(a->normal_y, b->normal_y, 4 * PIXELS);
    sl_gbuffer_destroy(a);
    sl_gbuffer_destroy(b);
    sl_raster_destroy(fresh);
    destroy_raster(raster, scene);
}

/* By place, so that vertices that share one stay together. */
static sl_vec3 wave(sl_vec3 p, float phase) {
    return sl_v3(p.x + 0.15f * sinf(3.0f * p.y + phase), p.y + 0.1f * sinf(2.0f * p.z + 2.0f * phase),
                 p.z + 0.15f * sinf(2.5f * p.x + phase));
}

static void a_mesh_that_deforms_is_drawn_as_if_it_were_made_anew_each_frame(void **state) {
    sl_scene *scene = furnished_room(10, 6);
    sl_raster *raster = raster_of(scene);
    sl_vec3 *rest = malloc(scene->vertex_count * sizeof *rest);
    assert_non_null(rest);
    for (uint32_t v = 0; v < scene->vertex_count; v++) rest[v] = sl_scene_position(scene, v);
    const float *vertices = raster->vertex_x;
    for (int frame = 0; frame < 8; frame++) {
        for (uint32_t v = 0; v < scene->vertex_count; v++) {
            sl_vec3 p = wave(rest[v], (float)frame);
            scene->position_x[v] = p.x;
            scene->position_y[v] = p.y;
            scene->position_z[v] = p.z;
        }
        sl_scene_derive(scene);
        assert_int_equal(sl_raster_move(raster, 2, NULL), SL_OK);
        assert_ptr_equal(raster->vertex_x, vertices); /* the clusters were kept */
        compare_with_fresh(raster, scene, NULL);
    }
    free(rest);
    destroy_raster(raster, scene);
}

/* ---- meshes of triangles of their own ---- */

enum { COUNT = 1500 };
typedef struct {
    float x[3 * COUNT], y[3 * COUNT], z[3 * COUNT];
    uint32_t vertex[3][COUNT];
    sl_raster_mesh mesh;
    sl_raster *raster;
} soup;

/* A sheet of triangles that touch, each with vertices of its own. */
static void make_sheet(soup *s) {
    const int columns = 30, di[6] = {0, 1, 1, 0, 1, 0}, dj[6] = {0, 0, 1, 0, 1, 1};
    for (int n = 0; n < 3 * COUNT; n++) {
        int square = n / 6, i = square % columns + di[n % 6], j = square / columns + dj[n % 6];
        s->x[n] = 0.125f * (float)i;
        s->y[n] = 1.0f + 0.0625f * (float)((i * 7 + j * 5) % 9);
        s->z[n] = 0.1875f * (float)j;
        s->vertex[n % 3][n / 3] = (uint32_t)n;
    }
    s->mesh =
        (sl_raster_mesh){3 * COUNT, COUNT, s->x, s->y, s->z, {s->vertex[0], s->vertex[1], s->vertex[2]}};
    assert_int_equal(sl_raster_create_mesh(&s->mesh, 1, &s->raster, NULL), SL_OK);
}

static void positions_that_become_infinite_or_nan_are_drawn_as_they_would_be_anew(void **state) {
    static soup s;
    static const float odd[] = {NAN, INFINITY, -INFINITY, 3e38f, -0.0f, 1e-42f};
    make_sheet(&s);
    for (uint64_t frame = 0; frame < 6; frame++) {
        uint64_t key = sl_random_key(94, frame);
        for (uint64_t n = 0; n < 60; n++) {
            float *axis[3] = {s.x, s.y, s.z};
            axis[n % 3][sl_random_bits(key, n) % (3 * COUNT)] = odd[sl_random_bits(key, 100 + n) % 6];
        }
        /* no area */
        for (int k = 0; k < 3; k++)
            s.y[300 * frame + (size_t)k] = s.z[300 * frame + (size_t)k] = s.x[300 * frame + (size_t)k];
        assert_int_equal(sl_raster_move(s.raster, 2, NULL), SL_OK);
        compare_with_fresh(s.raster, NULL, &s.mesh);
    }
    sl_raster_destroy(s.raster);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_object_that_moved_is_drawn_as_if_it_had_always_been_there),
        cmocka_unit_test(a_mesh_that_deforms_is_drawn_as_if_it_were_made_anew_each_frame),
        cmocka_unit_test(positions_that_become_infinite_or_nan_are_drawn_as_they_would_be_anew),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
