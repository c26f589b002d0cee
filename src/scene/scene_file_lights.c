/* Scene files: lights and sky. */
#include <float.h>
#include <stdio.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "image/formats.h"
#include "image/tone.h"
#include "scene/file.h"
#include "scene/scene_file.h"

/* Exactly one of two keys. */
static const cJSON *one_of(sl_json *json, const cJSON *object, const char *a, const char *b, bool *is_first) {
    const cJSON *first = sl_json_get(object, a), *second = sl_json_get(object, b);
    if (!first == !second) sl_json_fail(json, object, "expected either '%s' or '%s' here", a, b);
    *is_first = first != NULL;
    return first ? first : second;
}

static void read_vector(sl_json *json, const cJSON *object, const char *key, double v[3]) {
    sl_json_numbers(json, sl_json_need(json, object, key), 3, v);
}

static void read_strength(sl_json *json, const cJSON *item, sl_light_data *light) {
    sl_rgb c;
    if (sl_json_rgb(json, item, &c))
        memcpy(light->strength, (float[3]){c.r, c.g, c.b}, sizeof light->strength);
}

/* ---- lights ---------------------------------------------------------------------------------- */

static void read_point(sl_json *json, const cJSON *item, sl_light_data *light) {
    bool intensity;
    if (!SL_JSON_KEYS(json, item, "a point light", "type", "name", "position", "intensity", "power",
                      "keyframes"))
        return;
    read_vector(json, item, "position", light->position);
    read_strength(json, one_of(json, item, "intensity", "power", &intensity), light);
    light->is_power = !intensity;
}

static void read_spot(sl_json *json, const cJSON *item, sl_light_data *light) {
    const double most = (double)FLT_MAX;
    if (!SL_JSON_KEYS(json, item, "a spot light", "type", "name", "position", "direction", "intensity",
                      "inner_deg", "outer_deg", "keyframes"))
        return;
    read_vector(json, item, "position", light->position);
    read_vector(json, item, "direction", light->direction);
    read_strength(json, sl_json_need(json, item, "intensity"), light);
    double outer = 0.0;
    sl_json_number(json, sl_json_need(json, item, "outer_deg"), -most, most, &outer);
    double inner = outer;
    sl_json_number(json, sl_json_get(item, "inner_deg"), -most, most, &inner);
    light->inner_rad = sl_radians(inner);
    light->outer_rad = sl_radians(outer);
}

static void read_directional(sl_json *json, const cJSON *item, sl_light_data *light) {
    if (!SL_JSON_KEYS(json, item, "a directional light", "type", "name", "direction", "irradiance",
                      "keyframes"))
        return;
    read_vector(json, item, "direction", light->direction);
    read_strength(json, sl_json_need(json, item, "irradiance"), light);
}

static void read_quad(sl_json *json, const cJSON *item, sl_light_data *light) {
    bool radiance;
    if (!SL_JSON_KEYS(json, item, "a quad light", "type", "name", "corner", "edge1", "edge2", "radiance",
                      "power", "two_sided", "keyframes"))
        return;
    read_vector(json, item, "corner", light->position);
    read_vector(json, item, "edge1", light->edge1);
    read_vector(json, item, "edge2", light->edge2);
    sl_json_bool(json, sl_json_get(item, "two_sided"), &light->two_sided);
    read_strength(json, one_of(json, item, "radiance", "power", &radiance), light);
    light->is_power = !radiance;
}

static void add_light(sl_scene_file *file, const cJSON *item, const sl_light_data *data, size_t number) {
    sl_json *json = &file->json;
    const cJSON *keys = sl_json_get(item, "keyframes");
    char text[SL_RULE_TEXT], name[32];
    snprintf(name, sizeof name, "quad light %zu", number);
    const char *given = sl_json_string(json, sl_json_get(item, "name"));
    const char *fault = json->status == SL_OK ? sl_light_fault(data, text) : NULL;
    const cJSON *at = fault ? sl_json_get(item, fault) : NULL;
    if (fault) sl_json_fail(json, at ? at : item, "%s", text);
    if (json->status != SL_OK) return;
    uint32_t index;
    if (data->type == SL_LIGHT_QUAD) {
        json->status = sl_model_add_quad(&file->model, json->path, given ? given : name, data, &file->turn,
                                         &index, json->error);
        if (json->status == SL_OK) sl_scene_file_object_keys(file, keys, index, 1);
        return;
    }
    const sl_light light = sl_light_from(data, &file->turn);
    json->status = sl_model_add_light(&file->model, &light, &index, json->error);
    if (json->status == SL_OK && index != SL_NO_INDEX) sl_scene_file_light_keys(file, keys, index);
}

static void read_light(sl_scene_file *file, const cJSON *item, size_t number) {
    static const struct {
        const char *name;
        void (*read)(sl_json *, const cJSON *, sl_light_data *);
    } types[] = {{"point", read_point}, {"spot", read_spot}, {"directional", read_directional},
                 {"quad", read_quad}}; /* as sl_light_type */
    sl_json *json = &file->json;
    const char *type = sl_json_string(json, sl_json_need(json, item, "type"));
    sl_json_string(json, sl_json_get(item, "name"));
    if (!type || json->status != SL_OK) return;
    for (int i = 0; i < 4; i++) {
        sl_light_data light = {.type = (sl_light_type)i};
        if (strcmp(type, types[i].name) != 0) continue;
        types[i].read(json, item, &light);
        add_light(file, item, &light, number);
        return;
    }
    sl_json_fail(json, sl_json_get(item, "type"),
                 "unknown light type '%s'; expected 'point', 'spot', 'directional' or 'quad'", type);
}

void sl_scene_file_lights(sl_scene_file *file, const cJSON *list) {
    sl_json *json = &file->json;
    size_t count = sl_json_array(json, list), number = 0;
    for (const cJSON *item = count ? list->child : NULL; item && json->status == SL_OK; item = item->next) {
        if (cJSON_IsObject(item)) read_light(file, item, number++);
        else sl_json_fail(json, item, "expected a light to be an object { ... }");
    }
}

/* ---- sky ------------------------------------------------------------------------------------- */

static void picture_sky(sl_scene_file *file, const cJSON *item, const char *name, float scale) {
    sl_json *json = &file->json;
    char *path = sl_file_beside(json->path, name);
    sl_image *image = NULL;
    sl_error problem = {0};
    sl_status status =
        path ? sl_model_may_read(&file->model, path, &problem) : sl_fail_memory(&problem, "a file name");
    if (status == SL_OK) status = sl_model_note_file(&file->model, path, &problem);
    if (status == SL_OK) status = sl_sky_read(path, &image, &problem);
    sl_free(path);
    const float *plane[3] = {NULL};
    const bool coloured = status == SL_OK && sl_layer_planes(image, NULL, plane);
    sl_json_take(json, item, "environment:", status, &problem);
    if (status == SL_OK && !coloured) {
        sl_json_fail(json, item, "environment: expected a picture with channels R, G and B: %s", name);
    } else if (status == SL_OK) {
        sl_environment *e = &file->model.scene.environment;
        size_t texels = (size_t)image->width * (size_t)image->height;
        *e = (sl_environment){.present = true,
                              .width = image->width,
                              .height = image->height,
                              .texels = sl_allocate(3 * texels, sizeof(float))};
        if (!e->texels) json->status = sl_fail_memory(json->error, "the environment");
        for (size_t i = 0; e->texels && i < 3 * texels; i++) e->texels[i] = plane[i % 3][i / 3] * scale;
    }
    sl_image_destroy(image);
}

void sl_scene_file_environment(sl_scene_file *file, const cJSON *item) {
    sl_json *json = &file->json;
    if (!item || !SL_JSON_KEYS(json, item, "the environment", "file", "radiance", "scale")) return;
    double scale = 1.0;
    sl_json_number(json, sl_json_get(item, "scale"), 0.0, 1e30, &scale);
    bool is_file;
    const cJSON *what = one_of(json, item, "file", "radiance", &is_file);
    if (json->status != SL_OK) return;
    if (is_file) {
        const char *name = sl_json_string(json, what);
        if (name) picture_sky(file, what, name, (float)scale);
        return;
    }
    sl_rgb radiance;
    if (!sl_json_rgb(json, what, &radiance)) return;
    file->model.scene.environment =
        (sl_environment){.present = true, .constant = sl_rgb_scale(radiance, (float)scale)};
    if (!sl_rgb_is_finite(file->model.scene.environment.constant))
        sl_json_fail(json, item, "expected radiance times scale to be finite");
}
