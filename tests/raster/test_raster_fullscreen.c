/* Full-screen passes. */
#include "raster_support.h"
#include "raster/fragments/fullscreen.h"
#include "raster/fragments/pbuffer.h"

enum { WIDTH = 1300, HEIGHT = 61, PIXELS = WIDTH * HEIGHT };

typedef struct planes {
    const sl_pbuffer *color, *ids;  /* read */
    sl_pbuffer *sum, *blurred;      /* written */
    int calls_outside;
} planes;

/* Reads two pbuffers, one of them at neighbouring pixels too, and writes two; discards pixels of odd id. */
static uint64_t shade(void *context, int x0, int x1, int y) {
    planes *p = context;
    uint64_t shaded = 0;
    if (x0 < 0 || x1 > WIDTH || x0 >= x1 || y < 0 || y >= HEIGHT) p->calls_outside++;
    float running = 0.0f; /* along the run: the same bits only if runs are cut at the same places */
    for (int x = x0; x < x1; x++) {
        int i = y * WIDTH + x, left = x > 0 ? i - 1 : i, above = y + 1 < HEIGHT ? i + WIDTH : i;
        running += p->color->channel[0][i];
        if (p->ids->word[i] % 2) continue;
        p->sum->channel[0][i] += p->color->channel[0][i] + p->color->channel[1][i] + p->color->channel[2][i];
        p->blurred->channel[0][i] = (p->color->channel[1][left] + p->color->channel[1][above]) * 0.5f;
        p->blurred->channel[1][i] = running;
        shaded++;
    }
    return shaded;
}

static sl_pbuffer *new_pbuffer(sl_pbuffer_format format) {
    sl_pbuffer *p = NULL;
    assert_int_equal(sl_pbuffer_create(WIDTH, HEIGHT, format, &p, NULL), SL_OK);
    assert_true(p->width == WIDTH && p->height == HEIGHT);
    for (int c = 0; c < 4; c++) assert_true((p->channel[c] != NULL) == (c < sl_pbuffer_channels(format)));
    assert_true((p->word != NULL) == (format == SL_PBUFFER_R32UI));
    return p;
}

static planes run(const sl_pbuffer *color, const sl_pbuffer *ids, unsigned threads, sl_counters *counters) {
    planes p = {color, ids, new_pbuffer(SL_PBUFFER_R32F), new_pbuffer(SL_PBUFFER_RGBA32F), 0};
    sl_raster_fullscreen(WIDTH, HEIGHT, threads, shade, &p, counters);
    assert_int_equal(p.calls_outside, 0);
    return p;
}

static void release(planes *p) {
    sl_pbuffer_destroy(p->sum);
    sl_pbuffer_destroy(p->blurred);
}

typedef struct inputs {
    sl_pbuffer *color, *ids;
    uint64_t even;
} inputs;

static inputs random_inputs(void) {
    inputs in = {new_pbuffer(SL_PBUFFER_RGB32F), new_pbuffer(SL_PBUFFER_R32UI), 0};
    uint64_t key = sl_random_key(6, 0);
    for (uint64_t i = 0; i < PIXELS; i++) {
        for (uint64_t c = 0; c < 3; c++) in.color->channel[c][i] = sl_random_unit(key, 4 * i + c);
        in.ids->word[i] = (uint32_t)(sl_random_unit(key, 4 * i + 3) * 100.0f);
        in.even += in.ids->word[i] % 2 == 0;
    }
    return in;
}

static void every_pixel_is_shaded_once_and_counted(void **state) {
    (void)state;
    inputs in = random_inputs();
    sl_counters counters = {{0}};
    planes p = run(in.color, in.ids, 2, &counters);
    assert_true(counters.value[SL_COUNT_FRAGMENTS_SHADED] == in.even);
    for (int i = 0; i < PIXELS; i++) {
        float sum = 0.0f + (in.color->channel[0][i] + in.color->channel[1][i] + in.color->channel[2][i]);
        assert_true(p.sum->channel[0][i] == (in.ids->word[i] % 2 ? 0.0f : sum));
        int left = i % WIDTH > 0 ? i - 1 : i, above = i / WIDTH + 1 < HEIGHT ? i + WIDTH : i;
        float blurred = (in.color->channel[1][left] + in.color->channel[1][above]) * 0.5f;
        assert_true(p.blurred->channel[0][i] == (in.ids->word[i] % 2 ? 0.0f : blurred));
    }
    release(&p);
    sl_pbuffer_destroy(in.color);
    sl_pbuffer_destroy(in.ids);
}

static void the_bits_do_not_depend_on_the_number_of_threads(void **state) {
    (void)state;
    inputs in = random_inputs();
    sl_counters expected_counters = {{0}};
    planes expected = run(in.color, in.ids, 1, &expected_counters);
    for (unsigned threads = 2; threads < 300; threads += 1 + threads / 2) {
        sl_counters counters = {{0}};
        planes p = run(in.color, in.ids, threads, &counters);
        assert_memory_equal(p.sum->channel[0], expected.sum->channel[0], PIXELS * sizeof(float));
        for (int c = 0; c < 2; c++) assert_memory_equal(p.blurred->channel[c], expected.blurred->channel[c], PIXELS * sizeof(float));
        assert_memory_equal(&counters, &expected_counters, sizeof counters);
        release(&p);
    }
    release(&expected);
    sl_pbuffer_destroy(in.color);
    sl_pbuffer_destroy(in.ids);
}

static uint64_t count_call(void *context, int x0, int x1, int y) {
    (void)y;
    *(int *)context += x1 - x0;
    return (uint64_t)(x1 - x0);
}

static void targets_of_one_pixel_and_of_none_are_drawn(void **state) {
    (void)state;
    const int sizes[][3] = {{1, 1, 1}, {0, 5, 0}, {5, 0, 0}, {-3, -3, 0}, {513, 9, 4617}};
    for (int k = 0; k < 5; k++) {
        int pixels = 0;
        sl_counters counters = {{0}};
        sl_raster_fullscreen(sizes[k][0], sizes[k][1], 1, count_call, &pixels, &counters);
        assert_int_equal(pixels, sizes[k][2]);
        assert_true(counters.value[SL_COUNT_FRAGMENTS_SHADED] == (uint64_t)sizes[k][2]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_pixel_is_shaded_once_and_counted),
        cmocka_unit_test(the_bits_do_not_depend_on_the_number_of_threads),
        cmocka_unit_test(targets_of_one_pixel_and_of_none_are_drawn),
    };
    return cmocka_run_group_tests_name("full-screen passes", tests, NULL, NULL);
}
