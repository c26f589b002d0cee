/* Polygons of a mesh file by the numbers of their corners' positions, texture coordinates and normals. */
#pragma once

#include "scene/model.h"

typedef enum sl_corner_part {
    SL_CORNER_POSITION,
    SL_CORNER_UV,
    SL_CORNER_NORMAL,
    SL_CORNER_PARTS
} sl_corner_part;

typedef struct sl_corner {
    uint32_t at[SL_CORNER_PARTS]; /* SL_NO_INDEX: it has none */
} sl_corner;

/* Values that corners may name, and the polygon at hand. Zeroed: none. */
typedef struct sl_polygons {
    float (*value[SL_CORNER_PARTS])[3];
    size_t count[SL_CORNER_PARTS], room[SL_CORNER_PARTS];
    sl_corner *corner;
    size_t corner_count, corner_room;
    float *gathered; /* positions of its corners, then normals, then texture coordinates */
    uint32_t *cut;   /* its triangles */
    size_t gathered_room;
} sl_polygons;

/* False: there is no memory. */
bool sl_polygons_add_value(sl_polygons *polygons, sl_corner_part part, const float value[3]);
bool sl_polygons_add_corner(sl_polygons *polygons, sl_corner corner);
void sl_polygons_release(sl_polygons *polygons);

/* Adds the polygon at hand, of three corners at least, to a model as triangles; then there is none. All of
 * its corners have the same, and what they name is there. */
sl_status sl_polygons_place(sl_polygons *polygons, const char *path, uint32_t material, uint32_t object,
                            const sl_affine *placement, sl_model *model, sl_error *error);
