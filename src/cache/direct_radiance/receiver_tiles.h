/* Receivers (the paper's importons) side by side in lanes: a picture is lit tile by tile, and of a tile only the pixels that reflect.
 *
 * Thirty-two by four pixels: rays of neighbours stay together, blocks of 4 x 4 stay whole, and a tile's positions and normals
 * stay in the nearest cache while all photons pass over them. */
#ifndef SL_CACHE_DIRECT_RADIANCE_RECEIVER_TILES_H
#define SL_CACHE_DIRECT_RADIANCE_RECEIVER_TILES_H

#include "cache/direct_radiance/receivers.h"
#include "cache/light/light_kernels.h"

enum { SL_TILE_WIDTH = 32, SL_TILE_HEIGHT = 4, SL_TILE_PIXELS = SL_TILE_WIDTH * SL_TILE_HEIGHT, SL_TILE_LANES = 16, SL_TILE_PLANES = 12 };
_Static_assert((int)SL_TILE_PIXELS == (int)SL_LIGHT_BLOCK, "a tile is what the loops over lights take at once");

/* What a pixel does with light that falls on it. */
typedef enum sl_receiver_kind {
    SL_RECEIVER_NONE,    /* background, mirrors, black emitters */
    SL_RECEIVER_DIFFUSE,
    SL_RECEIVER_GLOSSY,  /* a Phong lobe, besides or alone: where the light goes depends on the eye */
    SL_RECEIVER_MIRROR   /* a mirror that receives light as if it were diffuse */
} sl_receiver_kind;

typedef struct sl_receiver_tile {
    size_t count;  /* lanes in use */
    size_t padded; /* rounded up to SL_TILE_LANES: loops run over whole vectors; lanes beyond have no normals, and so get no light */
    bool whole;    /* all pixels of a tile that lies in the picture whole, row by row */
    uint32_t pixel[SL_TILE_PIXELS];
    _Alignas(64) float x[SL_TILE_PIXELS], y[SL_TILE_PIXELS], z[SL_TILE_PIXELS];
    float geometric_x[SL_TILE_PIXELS], geometric_y[SL_TILE_PIXELS], geometric_z[SL_TILE_PIXELS];
    float normal_x[SL_TILE_PIXELS], normal_y[SL_TILE_PIXELS], normal_z[SL_TILE_PIXELS];
    float diffuse[3][SL_TILE_PIXELS]; /* kd / pi */
    /* Of glossy receivers: the eye's direction mirrored by the shading normal, ks (n+2) / (2 pi), and n. */
    float mirrored_x[SL_TILE_PIXELS], mirrored_y[SL_TILE_PIXELS], mirrored_z[SL_TILE_PIXELS];
    float specular[3][SL_TILE_PIXELS], exponent[SL_TILE_PIXELS];
} sl_receiver_tile;

/* Light on a tile's receivers: irradiance, and irradiance times the cosine power of each receiver's lobe. */
typedef struct sl_tile_light {
    _Alignas(64) float irradiance[3][SL_TILE_PIXELS];
    float lobe[3][SL_TILE_PIXELS];
} sl_tile_light;

/* Kinds by material: one for each, and NONE for the background as the last. */
typedef struct sl_receiver_kinds {
    const sl_scene *scene;
    sl_rgb trick_albedo;
    bool glossy;   /* there are glossy materials */
    uint8_t *of_material;
} sl_receiver_kinds;

/* trick_albedo: 0 leaves mirrors out. */
sl_status sl_receiver_kinds_find(const sl_scene *scene, sl_rgb trick_albedo, sl_receiver_kinds *kinds, sl_error *error);
void sl_receiver_kinds_release(sl_receiver_kinds *kinds);

sl_receiver_kind sl_receiver_kind_at(const sl_receiver_kinds *kinds, const sl_gbuffer *gbuffer, size_t pixel);
sl_light_points sl_receiver_tile_points(const sl_receiver_tile *tile);

/* What is done with each tile that has pixels to be lit. Costs are counted apart for every strip of tiles. */
typedef void sl_tile_program(void *context, const sl_receiver_tile *tile, bool glossy, sl_counters *counters);
/* Diffuse pixels of a tile first, then glossy ones; strips of tiles are shared out to threads. Counts the fragments. */
/* A strip of tiles from row y0 on, by this thread. */
void sl_receiver_tiles_strip(const sl_receivers *receivers, const sl_receiver_kinds *kinds, int y0, sl_tile_program *program, void *context,
                             sl_counters *counters);
sl_status sl_receiver_tiles_run(const sl_receivers *receivers, const sl_receiver_kinds *kinds, unsigned threads,
                                sl_tile_program *program, void *context, sl_counters *counters, sl_error *error);

#endif
