/* Over how much surface gathered photons were strewn: a disc, the section of a tilted plane, or the scene's
 * own triangles within the ellipsoid less what no photon met. */
#ifndef SL_CACHE_LIGHT_OCTREE_PHOTON_AREA_H
#define SL_CACHE_LIGHT_OCTREE_PHOTON_AREA_H

#include "cache/light_octree/octree.h"

typedef struct sl_ellipsoid {
    sl_vec3d centre;
    sl_vec3d normal; /* unit: its short axis; (0,0,0): a sphere */
    double flatness; /* f: half axes R, R, f R */
    double radius;   /* R */
} sl_ellipsoid;

double sl_disc_area(const sl_ellipsoid *e);
/* Of the plane with that unit normal at signed distance h from the centre; 0 where it misses. */
double sl_section_area(const sl_ellipsoid *e, sl_vec3d normal, double h);
/* Of a triangle's part inside: exact. */
double sl_triangle_in_ellipsoid(const sl_ellipsoid *e, sl_vec3d a, sl_vec3d b, sl_vec3d c);

/* ---- all triangles ---- */

/* Which triangles were met already in this query: one for each worker. */
typedef struct sl_triangle_marks {
    uint32_t *mark; /* a triangle's last query */
    uint32_t query;
} sl_triangle_marks;

/* Areas within the ellipsoid of triangles with n_t . n >= least_cosine, and with -n_t . n >= it; of layers
 * that hide each other, one. together: they are one sheet, to be seen from both sides, and not the two faces
 * of a wall: each side's area is that of both. flat: the same projected along the ellipsoid's normal, on its
 * disc; 0 without a normal. least_cosine -1: all triangles, together. */
typedef struct sl_strewn_area {
    double side[2], flat[2]; /* in front, behind */
    bool together;
} sl_strewn_area;

/* A zero normal: all triangles. */
sl_strewn_area sl_surface_in_ellipsoid(const sl_scene *scene, const sl_octree *octree,
                                       const sl_ellipsoid *ellipsoid, double least_cosine,
                                       sl_triangle_marks *marks);

/* ---- what photons tell of it by themselves (photon_hull.c) ----
 *
 * An ellipsoid may hold surface that no light reaches: walls inside walls, what stands behind mouldings and
 * under books. Photons divided by all of it are too few a square metre. Where they are strewn evenly over a
 * convex piece of area A, their hull, of N - N_b photons and N_b corners, tells A without bias (Baldin and
 * Reiss 2016, "Unbiased estimation of the volume of a convex body"):
 *
 *     A = |hull| (N + 1) / (N - N_b + 1),   with a standard deviation of about A sqrt(N_b) / N */

/* Places in a plane, and room to work in; a worker's own. */
typedef struct sl_hull_points {
    size_t count;
    float *x, *y;          /* room for `capacity` */
    uint32_t *outer;       /* likewise */
    uint32_t *chain;       /* room for twice as many */
} sl_hull_points;

sl_status sl_hull_points_create(size_t capacity, sl_hull_points *points, sl_error *error);
void sl_hull_points_release(sl_hull_points *points);
/* Some of the points, with the same room to work in. */
static inline sl_hull_points sl_hull_points_from(const sl_hull_points *p, size_t first, size_t count) {
    return (sl_hull_points){count, p->x + first, p->y + first, p->outer, p->chain};
}

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
