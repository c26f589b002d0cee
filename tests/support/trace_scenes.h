/* Small scenes made by hand for the tests of rays, lights and paths. */
#pragma once

#include "trace/trace.h"

enum { TRACE_VERTICES_MAX = 70000, TRACE_TRIANGLES_MAX = 140000 };

/* Collects triangles and materials; trace_mesh_build() makes the scene and empties the mesh. */
typedef struct trace_mesh {
    float *positions;
    uint32_t *indices, *material_index;
    size_t vertex_count, triangle_count;
    sl_material materials[16];
    size_t material_count;
    sl_light lights[4];
    size_t light_count;
    const sl_environment *environment;
    sl_camera camera;
    bool has_camera;
    float *texture_coordinates;
    sl_texture textures[1];
    size_t texture_count;
} trace_mesh;

trace_mesh trace_mesh_begin(void);
uint32_t trace_mesh_vertex(trace_mesh *mesh, float x, float y, float z);
void trace_mesh_triangle(trace_mesh *mesh, uint32_t a, uint32_t b, uint32_t c, uint32_t material);
/* A parallelogram corner, corner + a, corner + a + b, corner + b; its front is on the side of a x b. */
void trace_mesh_quad(trace_mesh *mesh, sl_vec3 corner, sl_vec3 a, sl_vec3 b, uint32_t material);
/* A closed box, fronts inside or outside. */
void trace_mesh_box(trace_mesh *mesh, sl_vec3 low, sl_vec3 high, bool inside, uint32_t material);
/* A closed sphere of rings x 2 rings quads, split into triangles, with bumps of relative height `bump`. */
void trace_mesh_sphere(trace_mesh *mesh, sl_vec3 centre, float radius, unsigned rings, float bump,
                       bool inside, uint32_t material);
uint32_t trace_mesh_material(trace_mesh *mesh, float diffuse, float specular, float exponent, float mirror,
                             float emission);
uint32_t trace_mesh_diffuse(trace_mesh *mesh, float diffuse);
uint32_t trace_mesh_lamp(trace_mesh *mesh, float emission); /* that reflects nothing */
void trace_mesh_point_light(trace_mesh *mesh, sl_vec3 position, sl_rgb intensity);
sl_scene *trace_mesh_build(trace_mesh *mesh);
void trace_mesh_discard(trace_mesh *mesh);
/* Diffuse, glossy and mirror surfaces, shading normals off their facets, seen from before them; which lights,
 * bit by bit: lamp, point, spot, distant, sky; and whether the lamp shines on both sides. */
sl_scene *trace_scene_lit_by(unsigned lights, bool mirrors);
sl_tracer *tracer_of(const sl_scene *scene); /* of one thread */
sl_transport transport_of(const char *name);

/* A path tracer's picture of a scene. */
typedef struct trace_picture {
    float *plane[3][3]; /* of all samples, the even and the odd ones: R, G and B, one behind the other */
    sl_counters counters;
} trace_picture;

/* Takes samples 0, 1, ..., or the last of them first. The caller frees it. */
trace_picture trace_picture_of(const sl_scene *scene, const sl_path_settings *settings, unsigned samples,
                               bool backwards);
void trace_picture_free(trace_picture *picture);
/* A point of an emitter, uniform by area: to_light, distance, and radiance over its density in solid angle.
 * False: the emitter is dark on that side. */
bool emitter_point(const sl_scene *scene, uint32_t emitter, sl_vec3 p, float u1, float u2,
                   sl_light_sample *sample);

/* Radiance along a ray by the path tracer's walks: sixteen sequences, whose spread tells the variance of
 * their mean. Fails where any sample is not finite. */
typedef struct traced_radiance {
    double mean[3], variance[3];
} traced_radiance;
traced_radiance trace_along(const sl_scene *scene, const sl_tracer *tracer, const sl_transport *transport,
                            sl_vec3 origin, sl_vec3 direction, unsigned samples);
