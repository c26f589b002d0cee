/* What the importer does not pass on from a glTF file: emissive strengths, vertical fields of view, and which extensions the
 * file cannot do without. */
#ifndef SL_SCENE_GLTF_H
#define SL_SCENE_GLTF_H

#include <stddef.h>

#include "softlux.h"

typedef struct sl_gltf {
    size_t material_count;
    double *emissive_strength; /* KHR_materials_emissive_strength; 1 where it is not given */
    size_t camera_count;
    double *vertical_fov;      /* radians; 0: not a perspective camera */
} sl_gltf;

/* Fails where the file is no glTF 2.0, or requires an extension that is not understood (compressed geometry, say). */
sl_status sl_gltf_read(const char *path, sl_gltf *gltf, sl_error *error);
void sl_gltf_release(sl_gltf *gltf);

#endif
