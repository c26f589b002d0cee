/* Loading a scene: from a scene file of ours, or from a mesh file alone. */
#include <stdio.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/print.h"
#include "base/values.h"
#include "scene/file.h"
#include "scene/import_process.h"
#include "scene/import_reply.h"
#include "scene/mesh_file.h"
#include "scene/scene_file.h"

/* ---- mesh files ------------------------------------------------------------------------------ */

static sl_status import(const char *path, const sl_affine *placement, sl_model *model, sl_error *error) {
    void *reply;
    size_t size;
    sl_status status = sl_import_run(path, placement, model->folder, sl_import_limits_of(path), &reply, &size,
                                     error);
    if (status != SL_OK) return status;
    status = sl_import_reply_read(path, reply, size, model, error);
    sl_free(reply);
    return status;
}

sl_status sl_mesh_file_load(const char *path, const sl_affine *placement, sl_model *model, sl_error *error) {
    static const struct {
        const char *extension;
        sl_status (*load)(const char *, const sl_affine *, sl_model *, sl_error *);
    } formats[] = {{".bpt", sl_bicubic_file_load},
                   {".obj", sl_obj_file_load},
                   {"", import}};
    size_t i = 0;
    while (!sl_ends_with(path, formats[i].extension)) i++;
    sl_status status = sl_model_note_file(model, path, error);
    return status == SL_OK ? formats[i].load(path, placement, model, error) : status;
}

static sl_status load_mesh_alone(const char *path, const sl_load_options *options, sl_scene **scene,
                                 sl_error *error) {
    sl_model model = {.view = options->view};
    sl_affine placement = options->up_axis == SL_UP_Z ? sl_affine_z_up() : sl_affine_identity();
    sl_error problem = {0};
    sl_status status =
        sl_file_exists(path) && !options->allow_outside ? sl_model_confine(&model, path, error) : SL_OK;
    if (status == SL_OK) status = sl_mesh_file_load(path, &placement, &model, error);
    if (status == SL_OK) {
        status = sl_model_build(&model, scene, &problem);
        if (status == SL_ERROR_INPUT) sl_fail(error, status, "%s: %s", path, problem.message);
        else if (status != SL_OK) sl_fail(error, status, "%s", problem.message);
    }
    sl_model_clear(&model);
    return status;
}

/* ---- of any kind ----------------------------------------------------------------------------- */

/* JSON by name or by its first character; glTF, which is JSON too, by name. */
static bool is_scene_file(const char *path) {
    if (sl_ends_with(path, ".json")) return true;
    if (sl_ends_with(path, ".gltf") || !sl_file_exists(path)) return false;
    FILE *file = fopen(path, "rb");
    if (!file) return false;
    int first = fgetc(file);
    while (first == ' ' || first == '\t' || first == '\r' || first == '\n') first = fgetc(file);
    fclose(file);
    return first == '{';
}

sl_status sl_scene_load_with(const char *path, const sl_load_options *options, sl_scene **scene,
                             sl_error *error) {
    if (!scene || !options) return sl_fail_null(error, "a place for a scene, and options");
    *scene = NULL;
    if (!path || !*path) return sl_fail(error, SL_ERROR_USAGE, "expected the name of a scene file");
    if (options->up_axis < SL_UP_AUTO || options->up_axis > SL_UP_Z)
        return sl_fail(error, SL_ERROR_USAGE, "expected an up axis of auto, y or z");
    bool is_ours = is_scene_file(path);
    if (is_ours && options->up_axis != SL_UP_AUTO)
        return sl_fail(
            error, SL_ERROR_USAGE,
            "%s: a scene file says itself which axis is up: expected \"up\" in it, and no --up-axis", path);
    void *before = sl_c_locale_begin();
    sl_status status = is_ours ? sl_scene_file_load(path, options, scene, error)
                               : load_mesh_alone(path, options, scene, error);
    sl_c_locale_end(before);
    return status;
}

sl_status sl_scene_load(const char *path, sl_scene **scene, sl_error *error) {
    return sl_scene_load_with(path, &(sl_load_options){0}, scene, error);
}
