/* What is seen in a mirror lies elsewhere than where the picture shows it, so the rectangle about a record's
 * sphere on the screen (step 1 of Algorithm 1) misses those pixels. They are found by where they lie in the
 * world instead: by boxes about 16 x 16 pixels each. */
#include "cache/splatting/mirrors.h"

#include "base/error.h"
#include "base/memory.h"

#include <math.h>

enum { BLOCK = 16, TILE = SL_SPLAT_TILE, BLOCKS_A_TILE = TILE / BLOCK };

static bool is_empty(sl_splat_rect r) { return r.x0 >= r.x1 || r.y0 >= r.y1; }
static int lesser(int a, int b) { return a < b ? a : b; }
static int greater(int a, int b) { return a > b ? a : b; }

static sl_splat_rect rect_union(sl_splat_rect a, sl_splat_rect b) {
    if (is_empty(a)) return b;
    if (is_empty(b)) return a;
    return (sl_splat_rect){lesser(a.x0, b.x0), lesser(a.y0, b.y0), greater(a.x1, b.x1), greater(a.y1, b.y1)};
}

/* ---- blocks ---- */

static void add_pixel(const sl_gbuffer *g, size_t pixel, sl_mirror_block *b) {
    int x = (int)(pixel % (size_t)g->width), y = (int)(pixel / (size_t)g->width);
    sl_vec3 p = sl_v3(g->position_x[pixel], g->position_y[pixel], g->position_z[pixel]);
    bool first = b->rect.x0 >= b->rect.x1;
    b->rect = rect_union(b->rect, (sl_splat_rect){x, y, x + 1, y + 1});
    b->low = first ? p : sl_v3(fminf(b->low.x, p.x), fminf(b->low.y, p.y), fminf(b->low.z, p.z));
    b->high = first ? p : sl_v3(fmaxf(b->high.x, p.x), fmaxf(b->high.y, p.y), fmaxf(b->high.z, p.z));
}

/* Blocks of a tile follow each other. */
static size_t block_of(const sl_gbuffer *g, size_t pixel) {
    size_t x = pixel % (size_t)g->width, y = pixel / (size_t)g->width,
           tiles = ((size_t)g->width + TILE - 1) / TILE;
    size_t tile = y / TILE * tiles + x / TILE, inside = y % TILE / BLOCK * BLOCKS_A_TILE + x % TILE / BLOCK;
    return tile * BLOCKS_A_TILE * BLOCKS_A_TILE + inside;
}

sl_status sl_mirror_blocks_make(const sl_gbuffer *g, const sl_reflections *reflections,
                                sl_mirror_blocks *blocks, sl_error *error) {
    size_t tiles = ((size_t)g->width + TILE - 1) / TILE * (((size_t)g->height + TILE - 1) / TILE),
           count = tiles * BLOCKS_A_TILE * BLOCKS_A_TILE;
    sl_mirror_blocks_release(blocks);
    blocks->width = g->width;
    blocks->height = g->height;
    if (!reflections) return SL_OK;
    blocks->blocks = sl_allocate(count, sizeof *blocks->blocks);
    if (!blocks->blocks) return sl_fail_memory(error, "what mirrors show");
    for (size_t k = 0; k < reflections->count; k++) {
        size_t pixel = reflections->pixel[k];
        if (g->material[pixel] != SL_NO_INDEX) add_pixel(g, pixel, &blocks->blocks[block_of(g, pixel)]);
    }
    for (size_t k = 0; k < count; k++) {
        if (blocks->blocks[k].rect.x0 < blocks->blocks[k].rect.x1)
            blocks->blocks[blocks->count++] = blocks->blocks[k];
    }
    return SL_OK;
}

void sl_mirror_blocks_release(sl_mirror_blocks *blocks) {
    sl_free(blocks->blocks);
    *blocks = (sl_mirror_blocks){0};
}

/* ---- spheres and blocks ---- */

static float outside(float low, float high, float x) {
    return x < low ? low - x : x > high ? x - high : 0.0f;
}

static bool reaches(const sl_mirror_block *b, sl_vec3 centre, float reach) {
    float x = outside(b->low.x, b->high.x, centre.x), y = outside(b->low.y, b->high.y, centre.y),
          z = outside(b->low.z, b->high.z, centre.z);
    return x * x + y * y + z * z <= reach * reach;
}

static bool reaches_any(const sl_mirror_blocks *blocks, sl_vec3 centre, float reach) {
    size_t k = 0;
    while (k < blocks->count && !reaches(&blocks->blocks[k], centre, reach)) k++;
    return k < blocks->count;
}

static sl_splat_rect part_in_tile(sl_splat_rect r, int x, int y) {
    sl_splat_rect part = {greater(r.x0, x), greater(r.y0, y), lesser(r.x1, x + TILE), lesser(r.y1, y + TILE)};
    return is_empty(part) ? (sl_splat_rect){0, 0, 0, 0} : part;
}

/* Blocks from number *next on that lie in the tile, as far as the sphere reaches them. */
static sl_splat_rect mirrored_in_tile(const sl_mirror_blocks *blocks, sl_vec3 centre, float reach, int x,
                                      int y, size_t *next) {
    sl_splat_rect all = {0, 0, 0, 0};
    for (; *next < blocks->count; (*next)++) {
        const sl_mirror_block *b = &blocks->blocks[*next];
        if (b->rect.x0 / TILE != x / TILE || b->rect.y0 / TILE != y / TILE) break;
        if (reaches(b, centre, reach)) all = rect_union(all, b->rect);
    }
    return all;
}

/* No pixel is in two rectangles, since tiles have none in common. */
size_t sl_mirror_rects(const sl_mirror_blocks *blocks, sl_vec3 centre, float reach, sl_splat_rect seen,
                       sl_splat_rect *rects) {
    size_t count = 0, next = 0;
    if (!reaches_any(blocks, centre, reach)) {
        if (rects) rects[0] = seen;
        return 1;
    }
    for (int y = 0; y < blocks->height; y += TILE) {
        for (int x = 0; x < blocks->width; x += TILE) {
            sl_splat_rect r =
                rect_union(part_in_tile(seen, x, y), mirrored_in_tile(blocks, centre, reach, x, y, &next));
            if (is_empty(r)) continue;
            if (rects) rects[count] = r;
            count++;
        }
    }
    return count;
}
