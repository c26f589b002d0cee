/* Features that a glTF file asks for and that are not had: told in one line for each feature. */
#ifndef SL_SCENE_GLTF_FEATURES_H
#define SL_SCENE_GLTF_FEATURES_H

#include <cjson/cJSON.h>

#include "scene/model.h"

/* Fails where the file requires an extension that is not had. */
sl_status sl_gltf_check_required(const char *path, const cJSON *root, sl_error *error);
void sl_gltf_tell_features(const char *path, const cJSON *root, sl_model *model);

#endif
