/* Mesh files of any kind that the importer (Assimp, in a process of its own) reads, and bicubic surfaces
 * (.bpt), appended to a model. */
#ifndef SL_SCENE_MESH_FILE_H
#define SL_SCENE_MESH_FILE_H

#include "scene/import_reply.h"
#include "scene/model.h"

/* `placement` comes after the file's own node transforms. Objects, materials, lights and the file's first
 * camera (if the model has none) are added. */
sl_status sl_mesh_file_load(const char *path, const sl_affine *placement, sl_model *model, sl_error *error);

struct sl_gltf;

/* Appends to a model what the importer made of a file. `path` is where textures are looked for; gltf: NULL
 * where the file is no glTF. */
sl_status sl_mesh_file_add(const char *path, const sl_import *file, const struct sl_gltf *gltf,
                           const sl_affine *placement, sl_model *model, sl_error *error);

/* ---- the readers of formats ---- */

/* OBJ, with its material libraries, OFF and bicubic surfaces are text and read here, where every mistake has
 * its line. */
sl_status sl_obj_file_load(const char *path, const sl_affine *placement, sl_model *model, sl_error *error);
sl_status sl_off_file_load(const char *path, const sl_affine *placement, sl_model *model, sl_error *error);
sl_status sl_bicubic_file_load(const char *path, const sl_affine *placement, sl_model *model,
                               sl_error *error);
/* A look at the header of a PLY file before it is imported: the importer trusts it, and makes up what it
 * promises and the file has not. It must be whole, without an element twice, and the file long enough for
 * what it announces. Files that neither are named so nor begin so pass. */
sl_status sl_header_check(const char *path, sl_error *error);

/* ---- between mesh_file.c, mesh_material.c and mesh_uv.c ---- */

/* Adds the file's materials, in its order. gltf: NULL where the file is no glTF. */
sl_status sl_mesh_materials(const char *path, const sl_import *file, const struct sl_gltf *gltf,
                            sl_model *model, sl_error *error);
/* Copies the texture coordinates by which the mesh's colour texture is looked up, 2 a vertex. */
void sl_mesh_copy_uvs(const char *path, const sl_import *file, const struct sl_gltf *gltf,
                      const sl_import_mesh *mesh, float *uvs, sl_model *model);

#endif
