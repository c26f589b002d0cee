/* Mesh files of any kind that the importer (Assimp, in a process of its own) reads, and those that are text
 * and read here, where every mistake has its line. */
#pragma once

#include "scene/model.h"

/* Adds a file's objects, materials, lights and first camera (if the model has none) to a model. `placement`
 * comes after the file's own node transforms. */
sl_status sl_mesh_file_load(const char *path, const sl_affine *placement, sl_model *model, sl_error *error);

/* Of one format: OBJ with its material libraries, bicubic surfaces. */
sl_status sl_obj_file_load(const char *path, const sl_affine *placement, sl_model *model, sl_error *error);
sl_status sl_bicubic_file_load(const char *path, const sl_affine *placement, sl_model *model,
                               sl_error *error);
