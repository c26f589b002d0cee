/* The lights as Direct Radiance Mapping takes them: points from which pictures are taken, each with an
 * intensity by direction.
 *
 *   point        I = Phi / 4 pi                                       (3)
 *   spot         I inside its cone, falling to 0 at the edge
 *   directional  an irradiance; its picture is a parallel projection of the scene's box
 *   area         I = Phi cos theta' / pi                              (6), (9): a very distant area light
 *
 * What a light of the scene is, and which triangles are one area light, is told by cache/light/lights.h. A
 * planar area light is n x n points, a solid one (a bulb) 6 n x n points of its surface. */
#ifndef SL_CACHE_DIRECT_RADIANCE_LIGHTS_H
#define SL_CACHE_DIRECT_RADIANCE_LIGHTS_H

#include "base/isa.h"
#include "cache/light/lights.h"
#include "raster/raster.h"

enum { SL_MAP_LIGHTS_MAX = 256 };

typedef enum sl_map_light_kind {
    SL_MAP_LIGHT_POINT,
    SL_MAP_LIGHT_SPOT,
    SL_MAP_LIGHT_DIRECTIONAL,
    SL_MAP_LIGHT_AREA
} sl_map_light_kind;

typedef struct sl_map_light {
    sl_map_light_kind kind;
    sl_vec3 position; /* directional: unused */
    /* unit. Spot: its axis; directional: the way light travels; area: the normal of the shining side */
    sl_vec3 direction;
    /* W/sr. Point, spot; area: along the normal, L_e times area. Directional: W/m^2 */
    sl_rgb intensity;
    float cos_inner, cos_outer; /* spot */
    float area;                 /* area lights: of the part that the point stands for, > 0 */
    bool two_sided;             /* area lights: the back shines as the front does */
    uint32_t lamp;              /* in sl_map_lights.lamps; SL_NO_INDEX: it stands for several */
    uint32_t siblings;          /* points of the same lamp, this one included; 0 counts as 1 */
} sl_map_light;

typedef struct sl_map_lights {
    size_t count;               /* at most SL_MAP_LIGHTS_MAX */
    sl_map_light *light;        /* lamp by lamp */
    sl_sampled_lights *lamps;   /* those of the scene */
} sl_map_lights;

/* subdivision: n >= 1, see sl_radiance_map_settings.emitter_samples; less where points would be more than
 * SL_MAP_LIGHTS_MAX. Of more lights than that the weakest are merged into the nearest of their kind, so that
 * no flux is lost. */
sl_status sl_map_lights_find(const sl_scene *scene, int subdivision, sl_map_lights **lights, sl_error *error);
void sl_map_lights_destroy(sl_map_lights *lights);

/* Radiant intensity (W/sr; directional: W/m^2) of a light in the unit direction away from it, as its map sees
 * it. */
sl_rgb sl_map_light_intensity(const sl_map_light *light, sl_vec3 direction);
/* W; of a directional light its irradiance. */
sl_rgb sl_map_light_flux(const sl_map_light *light);

/* An area light does not see itself: how far its lamp's triangles reach above the plane through it on the
 * shining side (back: on the other one). What lies lower is left out of its pictures. */
float sl_map_light_clearance(const sl_map_lights *lights, size_t light, bool back);

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

/* Pass 1: a depth cube around every light, and what it says: a receiver is lit if its reciprocal planar
 * depth is at least the stored one, less the most by which two points of the receiver's own plane in one
 * texel can differ. */

typedef struct sl_shadow_cubes sl_shadow_cubes;

/* A depth cube for every light, a parallel map for a directional one; size texels a side of a face (of
 * a spot that fits in one face, over its cone alone), and less where an area light is divided (its n x n
 * cubes together have n times the texels of one) or lights are so many that their cubes would take more than
 * 128 MiB. Faces that no receiver can need (behind a one-sided area light, outside a spot's cone, without
 * geometry) are not drawn, and counted as skipped. */
sl_status sl_shadow_cubes_render(const sl_scene *scene, const sl_raster *raster, const sl_map_lights *lights,
                                 int size, unsigned threads, sl_shadow_cubes **cubes, sl_counters *counters,
                                 sl_error *error);
void sl_shadow_cubes_destroy(sl_shadow_cubes *cubes);
size_t sl_shadow_cubes_bytes(const sl_shadow_cubes *cubes);

/* 1 where the light is seen, 0 where it is not, in between at a shadow's edge. p, and the receiver's
 * geometric normal n (unit, on the lit side) are arrays of count; lit[i] is multiplied. Points where lit is 0
 * already stay so. cubes may be NULL: all lit. */
void sl_shadow_cubes_lit(const sl_shadow_cubes *cubes, size_t light, size_t count, const float *px,
                         const float *py, const float *pz, const float *nx, const float *ny, const float *nz,
                         float *lit, sl_counters *counters);

/* The loop over receivers that look a light up, compiled for every instruction set. */

enum { SL_SHADOW_BLOCK = 128 };

/* The depth pictures around a light. A cube's hold 1/z, z along the picture's own axis, and have a
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
