/* Which surface point each texel of an atlas holds. A bilinear look-up in a chart reads texels whose centres
 * are less than one texel away in x and in y; those outside the chart must hold what lies at its border. With
 * charts two texels apart the square of such points about a centre meets one chart at most: the texel takes
 * the nearest point of the triangles in that square. */
#include "cache/light_octree/atlas/atlas.h"

#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"

enum { BAND = 16 }; /* rows done at once */

typedef struct texel_map {
    const sl_atlas *atlas;
    const sl_scene *scene;
    size_t *first;          /* of each band: the triangles that its texels may hold */
    uint32_t *listed;
    uint32_t *triangle;
    float *w1, *w2;
    float *distance;        /* squared: from the centre to the point */
} texel_map;

/* ---- triangles in the atlas ---- */

typedef struct flat_triangle {
    double x[3], y[3];      /* texels */
    double twice;           /* its area, with its sign */
    int low_row, high_row, low_column, high_column; /* of the texels whose squares its box meets */
} flat_triangle;

/* Texels whose centres are less than one away from what three numbers span. */
static void first_and_last(const double v[3], int size, int *first, int *last) {
    double low = floor(fmin(fmin(v[0], v[1]), v[2]) - 1.5) + 1.0,
           high = ceil(fmax(fmax(v[0], v[1]), v[2]) + 0.5) - 1.0;
    *first = (int)fmin(fmax(low, 0.0), size - 1.0);
    *last = (int)fmin(fmax(high, 0.0), size - 1.0);
}

static flat_triangle flat_triangle_of(const texel_map *m, size_t t) {
    flat_triangle f;
    int size = m->atlas->size;
    for (int k = 0; k < 3; k++) {
        float s, v;
        sl_atlas_point(&m->atlas->chart[m->atlas->chart_of[t]],
                       sl_scene_position(m->scene, m->scene->vertex[k][t]), &s, &v);
        f.x[k] = (double)s * size;
        f.y[k] = (double)v * size;
    }
    f.twice = (f.x[1] - f.x[0]) * (f.y[2] - f.y[0]) - (f.y[1] - f.y[0]) * (f.x[2] - f.x[0]);
    first_and_last(f.x, size, &f.low_column, &f.high_column);
    first_and_last(f.y, size, &f.low_row, &f.high_row);
    return f;
}

/* ---- the nearest point ---- */

typedef struct nearest_point {
    double squared, w1, w2;
} nearest_point;

static nearest_point on_edge(const flat_triangle *f, int k, double x, double y) {
    int next = k < 2 ? k + 1 : 0;
    double dx = f->x[next] - f->x[k], dy = f->y[next] - f->y[k], square = dx * dx + dy * dy;
    double t = square > 0.0 ? sl_clamp_unit(((x - f->x[k]) * dx + (y - f->y[k]) * dy) / square) : 0.0;
    double off_x = f->x[k] + t * dx - x, off_y = f->y[k] + t * dy - y, w[3] = {0.0, 0.0, 0.0};
    w[k] = 1.0 - t;
    w[next] = t;
    return (nearest_point){off_x * off_x + off_y * off_y, w[1], w[2]};
}

/* Finds the point of a triangle that is nearest to a centre. False where the triangle does not meet the open
 * square about it. */
static bool find_nearest(const flat_triangle *f, double x, double y, nearest_point *best) {
    double sign = f->twice < 0.0 ? -1.0 : 1.0, side[3];
    bool inside = f->twice != 0.0;
    for (int k = 0; k < 3; k++) {
        int next = k < 2 ? k + 1 : 0;
        double dx = f->x[next] - f->x[k], dy = f->y[next] - f->y[k];
        side[k] = sign * (dx * (y - f->y[k]) - dy * (x - f->x[k]));
        if (side[k] + fabs(dx) + fabs(dy) <= 0.0) return false;
        inside = inside && side[k] >= 0.0;
    }
    if (inside) {
        *best = (nearest_point){0.0, side[2] / fabs(f->twice), side[0] / fabs(f->twice)};
        return true;
    }
    *best = on_edge(f, 0, x, y);
    for (int k = 1; k < 3; k++) {
        nearest_point other = on_edge(f, k, x, y);
        if (other.squared < best->squared) *best = other;
    }
    return true;
}

/* ---- all texels, band by band ---- */

static void offer(const texel_map *m, size_t texel, uint32_t triangle, const nearest_point *p) {
    if (m->triangle[texel] != SL_NO_INDEX && !((float)p->squared < m->distance[texel])) return;
    m->triangle[texel] = triangle;
    m->distance[texel] = (float)p->squared;
    m->w1[texel] = (float)sl_clamp_unit(p->w1);
    m->w2[texel] = fminf((float)sl_clamp_unit(p->w2), 1.0f - m->w1[texel]);
}

static void map_band(void *context, size_t band, unsigned worker) {
    (void)worker;
    const texel_map *m = context;
    int size = m->atlas->size, begin = (int)band * BAND, end = begin + BAND < size ? begin + BAND : size;
    for (size_t i = m->first[band]; i < m->first[band + 1]; i++) {
        flat_triangle f = flat_triangle_of(m, m->listed[i]);
        for (int row = f.low_row > begin ? f.low_row : begin; row <= f.high_row && row < end; row++) {
            for (int column = f.low_column; column <= f.high_column; column++) {
                nearest_point p;
                if (find_nearest(&f, column + 0.5, row + 0.5, &p))
                    offer(m, (size_t)row * (size_t)size + (size_t)column, m->listed[i], &p);
            }
        }
    }
}

/* Lists the triangles of each band: counts, sums, and then their numbers. */
static bool list_triangles(texel_map *m, size_t bands) {
    m->first = sl_allocate(bands + 2, sizeof *m->first);
    if (!m->first) return false;
    for (size_t t = 0; t < m->scene->triangle_count; t++) {
        flat_triangle f = flat_triangle_of(m, t);
        for (int b = f.low_row / BAND; b <= f.high_row / BAND; b++) m->first[b + 2]++;
    }
    for (size_t b = 2; b < bands + 2; b++) m->first[b] += m->first[b - 1];
    m->listed = sl_allocate(m->first[bands + 1], sizeof *m->listed);
    for (size_t t = 0; m->listed && t < m->scene->triangle_count; t++) {
        flat_triangle f = flat_triangle_of(m, t);
        for (int b = f.low_row / BAND; b <= f.high_row / BAND; b++)
            m->listed[m->first[b + 1]++] = (uint32_t)t;
    }
    return m->listed != NULL;
}

sl_status sl_atlas_texels(const sl_atlas *atlas, const sl_scene *scene, unsigned threads, uint32_t *triangle,
                          float *w1, float *w2, sl_error *error) {
    size_t texels = (size_t)atlas->size * (size_t)atlas->size,
           bands = ((size_t)atlas->size + BAND - 1) / BAND;
    texel_map m = {.atlas = atlas,
                   .scene = scene,
                   .triangle = triangle,
                   .w1 = w1,
                   .w2 = w2,
                   .distance = sl_allocate(texels, sizeof *m.distance)};
    memset(triangle, 0xff, texels * sizeof *triangle);
    memset(w1, 0, texels * sizeof *w1);
    memset(w2, 0, texels * sizeof *w2);
    bool good = m.distance && list_triangles(&m, bands);
    if (good) sl_parallel_for(sl_thread_count(threads), bands, map_band, &m);
    SL_FREE_ALL(m.first, m.listed, m.distance);
    return good ? SL_OK : sl_fail_memory(error, "the texels of an atlas");
}
