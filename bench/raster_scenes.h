/* Scenes of the rasterizer's benchmark: scene files, with vertices shared as graphics hardware likes them, a
 * view through the camera, and points that it sees to gather at. */
#pragma once

#include "raster/raster.h"
#include "raster_osmesa.h"

enum { BENCH_POINTS = 24 };

/* name and path are set by who makes one; bench_scene_open() makes the rest. */
typedef struct bench_scene {
    const char *name, *path;
    bool gathers;      /* few enough triangles for OSMesa to draw hundreds of views */
    sl_scene *scene;
    sl_raster *raster;
    peer_mesh mesh; /* the scene's triangles in the scene's order */
    size_t points;
    sl_vec3 point[BENCH_POINTS], normal[BENCH_POINTS];
} bench_scene;

/* Does nothing where it has been opened. */
void bench_scene_open(bench_scene *scene);
/* Triangles as nine floats each, clip coordinates, and three colours each; nothing shared. */
void bench_scene_of_triangles(bench_scene *scene, const float *xyz, const float *colours, size_t count);
void bench_scene_close(bench_scene *scene);

/* The scene's camera, window depth. */
sl_view bench_camera_view(const bench_scene *scene, int width, int height);
/* Clip coordinates as they are. */
sl_view bench_flat_view(int width, int height);
/* The plane over point i, field of view in degrees. */
sl_view bench_plane_view(const bench_scene *scene, size_t i, int size, double degrees);
/* Five faces over point i: the top, then four halves. */
void bench_hemicube_views(const bench_scene *scene, size_t i, int size, sl_view views[5]);
