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
    SL_KERNEL_OF(maps->isa, sl_light_arrive)(points, &s->source, arrivals);
    if (!any(arrivals->weight, points->count)) return false;
    for (size_t i = 0; i < points->count; i++) lit[i] = 1.0f;
    SL_KERNEL_OF(maps->isa, sl_depth_cube_lit)(points, &s->cube, lit);
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

typedef struct {
    float seen[SL_LIGHT_BLOCK], all[SL_LIGHT_BLOCK]; /* sums of weights */
} shares;

/* Points [begin, end) of a block. */
typedef struct {
    size_t begin, end;
} span;

/* Nowhere a part of the samples alone. */
static bool all_agree(const shares *s, span at) {
    bool agree = true;
    for (size_t i = at.begin; i < at.end; i++) agree &= s->seen[i] == 0.0f || s->seen[i] == s->all[i];
    return agree;
}

/* Adds what samples [first, last) of an emitter give. */
static void add_samples(const sl_shadow_maps *maps, const sl_mapped_emitter *e, size_t first, size_t last,
                        const sl_light_points *points, span at, shares *s, sl_counters *counters) {
    const size_t k = at.begin;
    const sl_light_points some = {at.end - k,
                                  points->x + k,
                                  points->y + k,
                                  points->z + k,
                                  points->geometric_x + k,
                                  points->geometric_y + k,
                                  points->geometric_z + k,
                                  points->normal_x + k,
                                  points->normal_y + k,
                                  points->normal_z + k};
    sl_arrivals arrivals;
    float lit[SL_LIGHT_BLOCK];
    for (size_t sample = first; sample < last; sample++) {
        if (!look_up(maps, &maps->sources[e->first + sample], &some, &arrivals, lit, counters)) continue;
        for (size_t i = 0; i < some.count; i++) {
            s->all[k + i] += arrivals.weight[i];
            s->seen[k + i] += arrivals.weight[i] * lit[i];
        }
    }
}

/* Some of a block's points. */
typedef struct {
    uint8_t place[SL_LIGHT_BLOCK]; /* in the block */
    float x[SL_LIGHT_BLOCK], y[SL_LIGHT_BLOCK], z[SL_LIGHT_BLOCK];
    float geometric[3][SL_LIGHT_BLOCK], normal[3][SL_LIGHT_BLOCK];
    sl_light_points points;
} thinned;

static void take(const sl_light_points *all, size_t count, thinned *few) {
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
static void thin(const sl_light_points *all, thinned *few) {
    static const uint8_t begin[4] = {0, 2, 1, 3};
    size_t count = 0;
    for (size_t i = 0; i < all->count; i++) {
        if (i % 4 == begin[i / SL_MAPPED_COLUMNS % 4]) few->place[count++] = (uint8_t)i;
    }
    take(all, count, few);
}

static void put_back(const shares *own, const thinned *few, shares *s) {
    for (size_t k = 0; k < few->points.count; k++) {
        s->seen[few->place[k]] = own->seen[k];
        s->all[few->place[k]] = own->all[k];
    }
}

/* Where all points that were asked are lit, or none is, all others are as they; false: they differ, or none
 * is before the light. */
static bool fill_by_common_share(shares *s, size_t asked, size_t count) {
    bool dark = true, lit = true;
    for (size_t i = 0; i < asked; i++) {
        dark &= s->seen[i] == 0.0f;
        lit &= s->seen[i] == s->all[i];
    }
    for (size_t i = 0; i < count && lit != dark; i++) s->seen[i] = lit ? 1.0f : 0.0f, s->all[i] = 1.0f;
    return lit != dark;
}

/* ---- in motion: four neighbours share an emitter's samples ---- */

/* Interleaved sampling (Keller and Heidrich 2001), in squares of two by two pixels. */
enum { SHARERS = 4, HALF = SL_LIGHT_BLOCK / 2, SQUARES = HALF / SHARERS, SQUARES_A_TILE = SQUARES / 2 };

/* Of two tiles. */
typedef struct {
    thinned sorted;
    uint32_t one_surface[2 * SQUARES];
} squares;

/* Returns how many samples of an emitter a square asks. */
static size_t interleaved_count(const sl_mapped_emitter *e) { return e->count / 2; }

/* Tells of each square whether its pixels show one surface. */
static void find_surfaces(const sl_light_points *p, uint32_t *one) {
    const float *x = p->x, *y = p->y, *z = p->z, *nx = p->geometric_x, *ny = p->geometric_y,
                *nz = p->geometric_z;
    for (size_t first = 0; first < SL_LIGHT_BLOCK; first += HALF, one += SQUARES) {
        for (size_t k = 0; k < SQUARES; k++) one[k] = 1;
        for (size_t j = first + SQUARES; j < first + HALF; j += SQUARES) {
#pragma omp simd
            for (size_t k = 0; k < SQUARES; k++) {
                const size_t a = first + k, b = j + k;
                const sl_vec3 d = sl_v3(x[b] - x[a], y[b] - y[a], z[b] - z[a]),
                              m = sl_v3(nx[a], ny[a], nz[a]), n = sl_v3(nx[b], ny[b], nz[b]);
                one[k] &= sl_dot(m, n) > 0.9f ? sl_is_chord(d, sl_add(m, n)) : 0;
            }
        }
    }
}

/* Sorts the pixels of two tiles: first those of every other square, as on a chess board; in each half the
 * first ones of all squares, then the second ones, and so on. */
static void sort_by_squares(const sl_light_points *points, squares *of) {
    for (size_t k = 0; k < SL_LIGHT_BLOCK; k++) {
        const size_t half = k / HALF, sharer = k % HALF / SQUARES, square = k % SQUARES,
                     first = square / SQUARES_A_TILE * HALF, row = square % SQUARES_A_TILE / 2,
                     column = 2 * (square % 2) + (row + half) % 2, x = 2 * column + sharer % 2,
                     y = 2 * row + sharer / 2;
        of->sorted.place[k] = (uint8_t)(first + y * SL_MAPPED_COLUMNS + x);
    }
    take(points, SL_LIGHT_BLOCK, &of->sorted);
    find_surfaces(&of->sorted.points, of->one_surface);
}

/* Adds up what the pixels of each square have asked. Where they show several surfaces, and do not all say the
 * same, each is to ask all samples for itself: it is listed. Returns how many are. */
static size_t add_up_squares(const uint32_t *one, shares *s, uint8_t *apart) {
    size_t count = 0;
    for (size_t i = 0; i < 2 * SQUARES; i++) {
        const size_t first = i / SQUARES * HALF + i % SQUARES, end = first + HALF;
        float seen = 0.0f, all = 0.0f;
        for (size_t k = first; k < end; k += SQUARES) seen += s->seen[k], all += s->all[k];
        if (seen == 0.0f) continue;
        for (size_t k = first; k < end; k += SQUARES) {
            s->seen[k] = seen;
            s->all[k] = all;
            if (!one[i] && seen != all) apart[count++] = (uint8_t)k;
        }
    }
    return count;
}

static void share_squares(const sl_shadow_maps *maps, const sl_mapped_emitter *e, const squares *of,
                          shares *s, sl_counters *counters) {
    thinned apart;
    shares own = {0};
    const size_t count = add_up_squares(of->one_surface, s, apart.place);
    if (!count) return;
    take(&of->sorted.points, count, &apart);
    add_samples(maps, e, 0, interleaved_count(e), &apart.points, (span){0, count}, &own, counters);
    put_back(&own, &apart, s);
}

/* The pixels of a square ask a quarter of the samples each. Where half of the squares say the same, the
 * others would too. */
static void share_by_squares(const sl_shadow_maps *maps, const sl_mapped_emitter *e, const squares *of,
                             shares *s, sl_counters *counters) {
    const size_t asked = interleaved_count(e);
    shares own = {0};
    for (size_t k = 0; k < 2 * SHARERS; k++) {
        const size_t begin = k * SQUARES, q = k % SHARERS;
        if (k == SHARERS && fill_by_common_share(&own, HALF, SL_LIGHT_BLOCK)) break;
        add_samples(maps, e, q * asked / SHARERS, (q + 1) * asked / SHARERS, &of->sorted.points,
                    (span){begin, begin + SQUARES}, &own, counters);
    }
    share_squares(maps, e, of, &own, counters);
    put_back(&own, &of->sorted, s);
}

/* ---- the share of all ---- */

/* Where the first quarter of the samples says the same in a part of a block, the others would too: of a
 * picture the penumbrae alone need all. */
static void share_by_parts(const sl_shadow_maps *maps, const sl_mapped_emitter *e,
                           const sl_light_points *points, size_t pilot, size_t step, bool few, shares *s,
                           sl_counters *counters) {
    memset(s, 0, sizeof *s);
    for (size_t first = 0; first < points->count; first += step) {
        const span part = {first, sl_fewer(first + step, points->count)};
        add_samples(maps, e, 0, pilot, points, part, s, counters);
        if (!few && !all_agree(s, part)) add_samples(maps, e, pilot, e->count, points, part, s, counters);
    }
}

/* Where a quarter of a tile's points is lit alike, so are those between. */
static void share_of_tiles(const sl_shadow_maps *maps, const sl_mapped_emitter *e,
                           const sl_light_points *points, const thinned *few, size_t pilot, shares *s,
                           sl_counters *counters) {
    shares own = {0};
    add_samples(maps, e, 0, pilot, &few->points, (span){0, few->points.count}, &own, counters);
    if (fill_by_common_share(&own, few->points.count, points->count)) *s = own;
    else share_by_parts(maps, e, points, pilot, SL_MAPPED_PART, false, s, counters);
}

/* A block's points that are asked first, or instead of all. */
typedef struct {
    bool has_squares;
    squares squares;
    thinned few;
} tile;

static void share_of_samples(const sl_shadow_maps *maps, const sl_mapped_emitter *e,
                             const sl_light_points *points, const tile *t, unsigned parts, shares *s,
                             sl_counters *counters) {
    const size_t least = e->count / 4 > 4 ? e->count / 4 : 4, pilot = sl_fewer(least, e->count);
    if (t->has_squares && interleaved_count(e) >= SHARERS)
        share_by_squares(maps, e, &t->squares, s, counters);
    else if (parts & SL_MAPPED_TILE)
        share_of_tiles(maps, e, points, &t->few, pilot, s, counters);
    else
        share_by_parts(maps, e, points, pilot, points->count, parts & SL_MAPPED_FEW, s, counters);
}

static void add_emitter(const sl_shadow_maps *maps, const sl_mapped_emitter *e, const sl_light_points *points,
                        const tile *t, unsigned parts, float *r, float *g, float *b, sl_counters *counters) {
    float exact[SL_LIGHT_BLOCK];
    shares s;
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
    if (parts & SL_MAPPED_TILE) thin(points, &t.few);
    if (t.has_squares) sort_by_squares(points, &t.squares);
    for (size_t i = 0; i < maps->emitter_count; i++)
        add_emitter(maps, &maps->emitters[i], points, &t, parts, r, g, b, counters);
}
