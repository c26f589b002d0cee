/* What we do with what the importer (Assimp) makes of a file: an aiScene put together from the input's bytes, so that our code is tried and not
 * the importer's. What the importer promises (arrays as long as their counts, names that end, properties as long as their types say) holds; no
 * value, index, name, transform or nesting does. */
#include "support.h"

#include <assimp/material.h>
#include <assimp/scene.h>
#include <assimp/GltfMaterial.h>
#include <assimp/ObjMaterial.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/gltf.h"
#include "scene/mesh_file.h"

/* ---- blocks that live as long as the input ------------------------------------------------------------------------------- */

enum { BLOCKS_MAX = 4096 };
static void *blocks[BLOCKS_MAX];
static size_t block_count;

static void *block(size_t count, size_t size) {
    if (block_count == BLOCKS_MAX) fuzz_fail("too many blocks");
    void *made = calloc(count ? count : 1, size);
    if (!made) fuzz_fail("no memory");
    return blocks[block_count++] = made;
}

static void free_blocks(void) {
    while (block_count) free(blocks[--block_count]);
}

/* ---- parts ------------------------------------------------------------------------------------------------------------------ */

static struct aiVector3D take_vector(fuzz_bytes *in) {
    struct aiVector3D v = {fuzz_take_float(in), fuzz_take_float(in), fuzz_take_float(in)};
    return v;
}

/* One of a few names, so that some agree; or bytes, up to all that fit. */
static void take_name(fuzz_bytes *in, struct aiString *name) {
    static const char *const names[] = {"", "a", "b", "OPAQUE", "MASK", "BLEND", "*0", "*1", "*9999999999", "t.png", "..\\t.png", "no%20file.png"};
    uint32_t which = fuzz_take(in, 1);
    memset(name->data, 0, sizeof name->data);
    if (which < 200) {
        strcpy(name->data, names[which % (sizeof names / sizeof names[0])]);
    } else {
        size_t length = fuzz_take(in, 2) % sizeof name->data, left = (size_t)(in->end - in->at);
        memset(name->data, 'x', length);
        memcpy(name->data, in->at, length < left ? length : left);
        in->at += length < left ? length : left;
        name->data[length < sizeof name->data ? length : sizeof name->data - 1] = 0;
    }
    name->length = (ai_uint32)strlen(name->data);
}

static void set_key(struct aiMaterialProperty *p, const char *key, unsigned semantic, unsigned index) {
    strcpy(p->mKey.data, key);
    p->mKey.length = (ai_uint32)strlen(key);
    p->mSemantic = semantic;
    p->mIndex = index;
}

static void set_string(struct aiMaterialProperty *p, fuzz_bytes *in) {
    struct aiString text;
    take_name(in, &text);
    p->mType = aiPTI_String;
    p->mDataLength = 4 + text.length + 1;
    p->mData = block(p->mDataLength, 1);
    memcpy(p->mData, &text.length, 4);
    memcpy(p->mData + 4, text.data, text.length + 1);
}

/* The importer makes no doubles of what we ask for, and stops the process where it is asked to read one as a whole number. */
static void set_numbers(struct aiMaterialProperty *p, fuzz_bytes *in) {
    unsigned count = 1 + fuzz_take(in, 1) % 5;
    p->mType = fuzz_take(in, 1) % 4 == 0 ? aiPTI_Integer : aiPTI_Float;
    p->mDataLength = count * 4;
    p->mData = block(count, 4);
    for (unsigned i = 0; i < count; i++) {
        float value = fuzz_take_float(in);
        int32_t whole = fabsf(value) < 1e9f ? (int32_t)value : INT32_MIN;
        memcpy(p->mData + 4 * i, p->mType == aiPTI_Float ? (const void *)&value : (const void *)&whole, 4);
    }
}

static struct aiMaterial *take_material(fuzz_bytes *in) {
    static const struct {
        const char *key;
        unsigned semantic, index;
    } numbers[] = {{AI_MATKEY_COLOR_DIFFUSE}, {AI_MATKEY_COLOR_SPECULAR}, {AI_MATKEY_COLOR_EMISSIVE}, {AI_MATKEY_SHININESS},
                   {AI_MATKEY_SHININESS_STRENGTH}, {AI_MATKEY_OBJ_ILLUM}, {AI_MATKEY_OPACITY}, {AI_MATKEY_BASE_COLOR},
                   {AI_MATKEY_METALLIC_FACTOR}, {AI_MATKEY_ROUGHNESS_FACTOR}, {AI_MATKEY_TWOSIDED}, {AI_MATKEY_GLTF_ALPHACUTOFF},
                   {AI_MATKEY_UVWSRC(aiTextureType_DIFFUSE, 0)}, {AI_MATKEY_UVTRANSFORM(aiTextureType_DIFFUSE, 0)}};
    static const struct {
        const char *key;
        unsigned semantic, index;
    } texts[] = {{AI_MATKEY_NAME}, {AI_MATKEY_GLTF_ALPHAMODE}, {AI_MATKEY_TEXTURE(aiTextureType_DIFFUSE, 0)},
                 {AI_MATKEY_TEXTURE(aiTextureType_OPACITY, 0)}, {AI_MATKEY_TEXTURE(aiTextureType_HEIGHT, 0)},
                 {AI_MATKEY_TEXTURE(aiTextureType_METALNESS, 0)}, {AI_MATKEY_TEXTURE(aiTextureType_UNKNOWN, 0)},
                 {AI_MATKEY_TEXTURE(aiTextureType_EMISSIVE, 0)}};
    enum { NUMBERS = sizeof numbers / sizeof numbers[0], TEXTS = sizeof texts / sizeof texts[0] };
    struct aiMaterial *m = block(1, sizeof *m);
    m->mNumProperties = m->mNumAllocated = fuzz_take(in, 1) % 16;
    m->mProperties = block(m->mNumProperties, sizeof *m->mProperties);
    for (unsigned i = 0; i < m->mNumProperties; i++) {
        struct aiMaterialProperty *p = m->mProperties[i] = block(1, sizeof *p);
        unsigned which = fuzz_take(in, 1) % (NUMBERS + TEXTS);
        if (which < NUMBERS) {
            set_key(p, numbers[which].key, numbers[which].semantic, numbers[which].index);
            set_numbers(p, in);
        } else {
            set_key(p, texts[which - NUMBERS].key, texts[which - NUMBERS].semantic, texts[which - NUMBERS].index);
            set_string(p, in);
        }
    }
    return m;
}

static struct aiMesh *take_mesh(fuzz_bytes *in) {
    struct aiMesh *m = block(1, sizeof *m);
    uint32_t has = fuzz_take(in, 1);
    m->mNumVertices = fuzz_take(in, 1) % 40;
    m->mNumFaces = fuzz_take(in, 1) % 40;
    m->mMaterialIndex = fuzz_take(in, 1) % 5;
    take_name(in, &m->mName);
    m->mVertices = has % 16 == 15 ? NULL : block(m->mNumVertices, sizeof *m->mVertices);
    for (unsigned v = 0; m->mVertices && v < m->mNumVertices; v++) m->mVertices[v] = take_vector(in);
    if (has & 16) m->mNormals = block(m->mNumVertices, sizeof *m->mNormals);
    for (unsigned v = 0; m->mNormals && v < m->mNumVertices; v++) m->mNormals[v] = take_vector(in);
    for (int set = 0; set < 2; set++) {
        if (!(has & (32u << set))) continue;
        m->mTextureCoords[set] = block(m->mNumVertices, sizeof(struct aiVector3D));
        for (unsigned v = 0; v < m->mNumVertices; v++) m->mTextureCoords[set][v] = take_vector(in);
    }
    if (has & 128) m->mColors[0] = block(m->mNumVertices, sizeof(struct aiColor4D));
    m->mFaces = block(m->mNumFaces, sizeof *m->mFaces);
    for (unsigned f = 0; f < m->mNumFaces; f++) {
        struct aiFace *face = &m->mFaces[f];
        uint32_t kind = fuzz_take(in, 1);
        face->mNumIndices = kind < 240 ? 3 : kind % 5;
        face->mIndices = block(face->mNumIndices, sizeof *face->mIndices);
        for (unsigned c = 0; c < face->mNumIndices; c++) {
            face->mIndices[c] = fuzz_take(in, 1);
            if (kind != 255 && m->mNumVertices) face->mIndices[c] %= m->mNumVertices;
        }
    }
    return m;
}

static struct aiNode *take_node(fuzz_bytes *in, int *left, int depth) {
    struct aiNode *n = block(1, sizeof *n);
    uint32_t shape = fuzz_take(in, 1);
    n->mTransformation = (struct aiMatrix4x4){1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    float *m = &n->mTransformation.a1;
    for (unsigned i = 0; i < (shape & 1 ? 12u : 0u); i++) m[i] = fuzz_take_float(in);
    take_name(in, &n->mName);
    n->mNumMeshes = shape / 2 % 4;
    n->mMeshes = block(n->mNumMeshes, sizeof *n->mMeshes);
    for (unsigned i = 0; i < n->mNumMeshes; i++) n->mMeshes[i] = fuzz_take(in, 1) % 8;
    unsigned wanted = shape / 8 == 31 ? 1 : shape / 8 % 4;
    n->mChildren = block(wanted, sizeof *n->mChildren);
    for (unsigned i = 0; i < wanted && *left > 0; i++) {
        --*left;
        n->mChildren[n->mNumChildren++] = take_node(in, left, depth + 1);
    }
    return n;
}

static struct aiLight *take_light(fuzz_bytes *in) {
    struct aiLight *l = block(1, sizeof *l);
    take_name(in, &l->mName);
    l->mType = (enum aiLightSourceType)(fuzz_take(in, 1) % 6);
    l->mPosition = take_vector(in);
    l->mDirection = take_vector(in);
    l->mAttenuationQuadratic = fuzz_take_float(in);
    l->mColorDiffuse = (struct aiColor3D){fuzz_take_float(in), fuzz_take_float(in), fuzz_take_float(in)};
    l->mAngleInnerCone = fuzz_take_float(in);
    l->mAngleOuterCone = fuzz_take_float(in);
    return l;
}

static struct aiCamera *take_camera(fuzz_bytes *in) {
    struct aiCamera *c = block(1, sizeof *c);
    take_name(in, &c->mName);
    c->mPosition = take_vector(in);
    c->mUp = take_vector(in);
    c->mLookAt = take_vector(in);
    c->mHorizontalFOV = fuzz_take_float(in);
    c->mAspect = fuzz_take_float(in);
    return c;
}

static struct aiTexture *take_texture(fuzz_bytes *in) {
    struct aiTexture *t = block(1, sizeof *t);
    size_t length = fuzz_take(in, 1);
    t->mHeight = fuzz_take(in, 1) == 255;
    size_t left = (size_t)(in->end - in->at);
    if (length > left) length = left;
    t->mWidth = (unsigned)length;
    t->pcData = block(length, 1);
    memcpy(t->pcData, in->at, length);
    in->at += length;
    return t;
}

/* ---- the whole ----------------------------------------------------------------------------------------------------------------- */

#define TAKE_LIST(list, count, most, take) \
    do { \
        count = fuzz_take(&in, 1) % ((most) + 1); \
        list = block(count, sizeof *(list)); \
        for (unsigned i_ = 0; i_ < count; i_++) (list)[i_] = take(&in); \
    } while (0)

static sl_status import(const char *path, const struct aiScene *file, const sl_gltf *gltf, sl_scene **scene, sl_error *error) {
    sl_model model = {0};
    sl_affine identity = sl_affine_identity();
    sl_status status = sl_mesh_file_add(path, file, gltf, &identity, &model, error);
    if (status == SL_OK) status = sl_model_build(&model, scene, error);
    sl_model_clear(&model);
    return status;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_bytes in = {data, data + size};
    struct aiScene file = {0};
    uint32_t kind = fuzz_take(&in, 1);
    int nodes = kind & 4 ? 1500 : 20; /* as many as make one nesting too deep */
    TAKE_LIST(file.mMaterials, file.mNumMaterials, 4, take_material);
    TAKE_LIST(file.mMeshes, file.mNumMeshes, 4, take_mesh);
    TAKE_LIST(file.mTextures, file.mNumTextures, 2, take_texture);
    TAKE_LIST(file.mLights, file.mNumLights, 4, take_light);
    TAKE_LIST(file.mCameras, file.mNumCameras, 2, take_camera);
    double strength[2] = {(double)fuzz_take_float(&in), 1.0}, fov[1] = {(double)fuzz_take_float(&in)};
    sl_gltf gltf = {.material_count = 2, .emissive_strength = strength, .camera_count = 1, .vertical_fov = fov};
    file.mRootNode = take_node(&in, &nodes, 0);
    sl_scene *scene = NULL;
    sl_error error = {0};
    if (import(kind & 2 ? fuzz_path("i.obj") : fuzz_path("i.gltf"), &file, kind & 1 ? &gltf : NULL, &scene, &error) == SL_OK) {
        fuzz_check_scene(scene, fuzz_hash(data, size));
    } else {
        fuzz_check_error(&error);
    }
    sl_scene_destroy(scene);
    free_blocks();
    return 0;
}
