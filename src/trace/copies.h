/* Copies of a mesh: objects whose triangles are those of another object under an affine map, corner by
 * corner. The scene holds the triangles of each of them; the tracer's hierarchy is made of one of them alone,
 * and of the places of the others. Found by looking, so that they may come from anywhere: instances of a
 * builder, a file that repeats itself, objects that an edit has moved. */
#pragma once

#include "scene/affine.h"
#include "scene/scene.h"

typedef struct sl_copied_mesh {
    uint32_t first, count; /* the triangles of the first copy, which is the mesh */
    uint32_t copies;
    /* By how much a box about triangles of the mesh must grow, so that the map of a copy, turned round in
     * float, takes no ray of the scene past it that meets the copy's own triangles; to which comes what the
     * scene's boxes grow by, times the stretch. */
    double slack, stretch;
} sl_copied_mesh;

typedef struct sl_copy {
    uint32_t first, mesh;
    float from_mesh[12]; /* by columns: where the copy's triangles are, by those of the mesh */
} sl_copy;

typedef struct sl_copies {
    size_t mesh_count, copy_count;
    sl_copied_mesh *mesh;
    sl_copy *copy;           /* by `first` */
    size_t triangles, saved; /* of all copies; of all but the first ones */
} sl_copies;

/* Triangles that must be saved, or a hierarchy of them all is as well. */
enum { SL_COPIES_WORTH = 1 << 19 };

/* Finds copies that save at least that many triangles; else none. To be released, whatever comes of it. */
sl_status sl_copies_find(const sl_scene *scene, size_t worth, sl_copies *copies, sl_error *error);
void sl_copies_release(sl_copies *copies);
/* Reckons how many triangles copies save, by some corners of each: what memory is reckoned with. */
size_t sl_copies_expected(const sl_scene *scene);
