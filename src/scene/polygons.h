/* Polygons of a mesh file by the numbers of their corners' positions, texture coordinates and normals. */
#ifndef SL_SCENE_POLYGONS_H
#define SL_SCENE_POLYGONS_H

#include "scene/file.h"
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

typedef struct sl_polygon {
    uint32_t corner_count, material, object;
} sl_polygon;

/* Zeroed: none. */
typedef struct sl_polygons {
    float (*value[SL_CORNER_PARTS])[3];
    size_t count[SL_CORNER_PARTS], room[SL_CORNER_PARTS];
    sl_corner *corner; /* of the first polygon, of the second, and so on */
    size_t corner_count, corner_room;
    sl_polygon *polygon;
    size_t polygon_count, polygon_room;
} sl_polygons;

/* False: there is no memory. */
bool sl_polygons_add_value(sl_polygons *polygons, sl_corner_part part, const float value[3]);
bool sl_polygons_add_corner(sl_polygons *polygons, sl_corner corner);
/* Takes the last corners. */
bool sl_polygons_add(sl_polygons *polygons, sl_polygon polygon);
void sl_polygons_release(sl_polygons *polygons);

/* Appends all as triangles to a model, object by object; of what is named each has to be there. Objects
 * without polygons are none. first_material: which of the model's is the polygons' first. */
sl_status sl_polygons_place(const sl_polygons *polygons, const sl_names *objects, const sl_affine *placement,
                            uint32_t first_material, sl_model *model, sl_error *error);

/* Cuts a polygon into count - 2 triangles, along its diagonals where it does not cross itself and has at most
 * 256 corners: a convex one from its first corner. positions: 3 numbers a corner; triangles: 3 numbers of
 * corners each. */
void sl_polygon_cut(const float *positions, uint32_t count, uint32_t *triangles);

#endif
