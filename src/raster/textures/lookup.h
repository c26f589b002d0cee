/* The plain filters that single lookups share (lookup.c). */
#ifndef SL_RASTER_LOOKUP_H
#define SL_RASTER_LOOKUP_H

#include "raster/textures/texel_place.h"

/* The four texels around a point, lower left, lower right, upper left, upper right, and the weights between them. For
 * a nearest lookup all four are the same. */
typedef struct sl_footprint {
    const float *texel[4];
    double right, up;
} sl_footprint;

static inline double sl_filter_channel(const sl_footprint *f, int c) {
    double low = sl_mix((double)f->texel[0][c], (double)f->texel[1][c], f->right);
    double high = sl_mix((double)f->texel[2][c], (double)f->texel[3][c], f->right);
    return sl_mix(low, high, f->up);
}

/* Blends two levels (of a MIP map) or two slices (of a volume), and rounds once. One texel alone comes out as it
 * stands, also where it is infinite or -0. */
static inline void sl_filter_two(const sl_footprint *first, const sl_footprint *second, double weight, bool linear,
                                 float rgba[4]) {
    for (int c = 0; c < 4; c++) {
        if (!linear && !(weight > 0.0)) {
            rgba[c] = first->texel[0][c];
            continue;
        }
        double value = sl_filter_channel(first, c);
        if (weight > 0.0) value = sl_mix(value, sl_filter_channel(second, c), weight);
        rgba[c] = (float)value;
    }
}

#endif
