/* Texture coordinates: those of the colour texture, which alone is looked up point by point. */
#include <assimp/material.h>
#include <math.h>

#include "base/math.h"
#include "import/assimp.h"

static int whole_or(const struct aiMaterial *m, const char *key, unsigned type, unsigned index,
                    int otherwise) {
    unsigned one = 1;
    int value;
    return aiGetMaterialIntegerArray(m, key, type, index, &value, &one) == AI_SUCCESS ? value : otherwise;
}

/* Returns the set that the material's colour texture uses; NULL where the mesh has none. */
static const struct aiVector3D *set_of(const struct aiMaterial *m, const struct aiMesh *mesh,
                                       const sl_gltf_transform *t) {
    const int set = t->set >= 0 ? t->set : whole_or(m, AI_MATKEY_UVWSRC(aiTextureType_DIFFUSE, 0), 0);
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

static bool leaves_picture(const float *uv, size_t count) {
    const float least = -1e-3f, most = 1.0f + 1e-3f;
    for (size_t i = 0; i < 2 * count; i++) {
        if (uv[i] < least || uv[i] > most) return true;
    }
    return false;
}

static void check_wrapping(const char *path, const struct aiMaterial *m, const char *name, const float *uv,
                           size_t count, sl_model *model) {
    const int u = whole_or(m, AI_MATKEY_MAPPINGMODE_U(aiTextureType_DIFFUSE, 0), aiTextureMapMode_Wrap),
              v = whole_or(m, AI_MATKEY_MAPPINGMODE_V(aiTextureType_DIFFUSE, 0), aiTextureMapMode_Wrap);
    const bool repeated = u == aiTextureMapMode_Wrap && v == aiTextureMapMode_Wrap;
    if (repeated || !aiGetMaterialTextureCount(m, aiTextureType_DIFFUSE) || !leaves_picture(uv, count))
        return;
    const bool mirrored = u == aiTextureMapMode_Mirror || v == aiTextureMapMode_Mirror;
    sl_scene_warn(&model->scene,
                  "%s: material '%s': its texture is %s beyond its edges in the file, and repeated here",
                  path, name, mirrored ? "mirrored" : "clamped");
}

bool sl_import_uvs(const char *path, const struct aiScene *scene, const cJSON *gltf,
                   const struct aiMesh *mesh, float *uvs, sl_model *model) {
    const struct aiMaterial *material = scene->mMaterials[mesh->mMaterialIndex];
    struct aiString name = {.data = ""};
    aiGetMaterialString(material, AI_MATKEY_NAME, &name);
    const sl_gltf_transform t = sl_gltf_base_transform(gltf, name.data);
    const struct aiVector3D *from = set_of(material, mesh, &t);
    if (!from) return false;
    for (size_t v = 0; v < mesh->mNumVertices; v++) uvs[2 * v] = from[v].x, uvs[2 * v + 1] = from[v].y;
    if (t.given) transform(&t, uvs, mesh->mNumVertices);
    check_wrapping(path, material, name.data, uvs, mesh->mNumVertices, model);
    return true;
}
