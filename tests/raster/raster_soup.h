/* Random triangles of every kind that a rasterizer may treat differently, for comparisons with another
 * rasterizer, with double precision and with themselves. Every triangle has three vertices of its own. */
#pragma once

#include "raster/raster.h"

typedef enum soup_kind {
    SOUP_BIG,           /* corners anywhere on the screen */
    SOUP_MEDIUM,        /* up to 64 pixels */
    SOUP_SMALL,         /* up to 8 pixels */
    SOUP_SUBPIXEL,      /* up to 1 pixel */
    SOUP_SLIVER,        /* two corners far apart, the third beside the line between them */
    SOUP_MESH,          /* a screen-filling grid of about 5 pixels: shared edges, in random directions */
    SOUP_PIXEL_CENTRES, /* every corner on a pixel's centre */
    /* every coordinate half-way between two of the 1/256 pixel to which vertices are snapped */
    SOUP_TIES,
    /* corners up to a screen's width outside, and before the near or beyond the far plane */
    SOUP_PARTLY_OFF,
    SOUP_FAR_OFF,       /* corners up to thousands of screens outside */
    SOUP_PERSPECTIVE,   /* a camera's view of triangles before it: w from 0.2 to 20 */
    SOUP_NEAR_CLIPPED,  /* the same with corners behind the eye */
    SOUP_KINDS
} soup_kind;
extern const char *const soup_names[SOUP_KINDS];

typedef struct soup {
    size_t triangles;
    float *position[3];  /* x, y, z of 3 * triangles vertices */
    uint32_t *vertex[3]; /* corner k of triangle t: vertex 3 t + k */
    sl_view view;        /* window depth; a viewport of the size asked for at (0, 0) */
} soup;

/* About `triangles` of them (a mesh: as many as its grid makes) for a viewport of width x height. In a third
 * of the triangles z (of flat kinds) is constant and one of few values, so that depths tie. */
soup soup_make(soup_kind kind, uint64_t seed, size_t triangles, int width, int height);
void soup_free(soup *soup);
sl_raster_mesh soup_mesh(const soup *soup);
sl_raster *soup_raster(const soup *soup);

/* A configuration with sanitizers does a twentieth of the work. */
size_t soup_share(size_t count);
