/* Splats and coverage, drawn tile by tile and sixteen pixels at a time, against their plain counterpart: the
 * fragment program run on every pixel of the screen for every record in order. Every bit must agree. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/counters.h"
#include "base/random.h"
#include "cache/splatting/splatting.h"

enum { MOST_PIXELS = 200 * 150, RECORDS = 150, PLANES = 6 };

/* A view into the corner of a room, with holes that receive nothing and hold what must never be looked at. */
typedef struct {
    int width, height;
    sl_camera camera;
    float px[MOST_PIXELS], py[MOST_PIXELS], pz[MOST_PIXELS], nx[MOST_PIXELS], ny[MOST_PIXELS],
        nz[MOST_PIXELS];
    uint32_t receives[MOST_PIXELS];
    float planes[PLANES * MOST_PIXELS]; /* weight, r, g, b, count, coverage */
    sl_record records[RECORDS];
    sl_record_pass pass;
} screen;

static float between(uint64_t key, uint64_t index, float low, float high) {
    return low + (high - low) * sl_random_unit(key, index);
}

/* The wall of the cube [-1, 1]^3 that a ray from inside meets; normals inwards and a little bent, as shading
 * normals are. */
static void meet_wall(screen *s, int pixel, sl_vec3 d) {
    const float direction[3] = {d.x, d.y, d.z}, eye[3] = {s->camera.eye.x, s->camera.eye.y, s->camera.eye.z};
    float nearest = INFINITY;
    int axis = 0;
    for (int k = 0; k < 3; k++) {
        float t = ((direction[k] > 0.0f ? 1.0f : -1.0f) - eye[k]) / direction[k];
        if (t < nearest) nearest = t, axis = k;
    }
    sl_vec3 p = sl_mad(s->camera.eye, nearest, d);
    float n[3] = {0.05f * p.y, 0.05f * p.z, 0.05f * p.x};
    n[axis] = direction[axis] > 0.0f ? -1.0f : 1.0f;
    sl_vec3 normal = sl_normalize_or(sl_v3(n[0], n[1], n[2]), sl_v3(0, 0, 1));
    s->px[pixel] = p.x, s->py[pixel] = p.y, s->pz[pixel] = p.z;
    s->nx[pixel] = normal.x, s->ny[pixel] = normal.y, s->nz[pixel] = normal.z;
    s->receives[pixel] = 1;
}

static void make_screen(screen *s, int width, int height) {
    memset(s, 0, sizeof *s);
    s->width = width;
    s->height = height;
    assert_true(
        sl_camera_look_at(&s->camera, sl_v3(0.7f, 0.3f, 0.8f), sl_v3(-1, -0.8f, -1), sl_v3(0, 1, 0), 1.2f));
    const sl_camera *c = &s->camera;
    float top = tanf(0.6f), right = top * (float)width / (float)height;
    for (int i = 0; i < width * height; i++) {
        int x = i % width, y = i / width;
        float u = (2.0f * ((float)x + 0.5f) / (float)width - 1.0f) * right,
              v = (2.0f * ((float)y + 0.5f) / (float)height - 1.0f) * top;
        meet_wall(s, i, sl_mad(sl_mad(sl_neg(c->back), u, c->right), v, c->up));
        if ((x / 9 + y / 7) % 6 != 1) continue;
        s->receives[i] = 0;
        if (x % 3 == 0)
            s->px[i] = s->py[i] = s->pz[i] = s->nx[i] = s->ny[i] = s->nz[i] = x % 2 ? NAN : INFINITY;
    }
    s->pass = (sl_record_pass){
        .receivers = {width, height, s->px, s->py, s->pz, s->nx, s->ny, s->nz, s->receives},
        .weights = {0.3f, 1.0f / 0.3f, 1e-5f},
        .radii = {.accuracy = (double)0.3f},
        .kernels = sl_splat_kernels_for(sl_isa_best()),
        .camera = &s->camera,
        .near_distance = 1e-4f,
        .coverage = s->planes + 5 * MOST_PIXELS,
        .threads = 1,
    };
}

/* At pixels of the screen, most of them; others outside the view, behind the eye or around it; tiny, huge and
 * broken ones. */
static void make_records(screen *s) {
    uint64_t key = sl_random_key(21, 22);
    for (uint64_t k = 0; k < RECORDS; k++) {
        size_t pixel = (size_t)between(key, 100 * k, 0.0f, (float)(s->width * s->height) - 1.0f);
        sl_record *r = &s->records[k];
        r->position = s->receives[pixel]
                          ? sl_v3(s->px[pixel], s->py[pixel], s->pz[pixel])
                          : sl_v3(between(key, 100 * k + 1, -1, 1), between(key, 100 * k + 2, -1, 1),
                                  between(key, 100 * k + 3, -1, 1));
        r->normal = s->receives[pixel] ? sl_v3(s->nx[pixel], s->ny[pixel], s->nz[pixel]) : sl_v3(0, 1, 0);
        float u = sl_random_unit(key, 100 * k + 4);
        r->radius = k % 10 == 0 ? 0.004f : 0.1f + 2.5f * u * u;
        r->stretch = 1.0f;
        r->irradiance = (sl_rgb){1.0f + u, 2.0f - u, 0.25f};
        for (uint64_t c = 0; c < 3; c++) {
            r->rotational[c] =
                sl_v3(between(key, 100 * k + 10 + c, -1, 1), between(key, 100 * k + 20 + c, -1, 1), u);
            r->translational[c] =
                sl_v3(u, between(key, 100 * k + 30 + c, -2, 2), between(key, 100 * k + 40 + c, -2, 2));
            r->rotational_length[c] = sl_length(r->rotational[c]);
        }
        r->behind_a_wall = k % 17 == 3; /* these go pixel by pixel */
    }
    s->records[5].radius = 0.0f;
    s->records[6].radius = NAN;
    s->records[7].position.x = NAN;
    s->records[8].radius = 1e30f;
    s->records[9].radius = INFINITY;
}

/* ---- the plain counterpart ---- */

static float twin_weight(const screen *s, const sl_record *k, size_t i, float *turn) {
    const float a = s->pass.weights.accuracy, tolerance = s->pass.weights.front_tolerance,
                reach = a * k->radius;
    float x = s->px[i] - k->position.x, y = s->py[i] - k->position.y, z = s->pz[i] - k->position.z;
    float mx = s->nx[i] - k->normal.x, my = s->ny[i] - k->normal.y, mz = s->nz[i] - k->normal.z;
    float squared = x * x + y * y + z * z;
    *turn = sqrtf(mx * mx + my * my + mz * mz);
    if (!s->receives[i] || !(squared <= reach * reach)) return 0.0f;
    float d = sqrtf(squared) * (1.0f / k->radius) + *turn * 0.70710678f;
    float s2 = x * (s->nx[i] + k->normal.x) + y * (s->ny[i] + k->normal.y) + z * (s->nz[i] + k->normal.z);
    if (!(d <= a) || !(s2 >= -2.0f * (0.01f * reach + tolerance)) || !(s2 <= reach + 2.0f * tolerance))
        return 0.0f;
    float w = 1.0f / fmaxf(d, 1e-3f) - s->pass.weights.offset;
    return w > 0.0f ? w : 0.0f;
}

static float twin_irradiance(const screen *s, const sl_record *k, int c, float e, size_t i, float turn) {
    sl_vec3 delta = sl_sub(sl_v3(s->px[i], s->py[i], s->pz[i]), k->position);
    sl_vec3 bend = sl_sub(sl_v3(s->nx[i], s->ny[i], s->nz[i]), k->normal);
    float value =
        e + sl_dot(bend, sl_cross(k->rotational[c], k->normal)) + sl_dot(delta, k->translational[c]);
    float most = e * (1.0f + s->pass.weights.accuracy) + k->rotational_length[c] * turn;
    return fmaxf(fminf(value, most), 0.0f);
}

static uint64_t scene_copy(const screen *s, float *planes) {
    uint64_t blended = 0;
    for (size_t k = 0; k < RECORDS; k++) {
        const sl_record *record = &s->records[k];
        const float e[3] = {record->irradiance.r, record->irradiance.g, record->irradiance.b};
        for (size_t i = 0; i < (size_t)(s->width * s->height); i++) {
            float turn, w = twin_weight(s, record, i, &turn);
            if (!(w > 0.0f)) continue;
            planes[i] += w;
            for (int c = 0; c < 3; c++)
                planes[(size_t)(c + 1) * MOST_PIXELS + i] += w * twin_irradiance(s, record, c, e[c], i, turn);
            planes[4 * MOST_PIXELS + i] += 1.0f;
            planes[5 * MOST_PIXELS + i] += w;
            blended++;
        }
    }
    return blended;
}

static sl_counters draw(screen *s) {
    float *p = s->planes;
    sl_splat_buffer buffer = {.weight = p,
                              .r = p + MOST_PIXELS,
                              .g = p + 2 * MOST_PIXELS,
                              .b = p + 3 * MOST_PIXELS,
                              .count = p + 4 * MOST_PIXELS};
    sl_counters counters = {{0}};
    memset(p, 0, sizeof s->planes);
    /* In two goes, as new records come: sums go back to the screen and come again. */
    const sl_record_list some = {.records = s->records, .count = 60},
                         all = {.records = s->records, .count = RECORDS};
    assert_int_equal(sl_splat_records(&s->pass, &some, 0, &buffer, &counters, NULL), SL_OK);
    assert_int_equal(sl_splat_records(&s->pass, &all, 60, &buffer, &counters, NULL), SL_OK);
    assert_int_equal(sl_cover(&s->pass, s->records, 90, NULL), SL_OK);
    assert_int_equal(sl_cover(&s->pass, s->records + 90, RECORDS - 90, NULL), SL_OK);
    return counters;
}

static void the_tiles_have_the_bits_of_the_plain_twin(void **state) {
    (void)state;
    static screen s;
    static float expected[PLANES * MOST_PIXELS];
    const int sizes[][2] = {{200, 150}, {64, 64}, {65, 63}, {129, 17}, {16, 130}, {1, 1}, {7, 3}};
    const unsigned threads[] = {1, 2, 3, 7};
    for (size_t n = 0; n < sizeof sizes / sizeof sizes[0]; n++) {
        make_screen(&s, sizes[n][0], sizes[n][1]);
        make_records(&s);
        memset(expected, 0, sizeof expected);
        uint64_t blended = scene_copy(&s, expected);
        assert_true(blended > (n == 0 ? 50000u : 0u));
        for (int isa = 0; isa <= (int)sl_isa_best(); isa++) {
            for (int t = 0; t < 4; t++) {
                s.pass.kernels = sl_splat_kernels_for((sl_isa)isa);
                s.pass.threads = threads[t];
                sl_counters counters = draw(&s);
                assert_memory_equal(s.planes, expected, sizeof expected);
                assert_int_equal(counters.value[SL_COUNT_FRAGMENTS_BLENDED], blended);
                assert_int_equal(counters.value[SL_COUNT_SPLATS], RECORDS);
            }
        }
    }
}

static void what_does_not_receive_never_leaks(void **state) {
    (void)state;
    static screen s;
    make_screen(&s, 200, 150);
    make_records(&s);
    draw(&s);
    size_t holes = 0;
    for (size_t i = 0; i < 200 * 150; i++) {
        for (size_t c = 0; c < PLANES; c++) {
            float value = s.planes[c * MOST_PIXELS + i];
            assert_true(isfinite(value));
            if (!s.receives[i]) assert_true(value == 0.0f);
        }
        holes += !s.receives[i];
    }
    assert_true(holes > 1000);
}

static void the_weight_of_single_pixels_has_the_bits_of_the_twin(void **state) {
    (void)state;
    static screen s;
    make_screen(&s, 65, 63);
    make_records(&s);
    for (size_t k = 0; k < RECORDS; k++) {
        for (size_t i = 0; i < 65 * 63; i++) {
            float turn, expected = twin_weight(&s, &s.records[k], i, &turn),
                        got = sl_record_weight(&s.pass, &s.records[k], i);
            assert_true(got == expected);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_tiles_have_the_bits_of_the_plain_twin),
        cmocka_unit_test(what_does_not_receive_never_leaks),
        cmocka_unit_test(the_weight_of_single_pixels_has_the_bits_of_the_twin),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
