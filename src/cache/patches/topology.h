/* The faces on which all meshes are built, and which corners they share.
 *
 * A face is a side of a scene triangle: 2 t is the front of triangle t, 2 t + 1 its back; light on them has
 * nothing in common. Faces share the samples of a corner or an edge only inside one orientation group: the
 * same position and the same shading normal there (up to 1e-4 radians, so that coplanar triangles share
 * theirs) and, where the caller says so, the same exponent. A crease has samples of its own on either side.
 * Such a shared corner is a site.
 *
 *   topology.c       all of it; degenerate triangles
 *   sites.c          shared corners
 *   edges.c          which faces lie along the same two sites */
#ifndef SL_PATCHES_TOPOLOGY_H
#define SL_PATCHES_TOPOLOGY_H

#include "scene/scene.h"
#include "cache/patches/solids.h"

typedef struct sl_topology {
    const sl_scene *scene;
    size_t face_count;           /* 2 x triangles */
    size_t site_count;
    /* by face: the sites of its triangle's corners 0, 1, 2 (in the triangle's order on both sides) */
    uint32_t *site[3];
    sl_vec3 *site_position, *site_normal; /* normals unit, on the face's side */
    uint32_t *site_face;         /* the lowest face that has it */
    uint8_t *site_shared;        /* whether others have it too */
    /* by triangle: of no area (below 1e-12 of the scene's scale squared): receives nothing, hides light all
     * the same */
    uint8_t *degenerate;
    sl_solids *solids;
    /* Faces along an edge, whose two ends are sites: those of edge e are edge_face[edge_start[e] ..
     * edge_start[e + 1]). */
    uint32_t *edge[3];           /* by face: the edge opposite to corner 0, 1, 2 */
    size_t edge_count;
    uint32_t *edge_start, *edge_face; /* faces ascending */
    /* the sites at its ends; edges are in the order of the lower, then the higher */
    uint32_t *edge_low, *edge_high;
} sl_topology;

/* by_exponent: sites of materials with different exponents are apart (radiance of lobes depends on them). The
 * scene must outlive it. */
sl_status sl_topology_create(const sl_scene *scene, bool by_exponent, sl_topology **topology,
                             sl_error *error);
void sl_topology_destroy(sl_topology *topology);
size_t sl_topology_memory_bytes(const sl_topology *topology);
/* The unit geometric normal on a face's side. */
static inline sl_vec3 sl_face_normal(const sl_scene *scene, uint32_t face) {
    sl_vec3 n = sl_scene_geometric_normal(scene, face / 2);
    return face & 1u ? sl_v3(-n.x, -n.y, -n.z) : n;
}

#endif
