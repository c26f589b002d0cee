/* The fragment programs of passes 6 and 7: loops over a tile's receivers that are compiled for every instruction set. */
#ifndef SL_CACHE_DIRECT_RADIANCE_RECEIVER_KERNELS_H
#define SL_CACHE_DIRECT_RADIANCE_RECEIVER_KERNELS_H

#include "cache/direct_radiance/receiver_tiles.h"
#include "cache/direct_radiance/weights.h"

/* kd to kd / pi; lanes without a sound normal get none, and so no light. */
typedef void sl_prepare_kernel(sl_receiver_tile *tile);
/* A whole tile, prepared: rows of 12 planes of that width (positions, geometric and shading normals, kd) from pixel[0] on. */
typedef void sl_fetch_rows_kernel(const float *const plane[SL_TILE_PLANES], size_t width, sl_receiver_tile *tile);
/* Does a tile of the picture (one that lies in it whole) show one material? Then pixel gets all of its pixels. */
typedef bool sl_survey_kernel(const uint32_t *material, uint32_t first, uint32_t width, uint32_t *pixel);
/* Radiance that leaves towards the eye. */
typedef void sl_reflect_kernel(const sl_receiver_tile *tile, const sl_tile_light *light, bool glossy, float (*radiance)[SL_TILE_PIXELS]);

/* The same, added to three planes of that width. */
typedef void sl_reflect_to_kernel(const sl_receiver_tile *tile, const sl_tile_light *light, bool glossy, int width, float *const planes[3]);
/* Its luminance's absolute value, into a plane. */
typedef void sl_reflect_spread_kernel(const sl_receiver_tile *tile, const sl_tile_light *light, bool glossy, float *plane);
/* lit_i: 1 where 0 < weight_i <= largest, else 0. Is any? */
typedef bool sl_reached_kernel(size_t count, const float *weight, float largest, float *lit);
/* a_i = b_i > 0 ? a_i : 0 */
typedef void sl_where_kernel(size_t count, const float *b, float *a);

/* share[0] half[0] + share[1] half[1] */
typedef void sl_combine_kernel(size_t count, bool glossy, const sl_tile_light half[2], const float share[2], sl_tile_light *sum);

/* (10) over Lambertian photons in index order: adds the even ones to the irradiance of half[0], the odd ones to that of half[1]. */
typedef void sl_photon_sum_kernel(const sl_receiver_tile *tile, const sl_photon_registers *photons, size_t count, bool cosine,
                                  sl_tile_light half[2]);
/* One photon's weight, or its polygon's where pi (its Pi by Lambert's formula) is given. */
typedef void sl_photon_weigh_kernel(const sl_receiver_tile *tile, const sl_photon_registers *photon, bool cosine, float *weight);
typedef void sl_polygon_weigh_kernel(const sl_receiver_tile *tile, const sl_photon_registers *photon, const sl_photon_polygon *polygon,
                                     const float *pi, float *weight);
/* Where a receiver's lobe looks: a point, or a direction. What has an area is a disc of that normal, seen from its front or from both
 * sides; extent: area / (4 pi), else 0. */
typedef struct sl_lobe_target {
    sl_vec3 towards;
    bool direction;
    sl_vec3 normal;
    float extent;
    bool two_sided;
} sl_lobe_target;

/* Cosine powers: of a photon's lobe towards the receivers; of the receivers' lobes towards what lights them. */
typedef void sl_photon_lobe_kernel(const sl_receiver_tile *tile, const sl_photon_registers *photon, const sl_lobe_registers *lobe,
                                   float *power);
typedef void sl_receiver_lobe_kernel(const sl_receiver_tile *tile, const sl_lobe_target *target, float *power);
/* The mirrored directions of the eye, from where the eye is, which they replace. */
typedef void sl_mirror_eye_kernel(sl_receiver_tile *tile);
/* a_i *= b_i */
typedef void sl_multiply_kernel(size_t count, const float *b, float *a);

typedef struct sl_receiver_kernels {
    sl_prepare_kernel *prepare;
    sl_fetch_rows_kernel *fetch_rows;
    sl_survey_kernel *survey;
    sl_reflect_to_kernel *reflect_to;
    sl_reflect_spread_kernel *reflect_spread;
    sl_reached_kernel *reached;
    sl_where_kernel *where;
    sl_combine_kernel *combine;
    sl_photon_sum_kernel *sum;
    sl_photon_weigh_kernel *weigh;
    sl_polygon_weigh_kernel *weigh_polygon;
    sl_photon_lobe_kernel *photon_lobe;
    sl_receiver_lobe_kernel *receiver_lobe;
    sl_mirror_eye_kernel *mirror_eye;
    sl_multiply_kernel *multiply;
    sl_light_kernels light;
} sl_receiver_kernels;

SL_KERNEL_VARIANTS(sl_prepare_kernel, sl_receivers_prepare);
SL_KERNEL_VARIANTS(sl_fetch_rows_kernel, sl_receivers_fetch_rows);
SL_KERNEL_VARIANTS(sl_survey_kernel, sl_receivers_survey);
SL_KERNEL_VARIANTS(sl_reflect_to_kernel, sl_receivers_reflect_to);
SL_KERNEL_VARIANTS(sl_reflect_spread_kernel, sl_receivers_spread);
SL_KERNEL_VARIANTS(sl_reached_kernel, sl_receivers_reached);
SL_KERNEL_VARIANTS(sl_where_kernel, sl_receivers_where);
SL_KERNEL_VARIANTS(sl_combine_kernel, sl_receivers_combine);
SL_KERNEL_VARIANTS(sl_photon_sum_kernel, sl_photons_sum);
SL_KERNEL_VARIANTS(sl_photon_weigh_kernel, sl_photon_weigh);
SL_KERNEL_VARIANTS(sl_polygon_weigh_kernel, sl_photon_polygon);
SL_KERNEL_VARIANTS(sl_photon_lobe_kernel, sl_photon_lobe_power);
SL_KERNEL_VARIANTS(sl_receiver_lobe_kernel, sl_receiver_lobe_power);
SL_KERNEL_VARIANTS(sl_mirror_eye_kernel, sl_receiver_mirror_eye);
SL_KERNEL_VARIANTS(sl_multiply_kernel, sl_receivers_multiply);

static inline sl_receiver_kernels sl_receiver_kernels_for(sl_isa isa) {
    return (sl_receiver_kernels){
        SL_KERNEL_OF(isa, sl_receivers_prepare), SL_KERNEL_OF(isa, sl_receivers_fetch_rows),
        SL_KERNEL_OF(isa, sl_receivers_survey), SL_KERNEL_OF(isa, sl_receivers_reflect_to),
        SL_KERNEL_OF(isa, sl_receivers_spread), SL_KERNEL_OF(isa, sl_receivers_reached),
        SL_KERNEL_OF(isa, sl_receivers_where), SL_KERNEL_OF(isa, sl_receivers_combine),
        SL_KERNEL_OF(isa, sl_photons_sum), SL_KERNEL_OF(isa, sl_photon_weigh),
        SL_KERNEL_OF(isa, sl_photon_polygon), SL_KERNEL_OF(isa, sl_photon_lobe_power),
        SL_KERNEL_OF(isa, sl_receiver_lobe_power), SL_KERNEL_OF(isa, sl_receiver_mirror_eye),
        SL_KERNEL_OF(isa, sl_receivers_multiply), sl_light_kernels_for(isa)};
}

/* Fills the lanes from the tile's count and pixels; not what glossy receivers have besides. */
void sl_receiver_tile_fetch(const sl_gbuffer *gbuffer, const sl_receiver_kernels *kernels, sl_receiver_tile *tile);

#endif
