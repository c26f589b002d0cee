/* What kind of file a scene is: a scene file of ours, or a mesh file. */
#include <stdio.h>

#include "base/error.h"
#include "base/print.h"
#include "scene/file.h"
#include "scene/mesh_file.h"
#include "scene/scene_file.h"

static sl_status load_mesh_alone(const char *path, const sl_load_options *options, sl_scene **scene, sl_error *error) {
    sl_model model = {0};
    sl_affine identity = sl_affine_identity();
    sl_error problem = {0};
    sl_status status = sl_file_exists(path) && !options->allow_outside ? sl_model_confine(&model, path, error) : SL_OK;
    if (status == SL_OK) status = sl_mesh_file_load(path, &identity, &model, error);
    if (status == SL_OK) {
        status = sl_model_build(&model, scene, &problem);
        if (status == SL_ERROR_INPUT) sl_fail(error, status, "%s: %s", path, problem.message);
        else if (status != SL_OK) sl_fail(error, status, "%s", problem.message);
    }
    sl_model_clear(&model);
    return status;
}

/* JSON by name or by its first character; glTF, which is JSON too, by name. */
static bool is_scene_file(const char *path) {
    if (sl_file_has_extension(path, ".json")) return true;
    if (sl_file_has_extension(path, ".gltf") || !sl_file_exists(path)) return false;
    FILE *file = fopen(path, "rb");
    if (!file) return false;
    int first = fgetc(file);
    while (first == ' ' || first == '\t' || first == '\r' || first == '\n') first = fgetc(file);
    fclose(file);
    return first == '{';
}

sl_status sl_scene_load_with(const char *path, const sl_load_options *options, sl_scene **scene, sl_error *error) {
    if (!scene || !options) return sl_fail_null(error, "a place for a scene, and options");
    *scene = NULL;
    if (!path || !*path) return sl_fail(error, SL_ERROR_USAGE, "expected the name of a scene file");
    void *before = sl_c_locale_begin();
    sl_status status = is_scene_file(path) ? sl_scene_file_load(path, options, scene, error) : load_mesh_alone(path, options, scene, error);
    sl_c_locale_end(before);
    return status;
}

sl_status sl_scene_load(const char *path, sl_scene **scene, sl_error *error) {
    return sl_scene_load_with(path, &(sl_load_options){0}, scene, error);
}
