/* How large a patch is on the screen. Its corners' clip coordinates lie between those of the face's; what is not in the picture is cut away
 * before the division by w (Sutherland and Hodgman 1974), so that a patch that reaches behind the eye has a size, too. */
#include "cache/multi_mesh/pixels.h"

enum { CUTS = 5, POINTS_MAX = 3 + CUTS };

static float row(const sl_view *view, int r, sl_vec3 q) {
    const float *m = view->clip[r];
    return m[0] * q.x + m[1] * q.y + m[2] * q.z + m[3];
}

sl_face_clip sl_face_clip_of(const sl_scene *scene, const sl_view *view, uint32_t face) {
    sl_face_clip clip;
    for (int c = 0; c < 3; c++) {
        sl_vec3 q = sl_sub(sl_scene_position(scene, scene->vertex[c][face / 2]), view->origin);
        float x = row(view, 0, q), y = row(view, 1, q), z = row(view, 2, q), w = row(view, 3, q);
        float near = view->depth == SL_DEPTH_INVERSE_W ? z : w + z;
        const float point[4] = {x, y, near, w};
        for (int k = 0; k < 4; k++) clip.corner[c][k] = point[k];
    }
    return clip;
}

/* How far inside a plane of the view's pyramid; the sides, then the near plane. */
static float inside(const float point[4], int plane) {
    switch (plane) {
    case 0: return point[3] - point[0];
    case 1: return point[3] + point[0];
    case 2: return point[3] - point[1];
    case 3: return point[3] + point[1];
    default: return point[2];
    }
}

static int cut(const float in[][4], int count, int plane, float out[][4]) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        const float *a = in[i], *b = in[i + 1 < count ? i + 1 : 0];
        float da = inside(a, plane), db = inside(b, plane);
        if (da >= 0.0f) {
            for (int k = 0; k < 4; k++) out[kept][k] = a[k];
            kept++;
        }
        if ((da >= 0.0f) != (db >= 0.0f)) {
            float t = da / (da - db);
            for (int k = 0; k < 4; k++) out[kept][k] = a[k] + t * (b[k] - a[k]);
            kept++;
        }
    }
    return kept;
}

/* Whether any point is not inside all planes; NaN is not. */
static bool is_cut(const float point[3][4]) {
    for (int i = 0; i < 3; i++) {
        for (int plane = 0; plane < CUTS; plane++) {
            if (!(inside(point[i], plane) >= 0.0f)) return true;
        }
    }
    return false;
}

static sl_screen_size measure(const sl_view *view, const float point[][4], int count) {
    float x[POINTS_MAX], y[POINTS_MAX], twice_area = 0.0f, longest = 0.0f;
    for (int i = 0; i < count; i++) {
        float w = point[i][3], half = w > 0.0f ? 0.5f / w : 0.0f;
        x[i] = point[i][0] * half * (float)view->width;
        y[i] = point[i][1] * half * (float)view->height;
    }
    for (int i = 0; i < count; i++) {
        int j = i + 1 < count ? i + 1 : 0;
        float dx = x[j] - x[i], dy = y[j] - y[i], squared = dx * dx + dy * dy;
        twice_area += (x[i] - x[0]) * (y[j] - y[0]) - (x[j] - x[0]) * (y[i] - y[0]);
        longest = squared > longest ? squared : longest;
    }
    return (sl_screen_size){0.5f * fabsf(twice_area), sqrtf(longest)};
}

sl_screen_size sl_screen_size_of(const sl_view *view, const sl_face_clip *face, const uint16_t p[3], const uint16_t q[3], float unit) {
    float a[POINTS_MAX][4], b[POINTS_MAX][4];
    const float(*corner)[4] = face->corner;
    for (int i = 0; i < 3; i++) {
        float w1 = (float)p[i] / unit, w2 = (float)q[i] / unit, w0 = 1.0f - w1 - w2;
        for (int k = 0; k < 4; k++) a[i][k] = w0 * corner[0][k] + w1 * corner[1][k] + w2 * corner[2][k];
    }
    if (!is_cut((const float(*)[4])a)) return measure(view, (const float(*)[4])a, 3);
    int count = 3;
    for (int plane = 0; plane < CUTS && count > 0; plane++) {
        count = plane % 2 ? cut((const float(*)[4])b, count, plane, a) : cut((const float(*)[4])a, count, plane, b);
    }
    return measure(view, (const float(*)[4])b, count); /* five cuts: the last is in b */
}
