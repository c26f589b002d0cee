/* Points that no second-level record covers get one: traversal.c of the visible records once more, over
 * points instead of pixels. A record's place and reach do not depend on the other records and coverage only
 * grows; so candidates are gathered many at a time and committed in order, and the records are those of a
 * visit one by one. */
#include "cache/bounces/second_level.h"

#include <string.h>

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
    sl_free(list->walls);
    *list = (sl_second_list){0};
}

sl_status sl_second_list_reserve(sl_second_list *list, size_t capacity, sl_error *error) {
    if (capacity <= list->capacity) return SL_OK;
    if (!sl_regrow(&list->records, list->count, capacity, sizeof *list->records) ||
        !sl_regrow(&list->points, list->count, capacity, sizeof *list->points) ||
        !sl_regrow(&list->terms, list->count, capacity, sizeof *list->terms) ||
        !sl_regrow(&list->walls, list->count, capacity, sizeof *list->walls))
        return sl_fail_memory(error, "second-level records");
    list->capacity = capacity;
    return SL_OK;
}

/* ---- a chunk of points and what covers them ---- */

typedef struct {
    const sl_cover_pass *pass;
    const sl_second_list *list;
    const sl_record_tree *tree;
    size_t known;               /* records that weight[] knows of */
    size_t count;
    uint32_t triangle[CHUNK];
    float position_x[CHUNK], position_y[CHUNK], position_z[CHUNK], normal_x[CHUNK], normal_y[CHUNK],
        normal_z[CHUNK];
    float weight[CHUNK];
    const sl_gather_point *point[CHUNK];
} chunk;

static void weigh_piece(void *context, size_t index, unsigned worker) {
    (void)worker;
    chunk *c = context;
    size_t first = index * PIECE, count = c->count - first < PIECE ? c->count - first : (size_t)PIECE;
    const sl_second_points points = {c->count, c->triangle, c->position_x, c->position_y, c->position_z,
                                     c->normal_x, c->normal_y, c->normal_z};
    const sl_second_field field = {.list = c->list, .near = c->tree, .rules = c->pass->rules};
    sl_second_sums sums;
    c->pass->kernel(&field, &points, first, count, true, &sums);
    for (size_t i = 0; i < count; i++) {
        float weight = sums.weight[i];
        const sl_gather_point *p = c->point[first + i];
        for (size_t k = c->tree->records; k < c->known && weight < c->pass->covered_weight; k++)
            weight += sl_second_weight(c->list, k, p->position, p->normal);
        c->weight[first + i] = weight;
    }
}

/* Adds the weights of records since then. */
static bool is_covered(chunk *c, size_t i) {
    float weight = c->weight[i];
    for (size_t k = c->known; k < c->list->count && weight < c->pass->covered_weight; k++)
        weight += sl_second_weight(c->list, k, c->point[i]->position, c->point[i]->normal);
    return weight >= c->pass->covered_weight;
}

static size_t fill_chunk(chunk *c, const sl_probed *points, uint64_t *next, uint64_t *at, uint64_t step) {
    c->count = 0;
    while (c->count < CHUNK && *next < points->count) {
        const sl_gather_point *p = &points->points[*at];
        ++*next;
        *at = (*at + step) % points->count;
        if (p->triangle == SL_NO_INDEX) continue;
        size_t i = c->count++;
        c->triangle[i] = p->triangle;
        c->position_x[i] = p->position.x, c->position_y[i] = p->position.y, c->position_z[i] = p->position.z;
        c->normal_x[i] = p->normal.x, c->normal_y[i] = p->normal.y, c->normal_z[i] = p->normal.z;
        c->point[i] = p;
    }
    return c->count;
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
    const sl_gather_point *const *points;
} gather_batch;

typedef struct {
    sl_record record;
    sl_second_walls walls;
} candidate;

static void gather_one(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    const gather_batch *b = context;
    candidate *out = result;
    const sl_cover_pass *pass = b->pass;
    sl_irradiance irradiance;
    sl_gather_irradiance(pass->gather, b->points[index], pass->scratch[worker], &irradiance, counters);
    if (irradiance.back_share > 0.5f &&
        irradiance.harmonic_mean < 1e-3f * sl_scene_central_diagonal(pass->scene))
        irradiance.harmonic_mean = irradiance.nearest = 0.0f; /* within an intersection of surfaces */
    out->record = sl_record_make(b->points[index], &irradiance, &pass->radii, 0.0f);
    sl_second_tame(&out->record);
    sl_second_walls_find(pass->scene, pass->tracer, b->points[index], pass->rules.accuracy, &out->record,
                         &out->walls, counters);
}

static sl_status commit(chunk *c, const size_t *members, const candidate *candidates, size_t count,
                        sl_second_list *list, sl_counters *counters, size_t *committed, sl_error *error) {
    *committed = 0;
    for (size_t i = 0; i < count; i++) {
        if (is_covered(c, members[i])) continue;
        bool full = list->count == list->capacity;
        sl_status status = full ? sl_second_list_reserve(list, 2 * list->capacity + 512, error) : SL_OK;
        if (status != SL_OK) return status;
        size_t k = list->count++;
        list->records[k] = candidates[i].record;
        list->points[k] = *c->point[members[i]];
        list->terms[k] = sl_record_terms_of(&list->records[k], &c->pass->rules);
        list->walls[k] = candidates[i].walls;
        ++*committed;
        sl_count(counters, SL_COUNT_SECOND_LEVEL_RECORDS, 1);
    }
    return SL_OK;
}

/* Uncovered points of the chunk get records, in order. *batch_size follows the waste and changes nothing
 * else. */
static sl_status cover_chunk(chunk *c, sl_second_list *list, size_t *batch_size, size_t *uncovered,
                             sl_counters *counters, sl_error *error) {
    const sl_gather_point *points[LARGEST_BATCH];
    size_t members[LARGEST_BATCH];
    candidate *candidates = sl_allocate(LARGEST_BATCH, sizeof *candidates);
    sl_status status = candidates ? SL_OK : sl_fail_memory(error, "a batch of second-level records");
    *uncovered = 0;
    for (size_t i = 0; i < c->count; i++) *uncovered += c->weight[i] < c->pass->covered_weight;
    for (size_t next = 0; status == SL_OK && next < c->count;) {
        size_t count = 0, committed;
        for (; next < c->count && count < *batch_size; next++) {
            if (is_covered(c, next)) continue;
            members[count] = next;
            points[count++] = c->point[next];
        }
        gather_batch gathers = {c->pass, points};
        const sl_batch batch = {count, gather_one, &gathers, candidates, sizeof *candidates};
        sl_batch_run(&batch, c->pass->threads, counters);
        status = commit(c, members, candidates, count, list, counters, &committed, error);
        if (committed * 8 >= count * 7 && *batch_size < LARGEST_BATCH) *batch_size *= 2;
        else if (committed * 3 < count * 2 && *batch_size > SMALLEST_BATCH) *batch_size /= 2;
    }
    sl_free(candidates);
    return status;
}

/* The points come in an order that makes every chunk a fair sample of them all. */
sl_status sl_cover_points(const sl_cover_pass *pass, const sl_probed *points, double few_uncovered,
                          size_t most_records, sl_second_list *list, sl_counters *counters, sl_error *error) {
    sl_record_tree tree = {0};
    chunk *c = sl_allocate(1, sizeof *c);
    uint64_t next = 0, at = 0, step = points->count ? sl_golden_step(points->count) : 1;
    size_t batch_size = SMALLEST_BATCH;
    sl_status status = c ? SL_OK : sl_fail_memory(error, "places for second-level records");
    bool few = false;
    while (status == SL_OK && !few && next < points->count) {
        /* Later records are weighed one by one; when they have become many, the tree takes them in. */
        if (!tree.node_count || list->count > tree.records + tree.records / 4 + 64)
            status = sl_record_tree_build(pass->scene, list, 1.0f, SL_TREE_LANES, &tree, error);
        if (status != SL_OK) break;
        c->pass = pass;
        c->list = list;
        c->tree = &tree;
        c->known = list->count;
        fill_chunk(c, points, &next, &at, step);
        sl_parallel_for(pass->threads, (c->count + PIECE - 1) / PIECE, weigh_piece, c);
        size_t uncovered;
        status = cover_chunk(c, list, &batch_size, &uncovered, counters, error);
        few = (double)uncovered <= few_uncovered * (double)c->count || list->count >= most_records;
    }
    sl_record_tree_free(&tree);
    sl_free(c);
    return status;
}

float sl_share_out_of_reach(const sl_second_field *field, sl_look_up_kernel *kernel,
                            const sl_probed *points) {
    sl_second_sums sums;
    size_t asked = 0, missed = 0;
    for (size_t i = 0; i < points->count; i++) {
        const sl_gather_point *p = &points->points[i];
        if (p->triangle == SL_NO_INDEX) continue;
        const sl_second_points one = {1, &p->triangle, &p->position.x, &p->position.y, &p->position.z,
                                      &p->normal.x, &p->normal.y, &p->normal.z};
        kernel(field, &one, 0, 1, true, &sums);
        asked++;
        if (!(sums.weight[0] > 0.0f)) missed++;
    }
    return asked ? (float)missed / (float)asked : 0.0f;
}
