/* A texture atlas over a scene's triangles: charts grown over the faces (Sander et al. 2003), each flattened
 * conformally (least squares conformal maps, Levy et al. 2002), packed into a square.
 *
 *   charts.c     which faces go together
 *   conformal.c  a chart in the plane
 *   pack.c       all charts in one texture
 *   atlas.c      the three of them, and what is done with what they refuse
 *   gutter.c     texels around charts, so that filtering finds no seams
 */
#ifndef SL_CACHE_LIGHT_OCTREE_ATLAS_H
#define SL_CACHE_LIGHT_OCTREE_ATLAS_H

#include "scene/scene.h"

typedef struct sl_atlas_settings {
    int size;          /* texels a side */
    int gutter;        /* texels between charts: 2 */
    double bend;       /* radians between a chart's axis and its faces' normals at most: 75 degrees */
    unsigned threads;
} sl_atlas_settings;

typedef struct sl_atlas {
    int size;
    size_t triangle_count;
    size_t chart_count;
    uint32_t *chart;        /* of each triangle */
    float *coordinates;     /* s, t in [0,1] of corners 0, 1, 2: 6 floats a triangle */
    double texels_per_unit; /* the common density: texels for a length of 1 in the scene */
    /* mean over the area of (largest / smallest singular value): 1 is conformal everywhere */
    double stretch;
    double coverage;        /* share of the texels that lie in a chart */
    size_t single;          /* charts of one triangle that nothing else could be done with */
} sl_atlas;

/* Every triangle is mapped once, no two overlap, none is flipped. Deterministic. Where all cannot fit the
 * density sinks; where it would sink below a texel a chart, that is an error which says which size would do.
 */
sl_status sl_atlas_create(const sl_scene *scene, const sl_atlas_settings *settings, sl_atlas **atlas,
                          sl_error *error);
void sl_atlas_destroy(sl_atlas *atlas);
size_t sl_atlas_bytes(const sl_atlas *atlas);

/* Which triangle each texel's centre lies in, and where (barycentric weights of corners 1 and 2); SL_NO_INDEX
 * outside all charts. Texels whose centre lies just outside a chart, within `gutter`, take the nearest point
 * of it. Arrays of size*size, row 0 at the bottom. */
sl_status sl_atlas_texels(const sl_atlas *atlas, const sl_scene *scene, int gutter, unsigned threads,
                          uint32_t *triangle, float *w1, float *w2, sl_error *error);

#endif
