/* The workloads: what the papers ask of graphics hardware, on ours and on OSMesa. */
#pragma once

#include "raster_measure.h"
#include "raster_scenes.h"

/* ---- raster_workloads.c: what is seen -------------------------------------------------------- */

void bench_id_map(measurer *m, bench_scene *scene, int width, int height);
void bench_gbuffer(measurer *m, bench_scene *scene);
void bench_hemisphere(measurer *m, bench_scene *scene, int size);
void bench_hemicube(measurer *m, bench_scene *scene, int size);
void bench_depth_cube(measurer *m, bench_scene *scene);

/* ---- raster_fragments.c: filling, blending, summing ------------------------------------------ */

void bench_splats(measurer *m, bench_scene *scene);
void bench_fill(measurer *m);
void bench_small_triangles(measurer *m);
void bench_reduction(measurer *m);
