/* The plain opposite of sl_raster_id(): the whole pipeline in one readable file (plain.c), a triangle and a
 * pixel at a time. Slow, and the same bits. */
#pragma once

#include "raster/raster.h"

/* Clears the viewport (its scissor's part) and draws all triangles. masks: the scene whose alpha masks are
 * tested, its triangles being the mesh's; NULL: none. Both planes of the target are wanted. */
void sl_plain_id(const sl_raster_mesh *mesh, const sl_scene *masks, const sl_view *view,
                 const sl_target *target);
/* All layers, second-level ones too: adds number[t] to sums[pixel] and 1 to sums[pixels + pixel] wherever
 * triangle t covers a pixel. */
void sl_plain_layers(const sl_raster_mesh *mesh, const sl_view *view, int width, int height,
                     const float *number, float *sums);
