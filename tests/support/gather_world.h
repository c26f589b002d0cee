/* Small worlds for the gather's tests: quads and spheres with their own materials, and everything that a
 * gather needs. */
#pragma once

#include "cache/hemisphere/gather.h"

enum {
    WORLD_VERTICES_MAX = 70000,
    WORLD_TRIANGLES_MAX = 140000,
    WORLD_MATERIALS_MAX = 512,
    WORLD_LIGHTS_MAX = 16
};

typedef struct world {
    float *positions, *normals;
    uint32_t *indices, *material_of;
    size_t vertices, triangles;
    sl_material materials[WORLD_MATERIALS_MAX];
    size_t material_count;
    sl_light lights[WORLD_LIGHTS_MAX];
    size_t light_count;
    sl_environment environment;

    sl_scene *scene; /* after world_build() */
    sl_raster *raster;
    sl_tracer *tracer;
    sl_counters counters;
} world;

world *world_new(void);
void world_free(world *w);
uint32_t world_material(world *w, sl_rgb diffuse, sl_rgb emission);
/* Front side: from which a, b, c, d run counter-clockwise. */
void world_quad(world *w, sl_vec3 a, sl_vec3 b, sl_vec3 c, sl_vec3 d, uint32_t material);
/* At z = -depth, seen from the origin, 90 degrees wide; x and y in pixels of a picture of side x side. */
void world_wall(world *w, int side, float x0, float y0, float x1, float y1, float depth, uint32_t material);
/* Six quads, fronts inside or outside. */
void world_box(world *w, sl_vec3 low, sl_vec3 high, bool inside, const uint32_t materials[6]);
/* Fronts inside; shading normals exact. material_of_x: materials by x from -radius to radius. */
void world_sphere(world *w, float radius, int rings, const uint32_t *materials_by_x, uint32_t count);
void world_point_light(world *w, sl_vec3 p, float intensity);
/* A room of 4 x 3 x 6 m with coloured walls, three boxes and one light: a point light, or a quad on the
 * ceiling. */
world *world_room(bool quad_light);
void world_build(world *w);

/* A gather of so many samples a side, lit by rays, that sees lamps. */
sl_gather_settings gather_settings(sl_gather_kind kind, int size);
static const sl_gather_kind gather_kinds[3] = {SL_GATHER_PLANE, SL_GATHER_HEMICUBE, SL_GATHER_RAYS};

typedef struct gatherer {
    sl_gather *gather;
    sl_gather_scratch *scratch;
    sl_counters *counters;
} gatherer;

gatherer gatherer_new(world *w, const sl_gather_settings *settings);
void gatherer_free(gatherer *g);
/* Flat receiver: both normals alike, no own triangle. */
sl_irradiance gather_at(gatherer *g, sl_vec3 p, sl_vec3 n, uint64_t key);
/* A receiver on the room's surfaces, by number: position, normals and triangle. */
sl_gather_point world_surface_point(const world *w, uint64_t number);
/* Made and thrown away in one call. */
sl_irradiance gather_once(world *w, const sl_gather_settings *settings, sl_vec3 p, sl_vec3 n);

void assert_within(double value, double expected, double most_apart);
