/* Sample photons: what pass 3 takes from the direct radiance map. A photon is a piece of directly lit surface; a receiver (the paper's
 * importon) adds up what all of them send. */
#ifndef SL_CACHE_DIRECT_RADIANCE_PHOTONS_H
#define SL_CACHE_DIRECT_RADIANCE_PHOTONS_H

#include "cache/frame/settings.h"
#include "cache/direct_radiance/radiance_map.h"

/* 64 bytes: what a fragment program would hold in four registers. */
typedef struct sl_map_photon {
    sl_vec3 position;     /* y */
    float footprint;      /* A' = b^2 dOmega, m^2 perpendicular to the light: (12) corrected. Of a flux group: A cos alpha */
    sl_rgb flux;          /* Psi = rho I dOmega / pi = L_o A, W/sr. With lobes: I dOmega, the material is the lobe's */
    float cos_alpha;      /* at y, towards the light; > 0 */
    sl_vec3 normal;       /* n_y, unit, on the lit side: the geometric one, which decides sides */
    float printed_area;   /* (13) with (12), for the printed weights: A of (14); its A' is printed_area * cos_alpha */
    sl_rgb radiance;      /* for the printed weights: L_o, or with lobes the irradiance that is reflected; of a group, the share that it has in its
                             sample's mean */
    uint32_t object;
} sl_map_photon;

/* How a photon on a surface that is not Lambertian reflects, beside photon i. */
typedef struct sl_photon_lobe {
    sl_rgb diffuse, specular; /* kd, ks */
    float exponent;
    sl_vec3 to_light;         /* unit */
    sl_vec3 normal;           /* unit, shading */
} sl_photon_lobe;

/* The corners of a photon's footprint on its tangent plane, in turn; count 0 where they do not all meet it in front of the light, or a ray
 * is longer than 4 b: then the flux weight stands in. */
typedef struct sl_photon_quad {
    int count; /* 0 or 4 */
    sl_vec3 corner[4];
    float area;  /* A_q > 0 */
    float depth; /* by how much the plane may miss the surface */
} sl_photon_quad;

typedef struct sl_map_photons {
    size_t count, room;      /* of the arrays */
    sl_map_photon *photon;   /* in order of light, face, row, column, group: of every sum */
    sl_photon_lobe *lobe;    /* NULL where all surfaces are Lambertian */
    sl_photon_quad *quad;    /* NULL unless the polygon weight is wanted */
    size_t first_of_light[SL_MAP_POINTS_MAX + 1]; /* light l's photons end where those of l + 1 begin */
    size_t samples_of_light[SL_MAP_POINTS_MAX];   /* M: a sample may have no photon, or a few groups of them */
    size_t dropped;          /* samples without a photon: nearer to the light than 1e-4 of the diagonal of the scene's core, or without light */
    float nearest;           /* r below which a photon gives nothing: 1e-6 of the scene's scale */
    float box_diagonal;      /* ||B_max - B_min|| of (15) */
} sl_map_photons;

/* settings are complete. A pure function of scene and map: nothing outlives a frame. */
sl_status sl_map_photons_take(const sl_scene *scene, const sl_radiance_map *map, const sl_radiance_map_settings *settings,
                              sl_map_photons **photons, sl_counters *counters, sl_error *error);
void sl_map_photons_destroy(sl_map_photons *photons);
size_t sl_map_photons_bytes(const sl_map_photons *photons);

#endif
