/* Rims of lamps. A lamp is hundreds of times as bright as what it lights: a pixel at its edge is wrong by
 * several times the picture's mean if its share of the lamp is off by a hundredth. So the light that such
 * pixels see of lamps and sky is taken from a close-up: the hardware draws the identifiers of a few pixels
 * with six thousand samples each, on a grid that is turned, so that no edge along rows or columns falls
 * between its lines. */
#pragma once

#include "raster/raster.h"
#include "scene/scene.h"

/* Gives the emission seen by the pixels of a box filter that are `wanted` (rows from the bottom), three
 * floats each; where a mirror is seen, whose emission is another's, wanted becomes 0. raster: of the scene.
 */
sl_status sl_rims_look(const sl_scene *scene, const sl_raster *raster, int width, int height, uint8_t *wanted,
                       float *emission, sl_counters *counters, sl_error *error);
