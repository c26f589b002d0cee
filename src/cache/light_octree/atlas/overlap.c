/* Overlaps of triangles in the plane, decided exactly: their corners are whole numbers. Each must have
 * positive area, and the insides of two must be disjoint, which they are if and only if the line through an
 * edge of one has the other on its outer side. That replaces what could be said of discs (positive everywhere
 * and a border that does not cross itself), and holds for charts with holes as well. */
#include "cache/light_octree/atlas/parts.h"

#include "base/memory.h"

static int64_t turn(const int64_t *a, const int64_t *b, const int64_t *p) {
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

/* An edge of t has u on its outer side (or on it). */
static bool separated_by(const int64_t *t, const int64_t *u) {
    for (size_t k = 0; k < 3; k++) {
        const int64_t *a = t + 2 * k, *b = t + 2 * ((k + 1) % 3);
        if (turn(a, b, u) <= 0 && turn(a, b, u + 2) <= 0 && turn(a, b, u + 4) <= 0) return true;
    }
    return false;
}

typedef struct box {
    int64_t low[2], high[2];
} box;

static box box_of(const int64_t *t) {
    box b = {{t[0], t[1]}, {t[0], t[1]}};
    for (size_t k = 1; k < 3; k++)
        for (size_t d = 0; d < 2; d++) {
            if (t[2 * k + d] < b.low[d]) b.low[d] = t[2 * k + d];
            if (t[2 * k + d] > b.high[d]) b.high[d] = t[2 * k + d];
        }
    return b;
}

/* A grid over all boxes, about one cell a triangle. */
typedef struct grid {
    int64_t low[2], cell[2];
    size_t side;
    size_t *first;
    uint32_t *triangle;
} grid;

static void cells_of(const grid *g, const box *b, size_t low[2], size_t high[2]) {
    for (size_t d = 0; d < 2; d++) {
        low[d] = (size_t)((b->low[d] - g->low[d]) / g->cell[d]);
        high[d] = (size_t)((b->high[d] - g->low[d]) / g->cell[d]);
    }
}

static bool fill_grid(grid *g, const box *boxes, size_t count) {
    box all = boxes[0];
    size_t low[2], high[2], entries = 0;
    for (size_t i = 1; i < count; i++)
        for (size_t d = 0; d < 2; d++) {
            if (boxes[i].low[d] < all.low[d]) all.low[d] = boxes[i].low[d];
            if (boxes[i].high[d] > all.high[d]) all.high[d] = boxes[i].high[d];
        }
    for (g->side = 1; g->side * g->side < count;) g->side++;
    for (size_t d = 0; d < 2; d++) {
        g->low[d] = all.low[d];
        g->cell[d] = (all.high[d] - all.low[d]) / (int64_t)g->side + 1;
    }
    for (size_t i = 0; i < count; i++) {
        cells_of(g, &boxes[i], low, high);
        entries += (high[0] - low[0] + 1) * (high[1] - low[1] + 1);
    }
    g->first = sl_allocate(g->side * g->side + 2, sizeof *g->first);
    g->triangle = sl_allocate(entries, sizeof *g->triangle);
    if (!g->first || !g->triangle) return false;
    for (int fill = 0; fill < 2; fill++) { /* count, then fill */
        for (size_t i = 0; i < count; i++) {
            cells_of(g, &boxes[i], low, high);
            for (size_t y = low[1]; y <= high[1]; y++)
                for (size_t x = low[0]; x <= high[0]; x++) {
                    size_t c = y * g->side + x;
                    if (fill) g->triangle[g->first[c + 1]++] = (uint32_t)i;
                    else g->first[c + 2]++;
                }
        }
        if (!fill)
            for (size_t c = 2; c < g->side * g->side + 2; c++) g->first[c] += g->first[c - 1];
    }
    return true;
}

/* The pair is tested in one cell alone: the one with the lower left corner of what the boxes share. */
static bool belongs(const grid *g, const box *a, const box *b, size_t cell) {
    box shared = {
        {a->low[0] > b->low[0] ? a->low[0] : b->low[0], a->low[1] > b->low[1] ? a->low[1] : b->low[1]},
        {0, 0}};
    shared.high[0] = a->high[0] < b->high[0] ? a->high[0] : b->high[0];
    shared.high[1] = a->high[1] < b->high[1] ? a->high[1] : b->high[1];
    if (shared.low[0] >= shared.high[0] || shared.low[1] >= shared.high[1]) return false;
    size_t low[2], high[2];
    cells_of(g, &shared, low, high);
    return low[1] * g->side + low[0] == cell;
}

static void test_cell(const grid *g, const int64_t *corner, const box *boxes, size_t cell, uint8_t *bad) {
    for (size_t i = g->first[cell]; i < g->first[cell + 1]; i++)
        for (size_t j = i + 1; j < g->first[cell + 1]; j++) {
            uint32_t a = g->triangle[i], b = g->triangle[j]; /* a < b */
            if (bad[a] || bad[b] || !belongs(g, &boxes[a], &boxes[b], cell)) continue;
            if (!separated_by(corner + 6 * (size_t)a, corner + 6 * (size_t)b) &&
                !separated_by(corner + 6 * (size_t)b, corner + 6 * (size_t)a))
                bad[b] = 1;
        }
}

bool sl_atlas_overlap(const int64_t *corner, size_t count, uint8_t *bad) {
    grid g = {{0}, {0}, 0, NULL, NULL};
    if (!count) return true;
    box *boxes = sl_allocate(count, sizeof *boxes);
    for (size_t i = 0; boxes && i < count; i++) {
        boxes[i] = box_of(corner + 6 * i);
        bad[i] = turn(corner + 6 * i, corner + 6 * i + 2, corner + 6 * i + 4) <= 0;
    }
    bool good = boxes && (count == 1 || fill_grid(&g, boxes, count));
    if (good && count > 1)
        for (size_t c = 0; c < g.side * g.side; c++) test_cell(&g, corner, boxes, c, bad);
    sl_free(boxes);
    sl_free(g.first);
    sl_free(g.triangle);
    return good;
}
