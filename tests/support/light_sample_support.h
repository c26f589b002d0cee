/* Shared by the tests of single lights: a scene with everything around it, and samples of its lights at
 * points. */
#pragma once

#include "unit_test.h"
#include "cache/light/light_sample.h"
#include "trace_scenes.h"

typedef struct light_world {
    sl_scene *scene;
    sl_raster *raster;
    sl_tracer *tracer;
    sl_sampled_lights *lights;
    sl_light_sample_settings settings;
    sl_light_sampling *sampling;
    sl_light_sample_scratch *scratch;
    sl_counters counters;
} light_world;

/* Takes the mesh. */
light_world light_world_make(trace_mesh *mesh);
/* Sampling by other settings from now on. */
void light_world_set(light_world *world, const sl_light_sample_settings *settings);
void light_world_free(light_world *world);

sl_lit_point lit_point(sl_vec3 position, sl_vec3 normal);
double sample_light(light_world *world, size_t light, sl_vec3 position, sl_vec3 normal);

/* Of radiance 1, facing down at that height, its corner with the least x and z at (x, z). */
void add_ceiling_light(trace_mesh *mesh, float x, float z, float width, float depth, float height);

void assert_near(double value, double expected, double tolerance);
#define assert_share(value, expected, tolerance) assert_near(value, expected, (tolerance) * fabs(expected))

/* G = 1/(2 pi) (x/sqrt(1+x^2) atan(y/sqrt(1+x^2)) + ...): F of a rectangle x by y with a corner straight
 * above. */
double corner_form(double x, double y);
/* F of a parallel rectangle x0..x1 by y0..y1 at distance h, seen from the origin. */
double rectangle_form(double x0, double x1, double y0, double y1, double h);
