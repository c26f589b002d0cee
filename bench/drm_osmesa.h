/* OSMesa (llvmpipe) as the peer of direct radiance mapping: the same passes by OpenGL, for scenes with one
 * light and without mirrors.
 *
 *     depth cube (six faces side by side in one plane) ── map (position, radiance, normal at once) ── read
 * back, photons by the processor ── camera, direct and indirect light in one program, photons in uniforms ──
 * picture read back
 *
 * Vertex and index buffers, programs and targets are made once; a frame changes nothing but matrices and
 * uniforms. The camera's pass is tried in three ways (see drm_way) and the fastest is kept. */
#ifndef SL_BENCH_DRM_OSMESA_H
#define SL_BENCH_DRM_OSMESA_H

#include "raster/raster.h"
#include "scene/scene.h"

typedef enum drm_shading {
    DRM_LOCAL,  /* no shadows, no indirect light */
    DRM_DIRECT, /* shadows */
    DRM_EVEN,   /* ... and indirect light by (11) */
    DRM_BOX,    /* by (15) */
    DRM_DISC,   /* by (14) */
    DRM_SHADINGS
} drm_shading;

/* How the camera's picture is shaded. */
typedef enum drm_way {
    DRM_FORWARD,     /* triangles in order */
    DRM_DEPTH_FIRST, /* depth, then what is visible: each pixel once */
    /* positions, normals and colours, then one triangle over the screen: best for triangles smaller than
     * pixels */
    DRM_DEFERRED,
    DRM_WAYS
} drm_way;

typedef struct drm_peer_options {
    int size;          /* of the picture */
    int shadow_size;   /* of a face of the depth cube */
    int samples;       /* m of m x m photons */
    double map_fov;
    sl_view map_view;  /* from the light */
    sl_vec3 position;  /* the light */
    sl_vec3 direction; /* of an area light: its normal */
    bool area;
    sl_rgb intensity;  /* of an area light: along its normal */
} drm_peer_options;

enum { DRM_PEER_SAMPLES = 5 }; /* the paper's hardware has room for as many a side, too */

typedef struct drm_peer drm_peer;

/* After peer_start(). The scene's own camera is drawn. */
drm_peer *drm_peer_create(const sl_scene *scene, const drm_peer_options *options);
void drm_peer_destroy(drm_peer *peer);
/* One frame, read back: RGBA, row 0 at the bottom; valid until the next. camera_only: depth cube and photons
 * are those of the frame before. */
const float *drm_peer_frame(drm_peer *peer, drm_shading shading, drm_way way, bool camera_only);
const char *drm_way_name(drm_way way);

#endif
