/* A scene's colour textures as texture images. */
#include "base/error.h"
#include "base/memory.h"
#include "raster/textures/textures.h"

struct sl_texture_set {
    size_t count;
    sl_texture_image **image; /* by the scene's texture; NULL where none is wanted */
};

static bool is_used(const sl_scene *scene, size_t texture) {
    for (size_t m = 0; m < scene->material_count; m++) {
        if (scene->materials[m].texture == texture) return true;
    }
    return false;
}

sl_status sl_texture_set_create(const sl_scene *scene, unsigned threads, sl_texture_set **set, sl_error *error) {
    *set = NULL;
    sl_texture_set *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "the textures");
    *s = (sl_texture_set){scene->texture_count, sl_allocate(scene->texture_count, sizeof *s->image)};
    sl_status status = s->image ? SL_OK : sl_fail_memory(error, "the textures");
    for (size_t i = 0; i < s->count && status == SL_OK; i++) {
        if (is_used(scene, i)) status = sl_texture_image_of_texture(&scene->textures[i], threads, &s->image[i], error);
    }
    if (status == SL_OK) *set = s;
    else sl_texture_set_destroy(s);
    return status;
}

void sl_texture_set_destroy(sl_texture_set *set) {
    if (!set) return;
    for (size_t i = 0; set->image && i < set->count; i++) sl_texture_image_destroy(set->image[i]);
    sl_free(set->image);
    sl_free(set);
}

const sl_texture_image *sl_texture_set_image(const sl_texture_set *set, uint32_t texture) {
    return texture < set->count ? set->image[texture] : NULL;
}

size_t sl_texture_set_memory_bytes(const sl_texture_set *set) {
    size_t texels = 0;
    for (size_t i = 0; i < set->count; i++) {
        const sl_texture_image *m = set->image[i];
        for (int l = 0; m && l < m->levels; l++) texels += (size_t)m->width[l] * (size_t)m->height[l];
    }
    return texels * 4 * sizeof(float);
}
