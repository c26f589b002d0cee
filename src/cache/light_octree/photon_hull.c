#include "cache/light_octree/photon_area.h"

#include <math.h>
#include <stdbool.h>

#include "base/error.h"
#include "base/memory.h"

enum { PHOTONS_LEAST = 8 };

/* So many standard deviations are sure. */
static const double sure = 3.0;
/* A few photons close together must not outshine all else. */
static const double share_least = 0.1;

sl_status sl_hull_points_create(size_t capacity, sl_hull_points *p, sl_error *error) {
    *p = (sl_hull_points){0, sl_allocate(2 * capacity, sizeof *p->x), NULL,
                          sl_allocate(3 * capacity + 2, sizeof *p->outer), NULL};
    if (!p->x || !p->outer) {
        sl_hull_points_release(p);
        return sl_fail_memory(error, "gathered photons");
    }
    p->y = p->x + capacity;
    p->chain = p->outer + capacity;
    return SL_OK;
}

void sl_hull_points_release(sl_hull_points *p) {
    sl_free(p->x);
    sl_free(p->outer);
    *p = (sl_hull_points){0, NULL, NULL, NULL, NULL};
}

/* ---- most points are far inside (Akl and Toussaint 1978) ---- */

enum { WAYS = 8 };

/* A convex polygon, counter-clockwise. */
typedef struct octagon {
    int corners;
    float x[WAYS], y[WAYS];
} octagon;

/* The points that lie farthest along (1,0), (1,1), (0,1) and on; those that are the same count once. */
static octagon octagon_of(const sl_hull_points *p) {
    octagon o = {.corners = 0};
    size_t farthest[WAYS] = {0};
    float most[WAYS];
    for (int w = 0; w < WAYS; w++) most[w] = -INFINITY;
    for (size_t i = 0; i < p->count; i++) {
        float x = p->x[i], y = p->y[i], up = x + y, down = x - y;
        const float along[WAYS] = {x, up, y, -down, -x, -up, -y, down};
        for (int w = 0; w < WAYS; w++) {
            if (!(along[w] > most[w])) continue;
            most[w] = along[w];
            farthest[w] = i;
        }
    }
    for (int w = 0; w < WAYS; w++) {
        float x = p->x[farthest[w]], y = p->y[farthest[w]];
        if (o.corners > 0 && x == o.x[o.corners - 1] && y == o.y[o.corners - 1]) continue;
        o.x[o.corners] = x;
        o.y[o.corners++] = y;
    }
    if (o.corners > 1 && o.x[o.corners - 1] == o.x[0] && o.y[o.corners - 1] == o.y[0]) o.corners--;
    return o;
}

/* Lists the points that are not clearly inside; returns how many. */
static size_t find_outer(const octagon *o, sl_hull_points *p) {
    float size = 0.0f;
    size_t count = 0;
    uint32_t *outer = p->chain; /* of each point: is it? */
    for (int e = 0; e < o->corners; e++) size = fmaxf(size, fmaxf(fabsf(o->x[e]), fabsf(o->y[e])));
    for (size_t i = 0; i < p->count; i++) outer[i] = 0;
    for (int e = 0; e < o->corners; e++) {
        int next = e + 1 < o->corners ? e + 1 : 0;
        const float x = o->x[e], y = o->y[e], dx = o->x[next] - x, dy = o->y[next] - y,
                    slack = 1e-5f * size * size;
#pragma omp simd
        for (size_t i = 0; i < p->count; i++) outer[i] |= dx * (p->y[i] - y) - dy * (p->x[i] - x) <= slack;
    }
    for (size_t i = 0; i < p->count; i++) {
        p->outer[count] = (uint32_t)i;
        count += outer[i];
    }
    return count;
}

/* ---- the hull of the rest (Andrew 1979) ---- */

static bool comes_before(const sl_hull_points *p, uint32_t a, uint32_t b) {
    return p->x[a] != p->x[b] ? p->x[a] < p->x[b] : p->y[a] < p->y[b];
}

static void sort_outer(sl_hull_points *p, size_t count) {
    for (size_t i = 1; i < count; i++) {
        uint32_t moved = p->outer[i];
        size_t k = i;
        for (; k > 0 && comes_before(p, moved, p->outer[k - 1]); k--) p->outer[k] = p->outer[k - 1];
        p->outer[k] = moved;
    }
}

/* Twice the area of (a, b, c), positive where they turn left. */
static double turn(const sl_hull_points *p, uint32_t a, uint32_t b, uint32_t c) {
    double x = (double)p->x[a], y = (double)p->y[a];
    return ((double)p->x[b] - x) * ((double)p->y[c] - y) - ((double)p->y[b] - y) * ((double)p->x[c] - x);
}

/* Adds a point to a chain that may not be shorter than `least`; what no longer turns left goes. */
static size_t add_to_chain(const sl_hull_points *p, size_t length, size_t least, uint32_t point) {
    while (length >= least + 2 && !(turn(p, p->chain[length - 2], p->chain[length - 1], point) > 0.0))
        length--;
    p->chain[length++] = point;
    return length;
}

/* Below from left to right, and back above. */
static size_t chain_around(const sl_hull_points *p, size_t count) {
    size_t length = 0, below;
    for (size_t i = 0; i < count; i++) length = add_to_chain(p, length, 0, p->outer[i]);
    below = length - 1;
    for (size_t i = count - 1; i-- > 0;) length = add_to_chain(p, length, below, p->outer[i]);
    return length - 1; /* the first point is the last as well */
}

sl_photon_hull sl_photon_hull_of(sl_hull_points *p) {
    sl_photon_hull hull = {0.0, 0};
    if (p->count < 3) return hull;
    octagon o = octagon_of(p);
    size_t count = o.corners > 1 ? find_outer(&o, p) : 0;
    if (count < 3) return hull;
    sort_outer(p, count);
    hull.corners = chain_around(p, count);
    for (size_t i = 2; i < hull.corners; i++)
        hull.area += 0.5 * turn(p, p->chain[0], p->chain[i - 1], p->chain[i]);
    return hull;
}

double sl_photon_hull_share(const sl_photon_hull *hull, size_t photons, double area) {
    if (photons < PHOTONS_LEAST || hull->corners < 3 || !(area > 0.0)) return 1.0;
    double count = (double)photons, corners = (double)hull->corners;
    double share = hull->area / area * ((count + 1.0) / (count - corners + 1.0));
    if (!(share * (1.0 + sure * sqrt(corners) / count) < 1.0)) return 1.0;
    return share > share_least ? share : share_least;
}
