/* The smallest box around a chart: one of its sides lies along an edge of the convex hull (Freeman, Shapira
 * 1975). */
#include "cache/light_octree/atlas/parts.h"

#include <stdlib.h>

#include "base/memory.h"

static int by_place(const void *x, const void *y) {
    const double *a = x, *b = y;
    if (a[0] != b[0]) return a[0] < b[0] ? -1 : 1;
    return (a[1] > b[1]) - (a[1] < b[1]);
}

static double turn(const double *a, const double *b, const double *p) {
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

/* Counter-clockwise, by Andrew's monotone chain; sorts the points. hull has room for count + 1 points more
 * than there are. */
static size_t convex_hull(double *sorted, size_t count, double *hull) {
    size_t n = 0;
    qsort(sorted, count, 2 * sizeof *sorted, by_place);
    for (int chain = 0; chain < 2; chain++) {
        size_t base = n + 1;
        for (size_t i = 0; i < count; i++) {
            const double *p = sorted + 2 * (chain ? count - 1 - i : i);
            while (n > base && turn(hull + 2 * (n - 2), hull + 2 * (n - 1), p) <= 0.0) n--;
            hull[2 * n] = p[0];
            hull[2 * n++ + 1] = p[1];
        }
        n--; /* the end of a chain begins the next */
    }
    return n;
}

static void extent(const double *p, size_t count, double c, double s, double low[2], double high[2]) {
    low[0] = low[1] = HUGE_VAL;
    high[0] = high[1] = -HUGE_VAL;
    for (size_t i = 0; i < count; i++) {
        double at[2] = {c * p[2 * i] + s * p[2 * i + 1], c * p[2 * i + 1] - s * p[2 * i]};
        for (size_t k = 0; k < 2; k++) {
            low[k] = at[k] < low[k] ? at[k] : low[k];
            high[k] = at[k] > high[k] ? at[k] : high[k];
        }
    }
}

bool sl_atlas_smallest_box(double *point, size_t count) {
    double *sorted = sl_allocate(count, 2 * sizeof *sorted),
           *hull = sl_allocate(2 * count + 2, 2 * sizeof *hull);
    double low[2], high[2], c = 1.0, s = 0.0, least = HUGE_VAL;
    bool good = sorted && hull;
    for (size_t i = 0; good && i < 2 * count; i++) sorted[i] = point[i];
    size_t corners = good ? convex_hull(sorted, count, hull) : 0;
    for (size_t i = 0; i < corners; i++) {
        const double *a = hull + 2 * i, *b = hull + 2 * ((i + 1) % corners);
        double x = b[0] - a[0], y = b[1] - a[1], length = sqrt(x * x + y * y);
        if (!(length > 0.0)) continue;
        extent(hull, corners, x / length, y / length, low, high);
        double area = (high[0] - low[0]) * (high[1] - low[1]);
        if (area < least) least = area, c = x / length, s = y / length;
    }
    sl_free(sorted);
    sl_free(hull);
    if (!good) return false;
    extent(point, count, c, s, low, high);
    bool lying = high[0] - low[0] > high[1] - low[1]; /* then a quarter turn more: (x, y) to (-y, x) */
    for (size_t i = 0; i < count; i++) {
        double x = c * point[2 * i] + s * point[2 * i + 1], y = c * point[2 * i + 1] - s * point[2 * i];
        point[2 * i] = lying ? -y : x;
        point[2 * i + 1] = lying ? x : y;
    }
    return true;
}
