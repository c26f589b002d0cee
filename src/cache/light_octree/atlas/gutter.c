/* Texels around charts, so that filtering finds no seams. A bilinear look-up in a chart reads texels whose
 * centres are less than one texel away in x and in y; those outside the chart must hold what lies at its
 * border, not what lies at its neighbour's. So distance is measured as that filter measures it, by the larger
 * of x and y: with charts two texels apart every texel that a chart's look-ups read is nearest to that chart.
 */
#include "cache/light_octree/atlas/parts.h"

#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"

enum { BAND = 16 }; /* rows done at once */

__extension__ typedef __int128 wide;

typedef struct texel_map {
    const sl_atlas *atlas;
    size_t count;           /* of triangles */
    int gutter;
    size_t *first;          /* of each band: the triangles that it holds texels or gutter of */
    uint32_t *listed;
    uint32_t *triangle;
    float *w1, *w2;         /* or NULL: only coverage is wanted */
    size_t *covered;        /* of each band */
    bool *failed;
} texel_map;

/* ---- which triangles each band meets ---- */

static void rows_of(const texel_map *m, size_t triangle, int *first, int *last) {
    const float *t = m->atlas->coordinates + 6 * triangle + 1;
    double low = fmin(fmin((double)t[0], (double)t[2]), (double)t[4]),
           high = fmax(fmax((double)t[0], (double)t[2]), (double)t[4]);
    int size = m->atlas->size;
    *first = (int)floor(low * size - 0.5) - m->gutter;
    *last = (int)floor(high * size + 0.5) + m->gutter;
    *first = *first < 0 ? 0 : *first;
    *last = *last > size - 1 ? size - 1 : *last;
}

static size_t band_count(const texel_map *m) { return ((size_t)m->atlas->size + BAND - 1) / BAND; }

static bool list_triangles(texel_map *m) {
    size_t bands = band_count(m);
    int first, last;
    m->first = sl_allocate(bands + 2, sizeof *m->first);
    if (!m->first) return false;
    for (size_t t = 0; t < m->count; t++) {
        rows_of(m, t, &first, &last);
        for (int b = first / BAND; b <= last / BAND; b++) m->first[b + 2]++;
    }
    for (size_t b = 2; b < bands + 2; b++) m->first[b] += m->first[b - 1];
    m->listed = sl_allocate(m->first[bands + 1], sizeof *m->listed);
    for (size_t t = 0; m->listed && t < m->count; t++) {
        rows_of(m, t, &first, &last);
        for (int b = first / BAND; b <= last / BAND; b++) m->listed[m->first[b + 1]++] = (uint32_t)t;
    }
    return m->listed != NULL;
}

/* ---- texels inside ---- */

/* Twice the area of a, b and a texel's centre, exactly: corners count in 2^-24 of the atlas, centres in 2^-24
 * / (2 size). */
static wide side(const int64_t *a, const int64_t *b, int64_t x, int64_t y, int64_t scale) {
    return (wide)(b[0] - a[0]) * (y - scale * a[1]) - (wide)(b[1] - a[1]) * (x - scale * a[0]);
}

static float weight(double w) { return (float)(w > 0.0 ? w < 1.0 ? w : 1.0 : 0.0); }

static void set_texel(const texel_map *m, size_t texel, uint32_t triangle, double w1, double w2) {
    m->triangle[texel] = triangle;
    if (!m->w1) return;
    m->w1[texel] = weight(w1);
    m->w2[texel] = fminf(weight(w2), 1.0f - m->w1[texel]);
}

static size_t cover_triangle(const texel_map *m, uint32_t triangle, int first_row, int last_row) {
    int64_t p[6], scale = 2 * (int64_t)m->atlas->size, unit = (int64_t)SL_ATLAS_GRID;
    size_t covered = 0, size = (size_t)m->atlas->size;
    for (size_t k = 0; k < 6; k++)
        p[k] = (int64_t)((double)m->atlas->coordinates[6 * (size_t)triangle + k] * SL_ATLAS_GRID);
    int64_t low = p[0] < p[2] ? p[0] : p[2], high = p[0] > p[2] ? p[0] : p[2];
    low = low < p[4] ? low : p[4];
    high = high > p[4] ? high : p[4];
    int from = (int)(low * (int64_t)size / unit), to = (int)(high * (int64_t)size / unit);
    double total = (double)((p[2] - p[0]) * (p[5] - p[1]) - (p[3] - p[1]) * (p[4] - p[0])) * (double)scale;
    for (int row = first_row; row <= last_row; row++)
        for (int i = from; i <= to && i < (int)size; i++) {
            int64_t x = (2 * (int64_t)i + 1) * unit, y = (2 * (int64_t)row + 1) * unit;
            size_t texel = (size_t)row * size + (size_t)i;
            if (m->triangle[texel] != SL_NO_INDEX) continue;
            wide e1 = side(p + 4, p, x, y, scale), e2 = side(p, p + 2, x, y, scale);
            if (e1 < 0 || e2 < 0 || side(p + 2, p + 4, x, y, scale) < 0 || !(total > 0.0)) continue;
            set_texel(m, texel, triangle, (double)e1 / total, (double)e2 / total);
            covered++;
        }
    return covered;
}

/* ---- texels just outside ---- */

typedef struct nearest {
    /* distance by the larger of x and y; squared Euclidean, which decides between equals */
    double larger, squared;
} nearest;

/* The point of a segment from a by d, seen from the origin, at t; keeps it if it is nearer than the best. */
static bool consider(const double a[2], const double d[2], double t, nearest *best, double *best_t) {
    t = t > 0.0 ? t < 1.0 ? t : 1.0 : 0.0;
    double x = fabs(a[0] + t * d[0]), y = fabs(a[1] + t * d[1]), larger = x > y ? x : y,
           squared = x * x + y * y;
    if (larger > best->larger || (larger == best->larger && squared >= best->squared)) return false;
    *best = (nearest){larger, squared};
    *best_t = t;
    return true;
}

/* max(|x|, |y|) along a segment is convex and piecewise linear: its minimum is at an end, at a zero of x or
 * y, or where |x| = |y|. */
static bool nearest_on_segment(const double a[2], const double b[2], nearest *best, double *t) {
    double d[2] = {b[0] - a[0], b[1] - a[1]}, square = d[0] * d[0] + d[1] * d[1];
    bool found = consider(a, d, 0.0, best, t);
    found |= consider(a, d, 1.0, best, t);
    if (d[0] != 0.0) found |= consider(a, d, -a[0] / d[0], best, t);
    if (d[1] != 0.0) found |= consider(a, d, -a[1] / d[1], best, t);
    if (d[0] != d[1]) found |= consider(a, d, (a[1] - a[0]) / (d[0] - d[1]), best, t);
    if (d[0] != -d[1]) found |= consider(a, d, -(a[0] + a[1]) / (d[0] + d[1]), best, t);
    if (square > 0.0) found |= consider(a, d, -(a[0] * d[0] + a[1] * d[1]) / square, best, t);
    return found;
}

static void surround_triangle(const texel_map *m, uint32_t triangle, int first_row, int last_row,
                              int band_row, nearest *best, bool *taken) {
    const float *s = m->atlas->coordinates + 6 * (size_t)triangle;
    int size = m->atlas->size;
    double p[3][2];
    for (size_t k = 0; k < 6; k++) p[k / 2][k % 2] = (double)s[k] * size;
    int from = (int)floor(fmin(fmin(p[0][0], p[1][0]), p[2][0]) - 0.5) - m->gutter;
    int to = (int)floor(fmax(fmax(p[0][0], p[1][0]), p[2][0]) + 0.5) + m->gutter;
    for (int row = first_row; row <= last_row; row++)
        for (int i = from < 0 ? 0 : from; i <= to && i < size; i++) {
            size_t here = (size_t)(row - band_row) * (size_t)size + (size_t)i,
                   texel = (size_t)row * (size_t)size + (size_t)i;
            if (m->triangle[texel] != SL_NO_INDEX && !taken[here]) continue;
            for (size_t k = 0; k < 3; k++) {
                double a[2] = {p[k][0] - i - 0.5, p[k][1] - row - 0.5}, t = 0.0;
                double b[2] = {p[(k + 1) % 3][0] - i - 0.5, p[(k + 1) % 3][1] - row - 0.5};
                if (!nearest_on_segment(a, b, &best[here], &t)) continue;
                taken[here] = true;
                set_texel(m, texel, triangle,
                          k == 0   ? t
                          : k == 1 ? 1.0 - t
                                   : 0.0,
                          k == 1   ? t
                          : k == 2 ? 1.0 - t
                                   : 0.0);
            }
        }
}

/* ---- all texels, band by band ---- */

static void map_band(void *context, size_t band, unsigned worker) {
    texel_map *m = context;
    (void)worker;
    int size = m->atlas->size, begin = (int)band * BAND,
        end = begin + BAND - 1 < size - 1 ? begin + BAND - 1 : size - 1, first, last;
    size_t texels = (size_t)(end - begin + 1) * (size_t)size;
    for (int pass = 0; pass < 2; pass++) {
        nearest *best = pass ? sl_allocate(texels, sizeof *best) : NULL;
        bool *taken = pass ? sl_allocate(texels, sizeof *taken) : NULL;
        if (pass && (!best || !taken)) m->failed[band] = true;
        for (size_t i = 0; best && i < texels; i++) best[i] = (nearest){m->gutter, HUGE_VAL};
        for (size_t i = m->first[band]; !m->failed[band] && i < m->first[band + 1]; i++) {
            rows_of(m, m->listed[i], &first, &last);
            first = first < begin ? begin : first;
            last = last > end ? end : last;
            if (pass) surround_triangle(m, m->listed[i], first, last, begin, best, taken);
            else m->covered[band] += cover_triangle(m, m->listed[i], first, last);
        }
        sl_free(best);
        sl_free(taken);
        if (!m->w1 || !m->gutter) break;
    }
}

static bool map_texels(texel_map *m, unsigned threads) {
    size_t bands = band_count(m), texels = (size_t)m->atlas->size * (size_t)m->atlas->size;
    memset(m->triangle, 0xff, texels * sizeof *m->triangle);
    m->covered = sl_allocate(bands, sizeof *m->covered);
    m->failed = sl_allocate(bands, sizeof *m->failed);
    bool good = m->covered && m->failed && list_triangles(m);
    if (good) sl_parallel_for(sl_thread_count(threads), bands, map_band, m);
    for (size_t b = 0; good && b < bands; b++) good = !m->failed[b];
    return good;
}

static void release_map(texel_map *m) {
    sl_free(m->first);
    sl_free(m->listed);
    sl_free(m->covered);
    sl_free(m->failed);
}

bool sl_atlas_cover(const sl_atlas *atlas, size_t triangle_count, unsigned threads, uint32_t *triangle,
                    size_t *covered) {
    texel_map m = {.atlas = atlas, .count = triangle_count, .triangle = triangle};
    bool good = map_texels(&m, threads);
    *covered = 0;
    for (size_t b = 0; good && b < band_count(&m); b++) *covered += m.covered[b];
    release_map(&m);
    return good;
}

sl_status sl_atlas_texels(const sl_atlas *atlas, const sl_scene *scene, int gutter, unsigned threads,
                          uint32_t *triangle, float *w1, float *w2, sl_error *error) {
    if (gutter < 0 || gutter > atlas->size)
        return sl_fail(error, SL_ERROR_USAGE, "an atlas's gutter must be 0 to %d texels, not %d", atlas->size,
                       gutter);
    texel_map m = {.atlas = atlas,
                   .count = scene->triangle_count,
                   .gutter = gutter,
                   .triangle = triangle,
                   .w1 = w1,
                   .w2 = w2};
    size_t texels = (size_t)atlas->size * (size_t)atlas->size;
    memset(w1, 0, texels * sizeof *w1);
    memset(w2, 0, texels * sizeof *w2);
    bool good = map_texels(&m, threads);
    release_map(&m);
    return good ? SL_OK : sl_fail_memory(error, "the texels of an atlas");
}
