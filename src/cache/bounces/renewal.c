/* Second-level records while objects and lights move: they stay where they lie on what has moved, and gather
 * anew in turns. Each takes its bounces from the others as they are then, so that light catches up with what
 * moves over some turns of all. */
#include "cache/bounces/second_level.h"

sl_status sl_second_open_gathers(sl_second_cache *cache, sl_error *error) {
    if (cache->gathers.gather) return SL_OK;
    return sl_gathers_create(cache->scene, NULL, cache->tracer, &cache->settings.gather,
                             cache->settings.threads, &cache->gathers, error);
}

/* ---- along with what moves ---- */

sl_status sl_second_cache_move(sl_second_cache *cache, const sl_tracer *tracer, const sl_shadow_maps *maps,
                               const sl_object_motion *motion, sl_error *error) {
    sl_second_list *list = &cache->list;
    sl_status status = SL_OK;
    cache->tracer = tracer;
    cache->settings.gather.maps = maps;
    cache->moved = true;
    cache->renewed = cache->waiting = 0;
    sl_gathers_destroy(&cache->gathers);
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

sl_status sl_second_cache_renew(sl_second_cache *cache, size_t count, sl_counters *counters,
                                sl_error *error) {
    if (count > cache->list.count) count = cache->list.count;
    if (!count) return SL_OK;
    sl_status status = sl_second_open_gathers(cache, error);
    if (status == SL_OK) status = sl_second_gather(cache, count, counters, error);
    if (status == SL_OK) cache->renewed += count;
    return status;
}

bool sl_second_cache_is_renewed(const sl_second_cache *cache) {
    return !cache->moved || cache->renewed >= cache->list.count;
}
