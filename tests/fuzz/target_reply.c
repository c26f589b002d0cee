/* What we do with what the importer's process answers, which is read as a stranger's file is: the input's
 * bytes stand between a reply's header and its end. The first byte says what the file is taken for. */
#include "support.h"

#include <stdlib.h>
#include <string.h>

#include "scene/gltf.h"
#include "scene/mesh_file.h"

/* A block as long as the reply, for the address sanitizer. */
static uint32_t *make_reply(const uint8_t *data, size_t size, size_t *bytes) {
    size_t words = 4 + (size + 3) / 4 + 1;
    *bytes = 4 * words;
    uint32_t *reply = malloc(*bytes);
    if (!reply) fuzz_fail("no memory");
    memset(reply, 0, *bytes);
    memcpy(reply, (const uint32_t[4]){SL_IMPORT_MAGIC, SL_IMPORT_VERSION, (uint32_t)*bytes, 0}, 16);
    if (size) memcpy(reply + 4, data, size);
    reply[words - 1] = SL_IMPORT_MAGIC;
    return reply;
}

static sl_status add(const char *path, const sl_import *file, const sl_gltf *gltf, sl_scene **scene,
                     sl_error *error) {
    sl_model model = {0};
    sl_affine identity = sl_affine_identity();
    sl_status status = sl_mesh_file_add(path, file, gltf, &identity, &model, error);
    if (status == SL_OK) status = sl_model_build(&model, scene, error);
    sl_model_clear(&model);
    return status;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size < 1) return 0;
    double strength[2] = {3.0, 1.0}, fov[1] = {0.7};
    sl_gltf gltf = {.material_count = 2,
                    .emissive_strength = strength,
                    .camera_count = 1,
                    .vertical_fov = fov};
    size_t bytes;
    uint32_t *reply = make_reply(data + 1, size - 1, &bytes);
    const char *path = data[0] & 2 ? fuzz_path("i.obj") : fuzz_path("i.gltf");
    sl_import file;
    sl_scene *scene = NULL;
    sl_error error = {0};
    sl_status status = sl_import_reply_read(path, reply, bytes, &file, &error);
    if (status == SL_OK && file.outcome == SL_IMPORT_READ) {
        status = add(path, &file, data[0] & 1 ? &gltf : NULL, &scene, &error);
    }
    if (status != SL_OK) fuzz_check_error(&error);
    else if (scene) fuzz_check_scene(scene, fuzz_hash(data, size));
    sl_scene_destroy(scene);
    sl_import_release(&file);
    free(reply);
    return 0;
}
