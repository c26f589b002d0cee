#include "scene/mesh_file.h"

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "scene/bicubic_file.h"
#include "scene/file.h"
#include "scene/gltf.h"
#include "scene/header_check.h"
#include "scene/import_io.h"
#include "scene/obj_check.h"

enum { DEEPEST_NODE = 1000 };

typedef struct importer {
    const char *path;
    const struct aiScene *file;
    const sl_gltf *gltf; /* NULL: another format */
    sl_affine placement;
    uint32_t first_material;
    sl_model *model;
    sl_error *error;
} importer;

static sl_vec3d to_vec3d(struct aiVector3D v) { return sl_v3d((double)v.x, (double)v.y, (double)v.z); }

static sl_affine to_affine(const struct aiMatrix4x4 *m) {
    return (sl_affine){{{(double)m->a1, (double)m->a2, (double)m->a3, (double)m->a4},
                        {(double)m->b1, (double)m->b2, (double)m->b3, (double)m->b4},
                        {(double)m->c1, (double)m->c2, (double)m->c3, (double)m->c4}}};
}

/* ---- meshes ---------------------------------------------------------------------------------------------------------------- */

static void copy_vertices(const importer *in, const struct aiMesh *mesh, const sl_affine *to_world, size_t first) {
    sl_affine to_world_normal = sl_affine_normal_map(to_world);
    const struct aiVector3D *uv = mesh->mTextureCoords[sl_mesh_uv_set(in->file, mesh->mMaterialIndex)];
    if (!uv) uv = mesh->mTextureCoords[0];
    for (unsigned v = 0; v < mesh->mNumVertices; v++) {
        size_t to = first + v;
        sl_vec3 p = sl_to_float(sl_affine_point(to_world, to_vec3d(mesh->mVertices[v])));
        memcpy(in->model->positions + 3 * to, (float[3]){p.x, p.y, p.z}, 3 * sizeof(float));
        if (mesh->mNormals) {
            sl_vec3 n = sl_affine_unit(&to_world_normal, sl_to_float(to_vec3d(mesh->mNormals[v])));
            memcpy(in->model->normals + 3 * to, (float[3]){n.x, n.y, n.z}, 3 * sizeof(float));
        }
        if (uv) memcpy(in->model->uvs + 2 * to, (float[2]){uv[v].x, uv[v].y}, 2 * sizeof(float));
    }
}

/* A transform that mirrors would turn fronts into backs: two corners change places. */
static sl_status copy_triangles(const importer *in, const struct aiMesh *mesh, bool mirrored, size_t first_vertex, uint32_t object) {
    size_t count = 0, first;
    for (unsigned f = 0; f < mesh->mNumFaces; f++) count += mesh->mFaces[f].mNumIndices == 3;
    sl_status status = sl_model_add_triangles(in->model, count, &first, in->error);
    if (status != SL_OK) return status;
    for (unsigned f = 0; f < mesh->mNumFaces; f++) {
        const struct aiFace *face = &mesh->mFaces[f];
        if (face->mNumIndices != 3) continue;
        for (unsigned c = 0; c < 3; c++) {
            unsigned corner = face->mIndices[mirrored && c > 0 ? 3 - c : c];
            if (corner >= mesh->mNumVertices) {
                return sl_fail(in->error, SL_ERROR_INPUT, "%s: vertex index %u is out of range: mesh '%s' has %u vertices", in->path,
                               corner, mesh->mName.data, mesh->mNumVertices);
            }
            in->model->indices[3 * first + c] = (uint32_t)(first_vertex + corner);
        }
        in->model->material_index[first] = in->first_material + mesh->mMaterialIndex;
        in->model->object_index[first++] = object;
    }
    return SL_OK;
}

static sl_status add_mesh(const importer *in, const struct aiMesh *mesh, const sl_affine *to_world, uint32_t object) {
    if (!mesh->mVertices || !mesh->mFaces || mesh->mMaterialIndex >= in->file->mNumMaterials) return SL_OK;
    size_t first;
    sl_status status = sl_model_add_vertices(in->model, mesh->mNumVertices, object, &first, in->error);
    if (status != SL_OK) return status;
    copy_vertices(in, mesh, to_world, first);
    if (mesh->mColors[0]) sl_model_warn(in->model, "%s: vertex colours are not used", in->path);
    if (mesh->mNumBones) sl_model_warn(in->model, "%s: skinned meshes are shown in their rest pose", in->path);
    return copy_triangles(in, mesh, sl_affine_determinant(to_world) < 0.0, first, object);
}

static sl_status add_node(const importer *in, const struct aiNode *node, const sl_affine *parent, int depth) {
    if (depth > DEEPEST_NODE) return sl_fail(in->error, SL_ERROR_INPUT, "%s: nodes are nested more than %d deep", in->path, DEEPEST_NODE);
    sl_affine local = to_affine(&node->mTransformation), to_world = sl_affine_after(parent, &local);
    sl_status status = SL_OK;
    uint32_t object = 0;
    if (node->mNumMeshes) status = sl_model_add_object(in->model, node->mName.data, &object, in->error);
    for (unsigned i = 0; i < node->mNumMeshes && status == SL_OK; i++) {
        unsigned mesh = node->mMeshes[i];
        if (mesh < in->file->mNumMeshes) status = add_mesh(in, in->file->mMeshes[mesh], &to_world, object);
    }
    for (unsigned i = 0; i < node->mNumChildren && status == SL_OK; i++) {
        status = add_node(in, node->mChildren[i], &to_world, depth + 1);
    }
    return status;
}

/* ---- lights and cameras: they stand where the node of their name stands ------------------------------------------------------- */

static bool find_node(const struct aiNode *node, const char *name, const sl_affine *parent, int depth, sl_affine *to_world) {
    sl_affine local = to_affine(&node->mTransformation);
    *to_world = sl_affine_after(parent, &local);
    if (strcmp(node->mName.data, name) == 0) return true;
    sl_affine here = *to_world;
    for (unsigned i = 0; depth < DEEPEST_NODE && i < node->mNumChildren; i++) {
        if (find_node(node->mChildren[i], name, &here, depth + 1, to_world)) return true;
    }
    return false;
}

static sl_affine placed(const importer *in, const char *name) {
    sl_affine to_world;
    return find_node(in->file->mRootNode, name, &in->placement, 0, &to_world) ? to_world : in->placement;
}

static float cosine_of(float angle) { return (float)sl_cos((double)angle); }

/* Candela and lux of KHR_lights_punctual stand for W/sr and W/m^2. */
static sl_status add_light(const importer *in, const struct aiLight *from) {
    sl_affine to_world = placed(in, from->mName.data);
    sl_light light = {.intensity = {from->mColorDiffuse.r, from->mColorDiffuse.g, from->mColorDiffuse.b}};
    light.position = sl_to_float(sl_affine_point(&to_world, in->gltf ? sl_v3d(0, 0, 0) : to_vec3d(from->mPosition)));
    light.direction = sl_affine_unit(&to_world, sl_to_float(to_vec3d(from->mDirection)));
    if (from->mAttenuationQuadratic > 0.0f) light.intensity = sl_rgb_scale(light.intensity, 1.0f / from->mAttenuationQuadratic);
    switch (from->mType) {
    case aiLightSource_POINT: light.type = SL_LIGHT_POINT; break;
    case aiLightSource_DIRECTIONAL: light.type = SL_LIGHT_DIRECTIONAL; break;
    case aiLightSource_SPOT: light.type = SL_LIGHT_SPOT; break;
    default:
        sl_model_warn(in->model, "%s: light '%s' is neither point, spot nor directional and is left out", in->path, from->mName.data);
        return SL_OK;
    }
    if (light.type == SL_LIGHT_SPOT) { /* glTF gives angles from the axis, other formats the whole opening */
        float part = in->gltf ? 1.0f : 0.5f;
        light.cos_outer = cosine_of(part * fmaxf(from->mAngleOuterCone, from->mAngleInnerCone));
        light.cos_inner = cosine_of(part * fminf(from->mAngleOuterCone, from->mAngleInnerCone));
    }
    if (!(sl_rgb_max(light.intensity) > 0.0f)) {
        sl_model_warn(in->model, "%s: light '%s' gives no light and is left out", in->path, from->mName.data);
        return SL_OK;
    }
    if (light.type != SL_LIGHT_POINT && !(sl_dot(light.direction, light.direction) > 0.5f)) {
        sl_model_warn(in->model, "%s: light '%s' has no direction and is left out", in->path, from->mName.data);
        return SL_OK;
    }
    return sl_model_add_light(in->model, &light, in->error);
}

/* The vertical field of view; 0 where the camera has none. */
static float vertical_fov(const importer *in, unsigned index, const struct aiCamera *camera) {
    if (in->gltf) return index < in->gltf->camera_count ? (float)in->gltf->vertical_fov[index] : 0.0f;
    if (camera->mOrthographicWidth > 0.0f || !(camera->mHorizontalFOV > 0.0f)) return 0.0f;
    double aspect = camera->mAspect > 0.0f ? (double)camera->mAspect : 1.0;
    return (float)(2.0 * sl_atan(sl_tan(0.5 * (double)camera->mHorizontalFOV) / aspect));
}

static bool place_camera(const importer *in, unsigned index) {
    const struct aiCamera *from = in->file->mCameras[index];
    sl_affine to_world = placed(in, from->mName.data);
    /* A glTF camera looks along its node's -z; the importer's own frame doubles the node's translation. */
    sl_vec3d origin = in->gltf ? sl_v3d(0, 0, 0) : to_vec3d(from->mPosition);
    sl_vec3d forward = in->gltf ? sl_v3d(0, 0, -1) : to_vec3d(from->mLookAt), up = in->gltf ? sl_v3d(0, 1, 0) : to_vec3d(from->mUp);
    sl_vec3 eye = sl_to_float(sl_affine_point(&to_world, origin));
    sl_vec3 direction = sl_affine_unit(&to_world, sl_to_float(forward));
    /* Looking from the origin along the direction keeps all its bits, wherever the eye is. */
    bool good = sl_camera_look_at(&in->model->camera, sl_neg(direction), sl_v3(0, 0, 0), sl_to_float(sl_affine_vector(&to_world, up)),
                                  vertical_fov(in, index, from));
    in->model->camera.eye = eye;
    return good && sl_is_finite(eye);
}

static void add_camera(const importer *in) {
    for (unsigned i = 0; i < in->file->mNumCameras && !in->model->has_camera; i++) {
        const char *name = in->file->mCameras[i]->mName.data;
        in->model->has_camera = place_camera(in, i);
        if (!in->model->has_camera) sl_model_warn(in->model, "%s: camera '%s' is not a perspective camera and is left out", in->path, name);
        else if (in->file->mNumCameras > 1) sl_model_warn(in->model, "%s: of %u cameras '%s' is used", in->path, in->file->mNumCameras, name);
    }
}

/* ---- the file ------------------------------------------------------------------------------------------------------------------ */

/* Post-processing trusts what the readers made; damaged files make faces that it would run astray on. */
static sl_status check_faces(const char *path, const struct aiScene *file, sl_error *error) {
    for (unsigned m = 0; m < file->mNumMeshes; m++) {
        const struct aiMesh *mesh = file->mMeshes[m];
        for (unsigned f = 0; f < mesh->mNumFaces; f++) {
            const struct aiFace *face = &mesh->mFaces[f];
            if (face->mNumIndices == 0 || !face->mIndices) {
                return sl_fail(error, SL_ERROR_INPUT, "%s: expected faces that have corners: face %u of mesh '%s' has none", path, f, mesh->mName.data);
            }
            for (unsigned c = 0; c < face->mNumIndices; c++) {
                if (face->mIndices[c] < mesh->mNumVertices) continue;
                return sl_fail(error, SL_ERROR_INPUT, "%s: expected vertex numbers below %u: face %u of mesh '%s' names %u", path, mesh->mNumVertices, f, mesh->mName.data,
                               face->mIndices[c]);
            }
        }
    }
    return SL_OK;
}

sl_status sl_mesh_file_add(const char *path, const struct aiScene *file, const struct sl_gltf *gltf, const sl_affine *placement,
                           sl_model *model, sl_error *error) {
    const importer in = {path, file, gltf, *placement, (uint32_t)model->material_count, model, error};
    sl_status status = check_faces(path, file, error);
    if (status == SL_OK) status = sl_mesh_materials(path, file, gltf, model, error);
    if (status == SL_OK) status = add_node(&in, file->mRootNode, placement, 0);
    for (unsigned i = 0; i < file->mNumLights && status == SL_OK; i++) status = add_light(&in, file->mLights[i]);
    if (status == SL_OK) add_camera(&in);
    return status;
}

/* Reads, checks, and only then has polygons cut into triangles. Points and lines stay and are skipped. */
static sl_status import(const char *path, sl_import_io *io, const sl_model *model, const struct aiScene **file, sl_error *error) {
    *file = aiImportFileEx(path, 0, &io->procedures);
    if (io->refused[0]) {
        sl_error problem;
        sl_status refused = sl_model_may_read(model, io->refused, &problem);
        if (refused != SL_OK) return sl_fail(error, refused, "%s: names %s", path, problem.message);
    }
    if (io->starved) return sl_fail_memory(error, path); /* what the importer takes for a file that is not there */
    if (!*file || !(*file)->mRootNode) {
        const char *reason = *file ? "it is empty" : aiGetErrorString();
        if (!*file && ((reason && strstr(reason, "bad_alloc")) || sl_memory_has_ended())) return sl_fail_memory(error, path);
        if (reason && strncmp(reason, "No suitable reader found", 24) == 0) {
            return sl_fail(error, SL_ERROR_INPUT, "%s: expected a scene file (.json) or a mesh file (.obj, .gltf, .glb, .ply, .stl, .bpt, ...)", path);
        }
        return sl_fail(error, SL_ERROR_INPUT, "%s: cannot be read as a mesh: %s", path, reason && *reason ? reason : "it is damaged");
    }
    sl_status status = check_faces(path, *file, error);
    if (status != SL_OK) return status;
    *file = aiApplyPostProcessing(*file, aiProcess_Triangulate);
    if (*file) return SL_OK;
    return sl_fail(error, SL_ERROR_INPUT, "%s: cannot be read as a mesh: its polygons cannot be cut into triangles", path);
}

/* What the importer would read wrong or tell less well. */
static sl_status check_first(const char *path, sl_model *model, bool is_gltf, sl_gltf *gltf, sl_text *plain, sl_error *error) {
    if (is_gltf) return sl_gltf_read(path, gltf, error);
    if (sl_file_has_extension(path, ".obj")) return sl_obj_check(path, model, plain, error);
    return sl_header_check(path, error);
}

sl_status sl_mesh_file_load(const char *path, const sl_affine *placement, sl_model *model, sl_error *error) {
    sl_status status = sl_model_note_file(model, path, error);
    if (status != SL_OK) return status;
    if (sl_file_has_extension(path, ".bpt")) return sl_bicubic_file_load(path, placement, model, error);
    bool is_gltf = sl_file_has_extension(path, ".gltf") || sl_file_has_extension(path, ".glb");
    sl_gltf gltf = {0};
    sl_text plain = {0};
    status = check_first(path, model, is_gltf, &gltf, &plain, error);
    if (status != SL_OK) return status;
    const struct aiScene *file = NULL;
    sl_import_io io;
    sl_import_io_init(&io, path, model, &plain);
    status = import(path, &io, model, &file, error);
    sl_text_release(&plain);
    if (status == SL_OK) status = sl_mesh_file_add(path, file, is_gltf ? &gltf : NULL, placement, model, error);
    if (file) aiReleaseImport(file);
    sl_gltf_release(&gltf);
    return status;
}
