#include "app/steps/marks.h"

#include "base/vec.h"

#include <math.h>

bool sl_mark_project(const sl_mark_view *view, const float at[3], double *column, double *row) {
    sl_vec3 d = sl_sub(sl_v3_of(at), view->camera.eye);
    double ahead = -(double)sl_dot(d, view->camera.back), half = tan(0.5 * (double)view->camera.vertical_fov);
    if (!(ahead > 1e-5 * (double)view->scale)) return false;
    double scale = 0.5 * view->height / (half * ahead);
    *column = 0.5 * view->width + scale * (double)sl_dot(d, view->camera.right);
    *row = 0.5 * view->height - scale * (double)sl_dot(d, view->camera.up);
    return isfinite(*column) && isfinite(*row);
}

static bool within(const sl_mark_view *view, double column, double row) {
    return column > -1.0 && row > -1.0 && column < view->width + 1.0 && row < view->height + 1.0;
}

/* Something else lies in front of the mark: it may itself lie a little within the surface that it belongs to.
 */
bool sl_mark_is_hidden(const sl_mark_view *view, const float at[3]) {
    if (!view->tracer) return false;
    sl_vec3 eye = view->camera.eye, d = sl_sub(sl_v3_of(at), eye);
    float distance = sqrtf(sl_dot(d, d));
    const float far = 1.0f - 5e-3f * view->scale / fmaxf(distance, 1e-6f * view->scale);
    sl_ray16 ray = {.far = {0.0f}};
    sl_ray16_set(&ray, 0, eye, d, 0.0f, far, SL_NO_INDEX);
    sl_counters unused = {0};
    return far > 0.0f && sl_trace_occluded(view->tracer, &ray, 1, false, &unused) != 0;
}

/* Bright enough to be seen whatever it stands for. */
static void put_colour(FILE *out, const char *attribute, const float colour[3]) {
    float most = fmaxf(fmaxf(colour[0], colour[1]), colour[2]);
    int level[3];
    for (int c = 0; c < 3; c++)
        level[c] =
            most > 0.0f && isfinite(most) ? (int)lrintf(80.0f + 175.0f * fmaxf(colour[c], 0.0f) / most) : 200;
    fprintf(out, " %s=\"#%02x%02x%02x\"", attribute, level[0], level[1], level[2]);
}

static void put_disc(FILE *out, const sl_mark_view *view, const sl_mark *m) {
    enum { CORNERS = 20 };
    sl_frame frame = sl_frame_from_normal(sl_normalize_or(sl_v3_of(m->to), sl_v3(0.0f, 1.0f, 0.0f)));
    double column[CORNERS], row[CORNERS];
    for (int i = 0; i < CORNERS; i++) {
        double a = 6.283185307179586 * i / CORNERS;
        sl_vec3 p = sl_add(sl_v3_of(m->at), sl_frame_to_world(&frame, sl_v3(m->radius * (float)cos(a),
                                                                          m->radius * (float)sin(a), 0.0f)));
        /* reaches behind the eye */
        if (!sl_mark_project(view, (float[3]){p.x, p.y, p.z}, &column[i], &row[i])) return;
    }
    for (int i = 0; i < CORNERS; i++)
        fprintf(out, "%s%.1f %.1f", i ? "L" : "<path class=\"disc\" d=\"M", column[i], row[i]);
    fputs("Z\"", out);
    put_colour(out, "stroke", m->colour);
    fputs("/>", out);
}

static void put_mark(FILE *out, const sl_mark_view *view, const sl_mark *m) {
    double column, row, to_column, to_row;
    if (!sl_mark_project(view, m->at, &column, &row) || !within(view, column, row) ||
        sl_mark_is_hidden(view, m->at))
        return;
    switch (m->kind) {
    case SL_MARK_DISC: put_disc(out, view, m); /* and its centre */ /* fall through */
    case SL_MARK_POINT:
        fprintf(out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\".8\"", column, row);
        put_colour(out, "fill", m->colour);
        fputs("/>", out);
        break;
    case SL_MARK_SEGMENT:
        if (!sl_mark_project(view, m->to, &to_column, &to_row)) break;
        fprintf(out, "<path d=\"M%.1f %.1fL%.1f %.1f\"", column, row, to_column, to_row);
        put_colour(out, "stroke", m->colour);
        fputs("/>", out);
        break;
    }
}

void sl_marks_put(FILE *out, const void *marks) {
    const sl_marks *m = marks;
    size_t drawn = m->count < m->limit ? m->count : m->limit;
    for (size_t i = 0; i < drawn; i++) put_mark(out, m->view, &m->marks[i * m->count / drawn]);
}
