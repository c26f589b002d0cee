/* Receivers (the paper's importons) side by side in lanes: a picture is lit tile by tile, and of a tile only
 * the pixels that reflect.
 *
 * Thirty-two by four pixels: rays of neighbours stay together, blocks of 4 x 4 stay whole, and a tile's
 * positions and normals stay in the nearest cache while all photons pass over them. */
#pragma once

#include <float.h>
#include <stddef.h>

#include "base/isa.h"
#include "base/math.h"
#include "cache/direct_radiance/map.h"
#include "cache/light/light_kernels.h"
#include "raster/raster.h"

enum {
    SL_TILE_WIDTH = 32,
    SL_TILE_HEIGHT = 4,
    SL_TILE_PIXELS = SL_TILE_WIDTH * SL_TILE_HEIGHT,
    SL_TILE_LANES = 16,
    SL_TILE_PLANES = 12
};
_Static_assert((int)SL_TILE_PIXELS == (int)SL_LIGHT_BLOCK,
               "a tile is what the loops over lights take at once");

/* A pixel's reflection of light that falls on it. */
typedef enum sl_receiver_kind {
    SL_RECEIVER_NONE,    /* background, black emitters, what endless mirrors show */
    SL_RECEIVER_DIFFUSE,
    SL_RECEIVER_GLOSSY,  /* a Phong lobe, besides or alone: where the light goes depends on the eye */
    SL_RECEIVER_KINDS
} sl_receiver_kind;

typedef struct sl_receiver_tile {
    size_t count;  /* lanes in use */
    /* rounded up to SL_TILE_LANES: loops run over whole vectors; lanes beyond have no normals, and so get no
     * light */
    size_t padded;
    uint32_t pixel[SL_TILE_PIXELS], triangle[SL_TILE_PIXELS];
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

sl_light_points sl_receiver_tile_points(const sl_receiver_tile *tile);

/* A tile of one pixel; false where it does not receive. */
bool sl_receiver_tile_of_pixel(const sl_scene *scene, const sl_gbuffer *gbuffer, size_t pixel, bool *glossy,
                               sl_receiver_tile *tile);

/* E_j(x): what photon j at y sends to receiver x. d = y - x, r = |d|; cos = (n_x . d)+ / r and cos' = (-n_y .
 * d)+ / r are the cosines at the receiver and at the photon. Psi: the photon's flux, W/sr; L_o: its radiance,
 * Psi = L_o A; A': its footprint perpendicular to the light, alpha: the angle at which the light falls there,
 * A = A' / cos alpha. M, diagonal: see sl_weight_terms. Numbers are the paper's.
 *
 *     weight       E_j                                form     colour                  a            b
 *     flux         Psi cos cos' / (r^2 + A / pi)      disc     Psi cos alpha           cos alpha    A' / pi
 *     plain        Psi cos cos' / r^2                 disc     Psi                     1            0
 *     disc, (14)   L_o cos cos' A / (A + r^2)         disc     L_o                     1 / A        1
 *     even, (11)   L_o cos 2 pi / M                   cosine   L_o 2 pi / M
 *     box, (15)    L_o cos A' / diagonal^2            cosine   L_o A' / diagonal^2
 *
 * The default is flux, which is (14) put right: a disc of area A that faces x across r has the
 * cosine-weighted solid angle A / (r^2 + A / pi); where (14) has A alone, a surface all around x gives it L_o
 * instead of pi L_o. In (14) and (15) A and A' are the printed ones, by (13) and (12). The two forms that the
 * weights have in common, with a and b as above (flux without cos alpha as a divisor of its own):
 *
 *                            (n_x . d)+ (-n_y . d)+
 *     disc    E_j = colour  ------------------------ ,
 *                               r^2 (a r^2 + b)
 *
 *     cosine  E_j = colour  (n_x . d)+ / r ,                          neither distance nor the photon's
 * facing
 *
 * and a third one, the photon's footprint as a polygon. What does not depend on x is computed once a frame
 * and uploaded as three registers a photon. */

/* Three vectors of four floats. */
typedef struct sl_photon_registers {
    float x, y, z, a;
    float red, green, blue, b; /* colour; of a photon with a lobe, of its diffuse part */
    float nx, ny, nz, nearest; /* nearest: square of the distance below which the photon gives nothing */
} sl_photon_registers;

static inline bool sl_weight_is_cosine(sl_photon_weight weight) {
    return weight == SL_WEIGHT_EVEN || weight == SL_WEIGHT_BOX;
}
/* The printed weights are of L_o, the others of the flux Psi. */
static inline bool sl_weight_is_printed(sl_photon_weight weight) {
    return sl_weight_is_cosine(weight) || weight == SL_WEIGHT_DISC;
}

/* Terms of a weight that all photons share. */
typedef struct sl_weight_terms {
    float nearest_squared;
    float per_sample;   /* (11): 2 pi / M, M of the photon's light */
    float per_diagonal; /* (15): 1 / diagonal^2 */
    /* a power of two near 1 / diagonal^2: the denominators of tiny and huge scenes stay within floats */
    float unit;
} sl_weight_terms;

/* The j-indexed values of a photon. Of the polygon weight: those of the flux weight, which stands in for it.
 * A photon that is not finite gets no colour. */
static inline sl_photon_registers sl_photon_registers_of(const sl_map_photon *photon, sl_photon_weight weight,
                                                         sl_weight_terms terms) {
    const float area = photon->printed_area;
    sl_rgb colour = sl_weight_is_printed(weight) ? photon->radiance : photon->flux;
    float a = 0.0f, b = 1.0f, scale = 1.0f;
    if (weight == SL_WEIGHT_PLAIN) {
        a = 1.0f;
        b = 0.0f;
    } else if (weight == SL_WEIGHT_EVEN) {
        scale = terms.per_sample;
    } else if (weight == SL_WEIGHT_BOX) {
        scale = area * photon->cos_alpha * terms.per_diagonal; /* A' = A cos alpha */
    } else if (weight == SL_WEIGHT_DISC) {
        /* L_o cos cos' A / (A + r^2); A may be infinite: L_o cos cos' */
        a = area > 0.0f ? 1.0f / area : 0.0f;
        scale = area > 0.0f ? 1.0f : 0.0f;
    } else {
        a = scale = photon->cos_alpha;
        b = photon->footprint * (float)(1.0 / SL_PI);
    }
    if (!sl_weight_is_cosine(weight)) { /* exactly the same quotient */
        a *= terms.unit;
        b *= terms.unit;
        scale *= terms.unit;
    }
    sl_rgb c = sl_rgb_scale(colour, scale);
    bool good = sl_rgb_is_finite(c) && isfinite(a) && isfinite(b) && sl_is_finite(photon->position) &&
                sl_is_finite(photon->normal);
    if (!good) return (sl_photon_registers){.b = 1.0f, .nearest = terms.nearest_squared};
    return (sl_photon_registers){
        photon->position.x, photon->position.y, photon->position.z,   a, c.r, c.g, c.b, b, photon->normal.x,
        photon->normal.y,   photon->normal.z,   terms.nearest_squared};
}

/* The two forms, without the colour. geometric: the receiver's geometric normal; normal: its shading normal.
 * 0 below either horizon, at distances that are too small or beyond floats, and for all that is not a number.
 */
static inline float sl_disc_weight(const sl_photon_registers *p, sl_vec3 x, sl_vec3 geometric,
                                   sl_vec3 normal) {
    float dx = p->x - x.x, dy = p->y - x.y, dz = p->z - x.z;
    float squared = dx * dx + dy * dy + dz * dz;
    float above = geometric.x * dx + geometric.y * dy + geometric.z * dz;
    float here = normal.x * dx + normal.y * dy + normal.z * dz,
          there = -(p->nx * dx + p->ny * dy + p->nz * dz);
    float below = squared * (p->a * squared + p->b);
    bool lit = (above > 0.0f) & (here > 0.0f) & (there > 0.0f) & (squared > p->nearest) &
               (below >= 0x1p-126f) & (below <= 0x1p126f);
    float value = here * there / (lit ? below : 1.0f);
    return lit ? value : 0.0f;
}

static inline float sl_cosine_weight(const sl_photon_registers *p, sl_vec3 x, sl_vec3 geometric,
                                     sl_vec3 normal) {
    float dx = p->x - x.x, dy = p->y - x.y, dz = p->z - x.z;
    float squared = dx * dx + dy * dy + dz * dz;
    float above = geometric.x * dx + geometric.y * dy + geometric.z * dz,
          here = normal.x * dx + normal.y * dy + normal.z * dz;
    bool lit = (above > 0.0f) & (here > 0.0f) & (squared > p->nearest) & (squared >= 0x1p-126f) &
               (squared <= 0x1p126f);
    float value = here / sqrtf(lit ? squared : 1.0f);
    return lit ? value : 0.0f;
}

/* Pi / A_q, where the receiver is before the polygon and some of that above the receiver's plane. pi:
 * Lambert's formula, above the shading normal's horizon. A polygon is the tangent plane of what it stands
 * for: of a curved sheet it juts out over the sheet's other side. What faces it from as close as the plane is
 * to the sheet, or sees corners and not the middle from nearby, is that other side. */
static inline float sl_polygon_weight(const sl_photon_registers *p, const sl_photon_polygon *polygon,
                                      sl_vec3 x, sl_vec3 geometric, float pi) {
    float dx = p->x - x.x, dy = p->y - x.y, dz = p->z - x.z;
    float squared = dx * dx + dy * dy + dz * dz, there = -(p->nx * dx + p->ny * dy + p->nz * dz);
    float middle = geometric.x * dx + geometric.y * dy + geometric.z * dz;
    float facing = geometric.x * p->nx + geometric.y * p->ny + geometric.z * p->nz;
    bool touching = there < polygon->depth, beyond = (middle <= 0.0f) & (squared * polygon->over_area < 4.0f);
    bool above = false, other_side = (touching | beyond) & (facing < -0.5f);
    for (int c = 0; c < 4; c++) {
        const sl_vec3 q = polygon->corner[c];
        above |= geometric.x * (q.x - x.x) + geometric.y * (q.y - x.y) + geometric.z * (q.z - x.z) > 0.0f;
    }
    float value = pi * polygon->over_area;
    bool good = above & !other_side & (there > 0.0f) & (squared > p->nearest) & (value <= 0x1p126f);
    return good ? value : 0.0f;
}

/* ---- all photons of a frame ---- */

/* The directions into which a photon with a lobe sends its flux: the light's direction mirrored, and the
 * colour of the lobe. */
typedef struct sl_lobe_registers {
    float x, y, z, exponent;
    sl_rgb colour;
} sl_lobe_registers;

/* Power of the cosine between a lobe's axis (unit) and the direction d of length r: 0 beyond a right angle.
 */
static inline float sl_lobe_power(float along, float squared, float exponent) {
    float cosine = along / sqrtf(squared > 0.0f ? squared : 1.0f);
    float power = sl_powf(cosine < 1.0f ? cosine : 1.0f, exponent);
    return cosine > 0.0f ? power : 0.0f;
}

typedef enum sl_weight_form { SL_FORM_DISC, SL_FORM_COSINE, SL_FORM_POLYGON } sl_weight_form;

/* A photon as it is looked up: with SL_FORM_POLYGON the colour is the flux, to be multiplied by Pi / A_q; of
 * one with a lobe that of its diffuse part. lobe: is written where photons have lobes. */
sl_weight_form sl_photon_load(const sl_map_photons *photons, size_t photon, sl_photon_weight weight,
                              sl_photon_registers *registers, sl_lobe_registers *lobe);

/* The fragment programs of passes 6 and 7: loops over a tile's receivers that are compiled for every
 * instruction set. */

/* kd to kd / pi; lanes without a sound normal get none, and so no light. */
SL_KERNELS(void, sl_receivers_prepare, (sl_receiver_tile *tile));
/* Radiance that leaves towards the eye, added to three planes. */
SL_KERNELS(void, sl_receivers_reflect_to,
           (const sl_receiver_tile *tile, const sl_tile_light *light, bool glossy, float *const planes[3]));
/* Sets lit_i to 1 where 0 < weight_i <= largest, else both to 0; tells if any is lit. */
SL_KERNELS(bool, sl_receivers_reached, (size_t count, float *weight, float largest, float *lit));

/* (10) over Lambertian photons in index order: adds to the irradiance. */
SL_KERNELS(void, sl_photons_sum,
           (const sl_receiver_tile *tile, const sl_photon_registers *photons, size_t count, bool cosine,
            sl_tile_light *sum));
/* One photon's weight, or its polygon's where pi (its Pi by Lambert's formula) is given. */
SL_KERNELS(void, sl_photon_weigh,
           (const sl_receiver_tile *tile, const sl_photon_registers *photon, bool cosine, float *weight));
SL_KERNELS(void, sl_photon_polygon,
           (const sl_receiver_tile *tile, const sl_photon_registers *photon,
            const sl_photon_polygon *polygon, const float *pi, float *weight));
/* Where a receiver's lobe looks: a point, or a direction. What has an area is a disc of that normal, seen
 * from its front or from both sides; extent: area / (4 pi), else 0. */
typedef struct sl_lobe_target {
    sl_vec3 towards;
    bool direction;
    sl_vec3 normal;
    float extent;
    bool two_sided;
} sl_lobe_target;

/* Cosine powers: of a photon's lobe towards the receivers; of the receivers' lobes towards what lights them.
 */
SL_KERNELS(void, sl_photon_lobe_power,
           (const sl_receiver_tile *tile, const sl_photon_registers *photon, const sl_lobe_registers *lobe,
            float *power));
SL_KERNELS(void, sl_receiver_lobe_power,
           (const sl_receiver_tile *tile, const sl_lobe_target *target, float *power));
/* The mirrored directions of the eye, from where the eye is, which they replace. */
SL_KERNELS(void, sl_receiver_mirror_eye, (sl_receiver_tile *tile));
