/* The size of a patch on the screen. What is not in the picture is cut away before the division by w
 * (Sutherland and Hodgman 1974), so that a patch that reaches behind the eye has a size, too. */
#include "cache/patches/screen_size.h"

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

sl_screen_size sl_screen_size_of(const sl_view *view, int corners, const sl_clip_point *corner) {
    sl_clip_point a[POINTS_MAX], b[POINTS_MAX];
    if (!is_cut(corners, corner)) return measure(view, corners, corner);
    int count = cut(corner, corners, 0, b);
    for (int plane = 1; plane < CUTS && count > 0; plane++)
        count = plane % 2 ? cut(b, count, plane, a) : cut(a, count, plane, b);
    return measure(view, count, b); /* five cuts: the last is in b */
}

sl_face_clip sl_face_clip_of(const sl_scene *scene, const sl_view *view, uint32_t face) {
    sl_face_clip clip;
    for (int c = 0; c < 3; c++)
        clip.corner[c] = sl_clip_point_of(view, sl_scene_position(scene, scene->vertex[c][face / 2]));
    return clip;
}

sl_screen_size sl_face_part_size(const sl_view *view, const sl_face_clip *face, const uint16_t p[3],
                                 const uint16_t q[3], float unit) {
    sl_clip_point part[3];
    const sl_clip_point *corner = face->corner;
    for (int i = 0; i < 3; i++) {
        float w1 = (float)p[i] / unit, w2 = (float)q[i] / unit, w0 = 1.0f - w1 - w2;
        for (int k = 0; k < 4; k++)
            part[i].at[k] = w0 * corner[0].at[k] + w1 * corner[1].at[k] + w2 * corner[2].at[k];
    }
    return sl_screen_size_of(view, 3, part);
}
