/* Functions that a mesh's parts share beyond its own header. */
#ifndef SL_PATCHES_MESH_PARTS_H
#define SL_PATCHES_MESH_PARTS_H

#include "cache/patches/mesh.h"

/* The position of weights p, q of a face's corners 1 and 2, in 1/SL_MESH_DYADIC: of whatever face, and
 * whatever the order of an edge's ends, the same bits for the same point of an edge. */
sl_vec3 sl_mesh_position_in_face(const sl_mesh *mesh, uint32_t face, uint32_t p, uint32_t q);

/* Four fresh leaves below a node, or one that is a root (parent: SL_MESH_ROOT + its face): the first one's
 * index, or SL_NO_INDEX where memory ends. */
uint32_t sl_mesh_take_nodes(sl_mesh *mesh, int count, uint32_t parent);
void sl_mesh_free_nodes(sl_mesh *mesh, uint32_t first);

#endif
