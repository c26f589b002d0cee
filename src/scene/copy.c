#include "scene/copy.h"

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "scene/derive.h"

size_t sl_scene_copy_bytes(const sl_scene *scene) {
    sl_scene s = *scene; /* whose pointers are listed, and not followed */
    sl_scene_array arrays[SL_SCENE_ARRAYS];
    size_t bytes = sizeof s;
    sl_scene_arrays(&s, arrays);
    for (int k = 0; k < SL_SCENE_ARRAYS; k++) bytes += arrays[k].moves ? arrays[k].bytes : 0;
    return bytes;
}

sl_status sl_scene_copy(const sl_scene *scene, sl_scene **scene_copy, sl_error *error) {
    *scene_copy = NULL;
    sl_scene *t = sl_allocate(1, sizeof *t);
    if (!t) return sl_fail_memory(error, "a copy of the scene");
    *t = *scene;
    sl_scene_array arrays[SL_SCENE_ARRAYS];
    sl_scene_arrays(t, arrays);
    bool ok = true;
    for (int k = 0; k < SL_SCENE_ARRAYS; k++) {
        if (!arrays[k].moves) continue;
        void *own = ok ? sl_copy_of(sl_scene_array_at(&arrays[k]), arrays[k].bytes, 1) : NULL;
        sl_scene_array_put(&arrays[k], own);
        ok = own != NULL;
    }
    if (ok) {
        *scene_copy = t;
        return SL_OK;
    }
    sl_scene_copy_destroy(t);
    return sl_fail_memory(error, "a copy of the scene");
}

void sl_scene_copy_destroy(sl_scene *scene_copy) {
    if (!scene_copy) return;
    sl_scene_array arrays[SL_SCENE_ARRAYS];
    sl_scene_arrays(scene_copy, arrays);
    for (int k = 0; k < SL_SCENE_ARRAYS; k++)
        if (arrays[k].moves) sl_free(sl_scene_array_at(&arrays[k]));
    sl_free(scene_copy);
}
