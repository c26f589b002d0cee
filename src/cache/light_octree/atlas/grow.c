/* Charts grow over faces as in Sander et al. 2003: Dijkstra from all seeds at once, a step from face F to F'
 * costing (1 - n_C . n_F') |x_F - x_F'|, so that a chart runs freely over what is flat and stops where the
 * surface turns. */
#include "cache/light_octree/atlas/parts.h"

#include <string.h>

#include "base/memory.h"

/* Added to 1 - n.n: where all is flat the nearest seed gets the face. */
#define COMPACT 0x1p-7

/* ---- the queue ---- */

static bool before(const sl_atlas_queue_entry *a, const sl_atlas_queue_entry *b) {
    if (a->cost != b->cost) return a->cost < b->cost;
    if (a->face != b->face) return a->face < b->face;
    return a->chart < b->chart;
}

static bool push(sl_atlas_queue *q, sl_atlas_queue_entry e) {
    if (q->count == q->capacity) {
        size_t capacity = q->capacity ? 2 * q->capacity : 256;
        sl_atlas_queue_entry *entry = sl_allocate(capacity, sizeof *entry);
        if (!entry) return false;
        if (q->count) memcpy(entry, q->entry, q->count * sizeof *entry);
        sl_free(q->entry);
        q->entry = entry;
        q->capacity = capacity;
    }
    size_t i = q->count++;
    for (; i && before(&e, &q->entry[(i - 1) / 2]); i = (i - 1) / 2) q->entry[i] = q->entry[(i - 1) / 2];
    q->entry[i] = e;
    return true;
}

static sl_atlas_queue_entry pop(sl_atlas_queue *q) {
    sl_atlas_queue_entry top = q->entry[0], last = q->entry[--q->count];
    size_t i = 0;
    for (size_t child; (child = 2 * i + 1) < q->count; i = child) {
        if (child + 1 < q->count && before(&q->entry[child + 1], &q->entry[child])) child++;
        if (!before(&q->entry[child], &last)) break;
        q->entry[i] = q->entry[child];
    }
    q->entry[i] = last;
    return top;
}

/* ---- growing ---- */

/* The face beyond a half-edge, if it is in the region. */
static uint32_t neighbour(const sl_atlas_region *r, uint32_t half_edge) {
    uint32_t opposite = r->faces->opposite[half_edge];
    if (opposite == SL_NO_INDEX || r->member[opposite / 3] != r->id) return SL_NO_INDEX;
    return opposite / 3;
}

static sl_vec3d unit_or_zero(sl_vec3d a) {
    double length = sl_lengthd(a);
    return length > 0.0 ? sl_scaled(a, 1.0 / length) : sl_v3d(0.0, 0.0, 0.0);
}

/* The cosine of chart and face; slivers and charts without a normal agree with everything. */
static double agreement(sl_vec3d chart_normal, sl_vec3d face_normal) {
    if (sl_dotd(chart_normal, chart_normal) == 0.0 || sl_dotd(face_normal, face_normal) == 0.0) return 1.0;
    return sl_dotd(chart_normal, face_normal);
}

bool sl_atlas_grow(sl_atlas_region *r, const sl_atlas_seed *seed, size_t first, size_t count,
                   double cos_bend) {
    const sl_atlas_faces *f = r->faces;
    sl_vec3d *sum = sl_allocate(count, sizeof *sum); /* area-weighted normals of what each chart has so far */
    bool good = sum != NULL;
    r->queue.count = 0;
    for (size_t i = first; good && i < count; i++)
        good = push(&r->queue, (sl_atlas_queue_entry){0.0, seed[i].face, (uint32_t)i});
    while (good && r->queue.count) {
        sl_atlas_queue_entry e = pop(&r->queue);
        sl_vec3d own = seed[e.chart].normal;
        bool running = sl_dotd(own, own) == 0.0;
        if (r->chart[e.face] != SL_NO_INDEX) continue;
        if (running) own = unit_or_zero(sum[e.chart]);
        if (e.face != seed[e.chart].face && agreement(own, f->normal[e.face]) < cos_bend) continue;
        r->chart[e.face] = e.chart;
        r->cost[e.face] = e.cost;
        sum[e.chart] = sl_addd(sum[e.chart], sl_scaled(f->normal[e.face], f->area[e.face]));
        if (running) own = unit_or_zero(sum[e.chart]);
        for (uint32_t k = 0; good && k < 3; k++) {
            uint32_t to = neighbour(r, 3 * e.face + k);
            if (to == SL_NO_INDEX || r->chart[to] != SL_NO_INDEX) continue;
            double turn = agreement(own, f->normal[to]);
            if (turn < cos_bend && !running) continue;
            double step = sl_lengthd(sl_subd(f->centre[to], f->centre[e.face]));
            good =
                push(&r->queue, (sl_atlas_queue_entry){e.cost + (1.0 + COMPACT - turn) * step, to, e.chart});
        }
    }
    sl_free(sum);
    return good;
}

/* ---- centres ---- */

static bool at_border(const sl_atlas_region *r, uint32_t face) {
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t to = neighbour(r, 3 * face + k);
        if (to == SL_NO_INDEX || r->chart[to] != r->chart[face]) return true;
    }
    return false;
}

bool sl_atlas_centres(sl_atlas_region *r, size_t chart_count, uint32_t *centre) {
    const sl_atlas_faces *f = r->faces;
    bool good = true;
    r->queue.count = 0;
    for (size_t c = 0; c < chart_count; c++) centre[c] = SL_NO_INDEX;
    for (size_t i = 0; good && i < r->count; i++) {
        uint32_t face = r->face[i], c = r->chart[face];
        r->cost[face] = -1.0;
        if (c == SL_NO_INDEX) continue;
        if (centre[c] == SL_NO_INDEX) centre[c] = face;
        if (at_border(r, face)) good = push(&r->queue, (sl_atlas_queue_entry){0.0, face, c});
    }
    while (good && r->queue.count) { /* the last of a chart to be reached is the farthest */
        sl_atlas_queue_entry e = pop(&r->queue);
        if (r->cost[e.face] >= 0.0) continue;
        r->cost[e.face] = e.cost;
        uint32_t best = centre[e.chart];
        if (r->cost[best] < 0.0 || e.cost > r->cost[best]) centre[e.chart] = e.face;
        for (uint32_t k = 0; good && k < 3; k++) {
            uint32_t to = neighbour(r, 3 * e.face + k);
            if (to == SL_NO_INDEX || r->chart[to] != e.chart || r->cost[to] >= 0.0) continue;
            good = push(&r->queue,
                        (sl_atlas_queue_entry){e.cost + sl_lengthd(sl_subd(f->centre[to], f->centre[e.face])),
                                               to, e.chart});
        }
    }
    return good;
}
