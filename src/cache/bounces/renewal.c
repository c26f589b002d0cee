/* Second-level records while objects and lights move: they stay where they lie on what has moved, and gather
 * anew in turns. Each takes its bounces from the others as they are then, so that light catches up with what
 * moves over some turns of all. */
#include "cache/bounces/second_level.h"

#include "base/batch.h"
#include "base/error.h"
#include "base/memory.h"

sl_status sl_second_open_gathers(sl_second_cache *cache, const sl_raster *raster, sl_counters *counters,
                                 sl_error *error) {
    if (cache->gathers.gather) return SL_OK;
    return sl_record_gathers_create(cache->scene, raster, cache->tracer, &cache->settings.gather,
                                    cache->settings.threads, &cache->gathers, counters, error);
}

/* ---- along with what moves ---- */

sl_status sl_second_cache_move(sl_second_cache *cache, const sl_tracer *tracer, const sl_shadow_maps *maps,
                               const sl_object_motion *motion, sl_error *error) {
    sl_second_list *list = &cache->list;
    sl_status status = SL_OK;
    cache->tracer = tracer;
    cache->settings.gather.maps = maps;
    cache->moved = true;
    cache->renewed = 0;
    sl_record_gathers_destroy(&cache->gathers);
    sl_record_octree_free(&cache->octree);
    for (size_t i = 0; i < list->count && status == SL_OK; i++) {
        const sl_object_motion *m = &motion[cache->scene->object_index[list->points[i].triangle]];
        if (m->moves) {
            sl_gather_point_carry(&list->points[i], m);
            sl_record_carry(&list->records[i], m);
            list->terms[i] = sl_record_terms_of(&list->records[i], &cache->rules);
        }
        status = sl_record_octree_insert(cache->scene, &list->terms[i], (uint32_t)i, &cache->octree, error);
    }
    return status;
}

/* ---- in turns ---- */

static size_t in_turn(const sl_second_cache *cache, size_t index) {
    return (cache->next + index) % cache->list.count;
}

/* result: the record with the light that it receives now. */
static void gather_again(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    const sl_second_cache *cache = context;
    const sl_record_gathers *g = &cache->gathers;
    const size_t i = in_turn(cache, index);
    sl_irradiance e;
    sl_record *r = result;
    sl_gather_irradiance(g->gather, &cache->list.points[i], g->scratch[worker], &e, counters);
    *r = cache->list.records[i];
    sl_second_set_light(r, &e);
}

sl_status sl_second_cache_renew(sl_second_cache *cache, const sl_raster *raster, size_t count,
                                sl_counters *counters, sl_error *error) {
    sl_second_list *list = &cache->list;
    if (count > list->count) count = list->count;
    if (!count) return SL_OK;
    sl_record *again = sl_allocate(count, sizeof *again);
    sl_status status = again ? sl_second_open_gathers(cache, raster, counters, error)
                             : sl_fail_memory(error, "second-level records");
    if (status == SL_OK) {
        const sl_batch batch = {.count = count, .work = gather_again, .context = cache, .results = again,
                                .result_bytes = sizeof *again, .shared = true};
        sl_batch_run(&batch, cache->settings.threads, counters);
        for (size_t k = 0; k < count; k++) {
            const size_t i = in_turn(cache, k);
            list->records[i] = again[k];
            list->terms[i] = sl_record_terms_of(&again[k], &cache->rules);
        }
        cache->next = in_turn(cache, count);
        cache->renewed += count;
    }
    sl_free(again);
    return status;
}

bool sl_second_cache_is_renewed(const sl_second_cache *cache) {
    return !cache->moved || cache->renewed >= cache->list.count;
}
