#include "base/counters.h"
#include "base/math.h"
#include "cache/light/shadow_maps_internal.h"

#include <math.h>
#include <string.h>

/* ---- lighting points, a block at a time ---- */

static bool any(const float *values, size_t count) {
    uint32_t found = 0;
#pragma omp simd reduction(| : found)
    for (size_t i = 0; i < count; i++) found |= values[i] > 0.0f ? 1u : 0u;
    return found;
}

/* False: nothing arrives anywhere in the block, shadows aside. */
static bool look_up(const sl_shadow_maps *maps, const sl_mapped_source *s, const sl_light_points *points,
                    sl_arrivals *arrivals, float *lit, sl_counters *counters) {
    const sl_depth_cube *cube = &s->cube;
    const sl_cube_looks looks = {1, points->count, &cube};
    SL_KERNEL_OF(maps->isa, sl_light_arrive)(points, &s->source, arrivals);
    if (!any(arrivals->weight, points->count)) return false;
    for (size_t i = 0; i < points->count; i++) lit[i] = 1.0f;
    SL_KERNEL_OF(maps->isa, sl_depth_cube_lit)(points, &looks, lit);
    sl_count(counters, SL_COUNT_SHADOW_LOOKUPS, points->count);
    return true;
}

void sl_shadow_maps_each(const sl_shadow_maps *maps, const sl_light_points *points, unsigned parts,
                         sl_shadow_map_visitor *visit, void *context, sl_counters *counters) {
    sl_arrivals arrivals;
    float lit[SL_LIGHT_BLOCK];
    for (size_t i = 0; i < maps->source_count; i++) {
        const sl_mapped_source *s = &maps->sources[i];
        if ((s->part & parts) && look_up(maps, s, points, &arrivals, lit, counters))
            visit(context, &arrivals, lit, s->source.colour);
    }
}

/* ---- emitters: the exact irradiance of the whole times the share of the samples that is visible ---- */

/* Tells whether no point of [begin, end) sees some of the samples alone. */
static bool all_agree(const sl_light_shares *s, size_t begin, size_t end) {
    bool agree = true;
    for (size_t i = begin; i < end; i++) agree &= s->seen[i] == 0.0f || s->seen[i] == s->all[i];
    return agree;
}

sl_light_points sl_points_from(const sl_light_points *p, size_t first, size_t count) {
    return (sl_light_points){count,
                             p->x + first,
                             p->y + first,
                             p->z + first,
                             p->geometric_x + first,
                             p->geometric_y + first,
                             p->geometric_z + first,
                             p->normal_x + first,
                             p->normal_y + first,
                             p->normal_z + first};
}

static size_t next_points(const sl_light_points *points, size_t first, size_t each) {
    return first + each < points->count ? first + each : 0;
}

void sl_ask_samples(const sl_shadow_maps *maps, const sl_questions *q, const sl_light_points *points,
                    float *seen, float *all, sl_counters *counters) {
    sl_arrivals arrivals;
    float weight[SL_LIGHT_BLOCK], lit[SL_LIGHT_BLOCK];
    const sl_depth_cube *cube[SL_LIGHT_BLOCK];
    const sl_cube_looks looks = {q->count, q->each, cube};
    const size_t each = q->each, lanes = q->count * each;
    for (size_t k = 0, first = 0; k < q->count; k++, first = next_points(points, first, each)) {
        const sl_light_points some = sl_points_from(points, first, each);
        cube[k] = &q->source[k]->cube;
        SL_KERNEL_OF(maps->isa, sl_light_arrive)(&some, &q->source[k]->source, &arrivals);
        memcpy(weight + k * each, arrivals.weight, each * sizeof *weight);
    }
    if (!any(weight, lanes)) return;
    for (size_t i = 0; i < lanes; i++) lit[i] = weight[i] > 0.0f ? 1.0f : 0.0f;
    SL_KERNEL_OF(maps->isa, sl_depth_cube_lit)(points, &looks, lit);
    sl_count(counters, SL_COUNT_SHADOW_LOOKUPS, lanes);
    for (size_t k = 0, first = 0; k < lanes; k += each, first = next_points(points, first, each)) {
        for (size_t i = 0; i < each; i++) {
            all[first + i] += weight[k + i];
            seen[first + i] += weight[k + i] * lit[k + i];
        }
    }
}

void sl_add_samples(const sl_shadow_maps *maps, const sl_mapped_emitter *e, size_t first, size_t last,
                    const sl_light_points *points, size_t begin, size_t end, sl_light_shares *s,
                    sl_counters *counters) {
    const size_t each = end - begin, together = SL_LIGHT_BLOCK / each;
    const sl_light_points some = sl_points_from(points, begin, each);
    while (first < last) {
        sl_questions q = {.count = sl_fewer(together, last - first), .each = each};
        for (size_t k = 0; k < q.count; k++) q.source[k] = &maps->sources[e->first + first++];
        sl_ask_samples(maps, &q, &some, s->seen + begin, s->all + begin, counters);
    }
}

void sl_points_thin(const sl_light_points *all, size_t count, sl_thinned_points *few) {
    const float *from[9] = {all->x, all->y, all->z, all->geometric_x, all->geometric_y, all->geometric_z,
                            all->normal_x, all->normal_y, all->normal_z};
    float *to[9] = {few->x, few->y, few->z, few->geometric[0], few->geometric[1], few->geometric[2],
                    few->normal[0], few->normal[1], few->normal[2]};
    for (int k = 0; k < 9; k++) {
        for (size_t i = 0; i < count; i++) to[k][i] = from[k][few->place[i]];
    }
    few->points = (sl_light_points){count, few->x, few->y, few->z, few->geometric[0], few->geometric[1],
                                    few->geometric[2], few->normal[0], few->normal[1], few->normal[2]};
}

/* Takes a quarter of each part of a tile: of each row every fourth point, and of each column, too. */
static void thin(const sl_light_points *all, sl_thinned_points *few) {
    static const uint8_t begin[4] = {0, 2, 1, 3};
    size_t count = 0;
    for (size_t i = 0; i < all->count; i++) {
        if (i % 4 == begin[i / SL_MAPPED_COLUMNS % 4]) few->place[count++] = (uint8_t)i;
    }
    sl_points_thin(all, count, few);
}

void sl_shares_put_back(const sl_light_shares *own, const sl_thinned_points *few, sl_light_shares *s) {
    for (size_t k = 0; k < few->points.count; k++) {
        s->seen[few->place[k]] = own->seen[k];
        s->all[few->place[k]] = own->all[k];
    }
}

/* Where all points that were asked are lit, or none is, all others are as they; false: they differ, or none
 * is before the light. */
static bool fill_by_common_share(sl_light_shares *s, size_t asked, size_t count) {
    bool dark = true, lit = true;
    for (size_t i = 0; i < asked; i++) {
        dark &= s->seen[i] == 0.0f;
        lit &= s->seen[i] == s->all[i];
    }
    for (size_t i = 0; i < count && lit != dark; i++) s->seen[i] = lit ? 1.0f : 0.0f, s->all[i] = 1.0f;
    return lit != dark;
}

/* ---- the share of all ---- */

/* Where the first quarter of the samples says the same in a part of a block, the others would too: of a
 * picture the penumbrae alone need all. */
static void share_by_parts(const sl_shadow_maps *maps, const sl_mapped_emitter *e,
                           const sl_light_points *points, size_t pilot, size_t step, bool few,
                           sl_light_shares *s, sl_counters *counters) {
    memset(s, 0, sizeof *s);
    for (size_t first = 0; first < points->count; first += step) {
        const size_t end = sl_fewer(first + step, points->count);
        sl_add_samples(maps, e, 0, pilot, points, first, end, s, counters);
        if (!few && !all_agree(s, first, end))
            sl_add_samples(maps, e, pilot, e->count, points, first, end, s, counters);
    }
}

/* Where a quarter of a tile's points is lit alike, so are those between. */
static void share_of_tiles(const sl_shadow_maps *maps, const sl_mapped_emitter *e,
                           const sl_light_points *points, const sl_thinned_points *few, size_t pilot,
                           sl_light_shares *s, sl_counters *counters) {
    sl_light_shares own = {0};
    sl_add_samples(maps, e, 0, pilot, &few->points, 0, few->points.count, &own, counters);
    if (fill_by_common_share(&own, few->points.count, points->count)) *s = own;
    else share_by_parts(maps, e, points, pilot, SL_MAPPED_PART, false, s, counters);
}

/* A block's points that are asked first, or instead of all. */
typedef struct {
    bool has_squares;
    sl_light_squares squares;
    sl_thinned_points few;
} tile;

static void share_of_samples(const sl_shadow_maps *maps, const sl_mapped_emitter *e,
                             const sl_light_points *points, const tile *t, unsigned parts, sl_light_shares *s,
                             sl_counters *counters) {
    const size_t least = e->count / 4 > 4 ? e->count / 4 : 4, pilot = sl_fewer(least, e->count);
    if (t->has_squares && sl_can_interleave(e))
        sl_share_by_squares(maps, e, &t->squares, s, counters);
    else if (parts & SL_MAPPED_TILE)
        share_of_tiles(maps, e, points, &t->few, pilot, s, counters);
    else
        share_by_parts(maps, e, points, pilot, points->count, parts & SL_MAPPED_FEW, s, counters);
}

static bool all_can_interleave(const sl_shadow_maps *maps) {
    bool all = true;
    for (size_t i = 0; i < maps->emitter_count; i++) all &= sl_can_interleave(&maps->emitters[i]);
    return all;
}

static void add_emitter(const sl_shadow_maps *maps, const sl_mapped_emitter *e, const sl_light_points *points,
                        const tile *t, unsigned parts, float *r, float *g, float *b, sl_counters *counters) {
    float exact[SL_LIGHT_BLOCK];
    sl_light_shares s;
    SL_KERNEL_OF(maps->isa, sl_polygon_light)(points, &e->polygon, exact);
    if (!any(exact, points->count)) return;
    share_of_samples(maps, e, points, t, parts, &s, counters);
    for (size_t i = 0; i < points->count; i++) s.seen[i] = s.all[i] > 0.0f ? s.seen[i] / s.all[i] : 0.0f;
    SL_KERNEL_OF(maps->isa, sl_light_accumulate)(points->count, e->radiance, exact, s.seen, r, g, b);
}

void sl_shadow_maps_irradiance(const sl_shadow_maps *maps, const sl_light_points *points, unsigned parts,
                               float *r, float *g, float *b, sl_counters *counters) {
    sl_arrivals arrivals;
    float lit[SL_LIGHT_BLOCK];
    for (size_t i = 0; i < maps->plain_count; i++) {
        const sl_mapped_source *s = &maps->sources[i];
        if (!(s->part & parts) || !look_up(maps, s, points, &arrivals, lit, counters)) continue;
        SL_KERNEL_OF(maps->isa, sl_light_accumulate)(points->count, s->source.colour, arrivals.weight, lit,
                                                     r, g, b);
    }
    if (!(parts & SL_MAPPED_LIGHTS) || !maps->emitter_count) return;
    tile t;
    t.has_squares = (parts & SL_MAPPED_INTERLEAVED) && points->count == SL_LIGHT_BLOCK;
    if ((parts & SL_MAPPED_TILE) && !(t.has_squares && all_can_interleave(maps))) thin(points, &t.few);
    if (t.has_squares) sl_sort_by_squares(maps, points, &t.squares);
    for (size_t i = 0; i < maps->emitter_count; i++)
        add_emitter(maps, &maps->emitters[i], points, &t, parts, r, g, b, counters);
}
