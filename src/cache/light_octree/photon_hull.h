/* How much surface photons tell of by themselves: the convex hull of their places.
 *
 * An ellipsoid may hold surface that no light reaches: walls inside walls, what stands behind mouldings and
 * under books. Photons divided by all of it are too few a square metre. Where they are strewn evenly over a
 * convex piece of area A, their hull, of N - N_b photons and N_b corners, tells A without bias (Baldin and
 * Reiss 2016, "Unbiased estimation of the volume of a convex body"):
 *
 *     A = |hull| (N + 1) / (N - N_b + 1),   with a standard deviation of about A sqrt(N_b) / N
 */
#ifndef SL_CACHE_LIGHT_OCTREE_PHOTON_HULL_H
#define SL_CACHE_LIGHT_OCTREE_PHOTON_HULL_H

#include "base/error.h"

#include <stddef.h>
#include <stdint.h>

/* Places in a plane, and room to work in; a worker's own. */
typedef struct sl_hull_points {
    size_t count;
    float *x, *y;          /* room for `capacity` */
    uint32_t *outer;       /* likewise */
    uint32_t *chain;       /* room for twice as many */
} sl_hull_points;

sl_status sl_hull_points_create(size_t capacity, sl_hull_points *points, sl_error *error);
void sl_hull_points_release(sl_hull_points *points);

typedef struct sl_photon_hull {
    double area;           /* 0: all in one line */
    size_t corners;
} sl_photon_hull;

/* Does not depend on the points' order. */
sl_photon_hull sl_photon_hull_of(sl_hull_points *points);
/* Of an area of surface, the share that those photons say they were strewn over: 1 unless they are sure that
 * it is less. */
double sl_photon_hull_share(const sl_photon_hull *hull, size_t photons, double area);

#endif
