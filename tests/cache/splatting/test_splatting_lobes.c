/* The fragment program of radiance records against the plain one of moved lobes, at every order and on every
 * instruction set: what stands in the padding of vectors must never count. And how far such a record's
 * gradients bear. */
#include <string.h>

#include "unit_test.h"
#include "base/random.h"
#include "cache/splatting/glossy.h"
#include "harmonics_support.h"

enum { PIXELS = 40, FLOATS = 9 * SL_HSH_STRIDE_MAX };

typedef struct view_of_pixels {
    float position[3][PIXELS], normal[3][PIXELS];
    uint32_t receives[PIXELS], material[PIXELS];
    sl_splat_receivers receivers;
    sl_material surfaces[2];
    sl_scene scene;
    sl_glossy *glossy;
    sl_glossy_view view;
    float coefficients[FLOATS];
    sl_glossy_record record;
} view_of_pixels;

static float number(uint64_t index) { return 2.0f * sl_random_unit(sl_random_key(4, 0), index) - 1.0f; }

static sl_vec3 direction(uint64_t index) {
    return sl_normalize_or(sl_v3(number(3 * index), number(3 * index + 1), number(3 * index + 2)),
                           sl_v3(0, 0, 1));
}

static void open_view(view_of_pixels *v, int order) {
    size_t stride = sl_hsh_stride(order);
    *v = (view_of_pixels){.surfaces = {{.specular = {1, 1, 1}, .exponent = 12.0f}, {.diffuse = {1, 1, 1}}}};
    sl_vec3 up = direction(99);
    for (uint64_t i = 0; i < PIXELS; i++) {
        sl_vec3 n = i % 5 ? sl_normalize_or(sl_mad(up, 0.4f, direction(i)), up) : up;
        v->normal[0][i] = n.x, v->normal[1][i] = n.y, v->normal[2][i] = n.z;
        for (uint64_t k = 0; k < 3; k++) v->position[k][i] = 0.1f * number(1000 + 3 * i + k);
        v->receives[i] = 1;
        v->material[i] = i == PIXELS - 1;
    }
    v->receivers = (sl_splat_receivers){
        PIXELS,       1,          v->position[0], v->position[1], v->position[2], v->normal[0], v->normal[1],
        v->normal[2], v->receives};
    v->scene = (sl_scene){.material_count = 2, .materials = v->surfaces};
    assert_int_equal(sl_glossy_create(&v->scene, order, &v->glossy, NULL), SL_OK);
    v->view = (sl_glossy_view){v->glossy, &v->receivers, v->material, sl_scale(direction(77), 5.0f), NULL};
    for (size_t i = 0; i < 9 * stride; i++) {
        size_t place = i % stride, odd = sl_hsh_odd_start(order);
        bool real =
            place < sl_hsh_even_count(order) || (place >= odd && place < odd + sl_hsh_odd_count(order));
        v->coefficients[i] = real ? number(2000 + i) : 0.0f;
    }
    v->record = (sl_glossy_record){{0.01f, -0.02f, 0.03f}, sl_frame_from_normal(up), v->coefficients};
}

static void expected_radiance(const view_of_pixels *v, int order, const sl_moved_lobe *lobe, size_t i,
                              double radiance[3]) {
    float weights[SL_HSH_STRIDE_MAX];
    size_t stride = sl_hsh_stride(order);
    const sl_frame *f = &v->record.frame;
    sl_vec3 p = sl_v3(v->position[0][i], v->position[1][i], v->position[2][i]);
    sl_vec3 n = sl_v3(v->normal[0][i], v->normal[1][i], v->normal[2][i]),
            out = sl_normalize_or(sl_sub(v->view.eye, p), n);
    float up = sl_dot(out, n), seen = up > 0.0f ? up : 0.0f;
    sl_vec3 r = sl_sub(sl_scale(n, seen + up), out), delta = sl_sub(p, v->record.position);
    double dx = (double)sl_dot(delta, f->x), dy = (double)sl_dot(delta, f->y);
    moved_lobe_look_up(lobe, order, sl_frame_to_local(f, r), sl_frame_to_local(f, n), seen, weights);
    for (size_t k = 0; k < 3; k++) {
        double here = 0.0, change = 0.0;
        for (size_t j = 0; j < stride; j++) {
            const float *c = v->coefficients + k * stride + j;
            here += (double)weights[j] * (double)c[0];
            change += (double)weights[j] * (dx * (double)c[3 * stride] + dy * (double)c[6 * stride]);
        }
        /* changes by half at most */
        radiance[k] = here + fmin(fmax(change, -0.5 * fabs(here)), 0.5 * fabs(here));
    }
}

static void every_order_on_every_instruction_set_equals_the_plain_loops(void **state) {
    static view_of_pixels v;
    for (int order = 1; order <= SL_HSH_ORDER_MAX; order++) {
        sl_moved_lobe *lobe;
        open_view(&v, order);
        assert_int_equal(sl_moved_lobe_create(order, 12.0, &lobe, NULL), SL_OK);
        for (size_t i = 0; i < PIXELS; i++) {
            double truth[3];
            float first[3];
            expected_radiance(&v, order, lobe, i, truth);
            for (int isa = SL_ISA_BASELINE; isa <= (int)sl_isa_best(); isa++) {
                float radiance[3];
                SL_KERNEL_OF((sl_isa)isa, sl_glossy_radiance)(&v.view, &v.record, i, radiance);
                if (isa == SL_ISA_BASELINE) memcpy(first, radiance, sizeof first);
                assert_memory_equal(radiance, first, sizeof first);
                for (int k = 0; k < 3; k++) /* the other material is not glossy */
                    assert_true(fabs((double)radiance[k] - (i == PIXELS - 1 ? 0.0 : truth[k])) < 2e-5);
            }
        }
        sl_moved_lobe_destroy(lobe);
        sl_glossy_destroy(v.glossy);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_order_on_every_instruction_set_equals_the_plain_loops),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
