#include "unit_test.h"
#include "scene_parts.h"

#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "scene/model.h"

static sl_status add_texture(sl_model *m, const sl_texture *from, size_t number, sl_error *error) {
    const size_t texels = (size_t)from->width * (size_t)from->height;
    sl_texture copy = *from;
    uint32_t index;
    if (from->width <= 0 || from->height <= 0 || !from->texels)
        return sl_fail(error, SL_ERROR_INPUT, "texture %zu is empty", number);
    if (!(copy.texels = sl_allocate_unset(texels, 4))) return sl_fail_memory(error, "the textures");
    memcpy(copy.texels, from->texels, 4 * texels);
    return sl_model_add_texture(m, from->file, &copy, &index, error);
}

static sl_status add_surfaces_and_lights(sl_model *m, const sl_scene_parts *parts, sl_error *error) {
    sl_status status = SL_OK;
    uint32_t index;
    for (size_t i = 0; i < parts->texture_count && status == SL_OK; i++)
        status = add_texture(m, &parts->textures[i], i, error);
    for (size_t i = 0; i < parts->material_count && status == SL_OK; i++)
        status = sl_model_add_material(m, &parts->materials[i], &index, error);
    for (size_t i = 0; i < parts->light_count && status == SL_OK; i++)
        status = sl_model_add_light(m, &parts->lights[i], &index, error);
    return status;
}

static sl_status add_objects(sl_model *m, const sl_scene_parts *parts, sl_error *error) {
    size_t count = parts->object_count;
    uint32_t index;
    sl_status status = SL_OK;
    for (size_t t = 0; !parts->object_count && parts->object_index && t < parts->triangle_count; t++) {
        if (parts->object_index[t] >= count) count = (size_t)parts->object_index[t] + 1;
    }
    for (size_t i = 0; i < count && status == SL_OK; i++)
        status = sl_model_add_object(m, parts->object_names ? parts->object_names[i] : "", &index, error);
    return status;
}

static void copy(void *to, const void *from, size_t bytes) {
    if (from && bytes) memcpy(to, from, bytes);
}

static sl_status add_triangles(sl_model *m, const sl_scene_parts *parts, sl_error *error) {
    const size_t vertices = parts->vertex_count, triangles = parts->triangle_count;
    size_t first;
    sl_status status = sl_model_add_vertices(m, vertices, &first, error);
    if (status == SL_OK) status = sl_model_add_triangles(m, triangles, &first, error);
    if (status != SL_OK) return status;
    copy(m->positions, parts->positions, 3 * vertices * sizeof(float));
    copy(m->normals, parts->normals, 3 * vertices * sizeof(float));
    copy(m->uvs, parts->texture_coordinates, 2 * vertices * sizeof(float));
    copy(m->indices, parts->indices, 3 * triangles * sizeof(uint32_t));
    copy(m->material_index, parts->material_index, triangles * sizeof(uint32_t));
    copy(m->object_index, parts->object_index, triangles * sizeof(uint32_t));
    return SL_OK;
}

static sl_status set_sky(sl_model *m, const sl_environment *from, sl_error *error) {
    if (!from) return SL_OK;
    sl_environment *e = &m->scene.environment;
    *e = (sl_environment){.present = from->present,
                          .constant = from->constant,
                          .width = from->width,
                          .height = from->height};
    if (from->width <= 0 || from->height <= 0 || !from->texels) return SL_OK; /* no picture */
    const size_t values = 3 * (size_t)from->width * (size_t)from->height;
    if (!(e->texels = sl_allocate_unset(values, sizeof(float))))
        return sl_fail_memory(error, "the environment");
    memcpy(e->texels, from->texels, values * sizeof(float));
    return SL_OK;
}

sl_status sl_scene_build(const sl_scene_parts *parts, sl_scene **scene, sl_error *error) {
    sl_model m = {.keeps_vertices = true,
                  .stays_dark = !parts->default_light,
                  .has_camera = parts->camera != NULL,
                  .view = parts->view,
                  .scene = {.film_width = parts->film_width, .film_height = parts->film_height}};
    *scene = NULL;
    if (parts->camera) m.camera = *parts->camera;
    sl_status status = add_surfaces_and_lights(&m, parts, error);
    if (status == SL_OK) status = set_sky(&m, parts->environment, error);
    if (status == SL_OK) status = add_objects(&m, parts, error);
    if (status == SL_OK) status = add_triangles(&m, parts, error);
    if (status == SL_OK) status = sl_model_build(&m, scene, error);
    sl_model_clear(&m);
    return status;
}

sl_scene *scene_built(const sl_scene_parts *parts) {
    sl_scene *scene;
    sl_error error = {0};
    if (sl_scene_build(parts, &scene, &error) != SL_OK) fail_msg("%s", error.message);
    return scene;
}
