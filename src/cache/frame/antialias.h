/* Edges of pictures that move. A film (film.h) has the method light each sub-frame, which takes as long as so
 * many pictures. Where there is no time for that, a pixel at an edge that shows has four samples, which see
 * the nearest of the triangles that centres around show, and a sample has the colour of the nearest centre
 * that shows its surface, as multisampling shades a surface once a pixel. */
#pragma once

#include "raster/raster.h"
#include "scene/scene.h"

typedef struct sl_antialias sl_antialias;

enum { SL_ANTIALIAS_BYTES = 17 }; /* a pixel */

sl_status sl_antialias_create(int width, int height, sl_antialias **antialias, sl_error *error);
void sl_antialias_destroy(sl_antialias *antialias);
/* Gives pixels at edges the mean of their samples: R, G and B of a picture of centres, rows from the top, as
 * the scene stands. id: triangles that the centres show, rows from the bottom; NULL: raster draws them. */
sl_status sl_antialias_edges(sl_antialias *antialias, const sl_scene *scene, const sl_raster *raster,
                             const uint32_t *id, unsigned threads, sl_image *picture, sl_counters *counters,
                             sl_error *error);
