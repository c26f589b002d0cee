/* The part of a picture that one thread draws.
 *
 * A tile's planes are kept in blocks of 4 x 4 pixels, a block being sixteen lanes side by side in memory:
 *
 *      y                                    12 13 14 15 | 28 29 30 31 | ...
 *      |     +--+--+--+                      8  9 10 11 | 24 25 26 27 |
 *      |     |b3|b4|b5|       each block:    4  5  6  7 | 20 21 22 23 |
 *      |     +--+--+--+                      0  1  2  3 | 16 17 18 19 |
 *      |     |b0|b1|b2|
 *      +---- +--+--+--+ ---- x              block 0       block 1
 *
 * Small triangles touch few blocks, where they would touch many rows. */
#pragma once

#include "raster/clusters.h"
#include "raster/view.h"

enum {
    SL_BLOCK = 4,          /* pixels along a block's side; also the most along a tiny triangle's */
    /* larger triangles are drawn in pieces of 64 x 64, within which edge functions fit 32 bits */
    SL_SPAN = 64,
    SL_TILE = 256,         /* pixels along a tile's side */
    SL_TILE_PIXELS = SL_TILE * SL_TILE
};

/* The picture in the making: at most SL_TILE x SL_TILE pixels, block by block. */
typedef struct sl_tile {
    int left, low;         /* the first block's first pixel, in the target; multiples of SL_TILE */
    int x0, y0, x1, y1;    /* the pixels to draw, half-open */
    int blocks_x, blocks_y;
    uint32_t *id;
    float *depth;
} sl_tile;

/* Pixels, inclusive. */
typedef struct sl_rectangle {
    int x0, y0, x1, y1;
} sl_rectangle;

/* A tile's place in the target and the viewport's part of it. */
void sl_tile_place(sl_tile *tile, const sl_pass_view *view, int column, int row);
/* Number and first of the tiles that the viewport touches. */
typedef struct sl_tiles {
    int first_column, first_row, columns, rows;
} sl_tiles;
sl_tiles sl_tiles_of(const sl_pass_view *view);

/* Index of a pixel in the tile's planes. */
static inline size_t sl_tile_index(const sl_tile *tile, int x, int y) {
    int i = x - tile->left, j = y - tile->low;
    return (size_t)(((j >> 2) * tile->blocks_x + (i >> 2)) * SL_LANES + (j & 3) * SL_BLOCK + (i & 3));
}
