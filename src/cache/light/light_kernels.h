/* The loops over points to be lit that are compiled for every instruction set. */
#pragma once

#include "base/isa.h"
#include "cache/light/lights.h"

enum { SL_LIGHT_BLOCK = 128 };

/* At most SL_LIGHT_BLOCK points to be lit. A point without normal gets nothing. */
typedef struct sl_light_points {
    size_t count;
    const float *x, *y, *z;
    const float *geometric_x, *geometric_y, *geometric_z; /* unit, on the side that is lit */
    const float *normal_x, *normal_y, *normal_z;          /* unit, shading */
} sl_light_points;

/* Tells whether d leads from one point of a smooth surface to another, of normals with this sum. Such a chord
 * leans as far out of the surface at one end as into it at the other, so it is square to the sum. A step
 * between two parallel surfaces is not, however small the angle at which they are seen. */
static inline bool sl_is_chord(sl_vec3 d, sl_vec3 sum) {
    const float slope = 0.05f, out = sl_dot(d, sum);
    return out * out <= slope * slope * 4.0f * sl_dot(d, d);
}

/* A light without extent, or a point of an emitter; and as pictures are taken from it. */
typedef struct sl_light_source {
    sl_source_kind kind;       /* not SOLID */
    sl_vec3 position;          /* directional: unused */
    /* unit: directional and spot, the way the light travels; area: the emitter's normal */
    sl_vec3 direction;
    float cos_inner, cos_outer; /* spot */
    /* area: area / pi, which keeps 1 / distance^2 finite: the sample stands for a disc */
    float extent;
    sl_rgb colour;              /* intensity, irradiance, or radiance x area */
    bool two_sided;             /* area: for pictures, the back shines too */
    /* area: how far its own triangles reach above the plane through it, on the front and on the back. What
     * lies lower is cut away by the near plane of its pictures */
    float clearance[2];
} sl_light_source;

/* Light that arrives from a source at the points of a block: irradiance = colour x weight. */
typedef struct sl_arrivals {
    float x[SL_LIGHT_BLOCK], y[SL_LIGHT_BLOCK], z[SL_LIGHT_BLOCK]; /* unit, towards the light */
    float weight[SL_LIGHT_BLOCK]; /* cosine over squared distance and the like; 0 below either horizon */
} sl_arrivals;

typedef struct sl_depth_cube sl_depth_cube; /* depth_cube.h */

typedef struct sl_polygon_light {
    sl_vec3 corner[3];
    sl_vec3 normal;                  /* unit, of the shining side */
    float area, extent_squared;      /* the largest squared distance of a corner from the centroid */
    sl_box bounds;
} sl_polygon_light;

/* Returns how many sides of emitters shine. */
size_t sl_emitter_sides(const sl_scene *scene);
sl_light_source sl_light_source_of(const sl_light *light);
/* Finds bounds and extent by the corners. */
void sl_polygon_light_bound(sl_polygon_light *light);
/* The front of an emitter, or its back. */
sl_polygon_light sl_polygon_light_of(const sl_scene *scene, const sl_emitter *emitter, bool back);

/* A side of an emitter for sl_aim_kernel: corner, two edges, normal (unit), area, chromaticity (radiance over
 * its luminance). */
enum { SL_SIDE_VALUES = 16 };

/* All sides that shine: what each gives where nothing hides it is known in closed form. */
typedef struct sl_light_sides {
    size_t count;
    sl_polygon_light *polygon;
    uint32_t *emitter;              /* of each side */
    float *values;                  /* the same for the kernels: SL_SIDE_VALUES each */
    /* a power of two: what the strongest of emitters is counted in, so that sums of samples stay
     * within floats */
    float unit;
    float *luminance;               /* of their radiances, in units */
} sl_light_sides;
/* Makes none where there are more than `most`, or where one has an alpha mask, which closed forms know
 * nothing of. What was made has to be released in case of failure too. */
sl_status sl_light_sides_make(const sl_scene *scene, size_t most, sl_light_sides *sides, sl_error *error);
void sl_light_sides_release(sl_light_sides *sides);

SL_KERNELS(void, sl_light_arrive,
           (const sl_light_points *points, const sl_light_source *source, sl_arrivals *arrivals));

/* Points and the depth cubes that they look in: `each` in the first, as many that follow in the second, and so
 * on; after the last points the first ones come again. Of several cubes all are of one size and kind, and their
 * points are a multiple of each; cubes x each is at most SL_LIGHT_BLOCK. */
typedef struct sl_cube_looks {
    size_t cubes, each;
    const sl_depth_cube *const *cube;
} sl_cube_looks;
/* Multiplies the cubes x each values of lit by 1 where the light is seen, 0 where it is not, in between at a
 * shadow's edge. */
SL_KERNELS(void, sl_depth_cube_lit, (const sl_light_points *points, const sl_cube_looks *looks, float *lit));
/* Unoccluded irradiance from a triangle of radiance 1, in closed form. */
SL_KERNELS(void, sl_polygon_light,
           (const sl_light_points *points, const sl_polygon_light *light, float *irradiance));
/* r, g, b += colour a_i b_i. */
SL_KERNELS(void, sl_light_accumulate,
           (size_t count, sl_rgb colour, const float *a, const float *b, float *r, float *g, float *bl));

typedef struct sl_aim_block {
    const sl_light_points *points;
    size_t sides;               /* that can light some point of the block */
    const uint32_t *side;       /* which of them */
    const float *values;        /* sl_light_sides */
    /* irradiance from each of them over its luminance, SL_LIGHT_BLOCK values a side */
    const float *share;
    const float *sums;          /* cumulative irradiances (luminance), SL_LIGHT_BLOCK values a side */
    const float *u0, *u1, *u2;  /* which side, and the point of it */
    int32_t *chosen;            /* out: which of the sides */
    float *x, *y, *z;           /* out: towards the light's point, whole */
    /* out: the sample's irradiance (luminance), shadows aside; both 0 where none arrives */
    float *weight;
    float *r, *g, *b;           /* out: its chromaticity */
    /* out: 1 where a ray must tell, 0: not lit, or the surface itself is in the way */
    float *wanted;
} sl_aim_block;

/* Chooses a side in proportion to its irradiance and a point of it by area. */
SL_KERNELS(void, sl_direct_aim, (const sl_aim_block *block));
