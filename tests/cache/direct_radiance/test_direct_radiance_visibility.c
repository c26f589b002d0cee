/* Indirect shadows: rays between receivers and photons, one by one. */
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "receiver_support.h"
#include "trace_scenes.h"

enum { WIDTH = 96, HEIGHT = 80, PIXELS = WIDTH * HEIGHT };

/* A room of side 1 with a square plate of side 0.2 hanging in its middle. */
typedef struct {
    sl_scene *scene;
    sl_tracer *tracer;
    sl_gbuffer *receivers;
} stage;

static sl_vec3 floor_point(int x, int y) {
    return sl_v3(((float)x + 0.5f) / WIDTH, 0.0f, ((float)y + 0.5f) / HEIGHT);
}

static stage make_stage(bool plate) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t grey = trace_mesh_diffuse(&mesh, 0.5f);
    (void)trace_mesh_material(&mesh, 0.2f, 0.4f, 12.0f, 0.0f, 0.0f);
    trace_mesh_box(&mesh, sl_v3(0, 0, 0), sl_v3(1, 1, 1), true, grey);
    if (plate) trace_mesh_quad(&mesh, sl_v3(0.4f, 0.5f, 0.4f), sl_v3(0.2f, 0, 0), sl_v3(0, 0, 0.2f), grey);
    stage s = {.scene = trace_mesh_build(&mesh),
               .receivers = make_receivers(WIDTH, HEIGHT, sl_v3(0.5f, 0.8f, 0.5f))};
    s.tracer = tracer_of(s.scene);
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++)
            set_receiver(s.receivers, (size_t)(y * WIDTH + x), floor_point(x, y), sl_v3(0, 1, 0),
                         sl_v3(0, 1, 0), sl_grey(0.5f), 0);
    }
    return s;
}

static void end_stage(stage *s) {
    sl_gbuffer_destroy(s->receivers);
    sl_tracer_destroy(s->tracer);
    sl_scene_destroy(s->scene);
}

/* Photons that shine downwards from below the ceiling. */
static sl_map_photons *ceiling_photons(size_t count) {
    sl_map_photons *p = make_photons(count, 1.7f);
    for (size_t j = 0; j < count; j++) {
        float x = count == 1 ? 0.5f : 0.2f + 0.6f * (float)j / (float)(count - 1);
        p->photon[j] = (sl_map_photon){.position = {x, 1.0f, 0.5f},
                                       .footprint = 1e-4f,
                                       .flux = {1.0f, 0.5f, 0.25f},
                                       .cos_alpha = 0.9f,
                                       .normal = {0, -1, 0},
                                       .printed_area = 1e-4f,
                                       .radiance = {1.0f, 0.5f, 0.25f}};
    }
    return p;
}

static planes light_up(const stage *s, const sl_map_photons *photons, sl_photon_visibility visibility,
                       unsigned threads, sl_counters *counters) {
    sl_light_pass pass = {.scene = s->scene,
                          .photons = photons,
                          .weight = SL_WEIGHT_FLUX,
                          .tracer = visibility == SL_VISIBILITY_NONE ? NULL : s->tracer,
                          .threads = threads};
    planes p = make_planes(PIXELS);
    sl_lit_picture picture = {.indirect = {p.value[0], p.value[1], p.value[2]}};
    light_indirectly(&pass, s->receivers, &picture, counters);
    return p;
}

/* Distance on the floor to the edge of the plate's shadow from (1/2, 1, 1/2): a square of side 0.4; below 0
 * inside. */
static float from_shadow(int x, int y) {
    sl_vec3 p = floor_point(x, y);
    return fmaxf(fabsf(p.x - 0.5f), fabsf(p.z - 0.5f)) - 0.2f;
}

static void rays_leave_the_plates_shadow_on_the_floor(void **state) {
    stage s = make_stage(true);
    sl_map_photons *photons = ceiling_photons(1);
    sl_counters costs = {{0}}, none = {{0}};
    planes open = light_up(&s, photons, SL_VISIBILITY_NONE, 1, &none),
           traced = light_up(&s, photons, SL_VISIBILITY_RAYS, 1, &costs);
    for (int i = 0; i < PIXELS; i++) {
        float edge = from_shadow(i % WIDTH, i / WIDTH);
        assert_true(open.value[0][i] > 0.0f);
        if (fabsf(edge) < 1e-3f) continue;
        for (int c = 0; c < 3; c++)
            assert_true(traced.value[c][i] == (edge > 0.0f ? open.value[c][i] : 0.0f));
    }
    assert_int_equal(none.value[SL_COUNT_SHADOW_RAYS], 0);
    assert_int_equal(costs.value[SL_COUNT_SHADOW_RAYS], PIXELS);
    free_planes(&open);
    free_planes(&traced);
    free_photons(photons);
    end_stage(&s);
}

/* The mean of a group of texels on a ball lies inside the ball. */
static void photon_a_little_inside_its_curved_surface_is_seen(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t grey = trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_sphere(&mesh, sl_v3(0, 1, 0), 0.5f, 32, 0.0f, false, grey);
    stage s = {.scene = trace_mesh_build(&mesh), .receivers = make_receivers(WIDTH, HEIGHT, sl_v3(0, 3, 0))};
    s.tracer = tracer_of(s.scene);
    for (int i = 0; i < PIXELS; i++)
        set_receiver(s.receivers, (size_t)i,
                     sl_v3(0.001f * (float)(i % WIDTH), -1.0f, 0.001f * (float)(i / WIDTH)), sl_v3(0, 1, 0),
                     sl_v3(0, 1, 0), sl_grey(0.5f), 0);
    /* A cap of 20 degrees: its mean is 0.015 deep, and it stands for a disc of radius 0.5 sin 20. */
    sl_map_photons *photons = ceiling_photons(1);
    photons->photon[0].position = sl_v3(0.0f, 0.5f + 0.015f, 0.0f);
    photons->photon[0].footprint = (float)(SL_PI * 0.171 * 0.171 * 0.9);
    sl_counters costs = {{0}};
    planes open = light_up(&s, photons, SL_VISIBILITY_NONE, 1, &costs),
           rays = light_up(&s, photons, SL_VISIBILITY_RAYS, 1, &costs);
    assert_true(open.value[0][0] > 0.0f);
    assert_memory_equal(open.value[0], rays.value[0], PIXELS * sizeof(float));
    free_planes(&open);
    free_planes(&rays);
    free_photons(photons);
    end_stage(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_leave_the_plates_shadow_on_the_floor),
        cmocka_unit_test(photon_a_little_inside_its_curved_surface_is_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
