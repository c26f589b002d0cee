/* Integrals of the hemispherical harmonics over an instrument's cells and along the walls between them, in
 * double: B_i = integral of H_i d omega of a cell, by Gauss's rule. Every instrument is symmetric about both
 * axes of its picture, so it is enough to know the quadrant x >= 0, y >= 0; of a cell or wall that an axis
 * cuts, these are the integrals over its part there. */
#ifndef SL_CACHE_PROJECTION_INTEGRALS_H
#define SL_CACHE_PROJECTION_INTEGRALS_H

#include "cache/hemisphere/gather_tables.h"
#include "cache/hemisphere/harmonics.h"

enum { SL_RULE_MAX = 24 };

/* Quadrature nodes on [0,1]. */
typedef struct sl_rule {
    int count;
    double node[SL_RULE_MAX], weight[SL_RULE_MAX];
} sl_rule;

typedef struct sl_instrument {
    sl_gather_kind kind;
    int size, width;
    double half_tangent; /* plane */
    sl_border border;    /* plane */
    int order;
    sl_hsh_recurrence recurrence;
    sl_rule fine, coarse; /* towards the horizon; elsewhere */
} sl_instrument;

sl_instrument sl_instrument_of(const sl_gather_tables *tables, double half_tangent, sl_border border,
                               int order);

/* sums: sl_hsh_stride(order) doubles, the integral of every H over the cell in column x and row y (and over
 * its border extension down to the horizon) in solid angle. */
void sl_cell_harmonics(const sl_instrument *instrument, int x, int y, double *sums);

/* A wall: the arc between two cells, made by surfaces at depth 1. Displacing the receiver by delta in the
 * surface gives the solid angle (x, y) . delta to the cell that lies to the right (above; on the y side),
 * taken from the one to the left (below; on the x side). mean: of every H along the arc, weighted by that
 * motion. */
typedef enum sl_wall_type {
    SL_WALL_COLUMN,
    SL_WALL_ROW,
    SL_WALL_BORDER_COLUMN,
    SL_WALL_BORDER_ROW
} sl_wall_type;
typedef struct sl_wall {
    double x, y;
    double mean[SL_HSH_STRIDE_MAX];
} sl_wall;

/* COLUMN: between cells (x-1, y) and (x, y); ROW: between (x, y-1) and (x, y); BORDER: what the outermost
 * column or row wall of the plane becomes in the radial extension. */
void sl_wall_harmonics(const sl_instrument *instrument, sl_wall_type type, int x, int y, sl_wall *wall);

#endif
