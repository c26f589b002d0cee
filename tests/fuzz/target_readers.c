/* What reads mesh files before, or instead of, the importer: surfaces, and the checks of OBJ, PLY, OFF and
 * glTF. */
#include "support.h"

#include "scene/gltf.h"
#include "scene/header_check.h"
#include "scene/obj_check.h"

static sl_status check_with(unsigned kind, sl_error *error) {
    sl_model model = {0};
    sl_gltf gltf = {0};
    sl_text plain = {0}, libraries = {0};
    sl_status status = SL_OK;
    if (kind == 1) status = sl_obj_check(fuzz_path("r.obj"), &model, &plain, &libraries, error);
    if (kind == 2) status = sl_header_check(fuzz_path("r.ply"), error);
    if (kind == 3) status = sl_header_check(fuzz_path("r.off"), error);
    if (kind == 4) status = sl_gltf_read(fuzz_path("r.gltf"), &model, &gltf, error);
    sl_text_release(&plain);
    sl_text_release(&libraries);
    sl_gltf_release(&gltf);
    sl_model_clear(&model);
    return status;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const char *const names[] = {"r.bpt", "r.obj", "r.ply", "r.off", "r.gltf"};
    if (size < 1) return 0;
    unsigned kind = data[0] % 5;
    fuzz_write(names[kind], data + 1, size - 1);
    sl_scene *scene = NULL;
    sl_error error = {0};
    sl_status status =
        kind == 0 ? sl_scene_load(fuzz_path(names[0]), &scene, &error) : check_with(kind, &error);
    if (status != SL_OK) fuzz_check_error(&error);
    else if (scene) fuzz_check_scene(scene, fuzz_hash(data, size));
    sl_scene_destroy(scene);
    return 0;
}
