/* All charts in one texture (section 2.9; the horizon of Levy et al. 2002): from the tallest to the lowest, each is put where its top stays lowest,
 * in any of four quarter turns, on a horizon of one height a column; charts fit into each other as their outlines do. The density is the
 * highest at which the horizon stays inside. */
#include "cache/light_octree/atlas/parts.h"

#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"

/* A little more than the gutter, for what rounding takes. */
#define SLACK 0x1p-8
/* The search for the density ends when it is known this well. */
#define PRECISION 1.003
enum { TRIES = 16, SIZE_MOST = 1 << 16 };

typedef struct sorted_chart {
    double height;
    uint32_t chart;
} sorted_chart;

typedef struct packing {
    const sl_atlas_charts *charts;
    size_t *first;          /* of each chart's border segments */
    double *segment;        /* x, y, x, y */
    sorted_chart *order;
    int gutter;
    int widest;             /* room of the scratch arrays, in columns */
    double *horizon, *low, *high;
} packing;

static int by_height(const void *x, const void *y) {
    const sorted_chart *a = x, *b = y;
    if (a->height != b->height) return a->height > b->height ? -1 : 1;
    return (a->chart > b->chart) - (a->chart < b->chart);
}

/* ---- outlines ---- */

static bool gather_borders(packing *p, const sl_atlas_faces *faces) {
    const sl_atlas_charts *c = p->charts;
    size_t at = 0;
    for (int fill = 0; fill < 2; fill++) { /* count, then fill */
        if (fill && !(p->segment = sl_allocate(at, 4 * sizeof *p->segment))) return false;
        at = 0;
        for (size_t i = 0; i < c->count; i++) {
            p->first[i] = at;
            for (size_t j = 3 * c->chart[i].first; j < 3 * (c->chart[i].first + c->chart[i].count); j++) {
                uint32_t h = 3 * c->face[j / 3] + (uint32_t)(j % 3), twin = faces->twin[h];
                if (twin != SL_NO_INDEX && c->of_face[twin / 3] == i) continue;
                if (fill) memcpy(p->segment + 4 * at, c->corner + 2 * (size_t)h, 2 * sizeof *p->segment);
                if (fill) memcpy(p->segment + 4 * at + 2, c->corner + 2 * (size_t)sl_atlas_next(h), 2 * sizeof *p->segment);
                at++;
            }
        }
    }
    p->first[c->count] = at;
    return true;
}

void sl_atlas_turn(int turns, double width, double height, double x, double y, double turned[2]) {
    turned[0] = turns == 0 ? x : turns == 1 ? height - y : turns == 2 ? width - x : y;
    turned[1] = turns == 0 ? y : turns == 1 ? x : turns == 2 ? height - y : width - x;
}

static void widen(double *low, double *high, double y) {
    *low = y < *low ? y : *low;
    *high = y > *high ? y : *high;
}

/* The lowest and highest point of a segment in each column that it passes. */
static void pass_segment(packing *p, int columns, double x0, double y0, double x1, double y1) {
    if (x1 < x0) {
        double x = x0, y = y0;
        x0 = x1, y0 = y1;
        x1 = x, y1 = y;
    }
    int from = (int)floor(x0), to = (int)floor(x1);
    from = from < 0 ? 0 : from > columns - 1 ? columns - 1 : from;
    to = to < from ? from : to > columns - 1 ? columns - 1 : to;
    widen(&p->low[from], &p->high[from], y0);
    widen(&p->low[to], &p->high[to], y1);
    for (int c = from + 1; c <= to; c++) { /* where it crosses from column to column */
        double y = y0 + (y1 - y0) * (((double)c - x0) / (x1 - x0));
        y = y0 < y1 ? fmin(fmax(y, y0), y1) : fmin(fmax(y, y1), y0);
        widen(&p->low[c - 1], &p->high[c - 1], y);
        widen(&p->low[c], &p->high[c], y);
    }
}

/* Fills low and high of the chart as it lies after some turns; returns its columns. */
static int outline(packing *p, uint32_t chart, double density, int turns) {
    const sl_atlas_chart *c = &p->charts->chart[chart];
    double width = density * c->width, height = density * c->height;
    double across = turns % 2 ? height : width, a[2], b[2];
    int columns = (int)fmin(ceil(across + SLACK), (double)p->widest);
    for (int i = 0; i < columns; i++) {
        p->low[i] = HUGE_VAL;
        p->high[i] = -HUGE_VAL;
    }
    for (size_t s = p->first[chart]; s < p->first[chart + 1]; s++) {
        const double *e = p->segment + 4 * s;
        sl_atlas_turn(turns, width, height, density * e[0], density * e[1], a);
        sl_atlas_turn(turns, width, height, density * e[2], density * e[3], b);
        pass_segment(p, columns, a[0], a[1], b[0], b[1]);
    }
    return columns;
}

/* ---- the horizon ---- */

typedef struct spot {
    double top, lost, y;
    int x, turns;
} spot;

/* The best place for the outline in low[]; better than `best` or not at all. */
static void try_turn(const packing *p, int room, int columns, double height, int turns, spot *best) {
    for (int x = 0; x + columns <= room; x++) {
        double y = 0.0, limit = best->top - height;
        for (int c = 0; c < columns && y <= limit; c++) {
            double above = p->horizon[x + c] - p->low[c];
            y = above > y ? above : y;
        }
        if (y > limit) continue;
        double lost = 0.0;
        for (int c = 0; c < columns; c++) lost += fmin(y + p->low[c], 1e30) - p->horizon[x + c];
        if (y + height < best->top || lost < best->lost) *best = (spot){y + height, lost, y, x, turns};
    }
}

static void raise_horizon(packing *p, int room, int columns, const spot *s) {
    for (int c = 0; c < columns; c++) {
        double top = s->y + p->high[c] + (double)p->gutter + SLACK;
        int from = s->x + c - p->gutter, to = s->x + c + p->gutter;
        for (int i = from < 0 ? 0 : from; i <= to && i < room; i++)
            if (top > p->horizon[i]) p->horizon[i] = top;
    }
}

/* The height that all charts need at a density, in a strip of `size` texels with half a gutter left free on both sides; infinite where one is wider. */
static double pack_strip(packing *p, int size, double density, sl_atlas_place *place) {
    int room = size - p->gutter;
    double highest = 0.0;
    for (int i = 0; i < room; i++) p->horizon[i] = 0.0;
    for (size_t i = 0; i < p->charts->count; i++) {
        uint32_t chart = p->order[i].chart;
        const sl_atlas_chart *c = &p->charts->chart[chart];
        spot best = {HUGE_VAL, HUGE_VAL, 0.0, 0, 0};
        for (int turns = 0; turns < 4; turns++) {
            double across = density * (turns % 2 ? c->height : c->width);
            if (across + SLACK > (double)room) continue;
            try_turn(p, room, outline(p, chart, density, turns), density * (turns % 2 ? c->width : c->height), turns, &best);
        }
        if (!(best.top < HUGE_VAL)) return HUGE_VAL;
        raise_horizon(p, room, outline(p, chart, density, best.turns), &best);
        highest = best.top > highest ? best.top : highest;
        place[chart] = (sl_atlas_place){best.x + 0.5 * (p->gutter + SLACK), best.y + 0.5 * p->gutter, best.turns};
    }
    return highest;
}

/* ---- the density ---- */

/* Returns the highest density found between `least` and what the area allows, 0 if not even `least` fits. */
static double search(packing *p, int size, double area, double least, sl_atlas_place *place, sl_atlas_place *trial) {
    double room = (double)(size - p->gutter), most = room / sqrt(area), fits = 0.0, density = 0.8 * most;
    size_t bytes = p->charts->count * sizeof *place;
    for (int t = 0; t < TRIES && !(fits > 0.0 && most < PRECISION * fits); t++) {
        if (density < least) density = least;
        double height = pack_strip(p, size, density, trial);
        double guess = density * sqrt(room / height); /* 0 where height is infinite */
        if (height <= room) {
            fits = density;
            memcpy(place, trial, bytes);
        } else {
            if (density <= least) return 0.0;
            most = density;
        }
        if (fits > 0.0) density = guess > 1.0005 * fits && guess < 0.9995 * most && t < 3 ? guess : sqrt(fits * most);
        else density = guess > 0.5 * density ? 0.995 * guess : 0.7 * density;
    }
    return fits;
}

/* A size at which the density `least` fits. */
static int sufficient_size(packing *p, int size, double least, sl_atlas_place *trial) {
    while (size < SIZE_MOST) {
        double height = pack_strip(p, size, least, trial);
        if (height + p->gutter <= (double)size) return size;
        double next = height < HUGE_VAL ? ceil(sqrt((double)size * (height + p->gutter))) : 1.25 * (double)size;
        size = next > (double)SIZE_MOST ? SIZE_MOST : next > (double)size ? (int)next : size + 1;
    }
    return size;
}

static bool prepare(packing *p, const sl_atlas_faces *faces, int size) {
    size_t charts = p->charts->count;
    p->widest = SIZE_MOST > size ? SIZE_MOST : size;
    p->first = sl_allocate(charts + 1, sizeof *p->first);
    p->order = sl_allocate(charts, sizeof *p->order);
    p->horizon = sl_allocate((size_t)p->widest, sizeof *p->horizon);
    p->low = sl_allocate((size_t)p->widest, sizeof *p->low);
    p->high = sl_allocate((size_t)p->widest, sizeof *p->high);
    if (!p->first || !p->order || !p->horizon || !p->low || !p->high || !gather_borders(p, faces)) return false;
    for (size_t i = 0; i < charts; i++) p->order[i] = (sorted_chart){p->charts->chart[i].height, (uint32_t)i};
    qsort(p->order, charts, sizeof *p->order, by_height);
    return true;
}

sl_status sl_atlas_pack(const sl_atlas_charts *charts, const sl_atlas_faces *faces, int size, int gutter, sl_atlas_place *place,
                        double *density, int *needed, sl_error *error) {
    packing p = {.charts = charts, .gutter = gutter};
    sl_atlas_place *trial = sl_allocate(charts->count, sizeof *trial);
    bool good = trial && prepare(&p, faces, size);
    double area = 0.0;
    for (size_t i = 0; i < charts->count; i++) area += charts->chart[i].area;
    double least = area > 0.0 ? sqrt((double)charts->count / area) : 1.0;
    *density = good ? search(&p, size, area > 0.0 ? area : 1.0, least, place, trial) : 0.0;
    *needed = good && !(*density > 0.0) ? sufficient_size(&p, size, least, trial) : size;
    sl_free(trial);
    sl_free(p.first);
    sl_free(p.segment);
    sl_free(p.order);
    sl_free(p.horizon);
    sl_free(p.low);
    sl_free(p.high);
    return good ? SL_OK : sl_fail_memory(error, "packing an atlas");
}
