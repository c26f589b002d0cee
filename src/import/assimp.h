/* From what Assimp made of a file to a model. */
#pragma once

#include <assimp/scene.h>

#include "import/gltf.h"
#include "scene/model.h"

/* Adds its meshes, materials, lights and first camera. `path` is where textures are looked for; gltf: NULL
 * where the file is no glTF. What it says that cannot be (indices beyond their lists, children and meshes
 * that are not there) is left out. */
sl_status sl_import_scene(const char *path, const struct aiScene *scene, const cJSON *gltf,
                          const sl_affine *placement, sl_model *model, sl_error *error);

/* ---- between meshes.c, materials.c and uvs.c ---- */

/* Adds the file's materials, in its order. */
sl_status sl_import_materials(const char *path, const struct aiScene *scene, const cJSON *gltf,
                              sl_model *model, sl_error *error);
/* Copies the texture coordinates by which the mesh's colour texture is looked up, 2 a vertex; false where it
 * has none. */
bool sl_import_uvs(const struct aiScene *scene, const cJSON *gltf, const struct aiMesh *mesh, float *uvs);

/* A look at the header of a PLY file before it is imported: Assimp trusts it, and makes up what it promises
 * and the file has not. It must be whole, and the file long enough for what it announces. Files that neither
 * are named so nor begin so pass. */
sl_status sl_ply_check(const char *path, sl_error *error);
