/* Texels of the direct radiance map, read as what photons are made of: their flux Psi = rho I dOmega / pi, in
 * which neither distance nor angle is left, and where, whence and onto what it falls. */
#ifndef SL_CACHE_DIRECT_RADIANCE_MAP_TEXEL_H
#define SL_CACHE_DIRECT_RADIANCE_MAP_TEXEL_H

#include "cache/direct_radiance/radiance_map.h"

/* All in double: y - L cancels where the scene lies far from the origin. */
typedef struct sl_map_texel {
    sl_vec3d position;   /* y */
    sl_vec3d normal;     /* unit, geometric, on the lit side */
    sl_vec3d shading;    /* unit; the geometric one where the map has no pictures of it */
    sl_vec3d to_light;   /* unit, at y towards where its light comes from */
    double way;          /* b */
    double cos_alpha;    /* of the geometric normal; >= SL_TEXEL_COS_MIN */
    double footprint;    /* A' = b^2 dOmega of the texel */
    double arriving[3];  /* I dOmega, W, less what mirrors kept */
    double flux[3];      /* Psi = L_o A of the texel, W/sr. Maps of true colour: W, still to be reflected by the material */
    double luminance;    /* of Psi, in maps of true colour of what the material reflects in all directions: weight of means; > 0 */
    double color[3];     /* the map's: L_o, or kd */
    const sl_material *material;
    uint32_t object;
} sl_map_texel;

/* Psi never has cos alpha in a denominator (L_o has the same cosine): so this guards 0/0 alone, and turns nothing that could be seen. */
#define SL_TEXEL_COS_MIN 1e-6
/* A group's area is the sum of A' / max(cos alpha, that): not larger than its texels' would be at that angle. */
#define SL_GROUP_COS_MIN 0.02
/* Photons nearer to their light than that share of the diagonal of the scene's core are dropped. */
#define SL_PHOTON_NEAREST_LIGHT 1e-4

/* False where there is nothing to reflect light (coverage 0), no light, or the light is too near; then *texel is not written whole.
 * color: instead of the texel's own in the map; or NULL. */
bool sl_map_texel_read(const sl_scene *scene, const sl_radiance_map *map, const sl_map_face *face, int column, int row,
                       const double *color, sl_map_texel *texel);
/* Its index in the planes. */
static inline size_t sl_map_texel_index(const sl_map_face *face, int column, int row) {
    return face->first + (size_t)row * (size_t)face->width + (size_t)column;
}
/* A ray of the picture: towards texel coordinates (column, row), where texel (0, 0) is the square from 0 to 1. Not of unit length. */
void sl_map_face_ray(const sl_map_face *face, bool directional, double column, double row, sl_vec3d *origin, sl_vec3d *direction);

static inline double sl_luminance_of(const double c[3]) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

#endif
