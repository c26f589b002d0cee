/* The materials of an OBJ file in its model: those of its libraries (MTL), and those that it names and no
 * library has. */
#pragma once

#include "scene/file.h"
#include "scene/model.h"

/* A material's values beside those that the model's has. */
typedef struct sl_obj_material {
    unsigned long line; /* of its first use; 0: a library has it */
    bool may_mirror;    /* illum 3 or 5: without a diffuse colour it is a mirror */
} sl_obj_material;

/* Zero but for the model, the OBJ file and the first material's index in the model; release it. */
typedef struct sl_obj_materials {
    sl_model *model;
    const char *path;
    uint32_t first;
    sl_names names; /* number n is the model's material first + n */
    sl_obj_material *material;
    size_t count, material_room;
} sl_obj_materials;

/* Finds the index of a material, or adds a grey one; without a name that of faces that name none. `line`: of
 * its use; 0: a library has it. */
sl_status sl_obj_materials_find(sl_obj_materials *materials, const char *name, unsigned long line,
                                uint32_t *index, sl_error *error);
/* Reads a library: what materials here have, and nothing else. What is wrong is an input error with file and
 * line, what is not used a warning. */
sl_status sl_obj_materials_read(sl_obj_materials *materials, const char *path, sl_error *error);
/* Makes mirrors of what all that was read says are some. */
void sl_obj_materials_finish(sl_obj_materials *materials);
void sl_obj_materials_release(sl_obj_materials *materials);
