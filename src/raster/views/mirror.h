/* Planar mirrors: the scene is drawn again as seen from the eye's mirror image, where the mirror's pixels
 * are.
 *
 *          eye o                 The light's path eye - m - x is as long as the straight line from the image
 * of the \      x         eye to x: a view from there, its axes mirrored too, draws x where the mirror shows
 * it. \    /          The scene itself stays as it is, so whatever is computed at x (position, normal, side,
 *      ___________\__/______     shadow) needs no unfolding. What lies below the mirror's plane would stand
 * in the way: m/   mirror   the plane is the view's near plane.
 *                  /
 *           eye' o
 *
 * The near plane is oblique. In a matrix with a far plane (Lengyel 2005, "Oblique view frustum depth
 * projection and clipping") that skews the far plane and spends depth precision. Here depth is 1/w, which row
 * 2 of the matrix has no part in: the row holds the mirror's plane and nothing else, depth keeps all its
 * bits, and there is no far plane to skew.
 *
 * A mirrored view turns counter-clockwise triangles clockwise. Coverage does not ask for the winding, its
 * fill rule is the screen's, and sides are decided by sl_scene_surface() with the view's own origin: nothing
 * needs to be flipped. */
#ifndef SL_RASTER_MIRROR_H
#define SL_RASTER_MIRROR_H

#include "raster/raster.h"

/* normal . p = distance, normal of length 1. */
typedef struct sl_plane {
    sl_vec3d normal;
    double distance;
} sl_plane;

/* False where the corners span no plane (no area, not finite). */
bool sl_plane_through(sl_vec3 a, sl_vec3 b, sl_vec3 c, sl_plane *plane);
sl_vec3d sl_plane_reflect(const sl_plane *plane, sl_vec3d p);

/* A perspective view of the scene in a mirror, on the same pixels; 1/w depth, w being the way along the
 * unfolded line of sight. Of the scene, only what lies more than `offset` in front of the mirror (on the
 * eye's side) is drawn: enough to clear the mirror's own triangles of rounding, too little to be seen (a few
 * millionths of the scene's scale). A mirrored view may be mirrored again. False where nothing can be seen:
 * the eye is in the plane, or the plane is none. */
bool sl_view_mirrored(const sl_view *view, const sl_plane *mirror, double offset, sl_view *mirrored);

/* ---- what is seen, and by which path ---- */

typedef struct sl_mirrors {
    size_t count;
    sl_plane *plane;
    uint32_t *material;    /* of each */
    sl_vec3 *low, *high;   /* box of each */
    uint32_t *of_triangle; /* the scene's triangles: index of the mirror, or SL_NO_INDEX */
    double offset;         /* for sl_view_mirrored() */
} sl_mirrors;

/* The scene's planar mirrors, the largest `limit` of them: triangles of one mirror material in one plane,
 * whose shading normals do not bend away from it (those are curved mirrors). */
sl_status sl_mirrors_find(const sl_scene *scene, size_t limit, sl_mirrors **mirrors, sl_error *error);
void sl_mirrors_destroy(sl_mirrors *mirrors);

enum { SL_MIRROR_PATHS = 255 }; /* the stencil is a byte */

/* A way from the eye over mirrors: path 0 is the direct one. */
typedef struct sl_mirror_path {
    sl_view view;     /* what draws, and resolves, the path's pixels */
    uint32_t mirror;  /* the last one met; SL_NO_INDEX for path 0 */
    uint8_t before;   /* the path without it */
    int reflections;
    int x0, y0, x1, y1; /* its pixels' bounding rectangle, half-open */
} sl_mirror_path;

typedef struct sl_mirrored_image {
    int width, height;
    /* the caller's: what is seen at the end of the path; a mirror's triangle where no more reflections are
     * followed */
    uint32_t *id;
    float *depth;   /* the caller's, of the path's view: path 0's kind as asked, the others' 1/w */
    /* the stencil: which path each pixel takes; NULL: no mirror is in sight, all take path 0 */
    uint8_t *path;
    size_t path_count;
    sl_mirror_path paths[SL_MIRROR_PATHS];
} sl_mirrored_image;

/* One ID pass, and one stencilled pass for every mirror in sight along every path of fewer than `reflections`
 * reflections, into planes of the view's size. What would be path 256 is not followed. */
sl_status sl_raster_mirrored(const sl_raster *raster, const sl_view *view, const sl_mirrors *mirrors,
                             int reflections, unsigned threads, uint32_t *id, float *depth,
                             sl_mirrored_image **image, sl_counters *counters, sl_error *error);
void sl_mirrored_image_destroy(sl_mirrored_image *image);

#endif
