/* Points that no second-level record covers get one, as pixels do in ../splatting/traversal.c. */
#include "cache/bounces/second_level.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/golden.h"
#include "base/grow.h"
#include "base/memory.h"

enum { CHUNK = 2048 };

void sl_second_list_free(sl_second_list *list) {
    SL_FREE_ALL(list->records, list->points, list->terms);
    *list = (sl_second_list){0};
}

static sl_status make_room(sl_second_list *list, sl_error *error) {
    const size_t capacity = 2 * list->capacity + 512;
    if (list->count < list->capacity) return SL_OK;
    if (!sl_regrow(&list->records, list->count, capacity, sizeof *list->records) ||
        !sl_regrow(&list->points, list->count, capacity, sizeof *list->points) ||
        !sl_regrow(&list->terms, list->count, capacity, sizeof *list->terms))
        return sl_fail_memory(error, "second-level records");
    list->capacity = capacity;
    return SL_OK;
}

/* A record that R_min makes reach further than what it sees would bear has no use for its gradient: it would
 * say more about the nearest surfaces than about the way to them, and the bounces between two such records in
 * a corner would not die away. */
void sl_second_tame(sl_record *record) {
    if (record->own_radius > record->minimum_radius) return;
    for (int c = 0; c < 3; c++) record->translational[c] = sl_v3(0.0f, 0.0f, 0.0f);
}

float sl_second_weight(const sl_second_cache *cache, const sl_gather_point *p) {
    const sl_second_points one = {1, &p->triangle, &p->position.x, &p->position.y, &p->position.z,
                                  &p->normal.x, &p->normal.y, &p->normal.z};
    float weight = 0.0f;
    (void)SL_KERNEL_OF(cache->isa, sl_look_up)(cache, &one, NULL, &weight, NULL);
    return weight;
}

static bool is_covered(const sl_second_cache *cache, const sl_gather_point *point) {
    return sl_second_weight(cache, point) >= sl_covered_weight(cache->rules.accuracy);
}

static sl_status commit(sl_record_batch *b, sl_second_cache *cache, sl_counters *counters, sl_error *error) {
    sl_second_list *list = &cache->list;
    sl_status status = SL_OK;
    for (size_t i = 0; status == SL_OK && i < b->count; i++) {
        if (is_covered(cache, &b->point[i])) continue;
        status = make_room(list, error);
        if (status != SL_OK) return status;
        const size_t k = list->count;
        sl_second_tame(&b->record[i]);
        list->records[k] = b->record[i];
        list->points[k] = b->point[i];
        list->terms[k] = sl_record_terms_of(&list->records[k], &cache->rules);
        status = sl_record_octree_insert(cache->scene, &list->terms[k], (uint32_t)k, &cache->octree, error);
        if (status != SL_OK) return status;
        list->count++;
        sl_count(counters, SL_COUNT_SECOND_LEVEL_RECORDS, 1);
    }
    return status;
}

/* The points come in an order that makes every chunk a fair sample of them all. */
sl_status sl_cover_points(sl_second_cache *cache, const sl_probed *points, double few_uncovered,
                          size_t most_records, sl_counters *counters, sl_error *error) {
    const size_t total = points->count, step = total ? (size_t)sl_golden_step(total) : 1;
    sl_record_batch *b = sl_allocate(1, sizeof *b);
    sl_status status = b ? SL_OK : sl_fail_memory(error, "places for second-level records");
    size_t next = 0, size = SL_BATCH_MIN;
    if (status == SL_OK)
        *b = (sl_record_batch){.scene = cache->scene, .tracer = cache->tracer, .gathers = &cache->gathers,
                               .radii = cache->radii};
    for (bool few = false; status == SL_OK && !few && next < total;) {
        size_t looked = 0, uncovered = 0;
        while (status == SL_OK && looked < CHUNK && next < total) {
            for (b->count = 0; looked < CHUNK && next < total && b->count < size; next++) {
                const sl_gather_point *p = &points->points[next * step % total];
                if (p->triangle == SL_NO_INDEX) continue;
                looked++;
                if (!is_covered(cache, p)) b->point[b->count++] = *p;
            }
            const size_t before = cache->list.count;
            sl_record_batch_gather(b, counters);
            status = commit(b, cache, counters, error);
            uncovered += b->count;
            size = sl_record_batch_size(size, b->count, cache->list.count - before);
        }
        few = (double)uncovered <= few_uncovered * (double)looked || cache->list.count >= most_records;
    }
    sl_free(b);
    return status;
}
