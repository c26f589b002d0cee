/* Several texels as one photon for each surface that they show. */
#ifndef SL_CACHE_DIRECT_RADIANCE_PHOTON_GROUPS_H
#define SL_CACHE_DIRECT_RADIANCE_PHOTON_GROUPS_H

#include "cache/direct_radiance/photon_list.h"

enum { SL_PHOTON_GROUPS = 4 }; /* at most */

/* One surface's: sums of flux and area, and means of all else, weighted by luminance. */
typedef struct sl_photon_sum {
    sl_vec3d position, normal, shading, to_light;
    double luminance, way, area;
    double flux[3], radiance[3], diffuse[3], specular[3], exponent, glossy;
    sl_vec3d first_position, first_normal; /* of the texel that opened it */
    uint32_t object;                       /* likewise */
    bool bent;                             /* others' normals differ from that one */
    const sl_material *material;
    sl_texel_rectangle rectangle;
} sl_photon_sum;

/* Begins and ends as zeros. */
typedef struct sl_photon_groups {
    sl_photon_sum group[SL_PHOTON_GROUPS];
} sl_photon_groups;

/* Adds a texel. block: the solid angle for which printed weights take a photon. */
void sl_photon_groups_add(const sl_photon_list *list, const sl_map_face *face, int column, int row, double block,
                          sl_photon_groups *groups);
/* Appends the groups' photons, and empties the groups; false where there were none. */
bool sl_photon_groups_finish(sl_photon_list *list, const sl_map_face *face, sl_photon_groups *groups);

#endif
