/* Clipping, SL_PART triangles together in the lanes of a vector: what clip.c does to one, with the same
 * roundings. Start there.
 *
 * Most triangles that cross a plane of the view cross just one, in one of two ways:
 *
 *             0 o                       0             o  a corner outside the plane
 *             / \                      / \            p  the edge on which the way round, from corner 0 to 1
 * and on,
 *        ----p---q---- plane     -----p---q-----         first crosses it
 *           /     \                  /     \          q  the edge on which it crosses back
 *          1-------2              1 o       2 o
 *
 *     1, 2 and two new ones        0 and two new ones   (whichever corner is the one alone)
 *     remain: two triangles        remain: one
 *
 * With edge p being that from corner p to the next, and [p] the new vertex on it, a polygon of c corners
 * becomes
 *
 *     0 .. p, [p], [q], q+1 .. c-1   if corner 0 is inside,    [p], p+1 .. q, [q]   if it is outside.
 *
 * So a corner's place follows from p and q alone, without branches: which way a triangle is cut cannot be
 * foreseen, and that is what clipping one by one spends its time on. A triangle that crosses more planes
 * takes one after another, each lane its own.
 *
 * What is rare is left to clip.c: triangles that cross all six planes; polygons that rounding has bent, so
 * that their edges cross a plane four times; new vertices beside the eye, where w is almost 0; what would be
 * no number; the far edge of the largest target. The pieces of several triangles come out mixed, which cannot
 * be seen in the picture: among equally near ones the lowest index wins. */
#include "base/bits16.h"
#include "raster/block.h"
#include "raster/triangles.h"

typedef sl_part_floats floats;
typedef sl_part_ints ints;

enum { MOST_PLANES = 5, MOST_CORNERS = 3 + MOST_PLANES };

#define INLINE \
    static inline __attribute__((always_inline)) /* so that the numbers of corners below are constants */

INLINE floats absolute(floats a) { return (floats)((ints)a & 0x7fffffff); }
INLINE floats negated_if(ints mask, floats a) { return (floats)((ints)a ^ (mask & INT32_MIN)); }

typedef struct {
    floats x, y, z, w;
    ints own; /* whether it is one of the triangle's, not a new one */
} vertex;

typedef struct {
    ints count;
    vertex corner[MOST_CORNERS];
} polygon;

INLINE void take_if(ints mask, vertex *to, const vertex *from) {
    to->x = sl_part_select_floats(mask, to->x, from->x);
    to->y = sl_part_select_floats(mask, to->y, from->y);
    to->z = sl_part_select_floats(mask, to->z, from->z);
    to->w = sl_part_select_floats(mask, to->w, from->w);
    to->own = sl_part_select(mask, to->own, from->own);
}

/* ---- planes, each lane its own ---- */

/* Masks: of w - x, w + x, w - y, w + y, z + w (or z alone) and w - z. */
typedef struct {
    ints along_y, along_z, minus, alone;
} plane_form;

INLINE plane_form form_of(const sl_pass_view *view, ints plane) {
    return (plane_form){(plane & (SL_CLIP_TOP | SL_CLIP_BOTTOM)) != 0,
                        (plane & (SL_CLIP_NEAR | SL_CLIP_FAR)) != 0,
                        (plane & (SL_CLIP_RIGHT | SL_CLIP_TOP | SL_CLIP_FAR)) != 0,
                        (plane == SL_CLIP_NEAR) & sl_part_int(view->inverse_w ? -1 : 0)};
}

INLINE floats plane_distance(const plane_form *f, const vertex *p) {
    floats along = sl_part_select_floats(f->along_z, sl_part_select_floats(f->along_y, p->x, p->y), p->z);
    return sl_part_select_floats(f->alone, negated_if(f->minus, along) + p->w, along);
}

INLINE void settle(const plane_form *f, vertex *p) {
    ints off = ~f->alone & (absolute(plane_distance(f, p)) > 1e-4f * absolute(p->w));
    floats on_plane = negated_if(~f->minus, p->w);
    p->x = sl_part_select_floats(off & ~(f->along_y | f->along_z), p->x, on_plane);
    p->y = sl_part_select_floats(off & f->along_y, p->y, on_plane);
    p->z = sl_part_select_floats(off & f->along_z, p->z, on_plane);
}

typedef struct {
    vertex corner;
    floats d; /* its distance from the plane */
} edge_end;

INLINE void take_end_if(ints mask, edge_end *to, const vertex *v, floats d) {
    take_if(mask, &to->corner, v);
    to->d = sl_part_select_floats(mask, to->d, d);
}

/* The new vertex on the edge between a and b, one of which is outside: from the nearer one; where both are as
 * near, from the one inside. */
INLINE vertex cut_edge(const plane_form *f, const edge_end *a, const edge_end *b, ints *beside_eye) {
    ints from_a =
        sl_part_select(a->d < 0.0f, absolute(a->d) <= absolute(b->d), absolute(a->d) < absolute(b->d));
    edge_end from = *b, to = *a;
    take_end_if(from_a, &from, &a->corner, a->d);
    take_end_if(from_a, &to, &b->corner, b->d);
    const vertex *v = &from.corner, *w = &to.corner;
    floats t = from.d / (from.d - to.d);
    vertex p = {v->x + t * (w->x - v->x), v->y + t * (w->y - v->y), v->z + t * (w->z - v->z),
                v->w + t * (w->w - v->w), sl_part_int(0)};
    *beside_eye = ~(absolute(p.w) > 1e-3f * (absolute(v->w) + absolute(w->w)));
    settle(f, &p);
    return p;
}

/* ---- polygons ---- */

/* Polygons of at most n corners by a plane (0: by none, the polygon stays); at most n + 1 corners are left.
 * Returns which are doubtful. */
INLINE ints clip_by_plane(const sl_pass_view *view, ints plane, const polygon *old, int n, polygon *new) {
    const plane_form form = form_of(view, plane);
    const vertex *v = old->corner;
    const ints none = sl_part_int(MOST_CORNERS);
    floats d[MOST_CORNERS];
    ints in[MOST_CORNERS], p = none, q = none, crossings = sl_part_int(0), p_beside, q_beside;
    for (int i = 0; i < n; i++) {
        d[i] = plane_distance(&form, &v[i]);
        in[i] = (d[i] >= 0.0f) | (plane == 0);
    }
    for (int i = 0; i < n; i++) {
        ints next = i + 1 < n ? sl_part_select(old->count == i + 1, in[i + 1], in[0]) : in[0];
        ints crosses = (in[i] ^ next) & (old->count > i);
        p = sl_part_select(crosses & (p == none), p, sl_part_int(i));
        q = sl_part_select(crosses, q, sl_part_int(i));
        crossings -= crosses;
    }
    edge_end before_p = {v[0], d[0]}, after_p = {v[1], d[1]}, before_q = {v[1], d[1]}, after_q = {v[2], d[2]};
    for (int i = 1; i < n - 1; i++) { /* p is at most n - 2 */
        take_end_if(p == i, &before_p, &v[i], d[i]);
        take_end_if(p == i, &after_p, &v[i + 1], d[i + 1]);
    }
    for (int i = 2; i < n; i++) { /* q is at least 1 */
        const int next = i + 1 < n ? i + 1 : 0;
        take_end_if(q == i, &before_q, &v[i], d[i]);
        take_end_if(q == i, &after_q, &v[next], d[next]);
        if (next) take_end_if((q == i) & (old->count == next), &after_q, &v[0], d[0]);
    }
    const vertex new_p = cut_edge(&form, &before_p, &after_p, &p_beside);
    const vertex new_q = cut_edge(&form, &before_q, &after_q, &q_beside);

    const ints place_p = sl_part_select(in[0], sl_part_int(0), p + 1),
               place_q = sl_part_select(in[0], q - p + 1, p + 2);
    for (int j = 0; j <= n; j++) {
        ints from = j + sl_part_select(in[0], p, (p < j) & (q - p - 2));
        vertex *to = &new->corner[j];
        *to = v[j < n ? j : n - 1]; /* of the old corners, only the last can come last */
        for (int i = j < 3 ? j + 1 : j - 1; i < n; i++) {
            if (i != j) take_if(from == i, to, &v[i]);
        }
        if (j < n) take_if(place_p == j, to, &new_p);
        if (j > 1) take_if(place_q == j, to, &new_q);
    }
    ints uncut = in[0] & old->count, cut = sl_part_select(in[0], q - p + 2, old->count + p - q + 2);
    new->count = sl_part_select(p == none, cut, uncut);
    return (crossings > 2) | ((p != none) & (p_beside | q_beside));
}

/* ---- windows ---- */

typedef struct {
    floats x, y, depth;
    ints u, v;
} window;

/* fma(a, b, c) in the lanes asked for. */
INLINE floats fused(ints asked, floats a, float b, float c) {
#if defined __AVX512DQ__
    (void)asked;
    return (floats)_mm512_fmadd_ps((__m512)a, _mm512_set1_ps(b), _mm512_set1_ps(c));
#elif defined __AVX2__
    (void)asked;
    return (floats)_mm256_fmadd_ps((__m256)a, _mm256_set1_ps(b), _mm256_set1_ps(c));
#else
    for (int l = 0; l < SL_PART; l++) {
        if (asked[l]) a[l] = fmaf(a[l], b, c); /* a call, on machines without */
    }
    return a;
#endif
}

/* The triangles' own corners as in transform_kernels.c, new ones without fused operations and kept near the
 * view. */
INLINE floats place(floats x, ints own, float half, float offset) {
    floats low = sl_part_float(offset - half - 1.0f), high = sl_part_float(offset + half + 1.0f),
           at = x * half + offset;
    at = sl_part_select_floats(at < low, at, low);
    at = sl_part_select_floats(at > high, at, high);
    return sl_part_select_floats(own, at, fused(own, x, half, offset));
}

/* To 1/256 pixel, to even on a tie, as in transform_kernels.c; for |x| < SL_RASTER_MAX_SIZE. */
INLINE ints snap(floats x) { return ((ints)((x - 0.5f) * 256.0f + 12582912.0f) & 0x7fffff) - 0x400000; }

INLINE window to_window(const sl_pass_view *view, const vertex *p) {
    floats oow = 1.0f / p->w;
    window q = {.x = place(p->x * oow, p->own, view->half_width, view->offset_x),
                .y = place(p->y * oow, p->own, view->half_height, view->offset_y),
                .depth = view->inverse_w ? oow : (p->z * oow) * 0.5f + 0.5f};
    if (view->rule == SL_NEARER_IS_SMALLER) {
        q.depth = sl_part_select_floats(q.depth > 0.0f, sl_part_float(0.0f), q.depth);
        q.depth = sl_part_select_floats(q.depth > 1.0f, q.depth, sl_part_float(1.0f));
    }
    q.u = snap(q.x);
    q.v = snap(q.y);
    return q;
}

/* All the corners; returns which polygons hold a pixel centre in their box. Beside the eye, and where there
 * is no number to be had, it is doubtful. */
INLINE ints find_windows(const sl_pass_view *view, polygon *polygons, int n, window *windows, floats *largest,
                         ints *doubtful) {
    ints low_x = sl_part_int(INT32_MAX), high_x = sl_part_int(INT32_MIN), low_y = low_x, high_y = high_x;
    const float limit = (float)SL_RASTER_MAX_SIZE;
    *largest = sl_part_float(0.0f);
    for (int j = 0; j < n; j++) {
        vertex *p = &polygons->corner[j];
        const ints there = polygons->count > j;
        ints usable = p->w > 1e-30f;
        p->w = sl_part_select_floats(usable, sl_part_float(1.0f), p->w);
        windows[j] = to_window(view, p);
        usable &= (absolute(windows[j].x) < limit) & (absolute(windows[j].y) < limit) &
                  (absolute(windows[j].depth) < 1e30f);
        *doubtful |= there & ~usable;
        *largest = sl_part_select_floats(there & (windows[j].depth > *largest), *largest, windows[j].depth);
        ints x = (windows[j].u + 255) >> 8, y = (windows[j].v + 255) >> 8;
        low_x = sl_part_select(there & (x < low_x), low_x, x);
        low_y = sl_part_select(there & (y < low_y), low_y, y);
        high_x = sl_part_select(there & (x > high_x), high_x, x);
        high_y = sl_part_select(there & (y > high_y), high_y, y);
    }
    return (low_x < high_x) & (low_y < high_y);
}

/* ---- thin triangles: find_span() of clip.c ---- */

typedef struct {
    float x[3][SL_PART], y[3][SL_PART], depth[3][SL_PART];
} corners;

static inline double larger(double a, double b) { return a > b ? a : b; }

static void find_thin(const corners *restrict c, int32_t *restrict thin) {
#pragma omp simd
    for (int l = 0; l < SL_PART; l++) {
        double x0 = (double)c->x[0][l], y0 = (double)c->y[0][l];
        double x1 = (double)c->x[1][l] - x0, x2 = (double)c->x[2][l] - x0;
        double y1 = (double)c->y[1][l] - y0, y2 = (double)c->y[2][l] - y0;
        double wide = larger(larger(fabs(x1), fabs(x2)), fabs(x2 - x1)),
               high = larger(larger(fabs(y1), fabs(y2)), fabs(y2 - y1));
        thin[l] = fabs(x1 * y2 - x2 * y1) < larger(wide, high) ? -1 : 0;
    }
}

/* Returns which depth planes go through the triangle's corners, and these. */
INLINE ints find_span(const sl_pass_view *view, const vertex triangle[3], floats largest, corners *span) {
    int32_t thin[SL_PART];
    ints usable = sl_part_int(-1);
    for (int k = 0; k < 3; k++) {
        const vertex *p = &triangle[k];
        ints before = p->w > 0.0f;
        floats oow = 1.0f / sl_part_select_floats(before, sl_part_float(1.0f), p->w);
        floats x = (p->x * oow) * view->half_width + view->offset_x,
               y = (p->y * oow) * view->half_height + view->offset_y;
        floats depth = view->inverse_w ? oow : (p->z * oow) * 0.5f + 0.5f;
        usable &= before & (absolute(x) + absolute(y) < 1e9f) & (absolute(depth) <= 4.0f * largest);
        memcpy(span->x[k], &x, sizeof x);
        memcpy(span->y[k], &y, sizeof y);
        memcpy(span->depth[k], &depth, sizeof depth);
    }
    find_thin(span, thin);
    return usable & sl_part_load_ints(thin);
}

/* ---- in and out ---- */

/* Some lanes, packed one behind the other. Writes SL_PART in any case. */
INLINE void pack(uint32_t bits, ints a, void *to) {
#if defined __AVX512DQ__
    _mm512_storeu_si512(to, _mm512_maskz_compress_epi32((__mmask16)bits, (__m512i)a));
#else
    int32_t lanes[SL_PART], *packed = to;
    sl_part_store(lanes, a);
    for (uint32_t l = 0; l < SL_PART; l++) {
        *packed = lanes[l];
        packed += bits >> l & 1;
    }
#endif
}

/* The corners of SL_PART triangles. */
typedef struct {
    float x[3][SL_PART], y[3][SL_PART], z[3][SL_PART], w[3][SL_PART];
    int32_t codes[SL_PART], id[SL_PART];
    uint32_t masked; /* a bit each */
} fetched;

static void fetch(const sl_raster *r, uint32_t first, const sl_vertex_buffer *b, const uint8_t *list,
                  uint32_t count, fetched *f) {
    f->masked = 0;
    for (uint32_t l = 0; l < count; l++) {
        const uint32_t t = first + list[l];
        int32_t codes = 0;
        for (int k = 0; k < 3; k++) {
            const uint16_t i = r->corner[k][t];
            f->x[k][l] = b->x[i];
            f->y[k][l] = b->y[i];
            f->z[k][l] = b->z[i];
            f->w[k][l] = b->w[i];
            codes |= b->code[i];
        }
        f->codes[l] = codes;
        f->id[l] = (int32_t)r->triangle[t];
        if (r->masked) f->masked |= (uint32_t)r->triangle_masked[t] << l;
    }
}

/* Clears lanes without a triangle: what they compute does not matter, but it shall be of numbers. */
INLINE void clear(fetched *f) {
    const ints zero = sl_part_int(0);
    for (int k = 0; k < 3; k++) {
        sl_part_store(f->x[k], zero);
        sl_part_store(f->y[k], zero);
        sl_part_store(f->z[k], zero);
        sl_part_store(f->w[k], zero);
    }
    sl_part_store(f->codes, zero);
    sl_part_store(f->id, zero);
}

static void append_masks(uint32_t masked, uint32_t bits, uint8_t *to) {
    memset(to, 0, SL_PART);
    for (uint32_t left = masked ? bits : 0; left; left &= left - 1) *to++ = masked >> __builtin_ctz(left) & 1;
}

/* The fan's triangles (i - 1, i, 0) of the polygons that have a corner i. */
INLINE void append_fans(const fetched *f, const window *windows, int n, ints count, ints spanned,
                        const corners *span, sl_triangle_batch *batch) {
    for (int i = 2; i < n; i++) {
        const uint32_t bits = sl_part_negative(count > i), t = batch->count;
        const window *corner[3] = {&windows[i - 1], &windows[i], &windows[0]};
        for (int k = 0; k < 3; k++) {
            const window *c = corner[k];
            pack(bits, (ints)sl_part_select_floats(spanned, c->x, sl_part_load_floats(span->x[k])),
                 &batch->x[k][t]);
            pack(bits, (ints)sl_part_select_floats(spanned, c->y, sl_part_load_floats(span->y[k])),
                 &batch->y[k][t]);
            pack(bits, (ints)sl_part_select_floats(spanned, c->depth, sl_part_load_floats(span->depth[k])),
                 &batch->depth[k][t]);
            pack(bits, c->u, &batch->snapped_u[k][t]);
            pack(bits, c->v, &batch->snapped_v[k][t]);
        }
        pack(bits, sl_part_load_ints(f->id), &batch->id[t]);
        append_masks(f->masked, bits, &batch->masked[t]);
        batch->count += sl_bits16_count(bits);
    }
}

/* ---- the whole ---- */

/* The first `count` lanes, which cross at most `planes` planes. Returns those left to clip.c. */
INLINE uint32_t clip_part(const sl_pass_view *view, const fetched *f, uint32_t count, int planes,
                          sl_triangle_batch *batch) {
    const ints asked = sl_part_lane() < (int32_t)count;
    vertex triangle[3];
    polygon polygons[MOST_PLANES + 1];
    polygons[0].count = sl_part_int(3);
    for (int k = 0; k < 3; k++) {
        triangle[k] = (vertex){sl_part_load_floats(f->x[k]), sl_part_load_floats(f->y[k]),
                               sl_part_load_floats(f->z[k]), sl_part_load_floats(f->w[k]), sl_part_int(-1)};
        polygons[0].corner[k] = triangle[k];
    }
    ints codes = sl_part_load_ints(f->codes), doubtful = sl_part_int(0);
    for (int n = 0; n < planes; n++) {
        doubtful |= clip_by_plane(view, codes & -codes, &polygons[n], 3 + n, &polygons[n + 1]);
        codes &= codes - 1;
    }
    doubtful |= codes != 0;
    window windows[MOST_CORNERS];
    floats largest;
    corners span;
    ints seen = find_windows(view, &polygons[planes], 3 + planes, windows, &largest, &doubtful);
    ints drawn = asked & seen & ~doubtful;
    if (sl_part_negative(drawn)) {
        ints spanned = find_span(view, triangle, largest, &span);
        if (view->rule == SL_OPENGL_PLANE) spanned = sl_part_int(0);
        append_fans(f, windows, 3 + planes, drawn & polygons[planes].count, spanned, &span, batch);
    }
    return sl_part_negative(asked & doubtful);
}

uint32_t SL_KERNEL(sl_raster_clip)(const sl_raster *r, uint32_t first, const sl_pass_view *view,
                                   const sl_vertex_buffer *vertices, const uint8_t *list, uint32_t count,
                                   sl_triangle_batch *batch) {
    /* four lanes, without fused operations, gain nothing over clip.c */
    if (SL_PART == 4) return (1u << count) - 1u;
    uint32_t left = 0;
    fetched f;
    clear(&f);
    for (uint32_t n = 0; n < count; n += SL_PART) {
        const uint32_t here = count - n < SL_PART ? count - n : SL_PART;
        fetch(r, first, vertices, list + n, here, &f);
        int planes = 1;
        const ints codes = sl_part_load_ints(f.codes);
        for (ints more = codes & (codes - 1); planes < MOST_PLANES && sl_part_negative(more != 0);
             more &= more - 1)
            planes++;
        uint32_t doubtful;
        switch (planes) {
        case 1: doubtful = clip_part(view, &f, here, 1, batch); break;
        case 2: doubtful = clip_part(view, &f, here, 2, batch); break;
        case 3: doubtful = clip_part(view, &f, here, 3, batch); break;
        default: doubtful = clip_part(view, &f, here, MOST_PLANES, batch); break;
        }
        left |= doubtful << n;
    }
    return left;
}
