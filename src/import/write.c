#include "import/write.h"

#include <assimp/GltfMaterial.h>
#include <assimp/ObjMaterial.h>
#include <assimp/material.h>
#include <stdlib.h>
#include <string.h>

#define NONE UINT32_MAX

/* The whole is gone through twice: how many bytes it has stands before them. */
typedef struct writer {
    FILE *to; /* NULL: bytes are counted alone */
    uint64_t bytes;
    const struct aiScene *scene;
    uint32_t *mesh_place; /* in the list of those that are written; NONE: it is not */
    uint32_t mesh_count, node_count;
    bool *mesh_stands; /* some node has it */
    bool node_lost;    /* a child was not there */
} writer;

static void put(writer *w, const void *from, size_t size) {
    w->bytes += size;
    if (w->to && size) fwrite(from, 1, size, w->to);
}

static void put_word(writer *w, uint32_t word) { put(w, &word, sizeof word); }
static void put_float(writer *w, float value) { put(w, &value, sizeof value); }
static void put_vectors(writer *w, const struct aiVector3D *v, size_t count) {
    _Static_assert(sizeof *v == 3 * sizeof(float),
                   "Assimp's numbers are floats, and its vectors without gaps");
    put(w, v, v ? count * sizeof *v : 0);
}
static void put_padding(writer *w, size_t size) { put(w, "\0\0\0", size); }

static void put_text(writer *w, const char *text) {
    uint32_t length = (uint32_t)strlen(text);
    put_word(w, length);
    put(w, text, length + 1);
    put_padding(w, 3 - length % 4);
}

/* ---- textures and materials ---------------------------------------------------------------------------- */

static void put_textures(writer *w) {
    put_word(w, w->scene->mNumTextures);
    for (unsigned i = 0; i < w->scene->mNumTextures; i++) {
        const struct aiTexture *t = w->scene->mTextures[i];
        bool compressed = t && t->mHeight == 0 && t->pcData;
        uint32_t size = compressed ? t->mWidth : 0;
        put_word(w, compressed);
        put_word(w, size);
        put(w, compressed ? t->pcData : NULL, size);
        put_padding(w, (4 - size % 4) % 4);
    }
}

typedef enum kind { COLOUR, NUMBER, WHOLE, WRAPPING, TRANSFORM } kind;
static const struct {
    const char *key;
    unsigned type, index;
    kind kind;
} fields[SL_IMPORT_FIELDS] = {
    [SL_IMPORT_DIFFUSE] = {AI_MATKEY_COLOR_DIFFUSE, COLOUR},
    [SL_IMPORT_SPECULAR] = {AI_MATKEY_COLOR_SPECULAR, COLOUR},
    [SL_IMPORT_EMISSIVE] = {AI_MATKEY_COLOR_EMISSIVE, COLOUR},
    [SL_IMPORT_BASE] = {AI_MATKEY_BASE_COLOR, COLOUR},
    [SL_IMPORT_SHININESS] = {AI_MATKEY_SHININESS, NUMBER},
    [SL_IMPORT_STRENGTH] = {AI_MATKEY_SHININESS_STRENGTH, NUMBER},
    [SL_IMPORT_OPACITY] = {AI_MATKEY_OPACITY, NUMBER},
    [SL_IMPORT_METALLIC] = {AI_MATKEY_METALLIC_FACTOR, NUMBER},
    [SL_IMPORT_ROUGHNESS] = {AI_MATKEY_ROUGHNESS_FACTOR, NUMBER},
    [SL_IMPORT_CUTOFF] = {AI_MATKEY_GLTF_ALPHACUTOFF, NUMBER},
    [SL_IMPORT_ILLUM] = {AI_MATKEY_OBJ_ILLUM, WHOLE},
    [SL_IMPORT_TWO_SIDED] = {AI_MATKEY_TWOSIDED, WHOLE},
    [SL_IMPORT_GLOSSINESS] = {AI_MATKEY_GLOSSINESS_FACTOR, NUMBER},
    [SL_IMPORT_UV_SET] = {AI_MATKEY_UVWSRC(aiTextureType_DIFFUSE, 0), WHOLE},
    [SL_IMPORT_WRAP_U] = {AI_MATKEY_MAPPINGMODE_U(aiTextureType_DIFFUSE, 0), WRAPPING},
    [SL_IMPORT_WRAP_V] = {AI_MATKEY_MAPPINGMODE_V(aiTextureType_DIFFUSE, 0), WRAPPING},
    [SL_IMPORT_UV_TRANSFORM] = {AI_MATKEY_UVTRANSFORM(aiTextureType_DIFFUSE, 0), TRANSFORM},
};

static const enum aiTextureType maps[SL_IMPORT_MAPS] = {aiTextureType_DIFFUSE, aiTextureType_OPACITY,
                                                        aiTextureType_HEIGHT,  aiTextureType_METALNESS,
                                                        aiTextureType_UNKNOWN, aiTextureType_EMISSIVE,
                                                        aiTextureType_SPECULAR};

static bool get_whole(const struct aiMaterial *m, const char *key, unsigned type, unsigned index,
                      int *value) {
    unsigned one = 1;
    return aiGetMaterialIntegerArray(m, key, type, index, value, &one) == AI_SUCCESS;
}

static bool get_field(const struct aiMaterial *m, int field, float to[SL_IMPORT_FIELD_NUMBERS]) {
    const char *key = fields[field].key;
    unsigned type = fields[field].type, index = fields[field].index, one = 1;
    struct aiColor4D c;
    struct aiUVTransform t;
    int whole;
    switch (fields[field].kind) {
    case COLOUR:
        if (aiGetMaterialColor(m, key, type, index, &c) != AI_SUCCESS) return false;
        memcpy(to, (float[3]){c.r, c.g, c.b}, 3 * sizeof *to);
        return true;
    case NUMBER: return aiGetMaterialFloatArray(m, key, type, index, to, &one) == AI_SUCCESS && one == 1;
    case WHOLE:
        if (!get_whole(m, key, type, index, &whole)) return false;
        to[0] = (float)whole;
        return true;
    case WRAPPING:
        if (!get_whole(m, key, type, index, &whole)) return false;
        to[0] = whole == aiTextureMapMode_Wrap     ? SL_IMPORT_REPEATED
                : whole == aiTextureMapMode_Mirror ? SL_IMPORT_MIRRORED
                                                   : SL_IMPORT_CLAMPED;
        return true;
    default:
        if (aiGetMaterialUVTransform(m, key, type, index, &t) != AI_SUCCESS) return false;
        memcpy(to, (float[5]){t.mTranslation.x, t.mTranslation.y, t.mScaling.x, t.mScaling.y, t.mRotation},
               5 * sizeof *to);
        return true;
    }
}

static bool get_text(const struct aiMaterial *m, const char *key, unsigned type, unsigned index,
                     struct aiString *text) {
    return aiGetMaterialString(m, key, type, index, text) == AI_SUCCESS;
}

static bool get_map(const struct aiMaterial *m, int map, struct aiString *name) {
    return aiGetMaterialTextureCount(m, maps[map]) > 0 && get_text(m, AI_MATKEY_TEXTURE(maps[map], 0), name);
}

static void put_material(writer *w, const struct aiMaterial *m) {
    struct aiString text = {.data = ""};
    float value[SL_IMPORT_FIELDS][SL_IMPORT_FIELD_NUMBERS] = {{0}};
    uint32_t has = 0, names = 0;
    get_text(m, AI_MATKEY_NAME, &text);
    put_text(w, text.data);
    for (int i = 0; i < SL_IMPORT_FIELDS; i++) has |= (uint32_t)get_field(m, i, value[i]) << i;
    put_word(w, has);
    put(w, value, sizeof value);
    names = get_text(m, AI_MATKEY_GLTF_ALPHAMODE, &text);
    for (int i = 0; i < SL_IMPORT_MAPS; i++) names |= (uint32_t)get_map(m, i, &text) << (i + 1);
    put_word(w, names);
    if (get_text(m, AI_MATKEY_GLTF_ALPHAMODE, &text)) put_text(w, text.data);
    for (int i = 0; i < SL_IMPORT_MAPS; i++) {
        if (get_map(m, i, &text)) put_text(w, text.data);
    }
}

/* ---- meshes -------------------------------------------------------------------------------------------- */

static void put_uvs(writer *w, const struct aiVector3D *uvs, unsigned count) {
    for (unsigned v = 0; uvs && v < count; v++)
        put(w, (const float[2]){uvs[v].x, uvs[v].y}, 2 * sizeof(float));
}

static uint32_t flags_of(const struct aiMesh *mesh) {
    uint32_t flags = (mesh->mNormals ? SL_IMPORT_NORMALS : 0u) | (mesh->mColors[0] ? SL_IMPORT_COLOURS : 0u) |
                     (mesh->mNumBones ? SL_IMPORT_BONES : 0u);
    for (int i = 0; i < SL_IMPORT_UV_SETS; i++)
        flags |= mesh->mTextureCoords[i] ? (uint32_t)SL_IMPORT_UVS << i : 0u;
    return flags;
}

static bool is_triangle(const struct aiFace *face) { return face->mNumIndices == 3 && face->mIndices; }

static void put_mesh(writer *w, const struct aiMesh *mesh) {
    uint32_t triangles = 0;
    for (unsigned f = 0; f < mesh->mNumFaces; f++) triangles += is_triangle(&mesh->mFaces[f]);
    put_text(w, mesh->mName.data);
    put_word(w, mesh->mMaterialIndex);
    put_word(w, flags_of(mesh));
    put_word(w, mesh->mNumVertices);
    put_word(w, triangles);
    put_vectors(w, mesh->mVertices, mesh->mNumVertices);
    put_vectors(w, mesh->mNormals, mesh->mNumVertices);
    for (int i = 0; i < SL_IMPORT_UV_SETS; i++) put_uvs(w, mesh->mTextureCoords[i], mesh->mNumVertices);
    for (unsigned f = 0; f < mesh->mNumFaces; f++) {
        if (is_triangle(&mesh->mFaces[f])) put(w, mesh->mFaces[f].mIndices, 3 * sizeof(uint32_t));
    }
}

static bool is_sound(const writer *w, const struct aiMesh *mesh) {
    return mesh && mesh->mVertices && mesh->mFaces && mesh->mMaterialIndex < w->scene->mNumMaterials &&
           w->scene->mMaterials[mesh->mMaterialIndex];
}

static bool place_meshes(writer *w) {
    unsigned count = w->scene->mNumMeshes;
    w->mesh_place = calloc(count + 1, sizeof *w->mesh_place);
    w->mesh_stands = calloc(count + 1, sizeof *w->mesh_stands);
    if (!w->mesh_place || !w->mesh_stands) return false;
    for (unsigned i = 0; i < count; i++) {
        w->mesh_place[i] = is_sound(w, w->scene->mMeshes[i]) ? w->mesh_count++ : NONE;
    }
    return true;
}

static void put_meshes(writer *w) {
    put_word(w, w->mesh_count);
    for (unsigned i = 0; i < w->scene->mNumMeshes; i++) {
        if (w->mesh_place[i] != NONE) put_mesh(w, w->scene->mMeshes[i]);
    }
}

/* ---- nodes --------------------------------------------------------------------------------------------- */

static bool is_to_be_drawn(const writer *w, unsigned mesh) {
    return mesh < w->scene->mNumMeshes && w->mesh_place[mesh] != NONE;
}

static void survey_node(writer *w, const struct aiNode *node) {
    w->node_count++;
    for (unsigned i = 0; i < node->mNumMeshes; i++) {
        if (is_to_be_drawn(w, node->mMeshes[i])) w->mesh_stands[node->mMeshes[i]] = true;
    }
    for (unsigned i = 0; i < node->mNumChildren; i++) {
        if (node->mChildren[i]) survey_node(w, node->mChildren[i]);
        else w->node_lost = true;
    }
}

static void put_node(writer *w, const struct aiNode *node, uint32_t parent, uint32_t *next) {
    const struct aiMatrix4x4 *m = &node->mTransformation;
    uint32_t here = (*next)++, meshes = 0;
    for (unsigned i = 0; i < node->mNumMeshes; i++) meshes += is_to_be_drawn(w, node->mMeshes[i]);
    put_word(w, parent);
    put_text(w, node->mName.data);
    put(w,
        (const float[12]){m->a1, m->a2, m->a3, m->a4, m->b1, m->b2, m->b3, m->b4, m->c1, m->c2, m->c3, m->c4},
        12 * sizeof(float));
    put_word(w, meshes);
    for (unsigned i = 0; i < node->mNumMeshes; i++) {
        if (is_to_be_drawn(w, node->mMeshes[i])) put_word(w, w->mesh_place[node->mMeshes[i]]);
    }
    for (unsigned i = 0; i < node->mNumChildren; i++) {
        if (node->mChildren[i]) put_node(w, node->mChildren[i], here, next);
    }
}

/* Of a RAW file's groups the reader keeps the last one's node alone: the others' meshes stand in one of their
 * own. */
static void put_lost_node(writer *w) {
    static const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    uint32_t meshes = 0;
    for (unsigned i = 0; i < w->scene->mNumMeshes; i++) meshes += is_to_be_drawn(w, i) && !w->mesh_stands[i];
    put_word(w, 0);
    put_text(w, "");
    put(w, identity, sizeof identity);
    put_word(w, meshes);
    for (unsigned i = 0; i < w->scene->mNumMeshes; i++) {
        if (is_to_be_drawn(w, i) && !w->mesh_stands[i]) put_word(w, w->mesh_place[i]);
    }
}

static void put_nodes(writer *w) {
    uint32_t next = 0;
    put_word(w, w->node_count + w->node_lost);
    put_node(w, w->scene->mRootNode, NONE, &next);
    if (w->node_lost) put_lost_node(w);
}

/* ---- lights and cameras -------------------------------------------------------------------------------- */

static void put_lights(writer *w) {
    put_word(w, w->scene->mNumLights);
    for (unsigned i = 0; i < w->scene->mNumLights; i++) {
        const struct aiLight *l = w->scene->mLights[i];
        put_text(w, l->mName.data);
        put_word(w, l->mType == aiLightSource_POINT         ? SL_IMPORT_POINT
                    : l->mType == aiLightSource_SPOT        ? SL_IMPORT_SPOT
                    : l->mType == aiLightSource_DIRECTIONAL ? SL_IMPORT_DIRECTIONAL
                                                            : SL_IMPORT_OTHER_LIGHT);
        put_vectors(w, &l->mPosition, 1);
        put_vectors(w, &l->mDirection, 1);
        put(w, (const float[3]){l->mColorDiffuse.r, l->mColorDiffuse.g, l->mColorDiffuse.b},
            3 * sizeof(float));
        put_float(w, l->mAttenuationQuadratic);
        put_float(w, l->mAngleInnerCone);
        put_float(w, l->mAngleOuterCone);
    }
}

static void put_cameras(writer *w) {
    put_word(w, w->scene->mNumCameras);
    for (unsigned i = 0; i < w->scene->mNumCameras; i++) {
        const struct aiCamera *c = w->scene->mCameras[i];
        put_text(w, c->mName.data);
        put_vectors(w, &c->mPosition, 1);
        put_vectors(w, &c->mLookAt, 1);
        put_vectors(w, &c->mUp, 1);
        put_float(w, c->mHorizontalFOV);
        put_float(w, c->mAspect);
        put_float(w, c->mOrthographicWidth);
    }
}

/* ---- the whole ----------------------------------------------------------------------------------------- */

static void put_scene(writer *w) {
    put_textures(w);
    put_word(w, w->scene->mNumMaterials);
    for (unsigned i = 0; i < w->scene->mNumMaterials; i++) put_material(w, w->scene->mMaterials[i]);
    put_meshes(w);
    put_nodes(w);
    put_lights(w);
    put_cameras(w);
}

static void put_all(writer *w, uint64_t bytes, sl_import_outcome outcome, const char *text,
                    const sl_import_files *files) {
    w->bytes = 0;
    put_word(w, SL_IMPORT_MAGIC);
    put_word(w, SL_IMPORT_VERSION);
    put_word(w, (uint32_t)bytes);
    put_word(w, (uint32_t)(bytes >> 32));
    put_word(w, outcome);
    put_text(w, text);
    put_word(w, (uint32_t)files->opened_count);
    for (size_t i = 0; i < files->opened_count; i++) put_text(w, files->opened[i]);
    if (w->scene) put_scene(w);
    put_word(w, SL_IMPORT_MAGIC);
}

bool sl_import_write(FILE *to, sl_import_outcome outcome, const char *text, const sl_import_files *files,
                     const struct aiScene *scene) {
    writer w = {.scene = scene};
    if (scene && !place_meshes(&w)) return false;
    if (scene) survey_node(&w, scene->mRootNode);
    put_all(&w, 0, outcome, text, files);
    w.to = to;
    put_all(&w, w.bytes, outcome, text, files);
    free(w.mesh_place);
    free(w.mesh_stands);
    return fflush(to) == 0 && !ferror(to);
}
