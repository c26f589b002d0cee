/* Clipping: Sutherland and Hodgman 1974, plane by plane in clip space, before the division by w, so that
 * vertices behind the eye need no special case. Arithmetic and order are llvmpipe's (Mesa's draw module).
 *
 * A new vertex is found from the end of the edge that lies nearer to the plane, whichever way the edge is
 * walked, so the two triangles that share an edge get the same new vertex, and no pixel between them is lost
 * or drawn twice. */
#include <math.h>

#include "raster/triangles.h"

enum { POLYGON_MAX = 3 + SL_CLIP_PLANES };

typedef struct {
    float x, y, z, w;
    int32_t original; /* index of the vertex in the buffer, or -1 for a new one */
    int plane;        /* a new one's, on which it lies */
} clip_vertex;

static float plane_distance(const sl_pass_view *view, int plane, const clip_vertex *p) {
    switch (plane) {
    case 0: return -p->x + p->w;
    case 1: return p->x + p->w;
    case 2: return -p->y + p->w;
    case 3: return p->y + p->w;
    case 4: return view->inverse_w ? p->z : p->z + p->w;
    default: return -p->z + p->w;
    }
}

static clip_vertex interpolate(const clip_vertex *from, const clip_vertex *to, float t, int plane) {
    return (clip_vertex){from->x + t * (to->x - from->x), from->y + t * (to->y - from->y),
                         from->z + t * (to->z - from->z), from->w + t * (to->w - from->w), -1, plane};
}

/* Where the ends are thousands of times further out than the plane, rounding can leave the new vertex visibly
 * off it; then its coordinate is taken from the plane's equation. In all other cases the interpolated value
 * stands, as in llvmpipe. */
static void settle(const sl_pass_view *view, clip_vertex *p) {
    const float visible = 1e-4f;
    if (p->original >= 0 || !(fabsf(plane_distance(view, p->plane, p)) > visible * fabsf(p->w))) return;
    switch (p->plane) {
    case 0: p->x = p->w; break;
    case 1: p->x = -p->w; break;
    case 2: p->y = p->w; break;
    case 3: p->y = -p->w; break;
    case 4: p->z = view->inverse_w ? p->z : -p->w; break;
    default: p->z = p->w; break;
    }
}

/* Beside the eye, where w is almost 0 between ends before and behind, nothing is visible: later planes cut
 * the new vertex off, and what they cut from its edges shall have llvmpipe's bits. */
static clip_vertex cut_edge(const sl_pass_view *view, int plane, const clip_vertex *outside, float d_outside,
                            const clip_vertex *inside, float d_inside) {
    clip_vertex p = -d_outside < d_inside
                        ? interpolate(outside, inside, d_outside / (d_outside - d_inside), plane)
                        : interpolate(inside, outside, d_inside / (d_inside - d_outside), plane);
    if (fabsf(p.w) > 1e-3f * (fabsf(outside->w) + fabsf(inside->w))) settle(view, &p);
    return p;
}

static int clip_by_plane(const sl_pass_view *view, int plane, const clip_vertex *in, int count,
                         clip_vertex *out) {
    int made = 0;
    const clip_vertex *p = &in[0];
    float d = plane_distance(view, plane, p);
    for (int i = 1; i <= count; i++) {
        const clip_vertex *next = &in[i < count ? i : 0];
        float d_next = plane_distance(view, plane, next);
        if (d >= 0.0f && made < POLYGON_MAX) out[made++] = *p;
        if (d >= 0.0f && d_next < 0.0f && made < POLYGON_MAX)
            out[made++] = cut_edge(view, plane, next, d_next, p, d);
        if (d < 0.0f && d_next >= 0.0f && made < POLYGON_MAX)
            out[made++] = cut_edge(view, plane, p, d, next, d_next);
        p = next;
        d = d_next;
    }
    return made;
}

/* ---- viewport of clipped polygons ---- */

typedef struct {
    float x, y, depth;
    int32_t snapped_u, snapped_v;
    bool finite;
} window_vertex;

/* Where coordinates differ by many orders of magnitude, rounding may leave a cut vertex a little outside; a
 * pixel's margin keeps it representable. */
static float keep_near(float x, float middle, float half) {
    float low = middle - half - 1.0f, high = middle + half + 1.0f;
    return x < low ? low : x > high ? high : x;
}

static window_vertex to_window(const sl_pass_view *view, const sl_vertex_buffer *buffer,
                               const clip_vertex *p) {
    window_vertex q = {.finite = p->w >= SL_LEAST_W};
    if (p->original >= 0 && buffer->code[p->original] == 0) {
        int32_t i = p->original;
        return (window_vertex){buffer->window_x[i],  buffer->window_y[i],  buffer->depth[i],
                               buffer->snapped_u[i], buffer->snapped_v[i], true};
    }
    if (!q.finite) return q;
    float oow = 1.0f / p->w;
    float x = (p->x * oow) * view->half_width + view->offset_x,
          y = (p->y * oow) * view->half_height + view->offset_y;
    float depth = (p->z * oow) * 0.5f + 0.5f;
    q.x = keep_near(x, view->offset_x, view->half_width);
    q.y = keep_near(y, view->offset_y, view->half_height);
    /* OSMesa bounds the depths of pixels only; its plane goes through the corners as they come. */
    if (view->rule != SL_OPENGL_PLANE) depth = depth < 0.0f ? 0.0f : depth > 1.0f ? 1.0f : depth;
    q.depth = view->inverse_w ? oow : depth;
    q.finite = isfinite(q.x) && isfinite(q.y) && isfinite(q.depth);
    if (q.finite) {
        q.snapped_u = (int32_t)lrintf((q.x - 0.5f) * 256.0f);
        q.snapped_v = (int32_t)lrintf((q.y - 0.5f) * 256.0f);
    }
    return q;
}

static double largest3(double a, double b, double c) { return fmax(fmax(a, b), c); }

/* Of a triangle less than a pixel thin the pieces' own corners, rounded on the way and close together, span
 * no plane worth the name. The triangle's three do, if all are before the eye and not so much nearer than
 * what is left of it that their rounding errors would show there. OSMesa takes the pieces' own. */
static bool find_span(const sl_pass_view *view, const clip_vertex triangle[3], const window_vertex *left,
                      int count, window_vertex span[3]) {
    float largest = 0.0f;
    if (view->rule == SL_OPENGL_PLANE) return false;
    for (int i = 0; i < count; i++)
        largest = left[i].finite && left[i].depth > largest ? left[i].depth : largest;
    for (int k = 0; k < 3; k++) {
        const clip_vertex *p = &triangle[k];
        if (!(p->w > 0.0f)) return false;
        float oow = 1.0f / p->w;
        span[k].x = (p->x * oow) * view->half_width + view->offset_x;
        span[k].y = (p->y * oow) * view->half_height + view->offset_y;
        span[k].depth = view->inverse_w ? oow : (p->z * oow) * 0.5f + 0.5f;
        if (!(fabsf(span[k].x) + fabsf(span[k].y) < 1e9f && fabsf(span[k].depth) <= 4.0f * largest))
            return false;
    }
    double x1 = (double)span[1].x - (double)span[0].x, x2 = (double)span[2].x - (double)span[0].x;
    double y1 = (double)span[1].y - (double)span[0].y, y2 = (double)span[2].y - (double)span[0].y;
    return fabs(x1 * y2 - x2 * y1) <
           fmax(largest3(fabs(x1), fabs(x2), fabs(x2 - x1)), largest3(fabs(y1), fabs(y2), fabs(y2 - y1)));
}

/* span: NULL, or what the depth plane goes through. */
static bool append(sl_triangle_batch *batch, const window_vertex *a, const window_vertex *b,
                   const window_vertex *c, const window_vertex *span) {
    const window_vertex *corner[3] = {a, b, c};
    for (int k = 0; k < 3; k++) {
        if (!corner[k]->finite) return false;
    }
    uint32_t t = batch->count++;
    for (int k = 0; k < 3; k++) {
        const window_vertex *plane = span ? &span[k] : corner[k];
        batch->x[k][t] = plane->x;
        batch->y[k][t] = plane->y;
        batch->depth[k][t] = plane->depth;
        batch->snapped_u[k][t] = corner[k]->snapped_u;
        batch->snapped_v[k][t] = corner[k]->snapped_v;
    }
    return true;
}

/* Tells whether the box around what is left holds a pixel centre. */
static bool holds_centre(const window_vertex *window, int count) {
    int32_t low_u = INT32_MAX, high_u = INT32_MIN, low_v = INT32_MAX, high_v = INT32_MIN;
    for (int i = 0; i < count; i++) {
        const window_vertex *p = &window[i];
        if (!p->finite) continue;
        low_u = p->snapped_u < low_u ? p->snapped_u : low_u;
        high_u = p->snapped_u > high_u ? p->snapped_u : high_u;
        low_v = p->snapped_v < low_v ? p->snapped_v : low_v;
        high_v = p->snapped_v > high_v ? p->snapped_v : high_v;
    }
    return low_u <= high_u && (low_u + 255) >> 8 <= (high_u - 1) >> 8 &&
           (low_v + 255) >> 8 <= (high_v - 1) >> 8;
}

uint32_t sl_clip_triangle(const sl_pass_view *view, const sl_vertex_buffer *buffer, const uint16_t corner[3],
                          sl_triangle_batch *batch) {
    clip_vertex polygon[2][POLYGON_MAX], triangle[3];
    int32_t codes = 0;
    for (int k = 0; k < 3; k++) {
        uint16_t i = corner[k];
        polygon[0][k] = (clip_vertex){buffer->x[i], buffer->y[i], buffer->z[i], buffer->w[i], i, -1};
        triangle[k] = polygon[0][k];
        codes |= buffer->code[i];
    }
    int count = 3, now = 0;
    for (int plane = 0; plane < view->planes && count >= 3; plane++) {
        if (!(codes & 1 << plane)) continue;
        count = clip_by_plane(view, plane, polygon[now], count, polygon[1 - now]);
        now = 1 - now;
    }
    if (count < 3) return 0;
    window_vertex window[POLYGON_MAX];
    for (int i = 0; i < count; i++) {
        settle(view, &polygon[now][i]);
        window[i] = to_window(view, buffer, &polygon[now][i]);
    }
    if (!holds_centre(window, count)) return 0;
    window_vertex span[3];
    const bool spanned = find_span(view, triangle, window, count, span);
    uint32_t made = 0;
    for (int i = 2; i < count; i++)
        made += append(batch, &window[i - 1], &window[i], &window[0], spanned ? span : NULL);
    return made;
}
