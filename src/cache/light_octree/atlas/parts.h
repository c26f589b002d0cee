/* Data that the steps of the atlas hand to each other. Faces are the scene's triangles; corner 3 f + k is
 * corner k of face f, and the half-edge 3 f + k runs from that corner to the next one of its face. */
#pragma once

#include "cache/light_octree/atlas/atlas.h"

/* ---- faces.c ---- */

typedef struct sl_atlas_faces {
    const sl_scene *scene;
    size_t count;
    uint32_t *opposite;  /* of each half-edge: the one that runs the other way; SL_NO_INDEX at borders */
    sl_vec3d *normal;    /* unit; (0,0,0) for slivers, whose own normal says nothing */
    double *area;
} sl_atlas_faces;

static inline sl_vec3d sl_atlas_corner(const sl_atlas_faces *faces, size_t corner) {
    return sl_to_double(sl_scene_position(faces->scene, faces->scene->vertex[corner % 3][corner / 3]));
}
static inline uint32_t sl_atlas_next(uint32_t half_edge) {
    return half_edge % 3 == 2 ? half_edge - 2 : half_edge + 1;
}

sl_status sl_atlas_faces_create(const sl_scene *scene, sl_atlas_faces *faces, sl_error *error);
void sl_atlas_faces_release(sl_atlas_faces *faces);

/* ---- charts.c ---- */

/* A chart in its plane: a box of that size from the origin on, in units of the scene. */
typedef struct sl_atlas_plane {
    size_t first, count;          /* its faces: a range of `face` */
    sl_vec3d origin, right, up;   /* right x up is the plane's normal */
    double width, height;         /* the longer side lies along `right` */
    double x, y;                  /* its lower left corner in the atlas, in texels (pack.c) */
} sl_atlas_plane;

typedef struct sl_atlas_charts {
    size_t count;
    sl_atlas_plane *plane;
    uint32_t *face;         /* all faces, chart by chart */
    uint32_t *of_face;      /* the chart of each face */
} sl_atlas_charts;

sl_status sl_atlas_charts_create(const sl_atlas_faces *faces, double bend, sl_atlas_charts *charts,
                                 sl_error *error);
void sl_atlas_charts_release(sl_atlas_charts *charts);

/* ---- pack.c ---- */

/* Places all charts in a square of size x size texels at nearly the highest density at which shelves hold
 * them. Density 0: they do not fit with one texel a chart on the mean; then *needed is a size that would do.
 */
sl_status sl_atlas_pack(const sl_atlas_charts *charts, const sl_atlas_faces *faces, int size, int gutter,
                        double *density, int *needed, sl_error *error);
