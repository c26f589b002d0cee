/* Over how much surface gathered photons were strewn: a disc, the section of a tilted plane, or the scene's
 * own triangles within the ellipsoid less what no photon met. */
#pragma once

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

/* Areas within the ellipsoid of triangles with n_t . n >= least_cosine, and with -n_t . n >= it.
 * together: they are one sheet, to be seen from both sides, and not the two faces
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

/* ---- what photons tell of it by themselves ----
 *
 * An ellipsoid may hold surface that no light reaches: walls inside walls, what stands behind mouldings and
 * under books. Photons divided by all of it are too few a square metre. Points strewn evenly over an ellipse
 * of area A have a covariance C with A = 4 pi sqrt(det C); of a rectangle that says 1.05 times its area, of
 * half a disc 1.06. */

/* Sums over photons' places on the ellipsoid's disc. */
typedef struct sl_place_sums {
    double count, x, y, xx, xy, yy;
} sl_place_sums;

static inline void sl_place_sums_add(sl_place_sums *s, double x, double y) {
    s->count += 1.0;
    s->x += x;
    s->y += y;
    s->xx += x * x;
    s->xy += x * y;
    s->yy += y * y;
}

/* Of an area of surface, the share that those photons say they were strewn over: 1 unless it is clearly less.
 */
double sl_strewn_share(const sl_place_sums *places, double area);
