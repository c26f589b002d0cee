/* Charts that must be cut, and charts that may be joined. Growing decides each step by what a chart's normal
 * was; here the whole chart is looked at: one that bends too far is cut in two, two that share much of their
 * border and together bend no farther become one. */
#include "cache/light_octree/atlas/refine.h"

#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"

/* Charts are joined if what they share is at least this much of one's border. */
#define SHARED 0.25
enum { CUT_ROUNDS = 4, JOIN_PASSES = 16, AXIS_STEPS = 12 };

/* ---- cutting in two ---- */

typedef struct cutting {
    const sl_atlas_faces *faces;
    const sl_atlas_charts *charts;
    const uint32_t *split;
    uint32_t *part;         /* of each face */
    double *cost;
    size_t *parts;          /* of each chart to be split; 0: no memory */
} cutting;

static void unclaim(sl_atlas_region *r) {
    for (size_t i = 0; i < r->count; i++) r->chart[r->face[i]] = SL_NO_INDEX;
}

/* The face that is dearest to reach from `from`; one that cannot be reached where there is one. */
static uint32_t farthest(sl_atlas_region *r, uint32_t from, bool *good) {
    sl_atlas_seed seed = {from, {0.0, 0.0, 0.0}};
    unclaim(r);
    *good = *good && sl_atlas_grow(r, &seed, 0, 1, -2.0);
    uint32_t best = from;
    double cost = -1.0;
    for (size_t i = 0; *good && i < r->count; i++) {
        uint32_t f = r->face[i];
        if (r->chart[f] == SL_NO_INDEX) return f;
        if (r->cost[f] > cost) cost = r->cost[f], best = f;
    }
    return best;
}

/* Two seeds at the ends of the chart, moved to the middle of what they get a few times; what neither reaches
 * are further parts. */
static size_t cut_from(sl_atlas_region *r, sl_atlas_seed *seed) {
    bool good = true;
    uint32_t centre[2];
    seed[0].face = farthest(r, r->face[0], &good);
    seed[1].face = farthest(r, seed[0].face, &good);
    for (int round = 1; good; round++) {
        unclaim(r);
        good = sl_atlas_grow(r, seed, 0, 2, -2.0);
        if (!good || round == CUT_ROUNDS) break;
        good = sl_atlas_centres(r, 2, centre);
        if (!good || (centre[0] == seed[0].face && centre[1] == seed[1].face)) break;
        seed[0].face = centre[0];
        seed[1].face = centre[1];
    }
    size_t parts = 2;
    for (size_t i = 0; good && i < r->count; i++) {
        if (r->chart[r->face[i]] != SL_NO_INDEX) continue;
        seed[parts].face = r->face[i];
        good = sl_atlas_grow(r, seed, parts, parts + 1, -2.0);
        parts++;
    }
    return good ? parts : 0;
}

static void cut_task(void *context, size_t index, unsigned worker) {
    const cutting *c = context;
    (void)worker;
    const sl_atlas_chart *chart = &c->charts->chart[c->split[index]];
    sl_atlas_region r = {.faces = c->faces,
                         .member = c->charts->of_face,
                         .id = c->split[index],
                         .face = c->charts->face + chart->first,
                         .count = chart->count,
                         .chart = c->part,
                         .cost = c->cost};
    sl_atlas_seed *seed = sl_allocate(chart->count + 2, sizeof *seed);
    c->parts[index] = seed ? cut_from(&r, seed) : 0;
    sl_free(seed);
    sl_free(r.queue.entry);
}

/* Cuts the range of a chart into its parts; all but the first become new charts at the end. */
static bool commit_parts(sl_atlas_charts *charts, const sl_atlas_faces *faces, uint32_t id,
                         const uint32_t *part, size_t parts) {
    sl_atlas_chart whole = charts->chart[id];
    uint32_t *old = sl_allocate(whole.count, sizeof *old);
    size_t *first = sl_allocate(parts + 1, sizeof *first);
    if (old && first) {
        memcpy(old, charts->face + whole.first, whole.count * sizeof *old);
        for (size_t i = 0; i < whole.count; i++) first[part[old[i]] + 1]++;
        for (size_t p = 0; p < parts; p++) {
            uint32_t chart = p ? (uint32_t)charts->count++ : id;
            charts->chart[chart] = (sl_atlas_chart){.first = whole.first + first[p], .count = first[p + 1]};
            first[p + 1] += first[p];
        }
        for (size_t i = 0; i < whole.count; i++) {
            uint32_t face = old[i], p = part[face], chart = p ? (uint32_t)(charts->count - parts + p) : id;
            charts->face[whole.first + first[p]++] = face;
            charts->of_face[face] = chart;
            charts->chart[chart].area += faces->area[face];
        }
    }
    bool good = old && first;
    sl_free(old);
    sl_free(first);
    return good;
}

sl_status sl_atlas_charts_split(sl_atlas_charts *charts, const sl_atlas_faces *faces, const uint32_t *split,
                                size_t count, unsigned threads, sl_error *error) {
    cutting c = {faces,
                 charts,
                 split,
                 sl_allocate(faces->count, sizeof *c.part),
                 sl_allocate(faces->count, sizeof *c.cost),
                 sl_allocate(count, sizeof *c.parts)};
    bool good = c.part && c.cost && c.parts;
    if (good) sl_parallel_for(threads, count, cut_task, &c);
    for (size_t i = 0; good && i < count; i++)
        good = c.parts[i] && commit_parts(charts, faces, split[i], c.part, c.parts[i]);
    sl_free(c.part);
    sl_free(c.cost);
    sl_free(c.parts);
    return good ? SL_OK : sl_fail_memory(error, "cutting an atlas's charts");
}

sl_status sl_atlas_charts_set_apart(sl_atlas_charts *charts, const sl_atlas_faces *faces,
                                    const uint8_t *apart, sl_error *error) {
    uint32_t *part = sl_allocate(faces->count, sizeof *part);
    bool good = part != NULL;
    size_t count = charts->count;
    for (uint32_t id = 0; good && id < count; id++) {
        sl_atlas_chart c = charts->chart[id];
        uint32_t leaving = 0, next = 1;
        for (size_t i = c.first; i < c.first + c.count; i++) leaving += apart[charts->face[i]] != 0;
        if (!leaving || c.count == 1) continue;
        if (leaving == c.count) next = 0; /* nothing stays, so the first of them keeps the number */
        for (size_t i = c.first; i < c.first + c.count; i++)
            part[charts->face[i]] = apart[charts->face[i]] ? next++ : 0;
        good = commit_parts(charts, faces, id, part, next);
        if (leaving == c.count) continue;
        charts->chart[id].flat = c.flat && c.count - leaving > 1; /* one face alone is laid out as it is */
        sl_atlas_fit(charts, id);
    }
    sl_free(part);
    return good ? SL_OK : sl_fail_memory(error, "taking faces out of an atlas's charts");
}

/* ---- bending ---- */

static sl_vec3d add_normals(const sl_atlas_charts *charts, const sl_atlas_faces *faces,
                            const sl_atlas_chart *c, sl_vec3d sum) {
    for (size_t i = c->first; i < c->first + c->count; i++) {
        uint32_t f = charts->face[i];
        sum = sl_addd(sum, sl_scaled(faces->normal[f], faces->area[f]));
    }
    return sum;
}

/* The face of a chart that turns farthest from an axis, if it is farther than the one that `least` is of. */
static void farthest_turned(const sl_atlas_charts *charts, const sl_atlas_faces *faces,
                            const sl_atlas_chart *c, sl_vec3d axis, double *least, sl_vec3d *normal) {
    for (size_t i = c->first; i < c->first + c->count; i++) {
        sl_vec3d n = faces->normal[charts->face[i]];
        if (sl_dotd(n, n) == 0.0 || sl_dotd(n, axis) >= *least) continue;
        *least = sl_dotd(n, axis);
        *normal = n;
    }
}

/* Whether there is a cone about some axis that holds all normals of a chart (or of two). The axis is the mean
 * normal first, then it moves towards what is farthest from it, by less and less (Badoiu, Clarkson 2003). */
static bool bends_within(const sl_atlas_charts *charts, const sl_atlas_faces *faces, const sl_atlas_chart *a,
                         const sl_atlas_chart *b, double cos_bend) {
    sl_vec3d axis = add_normals(charts, faces, a, sl_v3d(0.0, 0.0, 0.0)), n = {0.0, 0.0, 0.0};
    if (b) axis = add_normals(charts, faces, b, axis);
    for (int step = 1; step <= AXIS_STEPS; step++) {
        double length = sl_lengthd(axis), least = 2.0;
        axis = length > 0.0 ? sl_scaled(axis, 1.0 / length) : sl_v3d(0.0, 0.0, 0.0);
        farthest_turned(charts, faces, a, axis, &least, &n);
        if (b) farthest_turned(charts, faces, b, axis, &least, &n);
        if (least > 1.5) return true; /* slivers alone, which have no normals */
        if (!(length > 0.0)) return false;
        if (least >= cos_bend) return true;
        axis = sl_addd(axis, sl_scaled(sl_subd(n, axis), 1.0 / (step + 1)));
    }
    return false;
}

sl_status sl_atlas_charts_unbend(sl_atlas_charts *charts, const sl_atlas_faces *faces, double cos_bend,
                                 unsigned threads, sl_error *error) {
    sl_status status = SL_OK;
    uint32_t *split = sl_allocate(faces->count, sizeof *split);
    if (!split) return sl_fail_memory(error, "an atlas's charts");
    while (status == SL_OK) {
        size_t count = 0;
        for (size_t c = 0; c < charts->count; c++) {
            const sl_atlas_chart *chart = &charts->chart[c];
            if (chart->count > 1 && !bends_within(charts, faces, chart, NULL, cos_bend))
                split[count++] = (uint32_t)c;
        }
        if (!count) break;
        status = sl_atlas_charts_split(charts, faces, split, count, threads, error);
    }
    sl_free(split);
    return status;
}

/* ---- joining ---- */

typedef struct shared_border {
    uint32_t a, b;          /* charts, a < b */
    double length;          /* of what they share; then, over the shorter border of the two */
} shared_border;

static int by_charts(const void *x, const void *y) {
    const shared_border *p = x, *q = y;
    if (p->a != q->a) return p->a < q->a ? -1 : 1;
    if (p->b != q->b) return p->b < q->b ? -1 : 1;
    return (p->length > q->length) - (p->length < q->length);
}

static int by_share(const void *x, const void *y) {
    const shared_border *p = x, *q = y;
    if (p->length != q->length) return p->length > q->length ? -1 : 1;
    return by_charts(x, y);
}

/* All pairs of charts that share some border, with the share; returns how many. */
static size_t shared_borders(const sl_atlas_charts *charts, const sl_atlas_faces *faces, shared_border *pair,
                             double *border) {
    size_t count = 0, pairs = 0;
    for (size_t c = 0; c < charts->count; c++) border[c] = 0.0;
    for (uint32_t h = 0; h < 3 * faces->count; h++) {
        uint32_t opposite = faces->opposite[h], a = charts->of_face[h / 3],
                 b = opposite == SL_NO_INDEX ? SL_NO_INDEX : charts->of_face[opposite / 3];
        if (a == b) continue;
        double length =
            sl_lengthd(sl_subd(sl_atlas_corner(faces, sl_atlas_next(h)), sl_atlas_corner(faces, h)));
        border[a] += length;
        if (b != SL_NO_INDEX && a < b) pair[count++] = (shared_border){a, b, length};
    }
    qsort(pair, count, sizeof *pair, by_charts);
    for (size_t i = 0; i < count; i++) {
        if (pairs && pair[pairs - 1].a == pair[i].a && pair[pairs - 1].b == pair[i].b)
            pair[pairs - 1].length += pair[i].length;
        else pair[pairs++] = pair[i];
    }
    for (size_t i = 0; i < pairs; i++) {
        double a = border[pair[i].a], b = border[pair[i].b], least = a < b ? a : b;
        pair[i].length = least > 0.0 ? pair[i].length / least : 1.0;
    }
    qsort(pair, pairs, sizeof *pair, by_share);
    return pairs;
}

/* One pass: each chart is joined at most once, to the one it shares the most with. Returns how many joined.
 */
static size_t join_pass(sl_atlas_charts *charts, const sl_atlas_faces *faces, double cos_bend,
                        shared_border *pair, double *border, uint32_t *into) {
    size_t joined = 0, pairs = shared_borders(charts, faces, pair, border), kept = 0;
    for (size_t c = 0; c < charts->count; c++) into[c] = SL_NO_INDEX;
    for (size_t i = 0; i < pairs && pair[i].length >= SHARED; i++) {
        uint32_t a = pair[i].a, b = pair[i].b;
        const sl_atlas_chart *p = &charts->chart[a], *q = &charts->chart[b];
        if (into[a] != SL_NO_INDEX || into[b] != SL_NO_INDEX) continue;
        if (!bends_within(charts, faces, p, q, cos_bend)) continue;
        into[a] = into[b] = a;
        joined++;
    }
    for (uint32_t c = 0; c < charts->count; c++)
        into[c] = into[c] == SL_NO_INDEX || into[c] == c ? (uint32_t)kept++ : into[into[c]];
    for (size_t f = 0; f < faces->count; f++) charts->of_face[f] = into[charts->of_face[f]];
    charts->count = kept;
    sl_atlas_charts_list(charts, faces);
    return joined;
}

static sl_status join(sl_atlas_charts *charts, const sl_atlas_faces *faces, double cos_bend,
                      sl_error *error) {
    shared_border *pair = sl_allocate(3 * faces->count, sizeof *pair);
    double *border = sl_allocate(charts->count, sizeof *border);
    uint32_t *into = sl_allocate(charts->count, sizeof *into);
    bool good = pair && border && into;
    for (int pass = 0; good && pass < JOIN_PASSES && join_pass(charts, faces, cos_bend, pair, border, into);
         pass++)
        continue;
    sl_free(pair);
    sl_free(border);
    sl_free(into);
    return good ? SL_OK : sl_fail_memory(error, "joining an atlas's charts");
}

sl_status sl_atlas_charts_refine(sl_atlas_charts *charts, const sl_atlas_faces *faces, double cos_bend,
                                 unsigned threads, sl_error *error) {
    sl_status status = sl_atlas_charts_unbend(charts, faces, cos_bend, threads, error);
    return status == SL_OK ? join(charts, faces, cos_bend, error) : status;
}
