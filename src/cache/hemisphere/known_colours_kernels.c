#include "cache/hemisphere/known_colours.h"

#include <string.h>

/* A row is done in blocks: indices in lanes, then the numbers at those indices brought beside one another,
 * then arithmetic in lanes again. */
enum { BLOCK = 64 };

typedef struct block {
    _Alignas(64) float triangle[SL_COLOURED_FLOATS][BLOCK], colour[SL_LATTICE_FLOATS][BLOCK];
    _Alignas(64) float w1[BLOCK], w2[BLOCK], a[BLOCK], b[BLOCK];
    _Alignas(64) int32_t seen[BLOCK], face[BLOCK], first[BLOCK], rows[BLOCK], at[BLOCK];
} block;

/* ---- tables to lanes ------------------------------------------------------------------------- */

typedef float four __attribute__((vector_size(16)));

static inline four load(const float *from) {
    four v;
    memcpy(&v, from, sizeof v);
    return v;
}

static inline void store(float *to, four v) { memcpy(to, &v, sizeof v); }

/* Entries of twelve floats, four pixels at a time: three times four rows of four become columns. (count is a
 * multiple of four.) */
static inline void fetch(const float *restrict table, const int32_t *restrict index, int count,
                         float (*restrict out)[BLOCK]) {
    for (int k = 0; k < count; k += 4) {
        for (int c = 0; c < 12; c += 4) {
            four p = load(table + 12 * index[k] + c), q = load(table + 12 * index[k + 1] + c);
            four r = load(table + 12 * index[k + 2] + c), s = load(table + 12 * index[k + 3] + c);
            four pq = __builtin_shufflevector(p, q, 0, 4, 1, 5),
                 rs = __builtin_shufflevector(r, s, 0, 4, 1, 5);
            four ps = __builtin_shufflevector(p, q, 2, 6, 3, 7),
                 rq = __builtin_shufflevector(r, s, 2, 6, 3, 7);
            store(&out[c][k], __builtin_shufflevector(pq, rs, 0, 1, 4, 5));
            store(&out[c + 1][k], __builtin_shufflevector(pq, rs, 2, 3, 6, 7));
            store(&out[c + 2][k], __builtin_shufflevector(ps, rq, 0, 1, 4, 5));
            store(&out[c + 3][k], __builtin_shufflevector(ps, rq, 2, 3, 6, 7));
        }
    }
}

/* ---- where a pixel's line meets its triangle ------------------------------------------------- */

/* With corner p and edges e1, e2 from it, t = eye - p and d the direction, corners 1 and 2 weigh d.(e2 x t) /
 * -(d.n) and d.(t x e1) / -(d.n), n = e1 x e2 (Moeller and Trumbore 1997). The eye is in front of the
 * triangle where t.n >= 0. Vertices were snapped to 1/256 pixel when it was drawn, so pixels on its rim may
 * lie a little outside: weights are clamped to the triangle. */
static inline void meet(block *b, int count, sl_vec3 eye, sl_vec3 origin, sl_vec3 along,
                        const float *restrict x) {
    float(*restrict v)[BLOCK] = b->triangle;
#pragma omp simd
    for (int k = 0; k < count; k++) {
        float dx = x[k] * along.x + origin.x, dy = x[k] * along.y + origin.y, dz = x[k] * along.z + origin.z;
        float tx = eye.x - v[0][k], ty = eye.y - v[1][k], tz = eye.z - v[2][k];
        float ax = v[3][k], ay = v[4][k], az = v[5][k], bx = v[6][k], by = v[7][k], bz = v[8][k];
        float nx = ay * bz - az * by, ny = az * bx - ax * bz, nz = ax * by - ay * bx;
        float across = -(dx * nx + dy * ny + dz * nz), over = 1.0f / (across != 0.0f ? across : 1.0f);
        float w1 = (dx * (by * tz - bz * ty) + dy * (bz * tx - bx * tz) + dz * (bx * ty - by * tx)) * over;
        float w2 = (dx * (ty * az - tz * ay) + dy * (tz * ax - tx * az) + dz * (tx * ay - ty * ax)) * over;
        w1 = w1 > 0.0f ? w1 : 0.0f; /* also where it is not a number */
        w2 = w2 > 0.0f ? w2 : 0.0f;
        w1 = w1 < 1.0f ? w1 : 1.0f;
        w2 = w2 < 1.0f ? w2 : 1.0f;
        float sum = w1 + w2, shrink = 1.0f / (sum > 1.0f ? sum : 1.0f);
        b->w1[k] = w1 * shrink;
        b->w2[k] = w2 * shrink;
        b->face[k] = 2 * b->seen[k] + (tx * nx + ty * ny + tz * nz >= 0.0f ? 0 : 1);
    }
}

static inline void find_small_triangles(block *b, int count, const sl_face_lattice *restrict face) {
    for (int k = 0; k < count; k++) {
        b->first[k] = face[b->face[k]].first;
        b->rows[k] = face[b->face[k]].rows;
    }
#pragma omp simd
    for (int k = 0; k < count; k++)
        b->at[k] = b->first[k] + sl_lattice_locate(b->w1[k], b->w2[k], b->rows[k], &b->a[k], &b->b[k]);
}

/* ---- a row ----------------------------------------------------------------------------------- */

/* Colours between the corners; below the horizon black. */
static inline void write(const sl_colour_pixels *p, const block *b, int count, size_t first,
                         sl_vec3 origin, sl_vec3 along, const float *restrict x) {
    const float *restrict weight = p->weight + first;
    const sl_vec3 up = p->horizon;
    for (int c = 0; c < 3; c++) {
        float *restrict radiance = p->radiance[c] + first, *restrict weighted = p->weighted[c] + first;
#pragma omp simd
        for (int k = 0; k < count; k++) {
            float dx = x[k] * along.x + origin.x, dy = x[k] * along.y + origin.y,
                  dz = x[k] * along.z + origin.z;
            float above = dx * up.x + dy * up.y + dz * up.z > 0.0f ? 1.0f : 0.0f;
            float value = b->colour[c][k] + b->a[k] * b->colour[c + 3][k] + b->b[k] * b->colour[c + 6][k];
            value = above * (value > 0.0f ? value : 0.0f);
            radiance[k] = value;
            weighted[k] = value * weight[k];
        }
    }
}

static inline void see(block *b, int count, const uint32_t *restrict id, uint32_t nothing) {
    for (int k = 0; k < count; k++) b->seen[k] = (int32_t)(id[k] < nothing ? id[k] : nothing);
}

void SL_KERNEL(sl_colour_pixels_shade)(const sl_colour_pixels *p) {
    block b;
    for (int row = 0; row < p->height; row++) {
        sl_vec3 origin = sl_mad(p->frame.z, p->y[row * p->width], p->frame.y);
        for (int at = 0; at < p->width; at += BLOCK) {
            int count = p->width - at < BLOCK ? p->width - at : BLOCK;
            size_t first = (size_t)row * (size_t)p->width + (size_t)at;
            see(&b, count, p->id + first, p->colours->triangle_count);
            fetch(p->colours->triangle, b.seen, count, b.triangle);
            meet(&b, count, p->eye, origin, p->frame.x, p->x + at);
            find_small_triangles(&b, count, p->colours->lattice.face);
            fetch(p->colours->lattice.colour, b.at, count, b.colour);
            write(p, &b, count, first, origin, p->frame.x, p->x + at);
        }
    }
}
