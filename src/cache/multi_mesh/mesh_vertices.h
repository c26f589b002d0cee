/* What mesh.c asks of mesh_vertices.c beyond the mesh's own header. */
#ifndef SL_MULTI_MESH_MESH_VERTICES_H
#define SL_MULTI_MESH_MESH_VERTICES_H

#include "cache/multi_mesh/mesh.h"

/* The position of weights p, q of a face's corners 1 and 2, in 1/SL_MESH_DYADIC: of whatever face, and whatever the order of an edge's ends, the same
 * bits for the same point of an edge. */
sl_vec3 sl_mesh_position_in_face(const sl_mesh *mesh, uint32_t face, uint32_t p, uint32_t q);

#endif
