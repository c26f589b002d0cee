/* Meshes, nodes, lights and the camera. */
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "import/assimp.h"

typedef struct placed {
    const struct aiNode *node;
    sl_affine to_world;
} placed;

typedef struct importer {
    const char *path;
    const struct aiScene *scene;
    const cJSON *gltf; /* NULL: another format */
    const sl_affine *placement;
    placed *nodes; /* in the order of their tree */
    size_t node_count;
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

/* ---- meshes ---------------------------------------------------------------------------------- */

static bool is_sound(const importer *in, unsigned index) {
    const struct aiScene *s = in->scene;
    const struct aiMesh *mesh = index < s->mNumMeshes ? s->mMeshes[index] : NULL;
    return mesh && mesh->mVertices && mesh->mFaces && mesh->mMaterialIndex < s->mNumMaterials &&
           s->mMaterials[mesh->mMaterialIndex];
}

/* Returns the corners of its triangles, to be freed; NULL without memory. */
static uint32_t *corners_of(const struct aiMesh *mesh, size_t *triangles) {
    uint32_t *corners = sl_allocate_unset(3 * (size_t)mesh->mNumFaces, sizeof *corners);
    *triangles = 0;
    for (unsigned f = 0; corners && f < mesh->mNumFaces; f++) {
        const struct aiFace *face = &mesh->mFaces[f];
        if (face->mNumIndices != 3 || !face->mIndices) continue;
        memcpy(corners + 3 * (*triangles)++, face->mIndices, 3 * sizeof *corners);
    }
    return corners;
}

static sl_status add_mesh(const importer *in, const struct aiMesh *mesh, const sl_affine *to_world,
                          uint32_t object) {
    _Static_assert(sizeof(struct aiVector3D) == 3 * sizeof(float), "three floats without gaps");
    sl_mesh made = {.name = mesh->mName.data,
                    .vertex_count = mesh->mNumVertices,
                    .positions = (const float *)mesh->mVertices,
                    .normals = (const float *)mesh->mNormals,
                    .material = in->first_material + mesh->mMaterialIndex,
                    .object = object};
    uint32_t *corners = corners_of(mesh, &made.triangle_count);
    float *uvs = sl_allocate(2 * (size_t)mesh->mNumVertices, sizeof *uvs);
    made.corners = corners;
    if (uvs && sl_import_uvs(in->scene, in->gltf, mesh, uvs)) made.uvs = uvs;
    if (mesh->mColors[0]) sl_scene_warn(&in->model->scene, "%s: vertex colours are not used", in->path);
    if (mesh->mNumBones)
        sl_scene_warn(&in->model->scene, "%s: skinned meshes are shown in their rest pose", in->path);
    sl_status status = corners && uvs ? sl_model_add_mesh(in->model, in->path, &made, to_world, in->error)
                                      : sl_fail_memory(in->error, in->path);
    sl_free(corners);
    sl_free(uvs);
    return status;
}

/* ---- nodes ----------------------------------------------------------------------------------- */

static sl_status add_meshes(importer *in, const struct aiNode *node, const sl_affine *to_world) {
    uint32_t object;
    sl_status status = SL_OK;
    for (unsigned i = 0, made = 0; i < node->mNumMeshes && status == SL_OK; i++) {
        if (!is_sound(in, node->mMeshes[i])) continue;
        if (made++ == 0) status = sl_model_add_object(in->model, node->mName.data, &object, in->error);
        if (status == SL_OK) status = add_mesh(in, in->scene->mMeshes[node->mMeshes[i]], to_world, object);
    }
    return status;
}

static size_t count_nodes(const struct aiNode *node) {
    size_t count = 1;
    for (unsigned i = 0; i < node->mNumChildren; i++)
        count += node->mChildren[i] ? count_nodes(node->mChildren[i]) : 0;
    return count;
}

static sl_status add_node(importer *in, const struct aiNode *node, const sl_affine *parent) {
    const sl_affine local = to_affine(&node->mTransformation);
    placed *here = &in->nodes[in->node_count++];
    *here = (placed){node, sl_affine_after(parent, &local)};
    sl_status status = add_meshes(in, node, &here->to_world);
    for (unsigned i = 0; i < node->mNumChildren && status == SL_OK; i++) {
        if (node->mChildren[i]) status = add_node(in, node->mChildren[i], &here->to_world);
    }
    return status;
}

/* ---- lights and cameras: they stand where the node of their name stands ---------------------- */

static sl_affine place_of(const importer *in, const char *name) {
    for (size_t i = 0; i < in->node_count; i++) {
        if (strcmp(in->nodes[i].node->mName.data, name) == 0) return in->nodes[i].to_world;
    }
    return *in->placement;
}

/* glTF gives angles from the axis, other formats the whole opening. Candela and lux of KHR_lights_punctual
 * stand for W/sr and W/m^2. */
static sl_light light_of(const importer *in, const struct aiLight *from) {
    const sl_affine to_world = place_of(in, from->mName.data);
    const float part = in->gltf ? 1.0f : 0.5f,
                scale = from->mAttenuationQuadratic > 0.0f ? 1.0f / from->mAttenuationQuadratic : 1.0f;
    return (sl_light){
        .type = from->mType == aiLightSource_POINT  ? SL_LIGHT_POINT
                : from->mType == aiLightSource_SPOT ? SL_LIGHT_SPOT
                                                    : SL_LIGHT_DIRECTIONAL,
        .position = sl_to_float(
            sl_affine_point(&to_world, in->gltf ? sl_v3d(0, 0, 0) : to_vec3d(from->mPosition))),
        .direction = sl_affine_unit(&to_world, sl_to_float(to_vec3d(from->mDirection))),
        .intensity = sl_rgb_scale(
            (sl_rgb){from->mColorDiffuse.r, from->mColorDiffuse.g, from->mColorDiffuse.b}, scale),
        .cos_outer = (float)sl_cos((double)(part * fmaxf(from->mAngleOuterCone, from->mAngleInnerCone))),
        .cos_inner = (float)sl_cos((double)(part * fminf(from->mAngleOuterCone, from->mAngleInnerCone)))};
}

static sl_status add_light(const importer *in, const struct aiLight *from) {
    const sl_light light = light_of(in, from);
    const bool known = from->mType == aiLightSource_POINT || from->mType == aiLightSource_SPOT ||
                       from->mType == aiLightSource_DIRECTIONAL;
    const char *why = NULL;
    uint32_t index;
    if (!known) why = "is neither point, spot nor directional";
    else if (light.type != SL_LIGHT_POINT && !(sl_dot(light.direction, light.direction) > 0.5f))
        why = "has no direction";
    if (!why) return sl_model_add_light(in->model, &light, &index, in->error);
    sl_scene_warn(&in->model->scene, "%s: light '%s' %s and is left out", in->path, from->mName.data, why);
    return SL_OK;
}

/* The vertical field of view; 0 where the camera has none. */
static float vertical_fov(const importer *in, const struct aiCamera *camera) {
    if (in->gltf) return (float)sl_gltf_vertical_fov(in->gltf, camera->mName.data);
    if (camera->mOrthographicWidth > 0.0f || !(camera->mHorizontalFOV > 0.0f)) return 0.0f;
    if (!(camera->mAspect > 0.0f)) return camera->mHorizontalFOV;
    return (float)(2.0 * sl_atan(sl_tan(0.5 * (double)camera->mHorizontalFOV) / (double)camera->mAspect));
}

/* A glTF camera looks along its node's -z; Assimp's own frame doubles the node's translation. */
static bool place_camera(const importer *in, unsigned index) {
    const struct aiCamera *from = in->scene->mCameras[index];
    const sl_affine to_world = place_of(in, from->mName.data);
    const sl_vec3d origin = in->gltf ? sl_v3d(0, 0, 0) : to_vec3d(from->mPosition),
                   forward = in->gltf ? sl_v3d(0, 0, -1) : to_vec3d(from->mLookAt),
                   up = in->gltf ? sl_v3d(0, 1, 0) : to_vec3d(from->mUp);
    const sl_vec3 eye = sl_to_float(sl_affine_point(&to_world, origin)),
                  direction = sl_affine_unit(&to_world, sl_to_float(forward));
    /* Looking from the origin along the direction keeps all its bits, wherever the eye is. */
    const bool good =
        sl_camera_look_at(&in->model->camera, sl_neg(direction), sl_v3(0, 0, 0),
                          sl_to_float(sl_affine_vector(&to_world, up)), vertical_fov(in, from));
    in->model->camera.eye = eye;
    return good && sl_is_finite(eye);
}

static void add_camera(const importer *in) {
    const unsigned count = in->scene->mNumCameras;
    for (unsigned i = 0; i < count && !in->model->has_camera; i++) {
        const char *name = in->scene->mCameras[i]->mName.data;
        in->model->has_camera = place_camera(in, i);
        if (!in->model->has_camera)
            sl_scene_warn(&in->model->scene, "%s: camera '%s' is not a perspective camera and is left out",
                          in->path, name);
        else if (count > 1)
            sl_scene_warn(&in->model->scene, "%s: of %u cameras '%s' is used", in->path, count, name);
    }
}

/* ---- the file -------------------------------------------------------------------------------- */

sl_status sl_import_scene(const char *path, const struct aiScene *scene, const cJSON *gltf,
                          const sl_affine *placement, sl_model *model, sl_error *error) {
    importer in = {.path = path,
                   .scene = scene,
                   .gltf = gltf,
                   .placement = placement,
                   .nodes = sl_allocate(count_nodes(scene->mRootNode), sizeof *in.nodes),
                   .first_material = (uint32_t)model->scene.material_count,
                   .model = model,
                   .error = error};
    sl_status status = in.nodes ? sl_import_materials(path, scene, gltf, model, error)
                                : sl_fail_memory(error, path);
    if (status == SL_OK) status = add_node(&in, scene->mRootNode, placement);
    for (unsigned i = 0; i < scene->mNumLights && status == SL_OK; i++)
        status = add_light(&in, scene->mLights[i]);
    if (status == SL_OK) add_camera(&in);
    sl_free(in.nodes);
    return status;
}
