/* Facts of a glTF file that the importer does not pass on, or not exactly. */
#ifndef SL_SCENE_GLTF_H
#define SL_SCENE_GLTF_H

#include <cjson/cJSON.h>
#include <stddef.h>

#include "scene/model.h"

/* KHR_texture_transform. */
typedef struct sl_gltf_transform {
    bool given;
    double offset[2], rotation, scale[2]; /* rotation in radians */
    int set;                              /* of texture coordinates; -1: the texture's own */
} sl_gltf_transform;

/* Materials and cameras in the importer's order. */
typedef struct sl_gltf {
    size_t material_count;
    double *emissive_strength; /* KHR_materials_emissive_strength; 1 where it is not given */
    bool *unlit;               /* KHR_materials_unlit */
    sl_gltf_transform *base_transform; /* of the base texture, or that of the diffuse colour */
    size_t camera_count;
    double *vertical_fov;      /* radians; 0: not a perspective camera */
} sl_gltf;

/* Fails where the file is no glTF 2.0, or requires an extension that is not had (compressed geometry, say).
 * Warns of what is not had. */
sl_status sl_gltf_read(const char *path, sl_model *model, sl_gltf *gltf, sl_error *error);
void sl_gltf_release(sl_gltf *gltf);

/* Features that a file asks for and that are not had (gltf_features.c): an error where it requires one, else
 * a line for each. */
sl_status sl_gltf_check_required(const char *path, const cJSON *root, sl_error *error);
void sl_gltf_tell_features(const char *path, const cJSON *root, sl_model *model);

#endif
