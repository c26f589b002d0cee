/* Edges of pictures that move. A film (film.h) has the method light each sub-frame, which takes as long as so
 * many pictures; where there is no time for that, the hardware draws identifiers alone at four samples of
 * each pixel at an edge, and a sample has the colour of the nearest centre that shows the same surface, as
 * multisampling shades a surface once a pixel. */
#ifndef SL_FRAME_ANTIALIAS_H
#define SL_FRAME_ANTIALIAS_H

#include "raster/raster.h"
#include "scene/scene.h"

typedef struct sl_antialias sl_antialias;

enum { SL_ANTIALIAS_BYTES = 33 }; /* a pixel */

sl_status sl_antialias_create(int width, int height, sl_antialias **antialias, sl_error *error);
void sl_antialias_destroy(sl_antialias *antialias);
/* Gives pixels at edges the mean of their samples: R, G and B of a picture of centres, rows from the top, as
 * the raster's scene stands. Scenes of more triangles than pixels stay as they are: edges are everywhere, and
 * drawing them again takes longer than all else. */
sl_status sl_antialias_edges(sl_antialias *antialias, const sl_scene *scene, const sl_raster *raster,
                             unsigned threads, sl_image *picture, sl_counters *counters, sl_error *error);

#endif
