/* Shared by the tests of Direct Radiance Mapping's passes 6 and 7: receivers placed by hand, and photons made
 * on the CPU in shapes whose light is known. Every function fails the test where anything fails. */
#pragma once

#include "cache/direct_radiance/direct_radiance.h"

/* ---- receivers ---- */

/* All background, seen from one eye. */
sl_gbuffer *make_receivers(int width, int height, sl_vec3 eye);
void set_receiver(sl_gbuffer *receivers, size_t pixel, sl_vec3 position, sl_vec3 geometric, sl_vec3 shading,
                  sl_rgb diffuse, uint32_t material);
/* A scene whose materials 0, 1, 2, ... are diffuse 0.5; glossy (kd 0.3, ks 0.4, n 20); a mirror of 0.8;
 * black; a lobe with n = 0. Its triangles are a cube of side 1 around (1/2, 1/2, 1/2). */
enum { DIFFUSE_MATERIAL, GLOSSY_MATERIAL, MIRROR_MATERIAL, BLACK_MATERIAL, FLAT_LOBE_MATERIAL };
sl_scene *receiver_scene(void);
/* It as the state of a group of tests. */
int make_receiver_scene(void **state);
int destroy_receiver_scene(void **state);

typedef struct planes {
    float *value[3];
    size_t count;
} planes;
planes make_planes(size_t count);
void free_planes(planes *p);

/* Radiance towards the eye, three planes each of width*height, row 0 at the bottom. */
typedef struct sl_lit_picture {
    float *direct[3], *indirect[3];
} sl_lit_picture;
/* Passes 6 and 7 over a whole picture, strip after strip. */
void light_directly(const sl_light_pass *pass, const sl_gbuffer *receivers, sl_lit_picture *picture,
                    sl_counters *counters);
void light_indirectly(const sl_light_pass *pass, const sl_gbuffer *receivers, sl_lit_picture *picture,
                      sl_counters *counters);

/* ---- photons ---- */

sl_map_photons *make_photons(size_t count, float diagonal);
void free_photons(sl_map_photons *photons);

/* Where a ray from the light meets a surface; normal towards the light. */
typedef bool meet_surface(const void *context, sl_vec3d light, sl_vec3d direction, sl_vec3d *position,
                          sl_vec3d *normal);
bool meet_unit_sphere(const void *context, sl_vec3d light, sl_vec3d direction, sl_vec3d *position,
                      sl_vec3d *normal);
bool meet_unit_cube(const void *context, sl_vec3d light, sl_vec3d direction, sl_vec3d *position,
                    sl_vec3d *normal);
/* The square [-1,1]^2 at z = 0. */
bool meet_floor(const void *context, sl_vec3d light, sl_vec3d direction, sl_vec3d *position,
                sl_vec3d *normal);

/* Photons of a point light of 1 W/sr: faces 0 (looking down -z) to faces - 1 of a cube, m x m samples each,
 * with (12) as printed for w = m, and with polygons. */
sl_map_photons *cube_photons(meet_surface *meet, const void *context, sl_vec3d light, int faces, int m,
                             double reflectance, double diagonal);
/* E by direct summation of the plain weight in double, with photons as fine as wanted: the exact one-bounce
 * irradiance. */
double exact_irradiance(meet_surface *meet, const void *context, sl_vec3d light, int faces, int m,
                        double reflectance, sl_vec3d x, sl_vec3d n);
/* E_j(x) of one photon by one weight (receivers.h), W/m^2: the plain form that the lanes agree with bit by
 * bit. n: the receiver's geometric normal decides what is above its horizon, the shading normal `shading`
 * gives the cosine. */
sl_rgb sl_photon_irradiance(const sl_map_photons *photons, size_t photon, sl_photon_weight weight, sl_vec3 x,
                            sl_vec3 n, sl_vec3 shading);
/* Sum of all photons by the plain form, one channel. */
double irradiance_at(const sl_map_photons *photons, sl_photon_weight weight, sl_vec3d x, sl_vec3d n);
