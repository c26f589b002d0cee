/* Texture coordinates: those of the colour texture, which alone is looked up point by point. */
#include <assimp/material.h>

#include "base/math.h"
#include "import/assimp.h"

/* Returns the set that the material's colour texture uses; NULL where the mesh has none. */
static const struct aiVector3D *set_of(const struct aiMaterial *m, const struct aiMesh *mesh,
                                       const sl_gltf_transform *t) {
    unsigned one = 1;
    int set = t->set;
    if (set < 0) aiGetMaterialIntegerArray(m, AI_MATKEY_UVWSRC(aiTextureType_DIFFUSE, 0), &set, &one);
    const bool known = set > 0 && set < AI_MAX_NUMBER_OF_TEXTURECOORDS && mesh->mTextureCoords[set];
    return mesh->mTextureCoords[known ? set : 0];
}

/* KHR_texture_transform: scaled, turned, moved, with v from the top down as in glTF; Assimp has turned it
 * over. */
static void transform(const sl_gltf_transform *t, float *uv, size_t count) {
    const double c = sl_cos(t->rotation), s = sl_sin(t->rotation);
    for (size_t i = 0; i < count; i++) {
        double u = t->scale[0] * (double)uv[2 * i], v = t->scale[1] * (1.0 - (double)uv[2 * i + 1]);
        uv[2 * i] = (float)(t->offset[0] + c * u + s * v);
        uv[2 * i + 1] = (float)(1.0 - (t->offset[1] - s * u + c * v));
    }
}

bool sl_import_uvs(const struct aiScene *scene, const cJSON *gltf, const struct aiMesh *mesh, float *uvs) {
    const struct aiMaterial *material = scene->mMaterials[mesh->mMaterialIndex];
    struct aiString name = {.data = ""};
    aiGetMaterialString(material, AI_MATKEY_NAME, &name);
    const sl_gltf_transform t = sl_gltf_base_transform(gltf, name.data);
    const struct aiVector3D *from = set_of(material, mesh, &t);
    if (!from) return false;
    for (size_t v = 0; v < mesh->mNumVertices; v++) uvs[2 * v] = from[v].x, uvs[2 * v + 1] = from[v].y;
    if (t.given) transform(&t, uvs, mesh->mNumVertices);
    return true;
}
