/* A uniform grid over the scene's triangles, and the triangles that a cone may meet: what a shadow sampler renders
 * instead of the whole scene (multi-mesh caching: "triangles found by cone against grid").
 *
 * Conservative in both steps: a triangle is in every cell that it touches, and a cell is left out only if no point of it
 * is in the cone. So whatever a ray from the apex inside the cone can hit is in the list. */
#ifndef SL_RASTER_GRID_H
#define SL_RASTER_GRID_H

#include "raster/views/cone.h"

typedef struct sl_grid sl_grid;

/* cells_per_axis: of a scene as large in all directions (cells are cubes); 0: (2 triangles)^(1/3). The scene must
 * outlive it. The same grid at any number of threads. */
sl_status sl_grid_create(const sl_scene *scene, int cells_per_axis, unsigned threads, sl_grid **grid, sl_error *error);
void sl_grid_destroy(sl_grid *grid);
size_t sl_grid_memory_bytes(const sl_grid *grid);
double sl_grid_cell_size(const sl_grid *grid);
size_t sl_grid_cell_count(const sl_grid *grid);

/* One worker's memory for queries. */
typedef struct sl_grid_scratch sl_grid_scratch;
sl_status sl_grid_scratch_create(const sl_grid *grid, sl_grid_scratch **scratch, sl_error *error);
void sl_grid_scratch_destroy(sl_grid_scratch *scratch);

typedef struct sl_grid_hits {
    const uint32_t *triangle; /* each once, ascending; in the scratch, until its next query */
    size_t count;
    size_t boxes_tested, cells_met; /* the bill */
} sl_grid_hits;
sl_grid_hits sl_grid_cone(const sl_grid *grid, const sl_cone *cone, sl_grid_scratch *scratch);

#endif
