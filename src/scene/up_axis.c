/* A thing that stands has its centre of mass above its feet. So the axis that points up is one along which
 * the middle of the surface lies within the box of what is lowest; legs and floors make that box a good part
 * of the model's, a tail that hangs down or a wall's edge does not. */
#include "scene/up_axis.h"

#include <math.h>

#include "base/math.h"
#include "base/values.h"

/* Of the height, how much counts as lowest; of the ground, how much that covers at least; how many times the
 * same for y that is. */
static const double lowest = 0.02, least_support = 0.1, far_more = 4.0;
/* A model flatter than that share of its width hangs on a wall as well as it lies on the ground. */
static const double flat = 0.05;
/* Cosine of the angle to the horizontal up to which a triangle is level. */
static const double level = 0.95;

bool sl_up_axis_is_unsaid(const char *path) {
    return sl_ends_with(path, ".obj") || sl_ends_with(path, ".stl") ||
           sl_ends_with(path, ".ply") || sl_ends_with(path, ".off");
}

typedef struct shape {
    double low[3], high[3], middle[3]; /* the box, and the mean of the surface */
    double area, level[3];             /* of all triangles, and of those that are level, by axis */
} shape;

static void corners_of(const sl_model *m, size_t triangle, double p[3][3]) {
    for (int c = 0; c < 3; c++) {
        for (size_t a = 0; a < 3; a++)
            p[c][a] = (double)m->positions[3 * (size_t)m->indices[3 * triangle + (size_t)c] + a];
    }
}

static void add_triangle(shape *s, double p[3][3]) {
    double normal[3];
    for (int a = 0; a < 3; a++) {
        int b = (a + 1) % 3, c = (a + 2) % 3;
        normal[a] = (p[1][b] - p[0][b]) * (p[2][c] - p[0][c]) - (p[1][c] - p[0][c]) * (p[2][b] - p[0][b]);
    }
    double area = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    if (!(area > 0.0) || !isfinite(area)) return;
    s->area += area;
    for (int a = 0; a < 3; a++) {
        s->level[a] += fabs(normal[a]) > level * area ? area : 0.0;
        s->middle[a] += area * (p[0][a] + p[1][a] + p[2][a]) / 3.0;
        for (int c = 0; c < 3; c++)
            s->low[a] = fmin(s->low[a], p[c][a]), s->high[a] = fmax(s->high[a], p[c][a]);
    }
}

static shape shape_of(const sl_model *m) {
    shape s = {.low = {INFINITY, INFINITY, INFINITY}, .high = {-INFINITY, -INFINITY, -INFINITY}};
    double p[3][3];
    for (size_t t = 0; t < m->triangle_count; t++) {
        corners_of(m, t, p);
        add_triangle(&s, p);
    }
    for (int a = 0; a < 3; a++) s.middle[a] /= s.area > 0.0 ? s.area : 1.0;
    return s;
}

typedef struct support {
    double share; /* of the ground that the box of what is lowest covers */
    bool stable;  /* the middle lies above it */
} support;

static support support_along(const sl_model *m, const shape *s, int axis) {
    const int across[2] = {(axis + 1) % 3, (axis + 2) % 3};
    const double limit = s->low[axis] + lowest * (s->high[axis] - s->low[axis]);
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (size_t i = 0; i < 3 * m->triangle_count; i++) {
        const float *p = m->positions + 3 * (size_t)m->indices[i];
        if (!((double)p[axis] <= limit)) continue;
        for (int k = 0; k < 2; k++)
            low[k] = fmin(low[k], (double)p[across[k]]), high[k] = fmax(high[k], (double)p[across[k]]);
    }
    support found = {1.0, true};
    for (int k = 0; k < 2; k++) {
        const double middle = s->middle[across[k]], extent = s->high[across[k]] - s->low[across[k]];
        found.stable = found.stable && middle > low[k] && middle < high[k];
        found.share *= extent > 0.0 ? (high[k] - low[k]) / extent : 0.0;
    }
    return found;
}

bool sl_model_stands_on_z(const sl_model *m) {
    const shape s = shape_of(m);
    const support y = support_along(m, &s, 1), z = support_along(m, &s, 2);
    const double height = s.high[2] - s.low[2], width = fmax(s.high[0] - s.low[0], s.high[1] - s.low[1]);
    return height > flat * width && !y.stable && z.stable && z.share >= least_support &&
           z.share >= far_more * y.share && s.level[2] >= s.level[1];
}

static void turn(float *xyz) {
    float y = xyz[1];
    xyz[1] = xyz[2];
    xyz[2] = 0.0f - y;
}

void sl_model_turn_z_up(sl_model *m) {
    for (size_t v = 0; v < m->vertex_count; v++) {
        turn(m->positions + 3 * v);
        turn(m->normals + 3 * v);
    }
}
