/* Loops over planes that need no geometry: blending of constants, reduction. */
#ifndef SL_RASTER_PLANES_H
#define SL_RASTER_PLANES_H

typedef struct sl_plane_kernels {
    /* Adds a value to pixels [x0, x1) x [y0, y1) of one plane of a tile (SL_SPLAT_TILE pixels a row, aligned to 64 bytes). */
    void (*add)(float *tile, int x0, int y0, int x1, int y1, float value);
    /* 2x2 sums of `rows` rows (even) of `width` pixels (even) into rows / 2 rows of width / 2. */
    void (*halve)(const float *in, int width, int rows, float *out);
} sl_plane_kernels;

const sl_plane_kernels *sl_plane_kernels_best(void);

#endif
