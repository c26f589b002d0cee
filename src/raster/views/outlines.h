/* Where one pixel may show more than one surface: the edges of triangles at which a picture may change, drawn
 * conservatively. An edge counts where a surface ends, bends or changes its material, and as a silhouette
 * where of two triangles of a smooth surface one faces the eye and the other does not. */
#pragma once

#include "raster/raster.h"

typedef struct sl_outlines sl_outlines;

/* Of the scene as it stands: made anew when objects have moved. */
sl_status sl_outlines_create(const sl_scene *scene, sl_outlines **outlines, sl_error *error);
void sl_outlines_destroy(sl_outlines *outlines);
/* Sets the byte of every pixel whose square an edge that is not hidden touches, and of those around it.
 * view: inverse-w depth; depth: of that view at the pixels' centres; touched: as large. All rows bottom
 * first. */
sl_status sl_outlines_draw(const sl_outlines *outlines, const sl_view *view, const float *depth,
                           uint8_t *touched, sl_error *error);
size_t sl_outlines_bytes(const sl_outlines *outlines);
/* An upper estimate, with what their making takes. */
double sl_outlines_need(double triangles);
