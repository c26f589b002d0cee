/* What stands has its centre of mass above its feet. So the axis that points up is one along which the middle
 * of all corners lies within the box of what is lowest; legs and floors make that box a good part of the
 * model's, a tail that hangs down or a wall's edge does not. */
#include "scene/up_axis.h"

#include <math.h>

#include "base/math.h"
#include "scene/file.h"

/* Of the height, how much counts as lowest; of the ground, how much that covers at least; how many times the
 * same for y that is. */
static const double lowest = 0.02, least_support = 0.1, far_more = 4.0;
/* What is flatter than that share of its width hangs on a wall as well as it lies on the ground. */
static const double flat = 0.05;
bool sl_up_axis_is_unsaid(const char *path) {
    return sl_file_has_extension(path, ".obj") || sl_file_has_extension(path, ".stl") ||
           sl_file_has_extension(path, ".ply") || sl_file_has_extension(path, ".off");
}

typedef struct shape {
    double low[3], high[3], middle[3]; /* the box, and the mean of all triangles' corners */
} shape;

static shape shape_of(const sl_model *m) {
    shape s = {.low = {INFINITY, INFINITY, INFINITY}, .high = {-INFINITY, -INFINITY, -INFINITY}};
    double count = 0.0;
    for (size_t i = 0; i < 3 * m->triangle_count; i++) {
        const float *p = m->positions + 3 * (size_t)m->indices[i];
        if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2])) continue;
        count++;
        for (int a = 0; a < 3; a++) {
            s.middle[a] += (double)p[a];
            s.low[a] = fmin(s.low[a], (double)p[a]), s.high[a] = fmax(s.high[a], (double)p[a]);
        }
    }
    for (int a = 0; a < 3; a++) s.middle[a] /= fmax(count, 1.0);
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
           z.share >= far_more * y.share;
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
