/* Readers of mesh files without the importer, or before it: surfaces, OBJ, headers of PLY, and glTF. */
#include "support.h"

#include "import/assimp.h"

static sl_status check_with(unsigned kind, const char *path, sl_error *error) {
    sl_model model = {0};
    cJSON *gltf = NULL;
    sl_status status = kind == 2 ? sl_ply_check(path, error) : sl_gltf_read(path, &model, &gltf, error);
    cJSON_Delete(gltf);
    sl_model_clear(&model);
    return status;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const char *const names[] = {"r.bpt", "r.obj", "r.ply", "r.gltf"};
    if (size < 1) return 0;
    unsigned kind = data[0] % 4;
    const char *path = fuzz_path(names[kind]);
    fuzz_write(names[kind], data + 1, size - 1);
    sl_scene *scene = NULL;
    sl_error error = {0};
    sl_status status = kind < 2 ? sl_scene_load(path, &scene, &error) : check_with(kind, path, &error);
    if (status != SL_OK) fuzz_check_error(&error);
    else if (scene) fuzz_check_scene(scene, fuzz_hash(data, size));
    sl_scene_destroy(scene);
    return 0;
}
