/* Texture coordinates of imported meshes: those of the colour texture, which alone is looked up point by
 * point. */
#include <math.h>
#include <string.h>

#include "base/math.h"
#include "scene/gltf.h"
#include "scene/mesh_file.h"

static int whole_or(const sl_import_material *material, sl_import_field field, int otherwise) {
    const float value = material->value[field][0];
    return material->has >> field & 1 && value >= 0.0f && value < 100.0f ? (int)value : otherwise;
}

static const sl_gltf_transform *transform_of(const struct sl_gltf *gltf, unsigned material) {
    return gltf && material < gltf->material_count ? &gltf->base_transform[material] : NULL;
}

/* Returns the set that the material's colour texture uses; NULL where the mesh has none. */
static const float *set_of(const sl_import_material *material, const sl_import_mesh *mesh,
                           const sl_gltf_transform *t) {
    int set = t && t->set >= 0 ? t->set : whole_or(material, SL_IMPORT_UV_SET, 0);
    bool known = set > 0 && set < SL_IMPORT_UV_SETS && mesh->uvs[set];
    return mesh->uvs[known ? set : 0];
}

/* KHR_texture_transform: scaled, turned, moved, with v from the top down as in glTF; the importer has turned
 * it over. */
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

static void check_wrapping(const char *path, const sl_import_material *material, const float *uv,
                           size_t count, sl_model *model) {
    int u = whole_or(material, SL_IMPORT_WRAP_U, SL_IMPORT_REPEATED);
    int v = whole_or(material, SL_IMPORT_WRAP_V, SL_IMPORT_REPEATED);
    bool repeated = u == SL_IMPORT_REPEATED && v == SL_IMPORT_REPEATED;
    if (repeated || !material->map[SL_IMPORT_MAP_DIFFUSE] || !leaves_picture(uv, count)) return;
    bool mirrored = u == SL_IMPORT_MIRRORED || v == SL_IMPORT_MIRRORED;
    sl_model_warn(model,
                  "%s: material '%s': its texture is %s beyond its edges in the file, and repeated here",
                  path, material->name, mirrored ? "mirrored" : "clamped");
}

void sl_mesh_copy_uvs(const char *path, const sl_import *file, const struct sl_gltf *gltf,
                      const sl_import_mesh *mesh, float *uvs, sl_model *model) {
    const sl_import_material *material = &file->materials[mesh->material];
    const sl_gltf_transform *t = transform_of(gltf, mesh->material);
    const float *from = set_of(material, mesh, t);
    if (!from) return;
    memcpy(uvs, from, 2 * (size_t)mesh->vertex_count * sizeof(float));
    if (t && t->given) transform(t, uvs, mesh->vertex_count);
    check_wrapping(path, material, uvs, mesh->vertex_count, model);
}
