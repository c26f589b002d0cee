/* Batches (base/batch.h): results and counters at any number of threads. */
#include "unit_test.h"
#include "base/batch.h"
#include "base/random.h"
#include "failing_memory.h"

enum { ITEMS = 1000, WORKERS = 7 };

typedef struct {
    uint64_t key;
    unsigned calls[WORKERS]; /* by worker */
} hashes;

static void hash_item(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    hashes *h = context;
    assert_true(worker < WORKERS);
    h->calls[worker]++;
    *(uint32_t *)result = sl_random_bits(h->key, index);
    sl_count(counters, SL_COUNT_RAYS, index);
}

static void run(unsigned threads, size_t count, uint32_t *results, sl_counters *counters) {
    hashes h = {.key = 5};
    const sl_batch batch = {.count = count, .work = hash_item, .context = &h, .results = results,
                            .result_bytes = sizeof *results};
    sl_batch_run(&batch, threads, counters);
    unsigned calls = 0;
    for (int w = 0; w < WORKERS; w++) calls += h.calls[w];
    assert_int_equal(calls, count);
}

static void every_item_is_computed_once_into_its_own_place_and_counted(void **state) {
    for (unsigned threads = 1; threads <= WORKERS; threads++) {
        uint32_t results[ITEMS + 1] = {[ITEMS] = 77};
        sl_counters counters = {{0}};
        counters.value[SL_COUNT_RAYS] = 3;
        run(threads, ITEMS, results, &counters);
        for (size_t i = 0; i < ITEMS; i++) assert_int_equal(results[i], sl_random_bits(5, i));
        assert_int_equal(results[ITEMS], 77);
        assert_int_equal(counters.value[SL_COUNT_RAYS], 3 + ITEMS * (ITEMS - 1) / 2);
    }
}

static void without_memory_for_counters_the_caller_computes_everything(void **state) {
    uint32_t results[ITEMS];
    sl_counters counters = {{0}};
    allocations_left = 0;
    run(4, ITEMS, results, &counters);
    allocations_left = -1;
    assert_int_equal(blocks_held, 0);
    assert_int_equal(results[ITEMS - 1], sl_random_bits(5, ITEMS - 1));
    assert_int_equal(counters.value[SL_COUNT_RAYS], ITEMS * (ITEMS - 1) / 2);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_item_is_computed_once_into_its_own_place_and_counted),
        cmocka_unit_test(without_memory_for_counters_the_caller_computes_everything),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
