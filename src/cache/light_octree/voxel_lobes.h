/* What a voxel keeps of its photons: directional lights, or one irradiance. */
#ifndef SL_CACHE_LIGHT_OCTREE_VOXEL_LOBES_H
#define SL_CACHE_LIGHT_OCTREE_VOXEL_LOBES_H

#include "cache/light_octree/voxel_lights.h"

/* Photons on one side of a surface, as arrays, in order of their ids; a worker's scratch. */
typedef struct sl_lobe_photons {
    size_t count;
    float *x, *y, *z;             /* omega */
    float *flux[3];
    double *luminance;            /* Y(flux) > 0 */
    double *inverse_cosine;       /* 1 / max(n_i . omega, epsilon) */
    double *weight, *nearest;     /* room for the clusters */
    uint8_t *of;
} sl_lobe_photons;

sl_status sl_lobe_photons_create(size_t capacity, sl_lobe_photons *photons, sl_error *error);
void sl_lobe_photons_release(sl_lobe_photons *photons);
/* The photons from `first` on. */
sl_lobe_photons sl_lobe_photons_from(const sl_lobe_photons *photons, size_t first, size_t count);
/* Adds a photon, unless it carries nothing, or nothing finite. normal: on the photon's side. */
void sl_lobe_photons_add(sl_lobe_photons *photons, sl_vec3 direction, sl_vec3 normal, const float flux[3]);

static const double SL_GRAZING = 0.05; /* epsilon: bounds a photon's weight, not its energy */

typedef struct sl_lobe_spread {
    double cost, weight;  /* J, sum w: of all clusters */
} sl_lobe_spread;

/* E = scale * sum of fluxes, scale = kappa / A. normal: n_v on the photons' side, or (0,0,0). flat: the
 * surface reflects light of all directions alike, and one light along its normal makes the same irradiance.
 * Writes at most `room` lights; returns how many texels are used. spread (clusters alone) is added to. */
int sl_lobes_of_photons(const sl_lobe_photons *photons, const sl_voxel_light_options *options, double scale,
                        sl_vec3 normal, bool flat, int room, sl_directional_light *light,
                        sl_lobe_spread *spread);
int sl_lobe_texels(const sl_voxel_light_options *options);

#endif
