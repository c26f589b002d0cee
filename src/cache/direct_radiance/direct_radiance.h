/* Direct Radiance Mapping (Frisvad, Frisvad, Christensen, Falster 2005): one bounce of indirect light,
 * gathered from pictures taken from the lights. Everything is computed again for every frame. Read in this
 * order:
 *
 *   direct_radiance.c   the paper: the passes of one frame
 *   plan.c              which of them a scene needs
 *
 *   lights.c            the lights as points from which pictures are taken, (3), (6)
 *   direct.c            passes 1 and 6: depth cubes; direct light by (5), (9)
 *   map.c               pass 2: the direct radiance map, (12), (13); map_faces.c: which pictures a light
 *                       takes; map_pictures.c: the pictures, and what mirrors in them light
 *   photons.c           pass 3: sample photons; photon_groups.c: many texels to a photon
 *   receivers.c         passes 5 and 6: what is seen, in tiles; receiver_kernels.c: loops over lanes
 *   indirect.c          pass 7: (10), the sum over all photons, weighed by (11), (14), (15), and (14) put
 *                       right; indirect shadows, which the paper leaves open
 *   picture.c           passes 5 to 8 strip by strip: what is seen, by way of mirrors too, and its light
 *   report.c            how much light the map holds, and how much of the photons' arrives
 *   method.c            the method's interface: frames, edits, memory, what made a pixel
 *
 * Mirrors, before the eye and before the lights, are followed by rays: there is no pass 4, the paper's
 * environment cubes, which show less of the same.
 */
#pragma once

#include "cache/direct_radiance/lights.h"
#include "cache/direct_radiance/map.h"
#include "cache/direct_radiance/receivers.h"
#include "cache/frame/announce.h"
#include "cache/frame/method.h"
#include "cache/reflect/reflect.h"
#include "trace/trace.h"

/* ---- the plan (plan.c): settings completed, and the passes that a scene needs ---- */

typedef struct sl_radiance_plan {
    bool receivers;      /* some surface is diffuse or glossy */
    bool shadows;        /* pass 1 */
    bool map;            /* passes 2 and 3: some surface reflects a light */
    bool glossy;         /* some surface is: true colour instead of radiance, eye vectors */
    bool normals;        /* pass 2c */
    bool mirrors;
    bool tracer;         /* rays are needed */
    bool environment;
} sl_radiance_plan;

/* Replaces what is 0 in settings->radiance_map, or left to quality. */
void sl_radiance_complete(sl_settings *settings);
/* settings are complete. */
sl_radiance_plan sl_radiance_plan_make(const sl_scene *scene, const sl_settings *settings);
void sl_radiance_transport(const sl_settings *settings, sl_transport *transport);
void sl_radiance_plan_write(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer);

sl_memory_need sl_radiance_need(const sl_scene *scene, const sl_settings *settings);

/* Passes 6 and 7: light on receivers. Direct light by (5) and (9) with shadow cubes; indirect light by (10),
 * the sum over the photons. */

typedef struct sl_light_pass {
    const sl_scene *scene;
    const sl_map_lights *lights;
    const sl_map_photons *photons;       /* NULL: no indirect light */
    sl_photon_weight weight;             /* not AUTO */
    const sl_tracer *tracer;             /* asks whether receivers see photons; NULL: they all do */
    unsigned threads;
} sl_light_pass;

/* (10): what is made once for a frame of its photons. The pass must outlive its sums. */
typedef struct sl_photon_sums sl_photon_sums;
/* with photons, not NULL */
sl_status sl_photon_sums_create(const sl_light_pass *pass, sl_photon_sums **sums, sl_error *error);
void sl_photon_sums_destroy(sl_photon_sums *sums);
/* Sums the photons in index order, without the receivers' lobes. */
void sl_photon_sums_irradiance(const sl_photon_sums *sums, const sl_receiver_tile *tile,
                               sl_tile_light *light);

/* Where a tile's light is added: planes that the tile's pixels are indices of. */
typedef struct sl_tile_target {
    float *direct[3], *indirect[3];
} sl_tile_target;

typedef struct sl_direct_light {
    const sl_light_pass *pass;
    /* 1 / r^2 nearer than which a light is taken to stand on the receiver: it then gives nothing */
    float largest_weight;
    sl_isa isa;
} sl_direct_light;

/* Add to a tile's pixels: each sum in the order of lights or photons, the same bits at any number of threads.
 */
sl_direct_light sl_direct_light_of(const sl_light_pass *pass);
void sl_direct_light_tile(const sl_direct_light *light, const sl_receiver_tile *tile, bool glossy,
                          const sl_tile_target *to, sl_counters *counters);
void sl_indirect_light_tile(const sl_photon_sums *sums, const sl_receiver_tile *tile, bool glossy,
                            const sl_tile_target *to, sl_counters *counters);
/* Both, on a strip of tiles from row y0 of the G-buffer on; NULL: no direct light, no photons. Diffuse pixels
 * of a tile come first, then glossy ones. */
void sl_light_strip(const sl_direct_light *direct, const sl_photon_sums *sums, const sl_scene *scene,
                    const sl_gbuffer *gbuffer, int y0, const sl_tile_target *to, sl_counters *counters);
/* Lists the radiance that each photon alone sends from the tile's one receiver towards the eye, in index
 * order, times `throughput`; weight: of its diffuse part, and 0 for what the receiver does not see. */
void sl_indirect_light_explain(const sl_photon_sums *sums, const sl_receiver_tile *tile, bool glossy,
                               sl_rgb throughput, sl_explanation_writer *writer);

/* ---- a frame (direct_radiance.c) ---- */

typedef struct sl_radiance_state {
    const sl_scene *scene;
    sl_settings settings;
    sl_radiance_plan plan;

    sl_raster *raster;
    sl_tracer *tracer;             /* visibility and mirrors alone */

    sl_map_lights *lights;         /* pass 1: with their depth cubes */
    sl_radiance_map *map;          /* pass 2 */
    sl_map_photons *photons;       /* pass 3 */
    double received;               /* sl_flux_received(); NaN where photons are asked for by rays */
    uint32_t *id;                  /* pass 5: the triangles that the picture shows */
    sl_image *image;               /* NULL: handed over already, or not drawn yet */

    bool placed;                   /* raster and tracer are those of the scene as it stands */
    bool lit;                      /* passes 1 to 3 as well */
    bool drawn;                    /* what is seen is that of this frame */
    sl_counters counters;
    sl_announcer announcer;
} sl_radiance_state;

/* Follows the scene's objects, and plans anew. */
sl_status sl_radiance_place(sl_radiance_state *state, sl_error *error);
/* Passes 1 to 3: what depends on the lights, and not on the camera. */
sl_status sl_radiance_light_up(sl_radiance_state *state, sl_error *error);
/* Passes 5 to 8, into the image. */
sl_status sl_radiance_draw(sl_radiance_state *state, sl_error *error);
/* The same of the ids that are drawn, strip by strip (picture.c). */
sl_status sl_radiance_draw_image(const sl_radiance_state *state, sl_image **image, sl_counters *counters,
                                 sl_error *error);
sl_light_pass sl_radiance_lighting(const sl_radiance_state *state);
void sl_radiance_forget_geometry(sl_radiance_state *state);
void sl_radiance_darken(sl_radiance_state *state);
/* Hand the map's pictures, photons as points coloured by their flux, and the light in the picture to an
 * observer (method.c). */
void sl_radiance_announce_map(sl_radiance_state *state);
void sl_radiance_announce_light(sl_radiance_state *state);
void sl_announce_photons(sl_announcer *announcer, const sl_map_photons *photons);

/* ---- the report (report.c): light that direct radiance maps leave out or count twice ---- */

/* *received: integral of E dA over both sides of all that receives light, at points all over it, over rho Phi
 * of the photons, without visibility. In a closed room without anything in it 1 (less what the weight loses);
 * beyond that, light that arrives behind what should stop it. NaN where there is nothing to divide by. */
sl_status sl_flux_received(const sl_light_pass *pass, double *received, sl_error *error);
/* Metadata of a picture with a map: softlux.flux_captured, softlux.flux_received, softlux.warning. The latter
 * tells of maps that hold less than half of the flux, of photons whose flux arrives more than 1.25 times, and
 * where (15), which divides by the square of the scene's diagonal, leaves next to nothing. */
sl_status sl_radiance_stamp(const sl_radiance_state *state, sl_image *image, sl_error *error);
