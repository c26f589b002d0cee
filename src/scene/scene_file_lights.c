/* Scene files: lights and sky. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "image/formats.h"
#include "scene/file.h"
#include "scene/scene_file.h"

/* Exactly one of two keys. */
static const cJSON *one_of(sl_json *json, const cJSON *object, const char *a, const char *b, bool *is_first) {
    const cJSON *first = sl_json_get(object, a), *second = sl_json_get(object, b);
    if (!first == !second) sl_json_fail(json, object, "expected either '%s' or '%s' here", a, b);
    *is_first = first != NULL;
    return first ? first : second;
}

static void read_direction(sl_scene_file *file, const cJSON *object, sl_vec3 *direction) {
    const cJSON *item = sl_json_need(&file->json, object, "direction");
    sl_vec3d v;
    if (!sl_scene_file_vector(file, item, &v)) return;
    *direction = sl_normalize_or(sl_to_float(v), sl_v3(0, 0, 0));
    if (!(sl_dot(*direction, *direction) > 0.5f))
        sl_json_fail(&file->json, item, "expected 'direction' to be other than 0");
}

static void read_position(sl_scene_file *file, const cJSON *object, sl_vec3 *position) {
    sl_vec3d v;
    if (sl_scene_file_vector(file, sl_json_need(&file->json, object, "position"), &v))
        *position = sl_to_float(v);
}

/* ---- lights without extent ------------------------------------------------------------------- */

/* A point light of power P has the intensity P / (4 pi) in every direction. */
static void read_point(sl_scene_file *file, const cJSON *item, sl_light *light) {
    sl_json *json = &file->json;
    if (!SL_JSON_KEYS(json, item, "a point light", "type", "name", "position", "intensity", "power",
                      "keyframes"))
        return;
    light->type = SL_LIGHT_POINT;
    read_position(file, item, &light->position);
    bool intensity;
    const cJSON *strength = one_of(json, item, "intensity", "power", &intensity);
    if (sl_json_rgb(json, strength, &light->intensity) && !intensity) {
        light->intensity = sl_rgb_scale(light->intensity, (float)(0.25 / SL_PI));
    }
}

static void read_spot(sl_scene_file *file, const cJSON *item, sl_light *light) {
    sl_json *json = &file->json;
    if (!SL_JSON_KEYS(json, item, "a spot light", "type", "name", "position", "direction", "intensity",
                      "inner_deg", "outer_deg", "keyframes"))
        return;
    light->type = SL_LIGHT_SPOT;
    read_position(file, item, &light->position);
    read_direction(file, item, &light->direction);
    sl_json_rgb(json, sl_json_need(json, item, "intensity"), &light->intensity);
    double outer = 0.0;
    sl_json_number(json, sl_json_need(json, item, "outer_deg"), 0.01, 180.0, &outer);
    double inner = outer;
    sl_json_number(json, sl_json_get(item, "inner_deg"), 0.0, 180.0, &inner);
    if (inner > outer)
        sl_json_fail(json, sl_json_get(item, "inner_deg"), "expected 'inner_deg' of at most 'outer_deg', %g",
                     outer);
    light->cos_inner = (float)sl_cos(sl_scene_file_radians(inner));
    light->cos_outer = (float)sl_cos(sl_scene_file_radians(outer));
}

static void read_directional(sl_scene_file *file, const cJSON *item, sl_light *light) {
    sl_json *json = &file->json;
    if (!SL_JSON_KEYS(json, item, "a directional light", "type", "name", "direction", "irradiance",
                      "keyframes"))
        return;
    light->type = SL_LIGHT_DIRECTIONAL;
    read_direction(file, item, &light->direction);
    sl_json_rgb(json, sl_json_need(json, item, "irradiance"), &light->intensity);
}

static void add_light(sl_scene_file *file, const cJSON *item, const sl_light *light) {
    uint32_t index;
    if (file->json.status != SL_OK) return;
    file->json.status = sl_model_add_light(&file->model, light, &index, file->json.error);
    if (file->json.status == SL_OK && index != SL_NO_INDEX)
        sl_scene_file_light_keys(file, sl_json_get(item, "keyframes"), index);
}

/* ---- quads: two emissive triangles ----------------------------------------------------------- */

typedef struct quad {
    sl_vec3d corner, edge1, edge2;
    sl_rgb radiance;
    bool two_sided;
} quad;

/* A diffuse emitter of power P and area A leaves the radiance P / (pi A) on each side that shines. */
static void read_quad(sl_scene_file *file, const cJSON *item, quad *q) {
    sl_json *json = &file->json;
    if (!SL_JSON_KEYS(json, item, "a quad light", "type", "name", "corner", "edge1", "edge2", "radiance",
                      "power", "two_sided", "keyframes"))
        return;
    sl_json_vec3(json, sl_json_need(json, item, "corner"), &q->corner);
    sl_json_vec3(json, sl_json_need(json, item, "edge1"), &q->edge1);
    sl_json_vec3(json, sl_json_need(json, item, "edge2"), &q->edge2);
    sl_json_bool(json, sl_json_get(item, "two_sided"), &q->two_sided);
    double area = sl_lengthd(sl_crossd(q->edge1, q->edge2));
    if (!(area > 0.0) || !isfinite(area))
        sl_json_fail(json, item, "expected a quad light with an area: 'edge1' and 'edge2' must span one");
    bool radiance;
    const cJSON *strength = one_of(json, item, "radiance", "power", &radiance);
    if (sl_json_rgb(json, strength, &q->radiance) && !radiance) {
        q->radiance = sl_rgb_scale(q->radiance, (float)(1.0 / (SL_PI * area * (q->two_sided ? 2.0 : 1.0))));
        if (!sl_rgb_is_finite(q->radiance))
            sl_json_fail(json, item, "expected a quad light whose area gives a finite radiance");
    }
}

static sl_status add_quad_geometry(sl_scene_file *file, const quad *q, const char *name, uint32_t *object) {
    static const unsigned along1[4] = {0, 1, 1, 0}, along2[4] = {0, 0, 1, 1};
    static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
    sl_model *m = &file->model;
    sl_error *error = file->json.error;
    sl_material material = sl_grey_material(name, 0.0f);
    float positions[12];
    sl_mesh mesh = {
        .name = name, .vertex_count = 4, .triangle_count = 2, .positions = positions, .corners = corners};
    material.emission = q->radiance;
    material.emission_two_sided = q->two_sided;
    for (int i = 0; i < 4; i++) {
        const sl_vec3 p = sl_to_float(
            sl_addd(q->corner, sl_addd(sl_scaled(q->edge1, along1[i]), sl_scaled(q->edge2, along2[i]))));
        memcpy(positions + 3 * i, (float[3]){p.x, p.y, p.z}, 3 * sizeof(float));
    }
    sl_status status = sl_model_add_material(m, &material, &mesh.material, error);
    if (status == SL_OK) status = sl_model_add_object(m, name, object, error);
    mesh.object = *object;
    return status == SL_OK ? sl_model_add_mesh(m, file->json.path, &mesh, &file->turn, error) : status;
}

static void add_quad(sl_scene_file *file, const cJSON *item, size_t number) {
    quad q = {0};
    read_quad(file, item, &q);
    const char *given = sl_json_string(&file->json, sl_json_get(item, "name"));
    char name[32];
    snprintf(name, sizeof name, "quad light %zu", number);
    if (file->json.status != SL_OK) return;
    uint32_t object = 0;
    file->json.status = add_quad_geometry(file, &q, given ? given : name, &object);
    if (file->json.status == SL_OK)
        sl_scene_file_object_keys(file, sl_json_get(item, "keyframes"), object, 1);
}

/* ---- all of them ----------------------------------------------------------------------------- */

void sl_scene_file_lights(sl_scene_file *file, const cJSON *list) {
    sl_json *json = &file->json;
    size_t count = sl_json_array(json, list), number = 0;
    for (const cJSON *item = count ? list->child : NULL; item && json->status == SL_OK;
         item = item->next, number++) {
        if (!cJSON_IsObject(item)) {
            sl_json_fail(json, item, "expected a light to be an object { ... }");
            return;
        }
        const char *type = sl_json_string(json, sl_json_need(json, item, "type"));
        sl_json_string(json, sl_json_get(item, "name"));
        if (!type || json->status != SL_OK) return;
        sl_light light = {0};
        if (strcmp(type, "point") == 0) read_point(file, item, &light);
        else if (strcmp(type, "spot") == 0) read_spot(file, item, &light);
        else if (strcmp(type, "directional") == 0) read_directional(file, item, &light);
        else if (strcmp(type, "quad") == 0) add_quad(file, item, number);
        else
            sl_json_fail(json, sl_json_get(item, "type"),
                         "unknown light type '%s'; expected 'point', 'spot', 'directional' or 'quad'", type);
        if (strcmp(type, "quad") != 0) add_light(file, item, &light);
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
    static const char *const channels[3] = {"R", "G", "B"};
    for (int c = 0; c < 3 && status == SL_OK; c++) plane[c] = sl_image_channel(image, channels[c]);
    sl_json_take(json, item, "environment:", status, &problem);
    if (status == SL_OK && (!plane[0] || !plane[1] || !plane[2])) {
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
