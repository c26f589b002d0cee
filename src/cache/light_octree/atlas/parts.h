/* What the steps of the atlas hand to each other. Faces are the scene's triangles; corner 3 f + k is corner k
 * of face f, and the half-edge 3 f + k runs from that corner to the next one of its face. */
#ifndef SL_CACHE_LIGHT_OCTREE_ATLAS_PARTS_H
#define SL_CACHE_LIGHT_OCTREE_ATLAS_PARTS_H

#include "cache/light_octree/atlas/atlas.h"

/* Atlas coordinates are whole multiples of 2^-24: floats hold them exactly, so that orientation and overlap
 * are decided without rounding. */
#define SL_ATLAS_GRID 16777216.0

/* ---- faces.c: which faces share an edge ---- */

typedef struct sl_atlas_faces {
    const sl_scene *scene;
    size_t count;
    uint32_t *point;     /* of each corner; corners with the same bits of position are the same point */
    /* of each half-edge: the one it is glued to, which runs the other way; SL_NO_INDEX at borders */
    uint32_t *opposite;
    sl_vec3d *normal;    /* unit; (0,0,0) for slivers, whose own normal says nothing */
    sl_vec3d *centre;
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

/* ---- grow.c: Dijkstra over faces ---- */

typedef struct sl_atlas_seed {
    uint32_t face;
    /* of the chart that grew from the last seed, unit; (0,0,0): none yet, the chart's running mean is used */
    sl_vec3d normal;
} sl_atlas_seed;

typedef struct sl_atlas_queue_entry {
    double cost;
    uint32_t face, chart;
} sl_atlas_queue_entry;

/* A priority queue ordered by (cost, face, chart). */
typedef struct sl_atlas_queue {
    sl_atlas_queue_entry *entry;
    size_t count, capacity;
} sl_atlas_queue;

typedef struct sl_atlas_region {
    const sl_atlas_faces *faces;
    const uint32_t *member; /* face f belongs to the region where member[f] == id */
    uint32_t id;
    const uint32_t *face;   /* its faces */
    size_t count;
    /* of each face of the scene, the region's alone are used: the seed it belongs to, or SL_NO_INDEX */
    uint32_t *chart;
    double *cost;           /* the same */
    sl_atlas_queue queue;
} sl_atlas_region;

/* Claims faces for seeds [first, count), nearest first; faces that turn more than acos(cos_bend) from a
 * chart's normal are left. False: no memory. */
bool sl_atlas_grow(sl_atlas_region *region, const sl_atlas_seed *seed, size_t first, size_t count,
                   double cos_bend);
/* For each chart the face farthest from the chart's border (its first face where it has no border). False: no
 * memory. */
bool sl_atlas_centres(sl_atlas_region *region, size_t chart_count, uint32_t *centre);

/* ---- charts.c ---- */

/* A chart is a range of `face`. */
typedef struct sl_atlas_chart {
    size_t first, count;
    /* of its smallest box, in the scene's units, the longer side upright; its corners' coordinates start at
     * 0 */
    double width, height;
    double area;            /* of its faces */
    bool flat;              /* its coordinates are valid */
} sl_atlas_chart;

typedef struct sl_atlas_charts {
    size_t count, capacity;
    sl_atlas_chart *chart;
    uint32_t *face;         /* all faces, chart by chart */
    uint32_t *of_face;      /* the chart of each face */
    double *corner;         /* u, v of each corner: 6 a face */
} sl_atlas_charts;

sl_status sl_atlas_charts_create(const sl_atlas_faces *faces, double bend, unsigned threads,
                                 sl_atlas_charts *charts, sl_error *error);
void sl_atlas_charts_release(sl_atlas_charts *charts);
/* Cuts the charts that `split` names in two or more; the parts after the first become new charts at the end.
 */
sl_status sl_atlas_charts_split(sl_atlas_charts *charts, const sl_atlas_faces *faces, const uint32_t *split,
                                size_t count, unsigned threads, sl_error *error);
/* The faces for which apart[] is set leave their charts and become charts of one face; what is left keeps its
 * place. */
sl_status sl_atlas_charts_set_apart(sl_atlas_charts *charts, const sl_atlas_faces *faces,
                                    const uint8_t *apart, sl_error *error);

/* ---- conformal.c, cholesky.c, box.c ---- */

/* Fills the corners of a chart and its box. `local` is scratch of one number a face of the scene. *scale is
 * what gave the chart the area of its faces: far from 1 where the map has gone astray. False: no memory. */
bool sl_atlas_flatten(sl_atlas_charts *charts, const sl_atlas_faces *faces, uint32_t chart, uint32_t *local,
                      double *scale);
/* Scales a chart so that it has the area of its faces, moves it to begin at 0 and measures its box; returns
 * the scale, 0 where there is none. */
double sl_atlas_fit(sl_atlas_charts *charts, uint32_t chart);

/* A Hermitian positive definite matrix, row by row, both halves, columns ascending. */
typedef struct sl_hermitian {
    size_t count;
    size_t *first;          /* count + 1 */
    uint32_t *column;
    double *re, *im;
} sl_hermitian;

/* Solves A x = b by conjugate gradients, x being the first guess, until |A x - b| <= tolerance |b|;
 * preconditioned by the Cholesky factor of A in nested dissection order (place: 2 coordinates a row, near
 * rows being near). Returns false without memory. */
bool sl_hermitian_solve(const sl_hermitian *a, const double *place, const double *b, double *x,
                        double tolerance, unsigned *iterations);

/* Turns points (2 numbers each) so that the area of their box is smallest, its longer side upright. False: no
 * memory. */
bool sl_atlas_smallest_box(double *point, size_t count);

/* ---- overlap.c ---- */

/* corner: 6 whole numbers a triangle, below 2^29. bad[i] is set for triangles without positive area and for
 * the later one of two whose insides meet. Returns the count of bad ones, SIZE_MAX without memory. */
size_t sl_atlas_overlap(const int64_t *corner, size_t count, uint8_t *bad);

/* ---- pack.c ---- */

typedef struct sl_atlas_place {
    double x, y;            /* texels of the chart's lower left corner */
    int turns;              /* quarter turns counter-clockwise */
} sl_atlas_place;

/* (x, y) of a chart as large as width x height after quarter turns counter-clockwise, its box still beginning
 * at 0. */
void sl_atlas_turn(int turns, double width, double height, double x, double y, double turned[2]);
/* Places all charts in a square of size x size texels at the highest density found or, with a hint that is
 * not 0, at the first density that fits from the hint down. Density 0: they do not fit with one texel a chart
 * on the mean; then *needed is a size that would do. */
sl_status sl_atlas_pack(const sl_atlas_charts *charts, const sl_atlas_faces *faces, int size, int gutter,
                        double hint, sl_atlas_place *place, double *density, int *needed, sl_error *error);

/* ---- gutter.c ---- */

/* Only the triangles whose insides (or edges: the lowest index) hold texel centres; and how many texels that
 * are. False: no memory. */
bool sl_atlas_cover(const sl_atlas *atlas, size_t triangle_count, unsigned threads, uint32_t *triangle,
                    size_t *covered);

#endif
