/* The lights as Direct Radiance Mapping takes them: each one a point from which pictures are taken, with an
 * intensity by direction.
 *
 *   point        I = Phi / 4 pi                                       (3)
 *   spot         I inside its cone, falling to 0 at the edge
 *   directional  an irradiance; its picture is a parallel projection of the scene's box
 *   area         I = Phi cos theta' / pi from its centre              (6), (9): a very distant area light
 *
 * Emissive triangles become area lights: those of one object and material that lie side by side in one plane
 * are one light (a quad, a panel); where there are more than SL_MAP_LIGHTS_MAX lights the weakest of a kind
 * are merged, by position and normal, so that no flux is lost. */
#ifndef SL_CACHE_DIRECT_RADIANCE_LIGHTS_H
#define SL_CACHE_DIRECT_RADIANCE_LIGHTS_H

#include "base/isa.h"
#include "raster/raster.h"
#include "scene/scene.h"

enum { SL_MAP_LIGHTS_MAX = 64, SL_MAP_POINTS_MAX = 256 };

typedef enum sl_map_light_kind {
    SL_MAP_LIGHT_POINT,
    SL_MAP_LIGHT_SPOT,
    SL_MAP_LIGHT_DIRECTIONAL,
    SL_MAP_LIGHT_AREA
} sl_map_light_kind;

typedef struct sl_map_light {
    sl_map_light_kind kind;
    sl_vec3 position; /* area: the centroid, by flux, brought before all of its triangles where they do not
                         lie in one plane; directional: unused */
    /* unit. Spot: its axis; directional: the way light travels; area: the normal of the shining side */
    sl_vec3 direction;
    /* W/sr. Point, spot; area: along the normal, L_e times area. Directional: W/m^2 */
    sl_rgb intensity;
    float cos_inner, cos_outer; /* spot */
    float area;                 /* area lights: > 0 */
    bool two_sided;             /* area lights: the back shines as the front does */
    size_t first, count;        /* area lights: their emitters, in sl_map_lights.emitter */
} sl_map_light;

/* A point of a light that receivers are lit from: its centre, or one of the n x n into which an area light is
 * divided. */
typedef struct sl_map_light_point {
    uint32_t light;
    sl_vec3 position;
    sl_rgb intensity;           /* the light's share, as above */
} sl_map_light_point;

typedef struct sl_map_lights {
    size_t count;
    /* point-like lights in scene order, then area lights by their first emitter */
    sl_map_light *light;
    size_t emitter_count;
    uint32_t *emitter;          /* indices of scene->emitters, light by light */
    /* the scene's triangles; SL_NO_INDEX where they do not shine. NULL without emitters */
    uint32_t *light_of_triangle;
    size_t point_count;
    sl_map_light_point *point;  /* light by light */
    sl_rgb flux;                /* of all of them but directional ones, in W */
} sl_map_lights;

/* subdivision: n >= 1, see sl_radiance_map_settings.emitter_samples. The points' intensities add up to the
 * light's. */
sl_status sl_map_lights_find(const sl_scene *scene, int subdivision, sl_map_lights **lights, sl_error *error);
void sl_map_lights_destroy(sl_map_lights *lights);
/* Every light point as a light of its own, for maps: what the middle of a large light does not see another
 * part of it may. NULL where no light is divided, or the points are more than SL_MAP_POINTS_MAX. Its
 * light_of_triangle is NULL. */
sl_status sl_map_lights_by_point(const sl_map_lights *lights, sl_map_lights **by_point, sl_error *error);

/* Radiant intensity (W/sr; directional: W/m^2) of a light in the unit direction away from it, as its map sees
 * it. */
sl_rgb sl_map_light_intensity(const sl_map_light *light, sl_vec3 direction);
/* W; of a directional light its irradiance. */
sl_rgb sl_map_light_flux(const sl_map_light *light);

/* An area light does not see itself: how far its own triangles reach above the plane through `eye` on the
 * shining side (back: on the other one). What lies lower is left out of pictures taken from the eye. */
float sl_map_light_clearance(const sl_scene *scene, const sl_map_lights *lights, size_t light, sl_vec3 eye,
                             bool back);

/* ---- groups of emissive triangles, and clusters of too many lights (light_groups.c) ---- */

/* Group numbers of the scene's emitters, by their first emitter; SL_NO_INDEX for those without finite flux.
 * Triangles of one object and material that share a corner and lie in one plane are one group. */
sl_status sl_emitters_group(const sl_scene *scene, uint32_t *group, size_t *groups, sl_error *error);

/* One light among those to be merged. */
typedef struct sl_light_seed {
    int kind;         /* only seeds of one kind are merged */
    double power;     /* >= 0 */
    sl_vec3 position; /* 0 where it means nothing */
    sl_vec3 normal;
} sl_light_seed;

/* Assigns each of `count` seeds to one of at most `most` clusters, numbered by their first seed: the seeds
 * themselves where they are few enough; else the cluster that has most power spread widest, in position and
 * normal, is split again and again: strong lights end up alone, the weakest together. */
sl_status sl_light_seeds_merge(const sl_light_seed *seed, size_t count, size_t most, float size,
                               uint32_t *cluster, size_t *clusters, sl_error *error);

/* Dividing an area light into the points that receivers are lit from. */

/* Nearer than d = 2 s to an area light of side s, (9) errs (on its axis by 8 % at 2 s, 33 % at s): n x n
 * cells of the least rectangle around the light in its plane become a point each, at the middle of the
 * light's part of the cell, with that part's share of the flux. At most n * n points are written; returns how
 * many: cells without light have none. emitter: the light's own. */
size_t sl_map_light_divide(const sl_scene *scene, const sl_map_light *light, const uint32_t *emitter, int n,
                           sl_map_light_point *point);

/* The place of one of a masked triangle's points (sl_scene_mask_point()); false where the mask takes it away.
 */
bool sl_map_light_mask_point(const sl_scene *scene, uint32_t triangle, int index, sl_vec3d *at);

/* Points of area lights that stand behind something: bars, jambs, a frame. */

/* Numbers of points found. */
typedef struct sl_light_openings {
    size_t points; /* of area lights */
    size_t moved;  /* to where light gets out */
    size_t shut;   /* light gets out nowhere in their cells */
} sl_light_openings;

/* (9) takes a cell of an area light for a point, which is wrong where something stands closer to the light
 * than the cell is large: behind a bar the point sees nothing, and the cell's light is gone. Where the
 * point's view is not that of the cell (16 places in it tell, by a small picture each), the point goes to the
 * place whose view is most like it, and keeps of its intensity what brings its light to the cell's mean.
 * Where nothing is that close, which is the rule, points stay where they are, for the price of a picture of
 * 16 x 16 each. */
sl_status sl_map_lights_find_openings(const sl_scene *scene, const sl_raster *raster, unsigned subdivision,
                                      unsigned threads, sl_map_lights *lights, sl_light_openings *found,
                                      sl_counters *counters, sl_error *error);

/* The directions around a light, cut into six sides; shadow cubes and radiance maps look along the same ones.
 *
 *            0           side 0 looks along the light's own direction (its axis, its normal), 1 to 4 to the
 * sides
 *          __|__         (+x -x +y -y of its frame), 5 back. The pictures of 1 to 4 have the light's
 * direction as 2 -|     |- 1     their up, so that their upper halves are a hemicube's.
 *            5
 *
 * An area light does not see its own triangles: what lies lower than they reach is cut away by the view's
 * near plane. */

enum { SL_LIGHT_SIDES = 6, SL_LIGHT_AHEAD = 0, SL_LIGHT_BACK = 5 };

/* z along the light's direction; of a point light the world's axes, turned so that z looks down (0, -1, 0).
 */
sl_frame sl_light_frame(const sl_map_light *light);
/* x right, y up, z the way the side looks. */
sl_frame sl_light_side(const sl_frame *light, int side);
/* False where the whole side, 90 degrees each way, is dark. */
bool sl_light_shines_on(const sl_map_light *light, int side);

/* A pyramid from `eye`, on the light's front or back; near: of lights without area. clearance: of that side,
 * of the light's triangles. */
typedef struct sl_light_picture {
    sl_vec3 eye;
    sl_frame frame;
    double left, right, bottom, top;
    int width, height;
    bool back;
    float clearance;
} sl_light_picture;
sl_view sl_light_picture_view(const sl_scene *scene, const sl_map_light *light,
                              const sl_light_picture *picture);

/* The scene's box as a directional light sees it. */
typedef struct sl_parallel_picture {
    sl_vec3 centre; /* of the box */
    sl_frame frame; /* z the way light travels */
    float reach_x, reach_y, reach_z; /* half extents */
} sl_parallel_picture;
sl_parallel_picture sl_parallel_picture_of(const sl_scene *scene, const sl_map_light *light);
sl_view sl_parallel_view(const sl_parallel_picture *picture, int width, int height);

/* Pass 1: a depth cube around every light point, and what it says: a receiver is lit if its reciprocal planar
 * depth is at least the stored one, less the most by which two points of the receiver's own plane in one
 * texel can differ. */

typedef struct sl_shadow_cubes sl_shadow_cubes;

/* A depth cube for every light point, a parallel map for a directional one; size texels a side of a face (of
 * a spot that fits in one face, over its cone alone), and less where an area light is divided (its n x n
 * cubes together have n times the texels of one) or lights are so many that their cubes would take more than
 * 128 MiB. Faces that no receiver can need (behind a one-sided area light, outside a spot's cone, without
 * geometry) are not drawn, and counted as skipped. */
sl_status sl_shadow_cubes_render(const sl_scene *scene, const sl_raster *raster, const sl_map_lights *lights,
                                 int size, unsigned threads, sl_shadow_cubes **cubes, sl_counters *counters,
                                 sl_error *error);
void sl_shadow_cubes_destroy(sl_shadow_cubes *cubes);
size_t sl_shadow_cubes_bytes(const sl_shadow_cubes *cubes);

/* 1 where the light point is seen, 0 where it is not, in between at a shadow's edge. p, and the receiver's
 * geometric normal n (unit, on the lit side) are arrays of count; lit[i] is multiplied. Points where lit is 0
 * already stay so. cubes may be NULL: all lit. */
void sl_shadow_cubes_lit(const sl_shadow_cubes *cubes, size_t light_point, size_t count, const float *px,
                         const float *py, const float *pz, const float *nx, const float *ny, const float *nz,
                         float *lit, sl_counters *counters);

/* The loop over receivers that look a light up, compiled for every instruction set. */

enum { SL_SHADOW_BLOCK = 128 };

/* The depth pictures around a light point. A cube's hold 1/z, z along the picture's own axis, and have a
 * border of one texel beyond 90 degrees, so that a filter never leaves its picture; a directional light's one
 * holds 1 - d, d in [0,1] linear in depth. So in both larger is nearer, 0 is empty, and a plane is a linear
 * function. A spot whose cone fits in the picture ahead has that one alone, no wider than the cone. */
typedef struct sl_shadow_cube {
    /* first a row of zeros, to which pictures without anything in them lead; then the pictures */
    float *depth;
    int32_t start[SL_LIGHT_SIDES];   /* where in depth each side's picture begins; 0: it has none */
    /* all bits of a place in the picture, or none where there is no picture */
    int32_t mask[SL_LIGHT_SIDES];
    int size;
    bool directional;
    /* of a cube's pictures: half their width at distance 1, without the border: 1, or a spot's own */
    float tangent;
    sl_vec3 eye;                     /* directional: the box's centre */
    sl_frame frame;                  /* of the light */
    float reach_x, reach_y, reach_z; /* directional: half extents */
    float rounding;                  /* by how much a receiver's position may be rounded */
} sl_shadow_cube;

/* Texels before the first picture. */
static inline size_t sl_shadow_zeros(int size) { return ((size_t)size + 2 + 15) / 16 * 16; }

/* Receivers, at most SL_SHADOW_BLOCK; normals unit, on the lit side; lit is multiplied. */
typedef void sl_shadow_cube_kernel(const sl_shadow_cube *cube, size_t count, const float *px, const float *py,
                                   const float *pz, const float *nx, const float *ny, const float *nz,
                                   float *lit);

SL_KERNEL_VARIANTS(sl_shadow_cube_kernel, sl_shadow_cube_lit);

static inline sl_shadow_cube_kernel *sl_shadow_cube_kernel_for(sl_isa isa) {
    return SL_KERNEL_OF(isa, sl_shadow_cube_lit);
}

#endif
