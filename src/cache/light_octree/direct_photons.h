/* The photon map made visible directly: at every point its k nearest photons, reflected one by one (Jensen
 * 1996). What the light octree approximates, at the price of a gather for each pixel: the peer beside which
 * its error and its speed are measured. */
#ifndef SL_CACHE_LIGHT_OCTREE_DIRECT_PHOTONS_H
#define SL_CACHE_LIGHT_OCTREE_DIRECT_PHOTONS_H

#include "cache/light_octree/photon_area.h"
#include "cache/photons/photon_tree.h"

/* The surface inside an ellipsoid, where the photons may be strewn over less than its disc: near edges and
 * corners. */
typedef double sl_ellipsoid_area(const void *context, const sl_ellipsoid *ellipsoid, unsigned worker);

typedef struct sl_direct_photons {
    const sl_photon_tree *tree;
    size_t neighbours;       /* k */
    double radius, flatness; /* r, f */
    double cos_acceptance;
    sl_ellipsoid_area *area; /* NULL: the disc's; called by many workers at once */
    const void *area_context;
    unsigned threads;
} sl_direct_photons;

/* Radiance that the surfaces reflect towards viewers (unit) of the photons' light: L = kappa / A sum
 * f_r(omega_i, v) (n . omega_i) / (n_i . omega_i) Phi_i, kappa = (k - 1) / k where the k-th photon set the
 * radius, else 1. Mirrors give nothing. irradiance (may be NULL): kappa / A sum Phi_i. */
sl_status sl_direct_photons_radiance(const sl_direct_photons *photons, size_t count,
                                     const sl_surface *surfaces, const sl_vec3 *to_viewer, sl_rgb *radiance,
                                     sl_rgb *irradiance, sl_counters *counters, sl_error *error);

#endif
