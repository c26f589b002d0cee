/* Which faces go together (Sander et al. 2003): charts grow from seeds, new seeds are planted in the middle
 * of the charts, charts grow anew, until the seeds stay where they are. How many seeds: one a connected part
 * to begin with, one more in every place that no chart may reach without bending too far. Connected parts are
 * independent, so they are done in parallel. */
#include "cache/light_octree/atlas/parts.h"

#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/light_octree/atlas/refine.h"

enum { ROUNDS = 20 };

/* ---- connected parts ---- */

typedef struct part_list {
    size_t count;
    size_t *first;          /* count + 1 */
    uint32_t *face;         /* part by part, ascending */
    uint32_t *of_face;
} part_list;

static void release_parts(part_list *p) {
    sl_free(p->first);
    sl_free(p->face);
    sl_free(p->of_face);
}

static bool connected_parts(const sl_atlas_faces *f, part_list *p) {
    *p = (part_list){0};
    uint32_t *stack = sl_allocate(f->count, sizeof *stack);
    p->of_face = sl_allocate(f->count, sizeof *p->of_face);
    p->face = sl_allocate(f->count, sizeof *p->face);
    p->first = sl_allocate(f->count + 2, sizeof *p->first);
    bool good = stack && p->of_face && p->face && p->first;
    if (good) memset(p->of_face, 0xff, f->count * sizeof *p->of_face);
    for (uint32_t start = 0; good && start < f->count; start++) {
        if (p->of_face[start] != SL_NO_INDEX) continue;
        uint32_t id = (uint32_t)p->count++;
        size_t depth = 0;
        stack[depth++] = start;
        p->of_face[start] = id;
        while (depth) {
            uint32_t face = stack[--depth];
            for (size_t h = 3 * (size_t)face; h < 3 * (size_t)face + 3; h++) {
                if (f->opposite[h] == SL_NO_INDEX || p->of_face[f->opposite[h] / 3] != SL_NO_INDEX) continue;
                p->of_face[f->opposite[h] / 3] = id;
                stack[depth++] = f->opposite[h] / 3;
            }
        }
    }
    sl_free(stack);
    if (!good) return false;
    for (size_t i = 0; i < f->count; i++) p->first[p->of_face[i] + 2]++;
    for (size_t c = 2; c < p->count + 2; c++) p->first[c] += p->first[c - 1];
    for (uint32_t i = 0; i < f->count; i++) p->face[p->first[p->of_face[i] + 1]++] = i;
    return true;
}

/* ---- the charts of one part ---- */

typedef struct planting {
    const sl_atlas_faces *faces;
    const part_list *parts;
    double cos_bend;
    uint32_t *chart;        /* of each face, counted from 0 in each part */
    double *cost;
    size_t *chart_count;    /* of each part */
    bool *failed;           /* of each part */
} planting;

typedef struct seed_bed {
    sl_atlas_seed *seed;
    uint32_t *centre, *left, *stack; /* as many as there are faces */
    sl_vec3d *normal;
    size_t count;
} seed_bed;

/* Gives each connected region of the unclaimed faces a number from bed->count on; returns the number of
 * regions. */
static size_t number_unclaimed(const sl_atlas_region *r, const seed_bed *bed, size_t left_count) {
    size_t regions = 0;
    for (size_t i = 0; i < left_count; i++) {
        if (r->chart[bed->left[i]] != SL_NO_INDEX) continue;
        uint32_t id = (uint32_t)(bed->count + regions++);
        size_t depth = 0;
        bed->stack[depth++] = bed->left[i];
        r->chart[bed->left[i]] = id;
        while (depth) {
            uint32_t face = bed->stack[--depth];
            for (size_t h = 3 * (size_t)face; h < 3 * (size_t)face + 3; h++) {
                uint32_t opposite = r->faces->opposite[h];
                if (opposite == SL_NO_INDEX || r->member[opposite / 3] != r->id ||
                    r->chart[opposite / 3] != SL_NO_INDEX)
                    continue;
                r->chart[opposite / 3] = id;
                bed->stack[depth++] = opposite / 3;
            }
        }
    }
    return regions;
}

/* Plants a seed in the middle of every region that nothing claimed and lets it grow, until all is claimed. */
static bool claim_the_rest(sl_atlas_region *r, seed_bed *bed, double cos_bend) {
    for (;;) {
        size_t left_count = 0;
        for (size_t i = 0; i < r->count; i++)
            if (r->chart[r->face[i]] == SL_NO_INDEX) bed->left[left_count++] = r->face[i];
        if (!left_count) return true;
        size_t regions = number_unclaimed(r, bed, left_count);
        sl_atlas_region rest = *r;
        rest.face = bed->left;
        rest.count = left_count;
        bool good = sl_atlas_centres(&rest, bed->count + regions, bed->centre);
        for (size_t i = 0; i < left_count; i++) r->chart[bed->left[i]] = SL_NO_INDEX;
        for (size_t i = bed->count; i < bed->count + regions; i++)
            bed->seed[i] = (sl_atlas_seed){bed->centre[i], {0.0, 0.0, 0.0}};
        r->queue = rest.queue;
        if (!good || !sl_atlas_grow(r, bed->seed, bed->count, bed->count + regions, cos_bend)) return false;
        bed->count += regions;
    }
}

/* Seeds move to the middle of their charts and learn their charts' normals; returns whether any moved. */
static bool replant(const sl_atlas_region *r, seed_bed *bed) {
    bool moved = false;
    for (size_t c = 0; c < bed->count; c++) bed->normal[c] = sl_v3d(0.0, 0.0, 0.0);
    for (size_t i = 0; i < r->count; i++) {
        uint32_t face = r->face[i], c = r->chart[face];
        bed->normal[c] = sl_addd(bed->normal[c], sl_scaled(r->faces->normal[face], r->faces->area[face]));
    }
    for (size_t c = 0; c < bed->count; c++) {
        double length = sl_lengthd(bed->normal[c]);
        if (bed->seed[c].face != bed->centre[c]) moved = true;
        bed->seed[c].face = bed->centre[c];
        bed->seed[c].normal = length > 0.0 ? sl_scaled(bed->normal[c], 1.0 / length) : sl_v3d(0.0, 0.0, 0.0);
    }
    return moved;
}

static bool grow_part(const planting *p, sl_atlas_region *r, seed_bed *bed) {
    for (size_t i = 0; i < r->count; i++) r->chart[r->face[i]] = SL_NO_INDEX;
    for (int round = 0; round < ROUNDS; round++) {
        for (size_t i = 0; i < r->count; i++) r->chart[r->face[i]] = SL_NO_INDEX;
        if (bed->count && !sl_atlas_grow(r, bed->seed, 0, bed->count, p->cos_bend)) return false;
        if (!claim_the_rest(r, bed, p->cos_bend)) return false;
        if (bed->count == r->count) return true;
        if (!sl_atlas_centres(r, bed->count, bed->centre)) return false;
        if (!replant(r, bed)) return true;
    }
    return true;
}

static void plant_part(void *context, size_t part, unsigned worker) {
    const planting *p = context;
    (void)worker;
    size_t first = p->parts->first[part], count = p->parts->first[part + 1] - first;
    sl_atlas_region r = {.faces = p->faces,
                         .member = p->parts->of_face,
                         .id = (uint32_t)part,
                         .face = p->parts->face + first,
                         .count = count,
                         .chart = p->chart,
                         .cost = p->cost};
    seed_bed bed = {sl_allocate(count, sizeof *bed.seed),   sl_allocate(count, sizeof *bed.centre),
                    sl_allocate(count, sizeof *bed.left),   sl_allocate(count, sizeof *bed.stack),
                    sl_allocate(count, sizeof *bed.normal), 0};
    p->failed[part] =
        !bed.seed || !bed.centre || !bed.left || !bed.stack || !bed.normal || !grow_part(p, &r, &bed);
    p->chart_count[part] = bed.count;
    sl_free(bed.seed);
    sl_free(bed.centre);
    sl_free(bed.left);
    sl_free(bed.stack);
    sl_free(bed.normal);
    sl_free(r.queue.entry);
}

/* ---- all charts ---- */

static bool allocate_charts(sl_atlas_charts *c, size_t faces, size_t count) {
    c->count = count;
    c->capacity = faces;
    c->chart = sl_allocate(faces, sizeof *c->chart);
    c->face = sl_allocate(faces, sizeof *c->face);
    c->of_face = sl_allocate(faces, sizeof *c->of_face);
    c->corner = sl_allocate(faces, 6 * sizeof *c->corner);
    return c->chart && c->face && c->of_face && c->corner;
}

/* Numbers the charts through all parts and lists their faces. */
static bool collect(const planting *p, sl_atlas_charts *charts) {
    size_t count = 0, parts = p->parts->count;
    size_t *offset = sl_allocate(parts, sizeof *offset);
    if (!offset) return false;
    for (size_t i = 0; i < parts; i++) {
        offset[i] = count;
        count += p->chart_count[i];
    }
    bool good = allocate_charts(charts, p->faces->count, count);
    for (size_t f = 0; good && f < p->faces->count; f++)
        charts->of_face[f] = (uint32_t)offset[p->parts->of_face[f]] + p->chart[f];
    if (good) sl_atlas_charts_list(charts, p->faces);
    sl_free(offset);
    return good;
}

void sl_atlas_charts_list(sl_atlas_charts *charts, const sl_atlas_faces *faces) {
    size_t at = 0;
    for (size_t c = 0; c < charts->count; c++) charts->chart[c] = (sl_atlas_chart){0};
    for (size_t f = 0; f < faces->count; f++) charts->chart[charts->of_face[f]].count++;
    for (size_t c = 0; c < charts->count; c++) {
        charts->chart[c].first = at;
        at += charts->chart[c].count;
        charts->chart[c].count = 0;
    }
    for (uint32_t f = 0; f < faces->count; f++) {
        sl_atlas_chart *c = &charts->chart[charts->of_face[f]];
        charts->face[c->first + c->count++] = f;
        c->area += faces->area[f];
    }
}

sl_status sl_atlas_charts_create(const sl_atlas_faces *faces, double bend, unsigned threads,
                                 sl_atlas_charts *charts, sl_error *error) {
    part_list parts;
    *charts = (sl_atlas_charts){0};
    planting p = {.faces = faces, .parts = &parts, .cos_bend = sl_cos(bend)};
    bool good = connected_parts(faces, &parts);
    p.chart = sl_allocate(faces->count, sizeof *p.chart);
    p.cost = sl_allocate(faces->count, sizeof *p.cost);
    p.chart_count = sl_allocate(parts.count, sizeof *p.chart_count);
    p.failed = sl_allocate(parts.count, sizeof *p.failed);
    good = good && p.chart && p.cost && p.chart_count && p.failed;
    if (good) sl_parallel_for(threads, parts.count, plant_part, &p);
    for (size_t i = 0; good && i < parts.count; i++) good = !p.failed[i];
    good = good && collect(&p, charts);
    release_parts(&parts);
    sl_free(p.chart);
    sl_free(p.cost);
    sl_free(p.chart_count);
    sl_free(p.failed);
    sl_status status = good ? sl_atlas_charts_refine(charts, faces, p.cos_bend, threads, error)
                            : sl_fail_memory(error, "an atlas's charts");
    if (status != SL_OK) sl_atlas_charts_release(charts);
    return status;
}

void sl_atlas_charts_release(sl_atlas_charts *c) {
    sl_free(c->chart);
    sl_free(c->face);
    sl_free(c->of_face);
    sl_free(c->corner);
    *c = (sl_atlas_charts){0};
}
