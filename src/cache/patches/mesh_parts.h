/* Functions that a mesh's parts share beyond its own header. */
#ifndef SL_PATCHES_MESH_PARTS_H
#define SL_PATCHES_MESH_PARTS_H

#include "cache/patches/mesh.h"

/* Four fresh leaves below a node, or one that is a root (parent: SL_MESH_ROOT + its face): the first one's
 * index, or SL_NO_INDEX where memory ends. */
uint32_t sl_mesh_take_nodes(sl_mesh *mesh, int count, uint32_t parent);
void sl_mesh_free_nodes(sl_mesh *mesh, uint32_t first);

#endif
