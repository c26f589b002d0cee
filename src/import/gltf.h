/* Facts of a glTF file that Assimp does not pass on, or not exactly. */
#pragma once

#include <cjson/cJSON.h>

#include "scene/model.h"

/* KHR_texture_transform. */
typedef struct sl_gltf_transform {
    bool given;
    double offset[2], rotation, scale[2]; /* rotation in radians */
    int set;                              /* of texture coordinates; -1: the texture's own */
} sl_gltf_transform;

/* Reads the file's JSON, to be released with cJSON_Delete() in any case. Fails where the file is no glTF 2.0,
 * or requires an extension that is not had (compressed geometry, say). Warns of what is not had. */
sl_status sl_gltf_read(const char *path, sl_model *model, cJSON **gltf, sl_error *error);

/* Of the camera of the node of that name, or of the first that has one; in radians, 0: none. Assimp tells the
 * horizontal one, by a formula that depends on its version. */
double sl_gltf_vertical_fov(const cJSON *gltf, const char *node);
/* Of the first material of that name; gltf may be NULL. */
double sl_gltf_emissive_strength(const cJSON *gltf, const char *material); /* 1 where it is not given */
/* Of the base texture, or that of the diffuse colour. */
sl_gltf_transform sl_gltf_base_transform(const cJSON *gltf, const char *material);
