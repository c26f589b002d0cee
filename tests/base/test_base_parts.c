/* The small parts of src/base: random numbers, vectors, parallel loops, memory, errors, instruction sets,
 * counters. */
#include <float.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/isa.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/random.h"
#include "base/vec.h"

/* ---- random.h ---- */

/* Chi-square of `bins` equally likely bins has mean bins-1 and variance 2(bins-1); five deviations are a
 * fault. */
static void assert_uniform(const uint32_t *histogram, int bins, double draws) {
    double expected = draws / bins, chi_square = 0.0;
    for (int i = 0; i < bins; i++)
        chi_square += (histogram[i] - expected) * (histogram[i] - expected) / expected;
    double freedom = bins - 1.0;
    if (fabs(chi_square - freedom) > 5.0 * sqrt(2.0 * freedom))
        fail_msg("chi-square %g, expected %g", chi_square, freedom);
}

static void random_numbers_are_uniform_within_and_across_streams(void **state) {
    enum { BINS = 256, DRAWS = 1 << 17 };
    for (uint64_t seed = 0; seed < 4; seed++) {
        uint32_t within[BINS] = {0}, low_bits[BINS] = {0}, across[BINS] = {0};
        uint64_t key = sl_random_key(seed, 1);
        for (uint64_t i = 0; i < DRAWS; i++) {
            within[(int)(sl_random_unit(key, i) * BINS)]++;
            low_bits[sl_random_bits(key, i) & (BINS - 1)]++;
            /* the first number of many streams */
            across[(int)(sl_random_unit(sl_random_key(seed, i), 0) * BINS)]++;
        }
        assert_uniform(within, BINS, DRAWS);
        assert_uniform(low_bits, BINS, DRAWS);
        assert_uniform(across, BINS, DRAWS);
    }
}

/* The correlation of n independent pairs has deviation 1/sqrt(n). */
static double correlation(uint64_t key_a, uint64_t key_b, uint64_t offset, uint64_t n) {
    double sum = 0.0;
    for (uint64_t i = 0; i < n; i++) {
        sum += ((double)sl_random_unit(key_a, i) - 0.5) * ((double)sl_random_unit(key_b, i + offset) - 0.5);
    }
    return 12.0 * sum / (double)n;
}

static void streams_and_seeds_are_not_correlated(void **state) {
    enum { N = 20000 };
    double bound = 5.0 / sqrt(N);
    for (uint64_t k = 0; k < 16; k++) {
        uint64_t key = sl_random_key(1, k);
        assert_true(fabs(correlation(key, sl_random_key(1, k + 1), 0, N)) < bound);
        assert_true(fabs(correlation(key, sl_random_key(2, k), 0, N)) < bound);
        /* seed and stream exchanged */
        assert_true(fabs(correlation(key, sl_random_key(k + 2, 1), 0, N)) < bound);
        assert_true(fabs(correlation(key, key, k + 1, N)) < bound);
    }
    assert_true(correlation(3, 3, 0, N) > 0.9); /* the measure sees what it should */
}

/* ---- vec.h ---- */

static void normalizing_gives_a_unit_vector_or_the_fallback(void **state) {
    sl_vec3 fallback = sl_v3(0.0f, 0.0f, 1.0f);
    float sizes[] = {1.0f, 1e-45f, 1e-40f, FLT_MIN, 1e-20f, 1e20f, FLT_MAX};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        sl_vec3 x = sl_normalize_or(sl_v3(-sizes[i], 0.0f, 0.0f), fallback);
        assert_true(x.x == -1.0f && x.y == 0.0f && x.z == 0.0f);
        sl_vec3 d = sl_normalize_or(sl_v3(sizes[i], sizes[i], -sizes[i]), fallback);
        assert_true(fabsf(d.x - 0.57735027f) < 1e-7f && d.y == d.x && d.z == -d.x);
    }
    sl_vec3 bad[] = {sl_v3(0, 0, 0),        sl_v3(-0.0f, 0, -0.0f), sl_v3(NAN, 1, 0),
                     sl_v3(INFINITY, 0, 0), sl_v3(1, -INFINITY, 0), sl_v3(0, 0, NAN)};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        sl_vec3 v = sl_normalize_or(bad[i], fallback);
        assert_true(v.x == 0.0f && v.y == 0.0f && v.z == 1.0f);
    }
}

static void assert_orthonormal(sl_vec3 n) {
    sl_frame f = sl_frame_from_normal(n);
    float e = 1e-6f;
    assert_true(sl_is_finite(f.x) && sl_is_finite(f.y));
    assert_true(fabsf(sl_dot(f.x, f.x) - 1.0f) < e && fabsf(sl_dot(f.y, f.y) - 1.0f) < e);
    assert_true(fabsf(sl_dot(f.x, f.y)) < e && fabsf(sl_dot(f.x, n)) < e && fabsf(sl_dot(f.y, n)) < e);
    assert_true(fabsf(sl_dot(sl_cross(f.x, f.y), n) - 1.0f) < 2.0f * e); /* right-handed */
    assert_true(f.z.x == n.x && f.z.y == n.y && f.z.z == n.z);
}

static void frames_are_orthonormal_for_every_normal(void **state) {
    float v[] = {0.0f, -0.0f, 1.0f, -1.0f};
    for (int i = 0; i < 2; i++) {
        for (int j = 0; j < 2; j++) {
            for (int k = 2; k < 4; k++) { /* the axes, with zeros of either sign: (0,0,-1) is the hard one */
                assert_orthonormal(sl_v3(v[i], v[j], v[k]));
                assert_orthonormal(sl_v3(v[i], v[k], v[j]));
                assert_orthonormal(sl_v3(v[k], v[i], v[j]));
            }
        }
    }
    uint64_t key = sl_random_key(1, 2);
    for (uint64_t i = 0; i < 100000; i++) {
        /* also close to the poles */
        float small = i % 4 == 0 ? exp2f(-30.0f * sl_random_unit(key, 4 * i)) : 1.0f;
        sl_vec3 a = sl_v3((2.0f * sl_random_unit(key, 4 * i + 1) - 1.0f) * small,
                          (2.0f * sl_random_unit(key, 4 * i + 2) - 1.0f) * small,
                          2.0f * sl_random_unit(key, 4 * i + 3) - 1.0f);
        assert_orthonormal(sl_normalize_or(a, sl_v3(0.0f, 1.0f, 0.0f)));
    }
}

/* ---- parallel.h ---- */

/* Scratch memory is chosen by the worker: two tasks never hold the same one at once. */
typedef struct {
    atomic_flag busy[7];
    atomic_uint clashes;
} scratch_record;

static void hold_scratch(void *context, size_t index, unsigned worker) {
    scratch_record *r = context;
    if (atomic_flag_test_and_set(&r->busy[worker])) atomic_fetch_add(&r->clashes, 1);
    volatile double work = (double)index;
    for (int i = 0; i < 200; i++) work = work * 0.5 + 1.0;
    atomic_flag_clear(&r->busy[worker]);
}

static void a_worker_runs_one_task_at_a_time(void **state) {
    scratch_record r;
    for (int i = 0; i < 7; i++) atomic_flag_clear(&r.busy[i]);
    atomic_init(&r.clashes, 0);
    sl_parallel_for(7, 5000, hold_scratch, &r);
    assert_int_equal(atomic_load(&r.clashes), 0);
}

/* An inner loop of a running task: in order, on worker 0, one at a time. */
typedef struct {
    size_t next;
    unsigned faults;
} inner_record;

static void inner_task(void *context, size_t index, unsigned worker) {
    inner_record *r = context;
    if (index != r->next || worker != 0) r->faults++;
    r->next++;
}

static void outer_task(void *context, size_t index, unsigned worker) {
    inner_record *records = context;
    sl_parallel_for(4, 50, inner_task, &records[index]);
}

static void nested_loops_run_alone_and_in_order(void **state) {
    inner_record records[20];
    memset(records, 0, sizeof records);
    sl_parallel_for(3, 20, outer_task, records);
    for (int i = 0; i < 20; i++) assert_true(records[i].next == 50 && records[i].faults == 0);
    inner_record alone = {0, 0};
    sl_parallel_for(1, 50, inner_task, &alone);
    assert_true(alone.next == 50 && alone.faults == 0);
}

/* ---- memory.h ---- */

static void allocation_is_aligned_and_zeroed(void **state) {
    size_t counts[] = {0, 1, 63, 64, 65, 1000};
    for (int i = 0; i < 6; i++) {
        unsigned char *block = sl_allocate(counts[i], 3);
        assert_non_null(block);
        assert_int_equal((uintptr_t)block % 64, 0);
        for (size_t j = 0; j < counts[i] * 3; j++) assert_int_equal(block[j], 0);
        memset(block, 0xff, counts[i] * 3); /* the next block of this size must be zero all the same */
        sl_free(block);
    }
    sl_free(NULL);
}

/* ---- error.h, counters.h, isa.h ---- */

static void an_error_is_one_line_that_ends(void **state) {
    sl_error error;
    memset(&error, 'x', sizeof error);
    assert_int_equal(sl_fail(&error, SL_ERROR_INPUT, "%s:%d: expected\na number\r\n", "scene.json", 12),
                     SL_ERROR_INPUT);
    assert_int_equal(error.status, SL_ERROR_INPUT);
    assert_string_equal(error.message, "scene.json:12: expected a number  ");
    char *text = malloc(100000);
    assert_non_null(text);
    memset(text, 'a', 99999);
    text[99999] = 0;
    sl_fail(&error, SL_ERROR_INPUT, "%s", text);
    assert_int_equal(strlen(error.message), sizeof error.message - 1);
    free(text);
    assert_int_equal(sl_fail_memory(&error, "the image"), SL_ERROR_RESOURCES);
    assert_non_null(strstr(error.message, "the image"));
    assert_int_equal(sl_fail(NULL, SL_ERROR_INPUT, "nobody listens"), SL_ERROR_INPUT);
}

static void counters_add_up_and_have_distinct_names(void **state) {
    sl_counters a, b;
    for (int i = 0; i < SL_COUNTERS; i++) {
        a.value[i] = (uint64_t)i;
        b.value[i] = 100;
        sl_count(&b, (sl_counter)i, 7);
        const char *name = sl_counter_name((sl_counter)i);
        assert_true(name && *name && strcmp(name, "unknown") != 0);
        for (int j = 0; j < i; j++) assert_string_not_equal(name, sl_counter_name((sl_counter)j));
    }
    sl_counters_add(&a, &b);
    for (int i = 0; i < SL_COUNTERS; i++) assert_true(a.value[i] == (uint64_t)i + 107);
    assert_string_equal(sl_counter_name(SL_COUNTERS), "unknown");
}

static void the_environment_lowers_the_instruction_set_and_never_raises_it(void **state) {
    unsetenv("SOFTLUX_ISA");
    sl_isa best = sl_isa_best();
    for (int isa = 0; isa < SL_ISAS; isa++) {
        setenv("SOFTLUX_ISA", sl_isa_name((sl_isa)isa), 1);
        assert_int_equal(sl_isa_best(), isa < (int)best ? isa : (int)best);
    }
    setenv("SOFTLUX_ISA", "nonsense", 1);
    assert_int_equal(sl_isa_best(), best);
    unsetenv("SOFTLUX_ISA");
#ifdef SL_BASELINE_ONLY
    assert_int_equal(best, SL_ISA_BASELINE);
#endif
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_numbers_are_uniform_within_and_across_streams),
        cmocka_unit_test(streams_and_seeds_are_not_correlated),
        cmocka_unit_test(normalizing_gives_a_unit_vector_or_the_fallback),
        cmocka_unit_test(frames_are_orthonormal_for_every_normal),
        cmocka_unit_test(a_worker_runs_one_task_at_a_time),
        cmocka_unit_test(nested_loops_run_alone_and_in_order),
        cmocka_unit_test(allocation_is_aligned_and_zeroed),
        cmocka_unit_test(an_error_is_one_line_that_ends),
        cmocka_unit_test(counters_add_up_and_have_distinct_names),
        cmocka_unit_test(the_environment_lowers_the_instruction_set_and_never_raises_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
