/* The size of a patch on the screen, of its corners as the camera sees them, or of cells of a curved one.
 * What is not in the picture is cut away before the division by w (Sutherland and Hodgman 1974), so that a
 * patch that reaches behind the eye has a size, too. */
#include "cache/patches/patches.h"

enum { CUTS = 5, POINTS_MAX = 4 + CUTS };

static float row(const sl_view *view, int r, sl_vec3 q) {
    const float *m = view->clip[r];
    return m[0] * q.x + m[1] * q.y + m[2] * q.z + m[3];
}

sl_clip_point sl_clip_point_of(const sl_view *view, sl_vec3 point) {
    sl_vec3 q = sl_sub(point, view->origin);
    float x = row(view, 0, q), y = row(view, 1, q), z = row(view, 2, q), w = row(view, 3, q);
    return (sl_clip_point){{x, y, view->depth == SL_DEPTH_INVERSE_W ? z : w + z, w}};
}

/* Returns how far inside a plane of the view's pyramid a point is; the sides, then the near plane. */
static float inside(const sl_clip_point *p, int plane) {
    switch (plane) {
    case 0: return p->at[3] - p->at[0];
    case 1: return p->at[3] + p->at[0];
    case 2: return p->at[3] - p->at[1];
    case 3: return p->at[3] + p->at[1];
    default: return p->at[2];
    }
}

static int cut(const sl_clip_point *in, int count, int plane, sl_clip_point *out) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        const sl_clip_point *a = &in[i], *b = &in[i + 1 < count ? i + 1 : 0];
        float da = inside(a, plane), db = inside(b, plane);
        if (da >= 0.0f) out[kept++] = *a;
        if ((da >= 0.0f) == (db >= 0.0f)) continue;
        float t = da / (da - db);
        for (int k = 0; k < 4; k++) out[kept].at[k] = a->at[k] + t * (b->at[k] - a->at[k]);
        kept++;
    }
    return kept;
}

/* Tells whether any point is not inside all planes; NaN is not. */
static bool is_cut(int count, const sl_clip_point *point) {
    for (int i = 0; i < count; i++) {
        for (int plane = 0; plane < CUTS; plane++) {
            if (!(inside(&point[i], plane) >= 0.0f)) return true;
        }
    }
    return false;
}

static sl_screen_size measure(const sl_view *view, int count, const sl_clip_point *point) {
    float x[POINTS_MAX], y[POINTS_MAX], twice_area = 0.0f, longest = 0.0f;
    for (int i = 0; i < count; i++) {
        float w = point[i].at[3], half = w > 0.0f ? 0.5f / w : 0.0f;
        x[i] = point[i].at[0] * half * (float)view->width;
        y[i] = point[i].at[1] * half * (float)view->height;
    }
    for (int i = 0; i < count; i++) {
        int j = i + 1 < count ? i + 1 : 0;
        float dx = x[j] - x[i], dy = y[j] - y[i], squared = dx * dx + dy * dy;
        twice_area += (x[i] - x[0]) * (y[j] - y[0]) - (x[j] - x[0]) * (y[i] - y[0]);
        longest = squared > longest ? squared : longest;
    }
    return (sl_screen_size){0.5f * fabsf(twice_area), sqrtf(longest)};
}

/* Of a convex polygon of three or four corners. */
static sl_screen_size size_of(const sl_view *view, int corners, const sl_clip_point *corner) {
    sl_clip_point a[POINTS_MAX], b[POINTS_MAX];
    if (!is_cut(corners, corner)) return measure(view, corners, corner);
    int count = cut(corner, corners, 0, b);
    for (int plane = 1; plane < CUTS && count > 0; plane++)
        count = plane % 2 ? cut(b, count, plane, a) : cut(a, count, plane, b);
    return measure(view, count, b); /* five cuts: the last is in b */
}

/* ---- patches --------------------------------------------------------------------------------- */

static sl_clip_point seen_at(const sl_patches *p, const sl_view *view, uint32_t root, uint32_t u,
                             uint32_t v) {
    return sl_clip_point_of(view, sl_root_position(p->primitives, root, u, v));
}

static void add(const sl_view *view, sl_clip_point a, sl_clip_point b, sl_clip_point c,
                sl_screen_size *size) {
    sl_screen_size part = size_of(view, 3, (const sl_clip_point[3]){a, b, c});
    size->area += part.area;
    size->edge = fmaxf(size->edge, part.edge);
}

/* A curved patch may bulge out of what its corners span, or come back to where it began: four by four cells
 * of it, two triangles each. */
static sl_screen_size curved_size(const sl_patches *p, const sl_view *view, const sl_patch_place *place) {
    enum { CELLS = 4 };
    sl_clip_point grid[CELLS + 1][CELLS + 1];
    sl_screen_size size = {0.0f, 0.0f};
    uint32_t side_u = (uint32_t)(place->u[2] - place->u[0]), side_v = (uint32_t)(place->v[2] - place->v[0]);
    for (uint32_t j = 0; j <= CELLS; j++) {
        for (uint32_t i = 0; i <= CELLS; i++)
            grid[j][i] = seen_at(p, view, place->root, place->u[0] + side_u * i / CELLS,
                                 place->v[0] + side_v * j / CELLS);
    }
    for (int j = 0; j < CELLS; j++) {
        for (int i = 0; i < CELLS; i++) {
            add(view, grid[j][i], grid[j][i + 1], grid[j + 1][i + 1], &size);
            add(view, grid[j][i], grid[j + 1][i + 1], grid[j + 1][i], &size);
        }
    }
    size.edge *= (float)CELLS; /* the patch's: its cells' sides are a quarter of that */
    return size;
}

sl_screen_size sl_patch_projected(const sl_patches *p, const sl_patch_place *place, const sl_view *view) {
    if (p->primitives->kind[place->root / 2] == SL_PRIMITIVE_BICUBIC) return curved_size(p, view, place);
    sl_clip_point corner[4];
    for (int c = 0; c < place->corners; c++)
        corner[c] = seen_at(p, view, place->root, place->u[c], place->v[c]);
    return size_of(view, place->corners, corner);
}
