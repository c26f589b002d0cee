/* A whole rasterizer in its plainest form: start here. One triangle after another, one pixel after another,
 * in the order of the pipeline:
 *
 *     1 transform    corners from the world into clip space
 *     2 clip codes   which planes of the view is a corner outside of? Triangles wholly outside one are done
 *     3 viewport     divide by w, scale to pixels, snap to 1/256 pixel
 *     4 clip         what crosses a plane is cut there
 *     5 set up       the triangle's edges and its depth, as functions of the pixel
 *     6 pixels       covered? nearer than what is there? then write triangle index and depth
 *
 * src/raster does the same thing fast: many triangles in the lanes of a vector, clusters of
 * triangles rejected whole, blocks of pixels, tiles for threads, near things first. All of that can be left
 * out without one bit of the picture changing; this file is what is left, and the tests hold it equal to the
 * fast path bit by bit.
 *
 * Clip space. A view's matrix takes a point to (x, y, z, w), w being its distance along the line of sight. On
 * the screen it is at (x/w, y/w), the screen's edges being at -1 and 1. Seen from above, w upwards, what
 * shows lies between two lines through the eye and beyond the near plane:
 *
 *          x = -w  \         w         /  x = w      before the division, "right of the screen" is x > w, a
 * comparison \        |        /              that is as good behind the eye as before it: that is why
 *                    \    shows      /               triangles are cut here, and not on the screen, where
 * points \      |      /                behind the eye (w < 0) come out upside down and points beside
 *                      \_____|_____/  near           it (w = 0) nowhere.
 *                            |
 *                 ----------eye---------- x
 */
#include "tests/raster/plain.h"

#include <math.h>

#include "raster/resolve/barycentrics.h"
#include "raster/triangles.h"

/* A corner on its way through steps 1 to 3. */
typedef struct {
    float x, y, z, w;          /* clip space */
    int code;                  /* SL_CLIP_..., one bit a plane */
    /* in pixels of the target, (0, 0) being the lower left pixel's lower left corner */
    float window_x, window_y;
    float depth;
    int32_t u, v;              /* window, in 1/256 pixel from the first pixel's centre */
} corner;

/* ---- 1 transform ----------------------------------------------------------------------------- */

/* Every product and sum is rounded to float by itself, in this order: another order would move some corner by
 * a rounding, and some pixel with it. */
static float times_row(const float row[4], float x, float y, float z) {
    return ((row[0] * x + row[1] * y) + row[2] * z) + row[3];
}

static void transform(const sl_pass_view *view, sl_vec3 p, corner *c) {
    float x = p.x - view->origin[0], y = p.y - view->origin[1], z = p.z - view->origin[2];
    c->x = times_row(view->clip[0], x, y, z);
    c->y = times_row(view->clip[1], x, y, z);
    c->z = times_row(view->clip[2], x, y, z);
    c->w = times_row(view->clip[3], x, y, z);
}

/* ---- 2 clip codes ---------------------------------------------------------------------------- */

/* NaN, infinities, and what is so large that differences would overflow: such triangles are dropped. A view
 * with 1/w depth has its near plane in z alone, and no far plane. A corner at the eye (so near that 1/w is
 * not finite) counts as before the near plane; one behind it is outside a side, but an oblique near plane
 * (mirrors' views have them) may lie further back. */
static void find_code(const sl_pass_view *view, corner *c) {
    c->code = 0;
    if (c->x > c->w) c->code |= SL_CLIP_RIGHT;
    if (c->x + c->w < 0.0f) c->code |= SL_CLIP_LEFT;
    if (c->y > c->w) c->code |= SL_CLIP_TOP;
    if (c->y + c->w < 0.0f) c->code |= SL_CLIP_BOTTOM;
    if ((view->inverse_w ? c->z : c->z + c->w) < 0.0f || (!c->code && !(c->w >= SL_LEAST_W)))
        c->code |= SL_CLIP_NEAR;
    if (!view->inverse_w && c->z > c->w) c->code |= SL_CLIP_FAR;
    if (!(fabsf(c->x) + fabsf(c->y) + fabsf(c->z) + fabsf(c->w) < 0x1p60f)) c->code = SL_CLIP_INVALID;
}

/* ---- 3 viewport ------------------------------------------------------------------------------ */

/* Snapping. Corners come to lie on a grid of 256 x 256 points a pixel; u and v are whole numbers, and from
 * here on the question which pixels are inside is one of integers, answered without any rounding.
 *
 *      +-----------+-----------+      x  a pixel's centre, where it is sampled. Pixel (i, j) has it at
 *      |           |           |         (u, v) = (256 i, 256 j), half a pixel from the corner that window_x
 *      |     x     |     x     |         and window_y count from
 *      |   (0,1)   |   (1,1)   |      .  some of the 256 x 256 points between: a corner goes to the nearest,
 *      +-----------+-----------+         in the middle of two to the even one. Two triangles that share a
 *      |           |           |         corner share it still.
 *      |     x . . | . . x     |
 *      |   (0,0)   |   (1,0)   |
 *      +-----------+-----------+  */
static void to_window(const sl_pass_view *view, corner *c) {
    float oow = 1.0f / c->w;
    c->window_x = fmaf(c->x * oow, view->half_width, view->offset_x);
    c->window_y = fmaf(c->y * oow, view->half_height, view->offset_y);
    c->u = (int32_t)lrintf((c->window_x - 0.5f) * 256.0f);
    c->v = (int32_t)lrintf((c->window_y - 0.5f) * 256.0f);
    float z = fmaf(c->z * oow, 0.5f, 0.5f); /* -1 (near) .. 1 (far) to 0 .. 1 */
    if (view->rule != SL_OPENGL_PLANE) { /* OSMesa bounds the pixels' depths only */
        z = z > 0.0f ? z : 0.0f;
        z = z < 1.0f ? z : 1.0f;
    }
    c->depth = view->inverse_w ? oow : z;
}

/* ---- 4 clip ---------------------------------------------------------------------------------- */

/* Cutting a triangle by up to six planes leaves a polygon of up to nine corners, drawn as a fan of triangles.
 * clip.c is plain as it stands; this only hands over the corners and takes the pieces back. */
static uint32_t clip(const sl_pass_view *view, const corner c[3], corner pieces[SL_CLIP_TRIANGLES][3]) {
    const uint16_t all_three[3] = {0, 1, 2};
    sl_vertex_buffer buffer;
    sl_triangle_batch fan;
    fan.count = 0;
    for (int k = 0; k < 3; k++) {
        buffer.x[k] = c[k].x, buffer.y[k] = c[k].y, buffer.z[k] = c[k].z, buffer.w[k] = c[k].w;
        buffer.window_x[k] = c[k].window_x, buffer.window_y[k] = c[k].window_y, buffer.depth[k] = c[k].depth;
        buffer.snapped_u[k] = c[k].u, buffer.snapped_v[k] = c[k].v, buffer.code[k] = c[k].code;
    }
    uint32_t count = sl_clip_triangle(view, &buffer, all_three, &fan);
    for (uint32_t n = 0; n < count; n++) {
        for (int k = 0; k < 3; k++) {
            pieces[n][k] = (corner){.window_x = fan.x[k][n],
                                    .window_y = fan.y[k][n],
                                    .depth = fan.depth[k][n],
                                    .u = fan.snapped_u[k][n],
                                    .v = fan.snapped_v[k][n]};
        }
    }
    return count;
}

/* ---- 5 set up -------------------------------------------------------------------------------- */

/* Twice the area, positive for counter-clockwise corners. */
static int64_t area_of(const corner c[3]) {
    return (int64_t)(c[1].u - c[0].u) * (c[2].v - c[0].v) - (int64_t)(c[2].u - c[0].u) * (c[1].v - c[0].v);
}

/* Depth is linear on the screen: z/w for what OpenGL stores, and 1/w. */
typedef struct {
    float du, dv;               /* per 1/256 pixel; per pixel in OpenGL's form */
    float origin;               /* at (origin_u, origin_v); at the target's first pixel in OpenGL's form */
    int32_t origin_u, origin_v;
    float least, most;          /* of the corners: the slope of a sliver may be wild, its depth is not */
    bool steep;                 /* float is not enough: in double, from the first corner */
    double steep_du, steep_dv, u, v, z;
} depth_plane;

/* Through the three corners before snapping, in double, told at the corner of the least depth: for 1/w that
 * is the far end, where an error would hurt most. */
static depth_plane depth_through(const corner c[3], bool inverse_w) {
    double u[3], v[3];
    for (int k = 0; k < 3; k++) {
        u[k] = (double)((c[k].window_x - 0.5f) * 256.0f);
        v[k] = (double)((c[k].window_y - 0.5f) * 256.0f);
    }
    double du1 = u[1] - u[0], dv1 = v[1] - v[0], dz1 = (double)c[1].depth - (double)c[0].depth;
    double du2 = u[2] - u[0], dv2 = v[2] - v[0], dz2 = (double)c[2].depth - (double)c[0].depth;
    double area = du1 * dv2 - dv1 * du2, over = 1.0 / (area != 0.0 ? area : 1.0);
    double du = (dz1 * dv2 - dz2 * dv1) * over, dv = (dz2 * du1 - dz1 * du2) * over;
    if (area == 0.0 || !(fabs(du) < 1e20) || !(fabs(dv) < 1e20)) du = dv = 0.0;
    int lowest = c[1].depth < c[0].depth ? 1 : 0;
    if (c[2].depth < c[lowest].depth) lowest = 2;
    depth_plane p = {.du = (float)du, .dv = (float)dv, .origin_u = c[lowest].u, .origin_v = c[lowest].v};
    p.origin =
        (float)((double)c[0].depth + (du * ((double)p.origin_u - u[0]) + dv * ((double)p.origin_v - v[0])));
    /* of what was clipped, corners may lie outside the view */
    p.least = c[lowest].depth > 0.0f ? c[lowest].depth : 0.0f;
    p.most = c[0].depth > c[1].depth ? c[0].depth : c[1].depth;
    if (c[2].depth > p.most) p.most = c[2].depth;
    if (!inverse_w && p.most > 1.0f) p.most = 1.0f;
    p.steep = fabs(du) * (fabs(du1) + fabs(du2)) + fabs(dv) * (fabs(dv1) + fabs(dv2)) > 8.0 * (double)p.most;
    p.steep_du = du, p.steep_dv = dv, p.u = u[0], p.v = v[0], p.z = (double)c[0].depth;
    return p;
}

/* OSMesa's way, for comparing with it bit by bit: in float, told at the target's corner, which may lie far
 * from the triangle. */
static depth_plane opengl_depth_through(const corner c[3]) {
    const corner *p0 = area_of(c) > 0 ? &c[1] : &c[0], *p1 = area_of(c) > 0 ? &c[0] : &c[1], *p2 = &c[2];
    float dx01 = p0->window_x - p1->window_x, dy01 = p0->window_y - p1->window_y,
          dz01 = p0->depth - p1->depth;
    float dx20 = p2->window_x - p0->window_x, dy20 = p2->window_y - p0->window_y,
          dz20 = p2->depth - p0->depth;
    float ooa = 1.0f / (dx01 * dy20 - dy01 * dx20);
    depth_plane p = {.least = 0.0f, .most = 1.0f};
    p.du = dz01 * (dy20 * ooa) - dz20 * (dy01 * ooa);
    p.dv = dz20 * (dx01 * ooa) - dz01 * (dx20 * ooa);
    p.origin = p0->depth - (p.du * (p0->window_x - 0.5f) + p.dv * (p0->window_y - 0.5f));
    return p;
}

/* ---- 6 pixels -------------------------------------------------------------------------------- */

/* The edge from P to Q has the function E(u, v) = (v_P - v_Q)(u - u_P) + (u_Q - u_P)(v - v_P): 0 on the line,
 * positive to the left of the way from P to Q. Inside the triangle all three are positive (once their signs
 * are turned by the area's).
 *
 *            2          The fill rule. A pixel's centre right on an edge, E = 0, must belong to one of the
 *           /|          two triangles that share the edge, never to both or none. It belongs to the triangle
 *    left  / |          that has it as a left edge (the inside lies towards larger u) or as a lowest
 *   (owns)/  | right    horizontal one (the inside lies above): of the two triangles, just one. So it is with
 *        /   | (not)    the points of a closed mesh: every pixel is drawn once in every layer.
 *       0----1
 *      lowest (owns)  */
static bool covers(const corner c[3], int64_t area, int64_t u, int64_t v) {
    for (int k = 0; k < 3; k++) {
        const corner *p = &c[(k + 1) % 3], *q = &c[(k + 2) % 3];
        int64_t a = p->v - q->v, b = q->u - p->u, e = a * (u - p->u) + b * (v - p->v);
        if (area < 0) a = -a, b = -b, e = -e;
        bool owns = a > 0 || (a == 0 && b > 0);
        if (e < 0 || (e == 0 && !owns)) return false;
    }
    return true;
}

static float depth_at(const depth_plane *p, bool opengl, int i, int j) {
    float z = opengl ? fmaf(p->dv, (float)j, fmaf(p->du, (float)i, p->origin))
                     : (p->origin + p->dv * (float)(256 * j - p->origin_v)) +
                           p->du * (float)(256 * i - p->origin_u);
    if (p->steep)
        z = (float)(p->z +
                    (p->steep_du * ((double)(256 * i) - p->u) + p->steep_dv * ((double)(256 * j) - p->v)));
    z = z < p->least ? p->least : z;
    return z > p->most ? p->most : z;
}

/* A triangle's alpha mask, looked up at the pixel's perspective-correct weights. */
static bool opaque_at(const sl_raster_mesh *mesh, const sl_scene *masks, const sl_view *view,
                      const sl_pass_view *pass, uint32_t t, int i, int j) {
    sl_vec3 q[3];
    float w1, w2;
    if (!masks || !sl_scene_has_alpha(masks, t)) return true;
    for (int k = 0; k < 3; k++) q[k] = sl_sub(sl_mesh_position(mesh, mesh->vertex[k][t]), view->origin);
    const sl_edge_lines lines = sl_edge_lines_make(pass, q[0], q[1], q[2]);
    sl_weights_at(&lines, i - view->x, j - view->y, &w1, &w2);
    return sl_scene_is_opaque(masks, t, w1, w2);
}

typedef struct {
    const sl_raster_mesh *mesh;
    const sl_scene *masks;
    const sl_view *view;
    sl_pass_view pass; /* the view's constants: size, offset, region to draw */
    const sl_target *target;
    const float *number; /* where layers are counted, without a depth test; else NULL */
    float *sums;
} picture;

static int32_t least_of(int32_t a, int32_t b, int32_t c) { return a < b ? (a < c ? a : c) : (b < c ? b : c); }
static int floor_of(int32_t u) { return (u - (u & 255)) / 256; } /* of u / 256 */

/* The depth test: nearer wins; what is as near as the pixel already is comes too late. */
static void draw_pixels(const picture *p, uint32_t t, const corner c[3]) {
    int64_t area = area_of(c);
    if (area == 0) return;
    bool opengl = p->pass.rule == SL_OPENGL_PLANE;
    depth_plane plane = opengl ? opengl_depth_through(c) : depth_through(c, p->pass.inverse_w);
    int x0 = sl_larger(floor_of(least_of(c[0].u, c[1].u, c[2].u)), p->pass.x0);
    int y0 = sl_larger(floor_of(least_of(c[0].v, c[1].v, c[2].v)), p->pass.y0);
    int x1 = sl_smaller(floor_of(-least_of(-c[0].u, -c[1].u, -c[2].u)) + 1, p->pass.x1);
    int y1 = sl_smaller(floor_of(-least_of(-c[0].v, -c[1].v, -c[2].v)) + 1, p->pass.y1);
    for (int j = y0; j < y1; j++) {
        for (int i = x0; i < x1; i++) {
            if (!covers(c, area, 256 * (int64_t)i, 256 * (int64_t)j)) continue;
            size_t pixel = (size_t)j * (size_t)p->target->width + (size_t)i;
            if (p->number) {
                p->sums[pixel] += p->number[t];
                p->sums[(size_t)p->target->width * (size_t)p->target->height + pixel] += 1.0f;
                continue;
            }
            float z = depth_at(&plane, opengl, i, j), old = p->target->depth[pixel];
            bool nearer = p->pass.inverse_w ? z > old : z < old;
            if (!nearer || !opaque_at(p->mesh, p->masks, p->view, &p->pass, t, i, j)) continue;
            p->target->id[pixel] = t;
            p->target->depth[pixel] = z;
        }
    }
}

/* ---- the whole ------------------------------------------------------------------------------- */

static void draw_triangle(const picture *p, uint32_t t) {
    corner c[3], pieces[SL_CLIP_TRIANGLES][3];
    for (int k = 0; k < 3; k++) {
        transform(&p->pass, sl_mesh_position(p->mesh, p->mesh->vertex[k][t]), &c[k]);
        find_code(&p->pass, &c[k]);
    }
    int some = c[0].code | c[1].code | c[2].code, all = c[0].code & c[1].code & c[2].code;
    if (all || some & SL_CLIP_INVALID) return; /* outside one plane; or not to be drawn at all */
    for (int k = 0; k < 3; k++) {
        if (!c[k].code) to_window(&p->pass, &c[k]);
        /* clipping finds it another place */
        else c[k].window_x = c[k].window_y = c[k].depth = 0.0f, c[k].u = c[k].v = 0;
    }
    if (!some) {
        draw_pixels(p, t, c);
        return;
    }
    uint32_t count = clip(&p->pass, c, pieces);
    for (uint32_t n = 0; n < count; n++) draw_pixels(p, t, pieces[n]);
}

static void clear(const picture *p) {
    for (int j = p->pass.y0; j < p->pass.y1; j++) {
        for (int i = p->pass.x0; i < p->pass.x1; i++) {
            size_t pixel = (size_t)j * (size_t)p->target->width + (size_t)i;
            p->target->id[pixel] = SL_NO_INDEX;
            p->target->depth[pixel] = p->pass.inverse_w ? 0.0f : 1.0f; /* as far as can be */
        }
    }
}

static void draw_all(const picture *p) {
    for (uint32_t t = 0; t < p->mesh->triangle_count; t++) {
        if (t != p->view->skip_triangle && !(p->view->left_out && p->view->left_out[t])) draw_triangle(p, t);
    }
}

void sl_plain_id(const sl_raster_mesh *mesh, const sl_scene *masks, const sl_view *view,
                 const sl_target *target) {
    picture p = {mesh,   masks, view, sl_pass_view_make(view, target->width, target->height),
                 target, NULL,  NULL};
    clear(&p);
    draw_all(&p);
}

void sl_plain_layers(const sl_raster_mesh *mesh, const sl_view *view, int width, int height,
                     const float *number, float *sums) {
    const sl_target size = {.width = width, .height = height};
    picture p = {mesh, NULL, view, sl_pass_view_make(view, width, height), &size, number, sums};
    draw_all(&p);
}
