/* Facts of a glTF file that Assimp does not pass on, or not exactly. */
#ifndef SL_IMPORT_GLTF_H
#define SL_IMPORT_GLTF_H

#include <cjson/cJSON.h>
#include <stddef.h>

#include "scene/model.h"

/* The file's text, and its materials and cameras in Assimp's order. */
typedef struct sl_gltf {
    cJSON *root;
    size_t material_count, camera_count;
    const cJSON **materials, **cameras;
} sl_gltf;

/* KHR_texture_transform. */
typedef struct sl_gltf_transform {
    bool given;
    double offset[2], rotation, scale[2]; /* rotation in radians */
    int set;                              /* of texture coordinates; -1: the texture's own */
} sl_gltf_transform;

/* Fails where the file is no glTF 2.0, or requires an extension that is not had (compressed geometry, say).
 * Warns of what is not had. Release it in any case. */
sl_status sl_gltf_read(const char *path, sl_model *model, sl_gltf *gltf, sl_error *error);
void sl_gltf_release(sl_gltf *gltf);

/* By the number of a material or camera; gltf may be NULL. */
double sl_gltf_emissive_strength(const sl_gltf *gltf, size_t material); /* 1 where it is not given */
bool sl_gltf_is_unlit(const sl_gltf *gltf, size_t material);
/* Of the base texture, or that of the diffuse colour. */
sl_gltf_transform sl_gltf_base_transform(const sl_gltf *gltf, size_t material);
double sl_gltf_vertical_fov(const sl_gltf *gltf, size_t camera); /* radians; 0: not a perspective camera */

/* Features that a file asks for and that are not had (gltf_features.c): an error where it requires one, else
 * a line for each. */
sl_status sl_gltf_check_required(const char *path, const cJSON *root, sl_error *error);
void sl_gltf_tell_features(const char *path, const cJSON *root, sl_model *model);

#endif
