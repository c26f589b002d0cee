/* Multi-mesh caching with hardware sampling: progressive global illumination from several meshes over the
 * same triangles, each refined on its own. Read in this order:
 *
 *   plan.c             which passes a scene needs
 *   multi_mesh.c       the paper: the passes of a picture, update by update
 *   world.c, state.c   what a picture is made from; made, edited, measured
 *   pixels.c           visible sizes (image pass 1)
 *   displayed.h        a mesh as the eye uses it: priorities, tests, drawing (progressive sampling, pass 3)
 *   irradiance.c       a mesh for each light, refined only where radiance asks for it
 *   direct.c           direct diffuse and specular radiance from them
 *   coarse.h           the coarse mesh of the whole scene, which indirect gathers see
 *   gather.c           the 160-degree gather
 *   merge.c            materials, and the five pictures into one (passes 2 and 4)
 *   explanation.c      a picture told backwards, pixel by pixel; marks.c: what can be seen of the meshes
 *
 * Faces, their shared corners and the quadtrees on them are those of cache/patches; single lights are sampled
 * in cache/light. */
#ifndef SL_MULTI_MESH_MULTI_MESH_H
#define SL_MULTI_MESH_MULTI_MESH_H

#include "cache/frame/method.h"

/* The size of the meshes of a method's state: the three that the eye sees, in the order of sl_component, all
 * lights' together, and the coarse mesh.
 *
 * Bytes are all that is allocated for a mesh, used or not: nodes (inner ones too), vertices (those that no
 * leaf has any more, too), their table, roots by face; of displayed meshes which pixels each node has, what
 * lies on leaves' edges, the heap, the list of what is to be drawn; of lights' the lists of samples; of the
 * coarse mesh what it has by face and by edge of the scene. Not counted: what would be there with meshes of
 * one leaf alone, as large as the scene or the picture (the primitives, the pixels' order, the gathers'
 * pictures). All together they take at most 150 bytes a leaf (test_multi_mesh_bytes). */
enum { SL_MESH_IRRADIANCE = 3, SL_MESH_COARSE, SL_MESH_KINDS };
typedef struct sl_mesh_census {
    size_t leaves, vertices, known; /* known: vertices with a value */
    size_t bytes;
} sl_mesh_census;
void sl_multi_mesh_census(const void *state, sl_mesh_census census[SL_MESH_KINDS]);

#endif
