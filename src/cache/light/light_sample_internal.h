/* Shared by the estimators of a single light (light_sample.h tells in which order to read them). */
#pragma once

#include "base/counters.h"
#include "cache/light/light_sample.h"
#include "cache/light/sample_kernels.h"
#include "raster/views/light_view.h"

/* Lights seen smaller than that (their size over their distance) are points: Lambert's formula and the
 * point's are as good as each other here, and in float pictures of them would be coarse. */
#define SL_TINY_LIGHT 5e-5
/* A thing within this share of the way to the light, at the light, is the light, or too near it to be told
 * from it. */
#define SL_LIGHT_MARGIN 1e-4

/* Known of an area light beforehand. */
typedef struct sl_light_shape_info {
    sl_light_surface surface;
    double size;               /* across: largest distance of a corner from the centroid, twice */
    double flatness;           /* planar: how far its corners may lie off its plane, roundings included */
    /* whoever sees the front of one of its triangles sees all of it, unless something else is in between */
    bool closed_form;
    sl_raster *raster;         /* of the light alone, where a look-at frustum is taken; or NULL */
    float *mesh_x;             /* what it is made of: x, y, z of its corners, and their numbers */
    uint32_t *mesh_corner;
} sl_light_shape_info;

/* By how much of its coordinates a point may be rounded, and how much more is safe. */
#define SL_LIGHT_LIFT 6e-7f

struct sl_light_sampling {
    const sl_scene *scene;
    const sl_raster *raster;
    const sl_tracer *tracer;
    const sl_sampled_lights *lights;
    sl_light_sample_settings settings;
    sl_light_shape_info *shape; /* by light */
    sl_isa isa;
    /* nearer than 1e-5 of the scene's scale nothing is drawn of what the paper's frustum sees */
    float near;
    /* how far on its way to the light the eye of other pictures is: it moves shadows, so a fifth of that */
    float step;
    /* how far above its surface a point must be, so that it lies above it in spite of rounding; in a
     * scattered scene, in its central region */
    float lift;
    size_t most_triangles;     /* of those lights */
    /* of the lights' own rasters the one that needs the largest scratch; or NULL */
    const sl_raster *widest;
};

struct sl_light_sample_scratch {
    sl_raster_scratch *raster, *light_raster;
    uint32_t *id, *light_id;   /* largest^2 pixels */
    float *depth, *light_depth;
    float *planes;             /* two of largest^2: the light's weights as they are seen, and all of them */
    float *halves;             /* for the reduction */
    float *column_x, *column_y, *row_x, *row_y; /* tangents of the pixels' centres */
    uint8_t *facing;           /* by triangle of a light */
    int picture_size;          /* of planes' first, 0: none */
};

/* A point that asks for an area light. Visibility is that of an eye above its surface in spite of rounding
 * and a little (`step`) on the way to the light's middle, past walls that stand on the point itself, for
 * whether they are before it or behind is rounding; weights are the point's. */
typedef struct sl_light_query {
    const sl_light_sampling *sampling;
    size_t light;
    const sl_lit_point *point;
    sl_vec3d middle;           /* of what is above the horizons, from the point */
    sl_vec3 lifted, eye;       /* above the surface; and on the way */
    int rays;                  /* n of n x n, if it comes to rays */
    const sl_light_numbers *numbers; /* which rays these are; NULL: jittered by the position */
    const sl_lit_lobe *lobe;   /* that reflects what rays bring; or NULL */
    sl_light_sample_scratch *scratch; /* NULL: no pictures */
    sl_counters *counters;
} sl_light_query;
sl_vec3 sl_light_lifted(const sl_light_sampling *sampling, const sl_lit_point *point);
sl_vec3 sl_light_eye(const sl_light_sampling *sampling, sl_vec3 lifted, sl_vec3d to_light);

typedef enum sl_light_shot {
    SL_SHOT_TAKEN,
    SL_SHOT_HIDDEN,          /* something is before all of the light: the rest of the work was not needed */
    SL_SHOT_NOTHING_BETWEEN, /* no picture was needed: all of the light is seen */
    SL_SHOT_IMPOSSIBLE       /* no frustum holds the light: take rays */
} sl_light_shot;

/* closed_forms.c. Area-weighted middle of what faces the point and is above its horizons, from the point;
 * (0,0,0): nothing is. */
sl_vec3d sl_light_middle(const sl_sampled_light *light, const sl_lit_point *point);

/* look_at.c */
sl_light_shot sl_look_at_shoot(const sl_light_query *query, int size, sl_light_sums *sums);

/* shadow_ray.c. Is the light's middle hidden? */
bool sl_light_middle_hidden(const sl_light_query *query);
/* F by rays: their weights in units of F, those of numbers times their count. */
sl_light_sums sl_light_rays(const sl_light_query *query);
/* F of a light without extent. */
double sl_light_without_extent(const sl_light_sampling *sampling, const sl_sampled_light *light,
                               const sl_lit_point *point, sl_counters *counters);
/* Cosine, inverse square law and cone of a light without extent; its direction, and how far it is (infinite).
 * 0: none arrives. */
double sl_light_point_form(const sl_sampled_light *light, const sl_lit_point *point, sl_vec3d *to_light,
                           double *distance);
