/* All charts in one texture, by their boxes on shelves: from the highest to the lowest, each on the first
 * shelf that has room for it, a new shelf above the others where none has (first fit by decreasing height).
 */
#include "cache/light_octree/atlas/parts.h"

#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"

/* Texels: a little more than the gutter, for what rounding takes. */
static const double slack = 0x1p-6;
/* The density falls by the first factor until all charts fit, and rises by the second while they still do. */
static const double fall = 0.95, rise = 1.01;
enum { SIZE_MOST = 1 << 16 };

typedef struct sorted_chart {
    double height, width;
    sl_atlas_plane *plane;
} sorted_chart;

/* A piece of the skyline reaches to the next one's x, the last one to the atlas's edge. */
typedef struct piece {
    double x, y;
} piece;

typedef struct packing {
    size_t count;
    sorted_chart *order;
    piece *piece;           /* of the skyline */
    size_t pieces;
    double gutter;
    double area;            /* of all faces */
} packing;

static int by_height(const void *x, const void *y) {
    const sorted_chart *a = x, *b = y;
    if (a->height != b->height) return a->height > b->height ? -1 : 1;
    if (a->width != b->width) return a->width > b->width ? -1 : 1;
    return (a->plane > b->plane) - (a->plane < b->plane);
}

/* Returns the height of the skyline over [x, x + width), from the piece at x on. */
static double height_over(const packing *p, size_t from, double width) {
    double y = 0.0, end = p->piece[from].x + width;
    for (size_t i = from; i < p->pieces && p->piece[i].x < end; i++) y = fmax(y, p->piece[i].y);
    return y;
}

/* Raises the skyline over [x, x + width), from the piece at x on, to y. */
static void raise_skyline(packing *p, size_t from, double width, double y) {
    double end = p->piece[from].x + width;
    size_t next = from + 1;
    while (next < p->pieces && p->piece[next].x <= end) next++;
    piece last = {end, p->piece[next - 1].y};
    bool cut = next < p->pieces ? p->piece[next].x > end : true;
    memmove(p->piece + from + 1 + cut, p->piece + next, (p->pieces - next) * sizeof *p->piece);
    p->pieces = p->pieces - next + from + 1 + cut;
    p->piece[from].y = y;
    if (cut) p->piece[from + 1] = last;
}

/* Places all charts in a square of that size at a density, gutters included. Returns whether they fit. */
static bool place_all(packing *p, double density, double size) {
    p->pieces = 1;
    p->piece[0] = (piece){0.0, 0.0};
    for (size_t c = 0; c < p->count; c++) {
        const sorted_chart *chart = &p->order[c];
        double width = density * chart->width + p->gutter, height = density * chart->height + p->gutter,
               y = HUGE_VAL;
        size_t at = 0;
        for (size_t i = 0; i < p->pieces && p->piece[i].x + width <= size; i++) {
            double over = p->piece[i].y < y ? height_over(p, i, width) : y;
            if (over < y) y = over, at = i;
        }
        if (y + height > size) return false;
        chart->plane->x = p->piece[at].x + 0.5 * p->gutter;
        chart->plane->y = y + 0.5 * p->gutter;
        raise_skyline(p, at, width, y + height);
    }
    return true;
}

/* Returns where the boxes of all charts, gutters included, would fill the square: sum (d w + g)(d h + g) =
 * room^2. */
static double highest_density(const packing *p, double room) {
    double squares = 0.0, sides = 0.0;
    for (size_t i = 0; i < p->count; i++) {
        squares += p->order[i].width * p->order[i].height;
        sides += p->order[i].width + p->order[i].height;
    }
    double half = 0.5 * p->gutter * sides, rest = room * room - (double)p->count * p->gutter * p->gutter;
    if (!(squares > 0.0) || !(rest > 0.0)) return 0.0;
    return rest / (half + sqrt(half * half + squares * rest));
}

static bool prepare(packing *p, const sl_atlas_charts *charts, const sl_atlas_faces *faces) {
    p->count = charts->count;
    p->order = sl_allocate(p->count, sizeof *p->order);
    p->piece = sl_allocate(2 * p->count + 2, sizeof *p->piece);
    if (!p->order || !p->piece) return false;
    for (size_t i = 0; i < p->count; i++)
        p->order[i] = (sorted_chart){charts->plane[i].height, charts->plane[i].width, &charts->plane[i]};
    qsort(p->order, p->count, sizeof *p->order, by_height);
    for (size_t f = 0; f < faces->count; f++) p->area += faces->area[f];
    return true;
}

/* Returns nearly the highest density at which all fit, or 0 where that is below `least`. */
static double search(packing *p, double size, double least) {
    double density = highest_density(p, size);
    while (density >= least && !place_all(p, density, size)) density *= fall;
    if (density < least) return 0.0;
    while (place_all(p, density * rise, size)) density *= rise;
    place_all(p, density, size);
    return density;
}

sl_status sl_atlas_pack(const sl_atlas_charts *charts, const sl_atlas_faces *faces, int size, int gutter,
                        double *density, int *needed, sl_error *error) {
    packing p = {.gutter = gutter + slack};
    bool good = prepare(&p, charts, faces);
    *needed = size;
    *density = 0.0;
    if (good) {
        double least = p.area > 0.0 ? sqrt((double)p.count / p.area) : 1.0;
        *density = search(&p, size, least);
        while (!(*density > 0.0) && *needed < SIZE_MOST && !place_all(&p, least, *needed))
            *needed += *needed / 16 + 1;
    }
    SL_FREE_ALL(p.order, p.piece);
    return good ? SL_OK : sl_fail_memory(error, "packing an atlas");
}
