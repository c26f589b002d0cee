/* What made a pixel, and what can be seen of the meshes: for those who look on. */
#ifndef SL_MULTI_MESH_EXPLANATION_H
#define SL_MULTI_MESH_EXPLANATION_H

#include "cache/frame/method.h"
#include "cache/multi_mesh/multi_mesh_internal.h"

/* See sl_method_explanation(). */
sl_status sl_multi_mesh_explanation(void *state, int x, int y, sl_explanation_writer *writer,
                                    sl_error *error);

/* marks.c: all of these do nothing without an observer. */

/* The triangles of image pass 1 as a plane of numbers. */
void sl_multi_mesh_announce_ids(sl_multi_mesh_state *s);
/* How much the roots matter, of the first mesh that there is, at the pixels that show them. */
void sl_multi_mesh_announce_priorities(sl_multi_mesh_state *s);
/* What one point in view gathers: the picture that is weighted and added up. */
void sl_multi_mesh_announce_gather(sl_multi_mesh_state *s);
/* What the vertex that sees about half of the first light sees of it: the picture that is added up, and what
 * is read back. */
void sl_multi_mesh_announce_light_sample(sl_multi_mesh_state *s);
/* The edges of a mesh's leaves in view, in the colours of what it holds there. */
void sl_multi_mesh_announce_edges(sl_multi_mesh_state *s, sl_component part);
/* Those of the first lights' meshes. */
void sl_multi_mesh_announce_lights(sl_multi_mesh_state *s);

#endif
