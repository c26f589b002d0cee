#include "scene/mesh_file.h"

#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "scene/file.h"
#include "scene/gltf.h"
#include "scene/import_process.h"

typedef struct importer {
    const char *path;
    const sl_import *file;
    const sl_gltf *gltf; /* NULL: another format */
    const sl_affine *placement;
    sl_affine *to_world; /* of each node */
    uint32_t first_material;
    sl_model *model;
    sl_error *error;
} importer;

static sl_vec3d to_vec3d(const float v[3]) { return sl_v3d((double)v[0], (double)v[1], (double)v[2]); }

static sl_affine to_affine(const float m[12]) {
    sl_affine made;
    for (int i = 0; i < 12; i++) made.m[i / 4][i % 4] = (double)m[i];
    return made;
}

/* ---- meshes ---------------------------------------------------------------------------------- */

static void copy_vertices(const importer *in, const sl_import_mesh *mesh, const sl_affine *to_world,
                          size_t first) {
    sl_affine to_world_normal = sl_affine_normal_map(to_world);
    sl_mesh_copy_uvs(in->path, in->file, in->gltf, mesh, in->model->uvs + 2 * first, in->model);
    for (uint32_t v = 0; v < mesh->vertex_count; v++) {
        size_t to = first + v;
        sl_vec3 p = sl_to_float(sl_affine_point(to_world, to_vec3d(mesh->positions + 3 * (size_t)v)));
        memcpy(in->model->positions + 3 * to, (float[3]){p.x, p.y, p.z}, 3 * sizeof(float));
        if (!mesh->normals) continue;
        sl_vec3 n = sl_affine_unit(&to_world_normal, sl_to_float(to_vec3d(mesh->normals + 3 * (size_t)v)));
        memcpy(in->model->normals + 3 * to, (float[3]){n.x, n.y, n.z}, 3 * sizeof(float));
    }
}

/* A transform that mirrors would turn fronts into backs: two corners change places. */
static sl_status copy_triangles(const importer *in, const sl_import_mesh *mesh, bool mirrored,
                                size_t first_vertex, uint32_t object) {
    size_t first;
    sl_status status = sl_model_add_triangles(in->model, mesh->triangle_count, &first, in->error);
    for (uint32_t t = 0; t < mesh->triangle_count && status == SL_OK; t++, first++) {
        for (unsigned c = 0; c < 3; c++) {
            uint32_t corner = mesh->corners[3 * (size_t)t + (mirrored && c > 0 ? 3 - c : c)];
            if (corner >= mesh->vertex_count) {
                return sl_fail(in->error, SL_ERROR_INPUT,
                               "%s: expected vertex numbers below %u: a face of mesh '%s' names %u", in->path,
                               mesh->vertex_count, mesh->name, corner);
            }
            in->model->indices[3 * first + c] = (uint32_t)(first_vertex + corner);
        }
        in->model->material_index[first] = in->first_material + mesh->material;
        in->model->object_index[first] = object;
    }
    return status;
}

static sl_status add_mesh(const importer *in, const sl_import_mesh *mesh, const sl_affine *to_world,
                          uint32_t object) {
    size_t first;
    sl_status status = sl_model_add_vertices(in->model, mesh->vertex_count, object, &first, in->error);
    if (status != SL_OK) return status;
    copy_vertices(in, mesh, to_world, first);
    if (mesh->flags & SL_IMPORT_COLOURS) {
        sl_model_warn(in->model, "%s: vertex colours are not used", in->path);
    }
    if (mesh->flags & SL_IMPORT_BONES) {
        sl_model_warn(in->model, "%s: skinned meshes are shown in their rest pose", in->path);
    }
    return copy_triangles(in, mesh, sl_affine_determinant(to_world) < 0.0, first, object);
}

static sl_status add_node(const importer *in, uint32_t index) {
    const sl_import_node *node = &in->file->nodes[index];
    sl_affine local = to_affine(node->transform);
    in->to_world[index] = sl_affine_after(index ? &in->to_world[node->parent] : in->placement, &local);
    sl_status status = SL_OK;
    uint32_t object = 0;
    if (node->mesh_count) status = sl_model_add_object(in->model, node->name, &object, in->error);
    for (uint32_t i = 0; i < node->mesh_count && status == SL_OK; i++) {
        status = add_mesh(in, &in->file->meshes[node->mesh[i]], &in->to_world[index], object);
    }
    return status;
}

/* ---- lights and cameras: they stand where the node of their name stands ---------------------- */

static sl_affine placed(const importer *in, const char *name) {
    for (uint32_t i = 0; i < in->file->node_count; i++) {
        if (strcmp(in->file->nodes[i].name, name) == 0) return in->to_world[i];
    }
    return *in->placement;
}

static float cosine_of(float angle) { return (float)sl_cos((double)angle); }

/* Candela and lux of KHR_lights_punctual stand for W/sr and W/m^2. */
static sl_status add_light(const importer *in, const sl_import_light *from) {
    sl_affine to_world = placed(in, from->name);
    sl_light light = {.intensity = {from->colour[0], from->colour[1], from->colour[2]}};
    light.position =
        sl_to_float(sl_affine_point(&to_world, in->gltf ? sl_v3d(0, 0, 0) : to_vec3d(from->position)));
    light.direction = sl_affine_unit(&to_world, sl_to_float(to_vec3d(from->direction)));
    if (from->quadratic > 0.0f) light.intensity = sl_rgb_scale(light.intensity, 1.0f / from->quadratic);
    switch (from->type) {
    case SL_IMPORT_POINT: light.type = SL_LIGHT_POINT; break;
    case SL_IMPORT_DIRECTIONAL: light.type = SL_LIGHT_DIRECTIONAL; break;
    case SL_IMPORT_SPOT: light.type = SL_LIGHT_SPOT; break;
    default:
        sl_model_warn(in->model, "%s: light '%s' is neither point, spot nor directional and is left out",
                      in->path, from->name);
        return SL_OK;
    }
    if (light.type == SL_LIGHT_SPOT) { /* glTF gives angles from the axis, other formats the whole opening */
        float part = in->gltf ? 1.0f : 0.5f;
        light.cos_outer = cosine_of(part * fmaxf(from->outer, from->inner));
        light.cos_inner = cosine_of(part * fminf(from->outer, from->inner));
    }
    if (!(sl_rgb_max(light.intensity) > 0.0f)) {
        sl_model_warn(in->model, "%s: light '%s' gives no light and is left out", in->path, from->name);
        return SL_OK;
    }
    if (light.type != SL_LIGHT_POINT && !(sl_dot(light.direction, light.direction) > 0.5f)) {
        sl_model_warn(in->model, "%s: light '%s' has no direction and is left out", in->path, from->name);
        return SL_OK;
    }
    return sl_model_add_light(in->model, &light, in->error);
}

/* The vertical field of view; 0 where the camera has none. */
static float vertical_fov(const importer *in, unsigned index, const sl_import_camera *camera) {
    if (in->gltf) return index < in->gltf->camera_count ? (float)in->gltf->vertical_fov[index] : 0.0f;
    if (camera->orthographic_width > 0.0f || !(camera->horizontal_fov > 0.0f)) return 0.0f;
    double aspect = camera->aspect > 0.0f ? (double)camera->aspect : 1.0;
    return (float)(2.0 * sl_atan(sl_tan(0.5 * (double)camera->horizontal_fov) / aspect));
}

static bool place_camera(const importer *in, unsigned index) {
    const sl_import_camera *from = &in->file->cameras[index];
    sl_affine to_world = placed(in, from->name);
    /* A glTF camera looks along its node's -z; the importer's own frame doubles the node's translation. */
    sl_vec3d origin = in->gltf ? sl_v3d(0, 0, 0) : to_vec3d(from->position);
    sl_vec3d forward = in->gltf ? sl_v3d(0, 0, -1) : to_vec3d(from->direction),
             up = in->gltf ? sl_v3d(0, 1, 0) : to_vec3d(from->up);
    sl_vec3 eye = sl_to_float(sl_affine_point(&to_world, origin));
    sl_vec3 direction = sl_affine_unit(&to_world, sl_to_float(forward));
    /* Looking from the origin along the direction keeps all its bits, wherever the eye is. */
    bool good =
        sl_camera_look_at(&in->model->camera, sl_neg(direction), sl_v3(0, 0, 0),
                          sl_to_float(sl_affine_vector(&to_world, up)), vertical_fov(in, index, from));
    in->model->camera.eye = eye;
    return good && sl_is_finite(eye);
}

static void add_camera(const importer *in) {
    for (uint32_t i = 0; i < in->file->camera_count && !in->model->has_camera; i++) {
        const char *name = in->file->cameras[i].name;
        in->model->has_camera = place_camera(in, i);
        if (!in->model->has_camera) {
            sl_model_warn(in->model, "%s: camera '%s' is not a perspective camera and is left out", in->path,
                          name);
        } else if (in->file->camera_count > 1) {
            sl_model_warn(in->model, "%s: of %u cameras '%s' is used", in->path, in->file->camera_count,
                          name);
        }
    }
}

/* ---- the file -------------------------------------------------------------------------------- */

sl_status sl_mesh_file_add(const char *path, const sl_import *file, const struct sl_gltf *gltf,
                           const sl_affine *placement, sl_model *model, sl_error *error) {
    sl_affine *to_world = sl_allocate(file->node_count, sizeof *to_world);
    if (!to_world) return sl_fail_memory(error, path);
    const importer in = {path,  file, gltf, placement, to_world, (uint32_t)model->material_count,
                         model, error};
    sl_status status = sl_mesh_materials(path, file, gltf, model, error);
    for (uint32_t i = 0; i < file->node_count && status == SL_OK; i++) status = add_node(&in, i);
    for (uint32_t i = 0; i < file->light_count && status == SL_OK; i++) {
        status = add_light(&in, &file->lights[i]);
    }
    if (status == SL_OK) add_camera(&in);
    sl_free(to_world);
    return status;
}

static sl_status fail_of_outcome(const char *path, const sl_import *file, const sl_model *model,
                                 sl_error *error) {
    sl_error problem;
    switch (file->outcome) {
    case SL_IMPORT_READ: return SL_OK;
    case SL_IMPORT_OUTSIDE:
        if (sl_model_may_read(model, file->text, &problem) != SL_OK) {
            return sl_fail(error, problem.status, "%s: names %s", path, problem.message);
        }
        return sl_fail(error, SL_ERROR_INPUT, "%s: names %s, which has moved", path, file->text);
    case SL_IMPORT_STARVED: return sl_fail_memory(error, path);
    case SL_IMPORT_UNKNOWN:
        return sl_fail(
            error, SL_ERROR_INPUT,
            "%s: expected a scene file (.json) or a mesh file (.obj, .gltf, .glb, .ply, .stl, .bpt, ...)",
            path);
    default:
        return sl_fail(error, SL_ERROR_INPUT, "%s: cannot be read as a mesh: %s", path,
                       *file->text ? file->text : "it is damaged");
    }
}

static sl_status add_reply(const char *path, const sl_import *file, const sl_gltf *gltf,
                           const sl_affine *placement, sl_model *model, sl_error *error) {
    sl_status status = SL_OK;
    for (uint32_t i = 0; i < file->file_count && status == SL_OK; i++) {
        status = sl_model_note_file(model, file->files[i], error);
    }
    if (status == SL_OK) status = fail_of_outcome(path, file, model, error);
    return status == SL_OK ? sl_mesh_file_add(path, file, gltf, placement, model, error) : status;
}

static sl_status import(const char *path, const sl_gltf *gltf, const sl_affine *placement, sl_model *model,
                        sl_error *error) {
    void *reply;
    size_t size;
    sl_import file;
    sl_status status =
        sl_import_run(path, model->folder, sl_import_limits_of(path), &reply, &size, error);
    if (status != SL_OK) return status;
    status = sl_import_reply_read(path, reply, size, &file, error);
    if (status == SL_OK) status = add_reply(path, &file, gltf, placement, model, error);
    sl_import_release(&file);
    sl_free(reply);
    return status;
}

static sl_status load_gltf(const char *path, const sl_affine *placement, sl_model *model, sl_error *error) {
    sl_gltf gltf;
    sl_status status = sl_gltf_read(path, model, &gltf, error);
    if (status == SL_OK) status = import(path, &gltf, placement, model, error);
    sl_gltf_release(&gltf);
    return status;
}

static sl_status load_other(const char *path, const sl_affine *placement, sl_model *model, sl_error *error) {
    sl_status status = sl_header_check(path, error);
    return status == SL_OK ? import(path, NULL, placement, model, error) : status;
}

sl_status sl_mesh_file_load(const char *path, const sl_affine *placement, sl_model *model, sl_error *error) {
    static const struct {
        const char *extension;
        sl_status (*load)(const char *, const sl_affine *, sl_model *, sl_error *);
    } formats[] = {{".bpt", sl_bicubic_file_load}, {".obj", sl_obj_file_load}, {".off", sl_off_file_load},
                   {".gltf", load_gltf},           {".glb", load_gltf},        {"", load_other}};
    size_t i = 0;
    while (!sl_file_has_extension(path, formats[i].extension)) i++;
    sl_status status = sl_model_note_file(model, path, error);
    return status == SL_OK ? formats[i].load(path, placement, model, error) : status;
}
