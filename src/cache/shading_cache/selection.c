/* Hit-and-test: pixels are drawn at random and accepted with their priority as chance, or, for a small share of draws, whatever it is: no
 * patch is ever left out for good, though nothing at its corners tells that it needs samples. */
#include "cache/shading_cache/selection.h"

#include "base/error.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/shading_cache/selection_parts.h"

static uint32_t most_of(const sl_selection *s, uint32_t leaf) {
    uint32_t most = s->settings->per_patch > 0 ? (uint32_t)s->settings->per_patch : 0;
    most = most < UINT16_MAX ? most : UINT16_MAX;
    return most < s->leaves[leaf].pixels ? most : s->leaves[leaf].pixels;
}

bool sl_selection_take(sl_selection *s, uint32_t pixel, sl_choice_kind kind) {
    uint32_t leaf = s->leaf[pixel], most = most_of(s, leaf);
    if (s->taken[leaf] >= most || sl_selection_visited(s, pixel)) return false;
    sl_selection_visit(s, pixel);
    s->choice[s->count++] = (sl_choice){pixel, leaf, kind};
    if (++s->taken[leaf] == most) s->open--;
    static const sl_counter counter[] = {
        [SL_CHOICE_HIT] = SL_COUNT_PIXELS_HIT, [SL_CHOICE_RANDOM] = SL_COUNT_PIXELS_RANDOM, [SL_CHOICE_FLOOD] = SL_COUNT_PIXELS_FLOODED};
    sl_count(s->counters, counter[kind], 1);
    return true;
}

/* One uniform number for both: below epsilon it is a random pixel, and what is left of it is the test. */
static void hit_and_test(sl_selection *s) {
    float e = s->settings->random_share;
    uint64_t key = sl_random_key(s->settings->seed, s->settings->update), test = 0;
    size_t points = (size_t)s->settings->points;
    double most = 8.0 * (double)points / (e > 0.0f ? (double)e : 0.03);
    for (; s->count < points && s->open > 0 && (double)test < most; test++) {
        uint32_t pixel = (uint32_t)((uint64_t)sl_random_bits(key, 2 * test) * s->pixel_count >> 32);
        float u = sl_random_unit(key, 2 * test + 1);
        if (s->leaf[pixel] == SL_NO_INDEX) continue;
        if (u < e) sl_selection_take(s, pixel, SL_CHOICE_RANDOM);
        else if (u - e < (1.0f - e) * s->leaves[s->leaf[pixel]].normal) sl_selection_take(s, pixel, SL_CHOICE_HIT);
    }
    sl_count(s->counters, SL_COUNT_PIXEL_TESTS, test);
}

static sl_status select_pixels(sl_selection *s, sl_error *error) {
    switch (s->settings->how) {
    case SL_PIXELS_SORTED: return sl_select_sorted(s, error);
    case SL_PIXELS_SYSTEMATIC: sl_select_systematically(s); break;
    default: hit_and_test(s);
    }
    return s->settings->flood_threshold > 1.0f ? SL_OK : sl_select_flood(s, error);
}

sl_status sl_select_pixels(const sl_selection_settings *settings, int width, int height, const uint32_t *leaf, size_t leaf_count,
                           const sl_leaf_priority *leaves, sl_choice *choice, size_t *choice_count, sl_counters *counters, sl_error *error) {
    *choice_count = 0;
    if (width <= 0 || height <= 0 || leaf_count == 0 || settings->points <= 0) return SL_OK;
    size_t pixels = (size_t)width * (size_t)height;
    sl_selection s = {.settings = settings, .width = width, .height = height, .pixel_count = pixels, .leaf_count = leaf_count, .leaf = leaf,
                      .leaves = leaves, .choice = choice, .counters = counters};
    s.visited = sl_allocate((pixels + 7) / 8, 1);
    s.taken = sl_allocate(leaf_count, sizeof *s.taken);
    for (uint32_t i = 0; i < leaf_count; i++) s.open += most_of(&s, i) > 0;
    sl_status status = s.visited && s.taken ? select_pixels(&s, error) : sl_fail_memory(error, "selection");
    sl_free(s.visited);
    sl_free(s.taken);
    *choice_count = status == SL_OK ? s.count : 0;
    return status;
}
