/* The materials of an OBJ file: those of its libraries (MTL), and those that it names and no library has. */
#ifndef SL_SCENE_OBJ_MATERIALS_H
#define SL_SCENE_OBJ_MATERIALS_H

#include "scene/file.h"
#include "scene/import_reply.h"
#include "scene/model.h"

/* Zero but for the model; release it. */
typedef struct sl_obj_materials {
    sl_model *model;
    sl_names names;
    sl_import_material *material;
    unsigned long *line; /* of the first use of each; 0: a library has it */
    size_t count, material_room, line_room;
    char **text; /* of the libraries: names are in it */
    size_t text_count, text_room;
} sl_obj_materials;

/* Finds a material, or adds a grey one; without a name that of faces that name none. `line`: of its use; 0: a
 * library has it. */
sl_status sl_obj_materials_find(sl_obj_materials *materials, const char *name, unsigned long line,
                                uint32_t *index, sl_error *error);
/* Reads a library: what materials here have, and nothing else. What is wrong is an input error with file and
 * line, what is not used a warning. */
sl_status sl_obj_materials_read(sl_obj_materials *materials, const char *path, sl_error *error);
void sl_obj_materials_release(sl_obj_materials *materials);

#endif
