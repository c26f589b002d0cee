/* Mesh files as they come, the importer (Assimp) included. The first byte says what the file is called. */
#include "support.h"

#include <stdio.h>

static const char *const extensions[] = {"obj", "gltf", "glb", "ply", "stl", "off", "3ds", "dae",
                                         "x",   "ms3d", "fbx", "lwo", "md2", "ase", "ac",  "dxf"};

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size < 1) return 0;
    char name[16];
    snprintf(name, sizeof name, "m.%s", extensions[data[0] % (sizeof extensions / sizeof extensions[0])]);
    fuzz_write(name, data + 1, size - 1);
    sl_scene *scene = NULL;
    sl_error error = {0};
    if (sl_scene_load(fuzz_path(name), &scene, &error) == SL_OK)
        fuzz_check_scene(scene, fuzz_hash(data, size));
    else fuzz_check_error(&error);
    sl_scene_destroy(scene);
    return 0;
}
