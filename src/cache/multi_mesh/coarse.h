/* The coarse mesh: every face of the scene that may be seen and reflects (not a solid's inner side, not
 * degenerate), cut until its edges are short enough, with U_dd = sum E_d / pi at its vertices, which gathers
 * see.
 *
 * A face of level l is cut into n^2 coarse triangles, n = 2^l, by n - 1 lines along each of its sides:
 *
 *     2         Lattice point (i, j) has weights i/n and j/n of the face's corners 1 and 2. Row j holds
 *     |\        2 (n - j) - 1 triangles, upright ones (corners (i, j), (i+1, j), (i, j+1)) and between
 *     |_\       them those on their heads ((i+1, j+1), (i, j+1), (i+1, j)): triangle number
 *     |\ |\     j (2n - j) + 2i + (1 if on its head). The corners of either kind are in the order of the
 *     0-\|-\ 1  face's corners 0, 1, 2: weights within it follow from the face's.
 *
 * Vertices are shared as all vertices of patches are.
 *
 *   coarse.c         levels and vertices; their values times the bounce's reflectance
 *   coarse_light.c   direct light at its vertices, by rays
 *   coarse_rounds.c  rounds in which all of them get it, some an update; gathers that see it */
#pragma once

#include "cache/hemisphere/gather.h"
#include "cache/patches/irradiance.h"
#include "scene/object_places.h"

enum { SL_COARSE_ABSENT = 0xff }; /* level of a face that is not in the coarse mesh */

/* The first coarse triangles stand for faces that are absent and for what lies beyond all faces. */
enum { SL_COARSE_BLACK, SL_COARSE_NOTHING, SL_COARSE_FIRST };

typedef struct sl_coarse {
    const sl_scene *scene;
    const sl_primitives *primitives;
    size_t face_count;
    uint8_t *level;            /* by face, or SL_COARSE_ABSENT */
    /* by the places that stand for all who share them, with U_dd; not a number: SL_VERTEX_INVALID */
    sl_patches *vertices;
    size_t vertex_count;
    sl_root_place *vertex;     /* in the first of the finest faces that have it */
    size_t triangle_count;     /* coarse ones */
    sl_face_lattice *face;     /* by face; two more for nothing, as if that were one more scene triangle */
    sl_rgb *reflectance;       /* by coarse triangle: k_d, the mean of its texture; NULL: nothing has any */
    bool reflectance_known;
    float *colour;             /* by coarse triangle, SL_LATTICE_FLOATS each */
} sl_coarse;

/* edge: in scene units; longer ones are split, at most so often. */
sl_status sl_coarse_create(const sl_scene *scene, const sl_primitives *primitives, float edge, int depth,
                           sl_coarse **coarse, sl_error *error);
void sl_coarse_destroy(sl_coarse *coarse);
size_t sl_coarse_memory_bytes(const sl_coarse *coarse);
/* Sets U_dd at vertex i; from the second bounce on U_dd + E_i / pi. Where it is not finite (or never set)
 * the other corners' mean stands in, triangle by triangle. */
void sl_coarse_set(sl_coarse *coarse, size_t vertex, sl_rgb radiosity_over_pi);
/* Colours times reflectance, in the form that gathers draw: after a round of sl_coarse_set(). */
void sl_coarse_finish(sl_coarse *coarse, unsigned threads);
/* Returns the brightest of all colours, by channel. */
sl_rgb sl_coarse_brightest(const sl_coarse *coarse);

/* Gives each vertex the area that it stands for: a third of each coarse triangle's that it is a corner of. */
void sl_coarse_areas(const sl_coarse *coarse, float *area);
/* Returns where a vertex is asked for light: at a face's rim a little within. */
sl_root_place sl_coarse_lit_place(const sl_coarse *coarse, size_t vertex);
/* Returns the vertex at lattice point (i, j) of a face that is in the mesh. */
uint32_t sl_coarse_lattice_vertex(const sl_coarse *coarse, uint32_t face, int i, int j);

/* ---- coarse_light.c ---- */

/* Direct light of the coarse mesh's vertices, and of displayed ones while things move. A gather sees hundreds
 * of them at once, so a few rays a light are enough, noise and all; and of many lights those that could give
 * most are asked, in that order (Ward 1994), until the others together could add but little: these are taken
 * to be as visible as the former were.
 * Nothing is kept for the picture's own meshes, nor are these refined for it. */
/* F of one light at a vertex; by how it was sampled, or 0: it was not. */
typedef struct sl_coarse_share {
    float share;
    uint32_t by;
} sl_coarse_share;

/* Returns U_dd = sum over lights of E_d / pi (equation 4 without k_d) from the shares of a point's lights. */
sl_rgb sl_direct_diffuse(const sl_sampled_lights *lights, const float *share);
/* U_dd at each place; NaN where it lies inside other geometry. A pure function of the place and the scene.
 * quick: by a sixteenth of the rays, while things move. kept: by place and light; what was sampled in the
 * same way is not sampled again. NULL: all is. Counts SL_COUNT_LIGHT_SAMPLES. */
sl_status sl_coarse_light_take(const sl_irradiance_settings *light, size_t count,
                               const sl_root_place *place, bool quick, sl_coarse_share *kept,
                               sl_rgb *radiance, sl_counters *counters, sl_error *error);

/* Shares of a whole coarse mesh, and the state of the scene that they were taken in. */
typedef struct sl_coarse_kept {
    size_t count;              /* of vertices; 0: there are none */
    sl_root_place *place;      /* by vertex: where light was asked for */
    sl_coarse_share *share;    /* by vertex and light */
    sl_sampled_lights *lights;
    sl_object_places *places;
    float scale;               /* the scene's, and ... */
    double step;               /* ... the sampling's, which tolerances follow */
} sl_coarse_kept;
/* Keeps the shares of a coarse mesh in place of those before; they are the kept ones' own from then on, also
 * after a failure. */
sl_status sl_coarse_keep(const sl_irradiance_settings *light, const sl_coarse *coarse,
                         sl_coarse_share *shares, sl_coarse_kept *kept, sl_error *error);
/* Copies those that would be the same, bit by bit, if they were taken in the scene as it is: places, of the
 * objects in it. The others stay. */
sl_status sl_coarse_shares_that_hold(const sl_coarse_kept *kept, const sl_irradiance_settings *light,
                                     const sl_object_places *places, const sl_coarse *coarse,
                                     sl_coarse_share *shares, sl_error *error);
void sl_coarse_forget_kept(sl_coarse_kept *kept);
size_t sl_coarse_kept_bytes(const sl_coarse_kept *kept);

/* ---- coarse_rounds.c ---- */

/* Returns E_i in W/m^2 at a point of a face, or in free space: what it sees of the coarse mesh's colours,
 * with which the gather was made; 0 where position or normals are no numbers. */
sl_rgb sl_coarse_gather(const sl_scene *scene, const sl_gather *gather, const sl_mesh_point *at,
                        sl_gather_scratch *scratch, sl_counters *counters);
