/* All charts in one texture (the horizon of Levy et al. 2002): from the tallest to the lowest, each is put
 * where its top stays lowest, in any of four quarter turns; charts fit into each other as their outlines do.
 * The horizon remembers what is free below it, so that small charts come to lie in the holes that large ones
 * left. The density is the highest at which all stay inside. */
#include "cache/light_octree/atlas/parts.h"

#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"

/* A little more than the gutter, for what rounding takes. */
#define SLACK 0x1p-8
/* The horizon is kept CLASSES times: the one of class k forgets gaps lower than 2^k texels, so that thick
 * charts need not look into thin gaps. */
enum { CLASSES = 6 };
/* Outlines wider than this many columns move in longer steps, so that they stop no oftener than this in a
 * width of their own; a few charts may be tried everywhere. */
enum { STEPS = 8, FEW_CHARTS = 256 };
/* So many charts look into large gaps alone. */
enum { MANY_CHARTS = 8192 };
/* Texels: nothing is put into gaps lower than this, tips of outlines aside. */
#define THIN 2.0
/* A chart that fills this much of its box looks the same upside down. */
#define BOX_LIKE 0.97
/* The search for the density ends when it is known this well. */
#define PRECISION 1.003
/* Charts lie this much denser than their boxes would: they fit into each other. */
#define LIKELY 1.1
#define STEP 1.05
enum { TRIES = 40, SIZE_MOST = 1 << 16 };

typedef struct sorted_chart {
    double height;
    uint32_t chart;
} sorted_chart;

/* What is taken of a column of texels, from the lowest up; gutters included. */
typedef struct span {
    double low, high;
} span;

typedef struct column {
    span *taken;
    size_t count, capacity;
} column;

typedef struct packing {
    const sl_atlas_charts *charts;
    size_t *first;          /* of each chart's border segments */
    double *segment;        /* x, y, x, y */
    sorted_chart *order;
    int gutter;
    int widest;             /* room of the arrays, in columns */
    column *horizon;        /* CLASSES x widest */
    double *low, *high;     /* the outline at hand */
    uint8_t *class_of;      /* of each of its columns */
    double *gap, thin;      /* of each column of texels: see find_gaps() */
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
                uint32_t h = 3 * c->face[j / 3] + (uint32_t)(j % 3), opposite = faces->opposite[h];
                if (opposite != SL_NO_INDEX && c->of_face[opposite / 3] == i) continue;
                if (fill) memcpy(p->segment + 4 * at, c->corner + 2 * (size_t)h, 2 * sizeof *p->segment);
                if (fill)
                    memcpy(p->segment + 4 * at + 2, c->corner + 2 * (size_t)sl_atlas_next(h),
                           2 * sizeof *p->segment);
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
    for (int i = 0; i < columns; i++) {
        p->class_of[i] = p->charts->count > MANY_CHARTS ? CLASSES - 1 : 0;
        while (p->class_of[i] + 1 < CLASSES && p->high[i] - p->low[i] >= (double)(2 << p->class_of[i]))
            p->class_of[i]++;
    }
    return columns;
}

/* ---- the horizon ---- */

static void release_horizon(packing *p) {
    for (int i = 0; p->horizon && i < CLASSES * p->widest; i++) sl_free(p->horizon[i].taken);
    sl_free(p->horizon);
    sl_free(p->low);
    sl_free(p->high);
    sl_free(p->class_of);
    sl_free(p->gap);
}

static bool widen_horizon(packing *p, int widest) {
    release_horizon(p);
    p->widest = widest;
    p->horizon = sl_allocate(CLASSES * (size_t)widest, sizeof *p->horizon);
    p->low = sl_allocate((size_t)widest, sizeof *p->low);
    p->high = sl_allocate((size_t)widest, sizeof *p->high);
    p->class_of = sl_allocate((size_t)widest, sizeof *p->class_of);
    p->gap = sl_allocate((size_t)widest, sizeof *p->gap);
    return p->horizon && p->low && p->high && p->class_of && p->gap;
}

typedef struct spot {
    double top, y;
    int x, turns;
} spot;

/* The lowest y >= `y` at which [y + low, y + high] is free in a column. */
static double lift(const column *c, double y, double low, double high) {
    for (size_t i = 0; i < c->count; i++) {
        if (c->taken[i].high <= y + low) continue;
        if (c->taken[i].low >= y + high) break;
        y = c->taken[i].high - low;
    }
    return y;
}

/* For each column of texels the bottom of the lowest gap that is as high as the thinnest column of the
 * outline (or THIN). */
static void find_gaps(packing *p, int room, int columns) {
    double thinnest = HUGE_VAL;
    int class = p->charts->count > MANY_CHARTS ? CLASSES - 1 : 0;
    for (int c = 0; c < columns; c++) thinnest = fmin(thinnest, p->high[c] - p->low[c]);
    thinnest = fmax(thinnest, THIN);
    while (class + 1 < CLASSES && thinnest >= (double)(2 << class)) class++;
    for (int x = 0; x < room; x++) p->gap[x] = lift(&p->horizon[class * p->widest + x], 0.0, 0.0, thinnest);
    p->thin = thinnest;
}

/* The lowest y for the outline at x, or something beyond the limit. */
static double rest(const packing *p, int x, int columns, double limit) {
    double y = 0.0;
    for (int c = 0; c < columns; c++) y = p->gap[x + c] - p->low[c] > y ? p->gap[x + c] - p->low[c] : y;
    /* until it has gone round without being lifted */
    for (int c = 0, settled = 0; settled < columns && y <= limit; c = c + 1 < columns ? c + 1 : 0) {
        double lifted = lift(&p->horizon[p->class_of[c] * p->widest + x + c], y, p->low[c], p->high[c]);
        settled = lifted > y ? 1 : settled + 1;
        y = lifted;
    }
    return y;
}

/* The lowest place for the outline in low[] and high[] where its top is below the best one's. Wide outlines
 * move in steps, and then to the left as far as they get without being lifted. */
static void try_turn(packing *p, int room, int columns, double height, int turns, spot *best) {
    int step = columns > STEPS && p->charts->count > FEW_CHARTS ? columns / STEPS : 1;
    bool found = false;
    find_gaps(p, room, columns);
    for (int x = 0; x + columns <= room; x += step) {
        /* the last column without any gap that would do: the outline cannot cover it */
        int blocked = columns - 1;
        while (blocked >= 0 && p->gap[x + blocked] + p->thin < best->top) blocked--;
        if (blocked >= 0) {
            x += blocked + 1 - step;
            continue;
        }
        double limit = best->top - height, y = rest(p, x, columns, limit);
        if (!(y < limit)) continue;
        *best = (spot){y + height, y, x, turns};
        found = true;
    }
    for (double y; found && step > 1 && best->x > 0; *best = (spot){y + height, y, best->x - 1, turns}) {
        y = rest(p, best->x - 1, columns, best->y);
        if (y > best->y) break;
    }
}

/* Adds a span to a column and joins what is too near to leave room between. */
static bool take(column *c, span s, double thinnest) {
    size_t from = 0, to;
    while (from < c->count && c->taken[from].high + thinnest < s.low) from++;
    for (to = from; to < c->count && c->taken[to].low <= s.high + thinnest; to++) {
        s.low = fmin(s.low, c->taken[to].low);
        s.high = fmax(s.high, c->taken[to].high);
    }
    if (to == from && c->count == c->capacity) {
        span *taken = sl_allocate(2 * c->capacity + 4, sizeof *taken);
        if (!taken) return false;
        if (c->count) memcpy(taken, c->taken, c->count * sizeof *taken);
        sl_free(c->taken);
        c->taken = taken;
        c->capacity = 2 * c->capacity + 4;
    }
    memmove(c->taken + from + 1, c->taken + to, (c->count - to) * sizeof *c->taken);
    c->taken[from] = s;
    c->count = c->count + 1 - (to - from);
    return true;
}

static bool take_spot(packing *p, int room, int columns, const spot *s) {
    double around = (double)p->gutter + SLACK;
    for (int i = s->x - p->gutter < 0 ? 0 : s->x - p->gutter; i < s->x + columns + p->gutter && i < room;
         i++) {
        span taken = {HUGE_VAL, -HUGE_VAL};
        for (int c = i - s->x - p->gutter; c <= i - s->x + p->gutter; c++) {
            if (c < 0 || c >= columns) continue;
            taken.low = fmin(taken.low, p->low[c]);
            taken.high = fmax(taken.high, p->high[c]);
        }
        taken.low += s->y - around;
        taken.high += s->y + around;
        for (int k = 0; k < CLASSES; k++)
            if (!take(&p->horizon[k * p->widest + i], taken, (double)(1 << k))) return false;
    }
    return true;
}

/* The height that all charts need at a density, in a strip of `size` texels with half a gutter left free on
 * both sides; infinite where it would pass `most`. False: no memory. */
static bool pack_strip(packing *p, int size, double density, double most, sl_atlas_place *place,
                       double *highest) {
    int room = size - p->gutter;
    *highest = 0.0;
    for (int i = 0; i < CLASSES * p->widest; i++) p->horizon[i].count = 0;
    for (size_t i = 0; i < p->charts->count; i++) {
        uint32_t chart = p->order[i].chart;
        const sl_atlas_chart *c = &p->charts->chart[chart];
        spot best = {most, 0.0, -1, 0};
        for (int turns = 0; turns < (c->area > BOX_LIKE * c->width * c->height ? 2 : 4); turns++) {
            double across = density * (turns % 2 ? c->height : c->width);
            if (across + SLACK > (double)room) continue;
            try_turn(p, room, outline(p, chart, density, turns), density * (turns % 2 ? c->width : c->height),
                     turns, &best);
        }
        *highest = best.x < 0 ? HUGE_VAL : fmax(best.top, *highest);
        if (best.x < 0) return true;
        if (!take_spot(p, room, outline(p, chart, density, best.turns), &best)) return false;
        place[chart] =
            (sl_atlas_place){best.x + 0.5 * (p->gutter + SLACK), best.y + 0.5 * p->gutter, best.turns};
    }
    return true;
}

/* ---- the density ---- */

/* Where the boxes of all charts, gutters included, would fill the square: not far from what will fit. */
static double likely_density(const packing *p, double room) {
    double squares = 0.0, sides = 0.0; /* sum of (d w + g) (d h + g) = room^2 */
    for (size_t i = 0; i < p->charts->count; i++) {
        const sl_atlas_chart *c = &p->charts->chart[i];
        squares += c->width * c->height;
        sides += c->width + c->height;
    }
    double half = 0.5 * p->gutter * sides,
           rest = room * room - (double)p->charts->count * p->gutter * p->gutter;
    if (!(squares > 0.0) || !(rest > 0.0)) return 0.0;
    return rest / (half + sqrt(half * half + squares * rest));
}

/* The highest density found, at least `least`; 0 if not even that fits. Steps up or down until the answer is
 * bracketed, then halves the bracket. With a hint: the first one that fits from there down. */
static bool search(packing *p, int size, double hint, double least, sl_atlas_place *place,
                   sl_atlas_place *trial, double *fits) {
    double room = (double)(size - p->gutter), most = 0.0,
           density = fmax(hint > 0.0 ? hint : LIKELY * likely_density(p, room), least), height;
    *fits = 0.0;
    for (int t = 0; t < TRIES && !(*fits > 0.0 && most > 0.0 && most < PRECISION * *fits); t++) {
        if (!pack_strip(p, size, density, room, trial, &height)) return false;
        if (height <= room) {
            *fits = density;
            memcpy(place, trial, p->charts->count * sizeof *place);
        } else {
            if (density <= least) return true;
            most = density;
        }
        if (hint > 0.0 && *fits > 0.0) return true;
        if (*fits > 0.0 && most > 0.0) density = sqrt(*fits * most);
        else density = *fits > 0.0 ? STEP * density : fmax(density / (hint > 0.0 ? PRECISION : STEP), least);
        if (t == TRIES - 2 && !(*fits > 0.0)) density = least;
    }
    return true;
}

/* A size at which the density `least` fits. */
static bool sufficient_size(packing *p, double least, sl_atlas_place *trial, int *size) {
    double height;
    while (*size < SIZE_MOST) {
        if (!widen_horizon(p, *size) || !pack_strip(p, *size, least, HUGE_VAL, trial, &height)) return false;
        if (height + p->gutter <= (double)*size) return true;
        double next =
            height < HUGE_VAL ? ceil(sqrt((double)*size * (height + p->gutter))) : 1.25 * (double)*size;
        *size = next > (double)SIZE_MOST ? SIZE_MOST : next > (double)*size ? (int)next : *size + 1;
    }
    return true;
}

static bool prepare(packing *p, const sl_atlas_faces *faces, int size) {
    size_t charts = p->charts->count;
    p->first = sl_allocate(charts + 1, sizeof *p->first);
    p->order = sl_allocate(charts, sizeof *p->order);
    if (!p->first || !p->order || !widen_horizon(p, size) || !gather_borders(p, faces)) return false;
    for (size_t i = 0; i < charts; i++) p->order[i] = (sorted_chart){p->charts->chart[i].height, (uint32_t)i};
    qsort(p->order, charts, sizeof *p->order, by_height);
    return true;
}

static void release(packing *p) {
    release_horizon(p);
    sl_free(p->first);
    sl_free(p->segment);
    sl_free(p->order);
}

sl_status sl_atlas_pack(const sl_atlas_charts *charts, const sl_atlas_faces *faces, int size, int gutter,
                        double hint, sl_atlas_place *place, double *density, int *needed, sl_error *error) {
    packing p = {.charts = charts, .gutter = gutter};
    sl_atlas_place *trial = sl_allocate(charts->count, sizeof *trial);
    double area = 0.0;
    for (size_t i = 0; i < charts->count; i++) area += charts->chart[i].area;
    double least = area > 0.0 ? sqrt((double)charts->count / area) : 1.0;
    bool good = trial && prepare(&p, faces, size) && search(&p, size, hint, least, place, trial, density);
    *needed = size;
    if (good && !(*density > 0.0)) good = sufficient_size(&p, least, trial, needed);
    sl_free(trial);
    release(&p);
    return good ? SL_OK : sl_fail_memory(error, "packing an atlas");
}
