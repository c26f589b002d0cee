#include "scene/mesh_file.h"

#include "base/memory.h"
#include "base/values.h"
#include "scene/file.h"
#include "scene/import_process.h"
#include "scene/import_reply.h"

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
                   {".off", sl_off_file_load},
                   {"", import}};
    size_t i = 0;
    while (!sl_ends_with(path, formats[i].extension)) i++;
    sl_status status = sl_model_note_file(model, path, error);
    return status == SL_OK ? formats[i].load(path, placement, model, error) : status;
}
