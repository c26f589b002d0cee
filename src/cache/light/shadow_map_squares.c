/* Frames in motion: the four pixels of a square share what they ask of an emitter's shadow maps (interleaved
 * sampling; Keller and Heidrich 2001). Two tiles of eight by eight pixels are asked together, every other
 * square first, as on a chess board: where those around a square see about the same share, it sees their
 * mean. */
#include "base/math.h"
#include "cache/light/shadow_maps_internal.h"

#include <math.h>
#include <string.h>

enum { HALF = SL_LIGHT_BLOCK / 2, SQUARES = SL_SQUARES / 2, A_TILE = SQUARES / 2 };

/* Returns how many samples of an emitter each pixel of a square asks, so that together they ask half. */
static size_t asked_by_each(const sl_mapped_emitter *e) { return e->count / 2 / SL_SQUARE; }

bool sl_can_interleave(const sl_mapped_emitter *e) { return asked_by_each(e) > 0; }

static void compare_surfaces(const sl_light_points *p, size_t a, size_t b, uint32_t *alike) {
    const float *x = p->x, *y = p->y, *z = p->z, *nx = p->geometric_x, *ny = p->geometric_y,
                *nz = p->geometric_z;
#pragma omp simd
    for (size_t k = 0; k < SQUARES; k++) {
        const size_t i = a + k, j = b + k;
        const sl_vec3 d = sl_v3(x[j] - x[i], y[j] - y[i], z[j] - z[i]), m = sl_v3(nx[i], ny[i], nz[i]),
                      n = sl_v3(nx[j], ny[j], nz[j]);
        alike[k] = sl_dot(m, n) > 0.9f ? sl_is_chord(d, sl_add(m, n)) : 0;
    }
}

static void find_surfaces(sl_light_squares *of) {
    for (size_t first = 0; first < SL_LIGHT_BLOCK; first += HALF) {
        for (size_t a = 0, pair = 0; a < SL_SQUARE; a++) {
            for (size_t b = a + 1; b < SL_SQUARE; b++, pair++)
                compare_surfaces(&of->sorted.points, first + a * SQUARES, first + b * SQUARES,
                                 of->alike[pair] + first / HALF * SQUARES);
        }
    }
}

void sl_order_squares(uint8_t place[SL_LIGHT_BLOCK]) {
    for (size_t k = 0; k < SL_LIGHT_BLOCK; k++) {
        const size_t half = k / HALF, sharer = k % HALF / SQUARES, square = k % SQUARES,
                     first = square / A_TILE * HALF, row = square % A_TILE / 2,
                     column = 2 * (square % 2) + (row + half) % 2, x = 2 * column + sharer % 2,
                     y = 2 * row + sharer / 2;
        place[k] = (uint8_t)(first + y * SL_MAPPED_COLUMNS + x);
    }
}

void sl_sort_by_squares(const sl_shadow_maps *maps, const sl_light_points *points, sl_light_squares *of) {
    memcpy(of->sorted.place, maps->square_order, sizeof maps->square_order);
    sl_points_thin(points, SL_LIGHT_BLOCK, &of->sorted);
    find_surfaces(of);
}

/* Tells whether two pixels of a square show one surface. */
static bool is_alike(const sl_light_squares *of, size_t square, size_t a, size_t b) {
    static const uint8_t pair[SL_SQUARE][SL_SQUARE] = {
        {0, 0, 1, 2}, {0, 0, 3, 4}, {1, 3, 0, 5}, {2, 4, 5, 0}};
    return a == b || of->alike[pair[a][b]][square];
}

static bool is_one_surface(const sl_light_squares *of, size_t square) {
    return of->alike[0][square] & of->alike[1][square] & of->alike[2][square];
}

/* Tells whether so many pixels of a square have asked enough for the surface that they show: where they have
 * seen nothing, two of them may have missed what arrives from a part of the emitter. */
static bool is_enough(size_t sharers, float seen, float all) {
    return all > 0.0f && (sharers > 2 || (sharers == 2 && seen > 0.0f));
}

/* Adds up what the pixels of a square that show one surface have asked. Where that is not enough they are to
 * ask all samples for themselves: they are listed. */
static size_t add_up_apart(const sl_light_squares *of, size_t square, size_t first, sl_light_shares *s,
                           uint8_t *apart) {
    float seen[SL_SQUARE], all[SL_SQUARE];
    size_t count = 0;
    for (size_t a = 0, k = first; a < SL_SQUARE; a++, k += SQUARES) seen[a] = s->seen[k], all[a] = s->all[k];
    for (size_t a = 0, k = first; a < SL_SQUARE; a++, k += SQUARES) {
        size_t sharers = 0;
        s->seen[k] = s->all[k] = 0.0f;
        for (size_t b = 0; b < SL_SQUARE; b++) {
            if (!is_alike(of, square, a, b)) continue;
            s->seen[k] += seen[b];
            s->all[k] += all[b];
            sharers++;
        }
        if (!is_enough(sharers, s->seen[k], s->all[k])) apart[count++] = (uint8_t)k;
    }
    return count;
}

/* Adds up what the pixels of each square have asked, apart where they show several surfaces and do not all
 * say the same. Returns how many are listed. */
static size_t add_up_squares(const sl_light_squares *of, sl_light_shares *s, uint8_t *apart) {
    size_t count = 0;
    for (size_t i = 0; i < 2 * SQUARES; i++) {
        const size_t first = i / SQUARES * HALF + i % SQUARES, end = first + HALF;
        float seen = 0.0f, all = 0.0f;
        for (size_t k = first; k < end; k += SQUARES) seen += s->seen[k], all += s->all[k];
        if (seen == 0.0f) continue;
        if (seen != all && !is_one_surface(of, i)) {
            count += add_up_apart(of, i, first, s, apart + count);
            continue;
        }
        for (size_t k = first; k < end; k += SQUARES) s->seen[k] = seen, s->all[k] = all;
    }
    return count;
}

static void share_squares(const sl_shadow_maps *maps, const sl_mapped_emitter *e, const sl_light_squares *of,
                          sl_light_shares *s, sl_counters *counters) {
    sl_thinned_points apart;
    sl_light_shares own = {0};
    const size_t count = add_up_squares(of, s, apart.place);
    if (!count) return;
    sl_points_thin(&of->sorted.points, count, &apart);
    sl_add_samples(maps, e, 0, SL_SQUARE * asked_by_each(e), &apart.points, 0, count, &own, counters);
    sl_shares_put_back(&own, &apart, s);
}

/* Adds what the pixels of `each` squares ask, a quarter of the samples each. */
static void add_squares(const sl_shadow_maps *maps, const sl_mapped_emitter *e, const sl_light_points *points,
                        size_t each, sl_light_shares *s, sl_counters *counters) {
    const size_t own = asked_by_each(e), together = SL_LIGHT_BLOCK / (SL_SQUARE * each);
    for (size_t begin = 0; begin < own; begin += together) {
        sl_questions q = {.count = SL_SQUARE * sl_fewer(together, own - begin), .each = each};
        for (size_t k = 0; k < q.count; k++)
            q.source[k] = &maps->sources[e->first + k % SL_SQUARE * own + begin + k / SL_SQUARE];
        sl_ask_samples(maps, &q, points, s->seen, s->all, counters);
    }
}

static bool is_partly(float share) { return share > 0.0f && share < 1.0f; }

/* Finds what share the pixels of each of the first half's squares see together; -1: nothing arrives there, or
 * not the same on all surfaces. */
static void judge_squares(const sl_light_squares *of, const sl_light_shares *s, float *share) {
    for (size_t i = 0; i < SQUARES; i++) {
        float seen = 0.0f, all = 0.0f;
        for (size_t k = i; k < HALF; k += SQUARES) seen += s->seen[k], all += s->all[k];
        share[i] = all > 0.0f ? seen / all : -1.0f;
        if (is_partly(share[i]) && !is_one_surface(of, i)) share[i] = -1.0f;
    }
}

/* Returns the mean share of the squares beside one of the second half; less than 0: they are not alike. */
static float share_around(const float *first, size_t square) {
    static const int8_t right[4] = {-1, 1, 0, 0}, up[4] = {0, 0, -1, 1};
    const float ALIKE = 0.25f;
    const int row = (int)(square % A_TILE / 2), column = 2 * (int)(square % 2) + (row + 1) % 2;
    const float *tile = first + square / A_TILE * A_TILE;
    float least = INFINITY, most = -1.0f, sum = 0.0f;
    int count = 0;
    for (int k = 0; k < 4; k++) {
        const int x = column + right[k], y = row + up[k];
        if (x < 0 || x >= 4 || y < 0 || y >= 4) continue;
        const float share = tile[2 * y + x / 2];
        least = fminf(least, share);
        most = fmaxf(most, share);
        sum += share;
        count++;
    }
    return least >= 0.0f && most - least <= ALIKE ? sum / (float)count : -1.0f;
}

/* Fills those of the second half whose neighbours are lit alike; returns how many others there are. */
static size_t fill_between(const sl_light_squares *of, sl_light_shares *s, uint8_t *others) {
    float first[SQUARES];
    size_t count = 0;
    judge_squares(of, s, first);
    for (size_t i = 0; i < SQUARES; i++) {
        float share = share_around(first, i);
        if (is_partly(share) && !is_one_surface(of, SQUARES + i)) share = -1.0f;
        if (share < 0.0f) others[count++] = (uint8_t)i;
        for (size_t k = HALF + i; k < 2 * HALF && share >= 0.0f; k += SQUARES)
            s->seen[k] = share, s->all[k] = 1.0f;
    }
    return count;
}

void sl_share_by_squares(const sl_shadow_maps *maps, const sl_mapped_emitter *e, const sl_light_squares *of,
                         sl_light_shares *s, sl_counters *counters) {
    const sl_light_points first = sl_points_from(&of->sorted.points, 0, HALF);
    sl_light_shares own = {0}, more = {0};
    uint8_t others[SQUARES];
    sl_thinned_points between;
    add_squares(maps, e, &first, SQUARES, &own, counters);
    const size_t count = fill_between(of, &own, others);
    for (size_t k = 0; k < SL_SQUARE * count; k++)
        between.place[k] = (uint8_t)(HALF + k / count * SQUARES + others[k % count]);
    sl_points_thin(&of->sorted.points, SL_SQUARE * count, &between);
    if (count) add_squares(maps, e, &between.points, count, &more, counters);
    sl_shares_put_back(&more, &between, &own);
    share_squares(maps, e, of, &own, counters);
    sl_shares_put_back(&own, &of->sorted, s);
}
