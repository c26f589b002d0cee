/* The order in which the importer numbers a glTF file's materials and cameras: that in which its nodes lead
 * to them, and not the file's. */
#ifndef SL_SCENE_GLTF_ORDER_H
#define SL_SCENE_GLTF_ORDER_H

#include <cjson/cJSON.h>

#include "softlux.h"

typedef struct sl_gltf_list {
    size_t count;
    const cJSON **item;
} sl_gltf_list;

/* Lists materials and cameras that the file's scene uses; both lists are to be released with
 * sl_free(list.item), also after a failure. */
sl_status sl_gltf_used(const cJSON *root, sl_gltf_list *materials, sl_gltf_list *cameras, sl_error *error);

#endif
