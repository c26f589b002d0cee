/* Points that no second-level record covers get one: traversal.c of the visible records once more, over
 * points instead of pixels. A record's place and reach do not depend on the other records and coverage only
 * grows; so candidates are gathered many at a time and committed in order, and the records are those of a
 * visit one by one. */
#include "cache/bounces/second_level.h"

#include "base/batch.h"
#include "base/error.h"
#include "base/golden.h"
#include "base/grow.h"
#include "base/memory.h"
#include "base/parallel.h"

enum { CHUNK = 2048, SMALLEST_BATCH = 8, LARGEST_BATCH = 128, PIECE = 64 };

void sl_second_list_free(sl_second_list *list) {
    sl_free(list->records);
    sl_free(list->points);
    sl_free(list->terms);
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

/* ---- a chunk of points and which of them are covered ---- */

typedef struct {
    const sl_cover_pass *pass;
    size_t count;
    const sl_gather_point *point[CHUNK];
    bool covered[CHUNK]; /* by the records that were there when the chunk was begun */
} chunk;

static bool is_covered(const sl_cover_pass *pass, const sl_gather_point *point) {
    return sl_second_weight(pass->field, pass->kernel, point) >= pass->covered_weight;
}

static void look_at_piece(void *context, size_t index, unsigned worker) {
    (void)worker;
    chunk *c = context;
    for (size_t i = index * PIECE; i < (index + 1) * PIECE && i < c->count; i++)
        c->covered[i] = is_covered(c->pass, c->point[i]);
}

/* The points come in an order that makes every chunk a fair sample of them all. */
static void fill_chunk(chunk *c, const sl_probed *points, uint64_t *next, uint64_t *at, uint64_t step) {
    c->count = 0;
    while (c->count < CHUNK && *next < points->count) {
        const sl_gather_point *p = &points->points[*at];
        ++*next;
        *at = (*at + step) % points->count;
        if (p->triangle != SL_NO_INDEX) c->point[c->count++] = p;
    }
}

/* ---- gathering ---- */

/* A record that R_min makes reach further than what it sees would bear has no use for its gradient: it would
 * say more about the nearest surfaces than about the way to them, and the bounces between two such records in
 * a corner would not die away. */
void sl_second_tame(sl_record *record) {
    if (record->own_radius > record->minimum_radius) return;
    for (int c = 0; c < 3; c++) record->translational[c] = sl_v3(0.0f, 0.0f, 0.0f);
}

typedef struct {
    const sl_cover_pass *pass;
    const sl_gather_point *point[LARGEST_BATCH];
    sl_record record[LARGEST_BATCH];
    size_t count;
} gather_batch;

static void gather_one(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    const gather_batch *b = context;
    sl_record *record = result;
    const sl_cover_pass *pass = b->pass;
    const sl_gather_point *point = b->point[index];
    sl_irradiance irradiance;
    sl_gather_irradiance(pass->gather, point, pass->scratch[worker], &irradiance, counters);
    if (irradiance.back_share > 0.5f &&
        irradiance.harmonic_mean < 1e-3f * sl_scene_central_diagonal(pass->scene))
        irradiance.harmonic_mean = irradiance.nearest = 0.0f; /* within an intersection of surfaces */
    *record = sl_record_make(point, &irradiance, &pass->radii, 0.0f);
    sl_second_tame(record);
    sl_record_find_walls(pass->scene, pass->tracer, point, pass->radii.accuracy,
                         sl_record_guard(&irradiance, &pass->radii), true, record, counters);
}

static sl_status commit(const gather_batch *b, sl_second_list *list, sl_record_octree *octree,
                        sl_counters *counters, sl_error *error) {
    for (size_t i = 0; i < b->count; i++) {
        if (is_covered(b->pass, b->point[i])) continue;
        sl_status status = make_room(list, error);
        if (status != SL_OK) return status;
        const size_t k = list->count;
        list->records[k] = b->record[i];
        list->points[k] = *b->point[i];
        list->terms[k] = sl_record_terms_of(&list->records[k], &b->pass->field->rules);
        status = sl_record_octree_insert(b->pass->scene, &list->terms[k], (uint32_t)k, octree, error);
        if (status != SL_OK) return status;
        list->count++;
        sl_count(counters, SL_COUNT_SECOND_LEVEL_RECORDS, 1);
    }
    return SL_OK;
}

/* Uncovered points of the chunk get records, in order. *batch_size follows the waste and changes nothing
 * else. */
static sl_status cover_chunk(const chunk *c, gather_batch *b, sl_second_list *list, sl_record_octree *octree,
                             size_t *batch_size, sl_counters *counters, sl_error *error) {
    sl_status status = SL_OK;
    for (size_t next = 0; status == SL_OK && next < c->count;) {
        const size_t before = list->count;
        for (b->count = 0; next < c->count && b->count < *batch_size; next++) {
            if (!c->covered[next] && !is_covered(c->pass, c->point[next]))
                b->point[b->count++] = c->point[next];
        }
        const sl_batch batch = {b->count, gather_one, b, b->record, sizeof *b->record};
        sl_batch_run(&batch, c->pass->threads, counters);
        status = commit(b, list, octree, counters, error);
        const size_t committed = list->count - before;
        if (committed * 8 >= b->count * 7 && *batch_size < LARGEST_BATCH) *batch_size *= 2;
        else if (committed * 3 < b->count * 2 && *batch_size > SMALLEST_BATCH) *batch_size /= 2;
    }
    return status;
}

sl_status sl_cover_points(const sl_cover_pass *pass, const sl_probed *points, double few_uncovered,
                          size_t most_records, sl_second_list *list, sl_record_octree *octree,
                          sl_counters *counters, sl_error *error) {
    chunk *c = sl_allocate(1, sizeof *c);
    gather_batch *b = sl_allocate(1, sizeof *b);
    uint64_t next = 0, at = 0, step = points->count ? sl_golden_step(points->count) : 1;
    size_t batch_size = SMALLEST_BATCH;
    sl_status status = c && b ? SL_OK : sl_fail_memory(error, "places for second-level records");
    for (bool few = false; status == SL_OK && !few && next < points->count;) {
        size_t uncovered = 0;
        c->pass = b->pass = pass;
        fill_chunk(c, points, &next, &at, step);
        sl_parallel_for(pass->threads, (c->count + PIECE - 1) / PIECE, look_at_piece, c);
        for (size_t i = 0; i < c->count; i++) uncovered += !c->covered[i];
        status = cover_chunk(c, b, list, octree, &batch_size, counters, error);
        few = (double)uncovered <= few_uncovered * (double)c->count || list->count >= most_records;
    }
    sl_free(b);
    sl_free(c);
    return status;
}
