/* What charts.c and refine.c owe each other. */
#ifndef SL_CACHE_LIGHT_OCTREE_ATLAS_REFINE_H
#define SL_CACHE_LIGHT_OCTREE_ATLAS_REFINE_H

#include "cache/light_octree/atlas/parts.h"

/* Lists the faces of each chart, ascending, from of_face. */
void sl_atlas_charts_list(sl_atlas_charts *charts, const sl_atlas_faces *faces);
/* Splits the charts whose normals do not lie in a cone of that cosine about any axis. */
sl_status sl_atlas_charts_unbend(sl_atlas_charts *charts, const sl_atlas_faces *faces, double cos_bend,
                                 unsigned threads, sl_error *error);
/* The same; then joins charts that share much of their border and together bend no farther. */
sl_status sl_atlas_charts_refine(sl_atlas_charts *charts, const sl_atlas_faces *faces, double cos_bend,
                                 unsigned threads, sl_error *error);

#endif
