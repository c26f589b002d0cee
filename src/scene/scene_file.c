/* The scene file itself: version, up axis, meshes, film, and the order in which its parts are read. */
#include "scene/scene_file.h"

#include <stdio.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "scene/derive.h"
#include "scene/file.h"
#include "scene/mesh_file.h"

enum { VERSION = 1 };

static void read_up(sl_scene_file *file, const cJSON *item) {
    file->turn = sl_affine_identity();
    const char *up = sl_json_string(&file->json, item);
    if (!up) return;
    if (strcmp(up, "z") == 0) {
        file->z_up = file->animation->z_up = true;
        file->turn = sl_affine_z_up();
    } else if (strcmp(up, "y") != 0) {
        sl_json_fail(&file->json, item, "expected 'up' to be \"y\" or \"z\", got \"%s\"", up);
    }
}

/* ---- meshes ---------------------------------------------------------------------------------- */

static void rename_objects(sl_scene_file *file, size_t first, const char *name) {
    for (size_t i = first; i < file->model.scene.object_count; i++) {
        char longer[512];
        bool only = file->model.scene.object_count - first == 1;
        snprintf(longer, sizeof longer, "%.200s%s%.200s", name, only ? "" : "/",
                 only ? "" : file->model.scene.object_names[i]);
        char *copy = sl_string_copy(longer);
        if (!copy) return; /* the old name will do */
        sl_free(file->model.scene.object_names[i]);
        file->model.scene.object_names[i] = copy;
    }
}

/* "faceted": every triangle with the normal of its own plane, whatever the mesh file says. */
static bool wants_facets(sl_json *json, const cJSON *item) {
    const char *word = sl_json_string(json, item);
    if (!word || strcmp(word, "file") == 0) return false;
    if (strcmp(word, "faceted") == 0) return true;
    sl_json_fail(json, item, "expected 'normals' to be 'file' or 'faceted', got '%s'", word);
    return false;
}

static void load_mesh(sl_scene_file *file, const cJSON *item) {
    sl_json *json = &file->json;
    if (!SL_JSON_KEYS(json, item, "a mesh", "file", "name", "transform", "material", "normals", "keyframes"))
        return;
    const cJSON *named = sl_json_need(json, item, "file");
    const char *name = sl_json_string(json, named), *label = sl_json_string(json, sl_json_get(item, "name"));
    bool faceted = wants_facets(json, sl_json_get(item, "normals"));
    sl_affine transform = sl_scene_file_transform(file, sl_json_get(item, "transform"));
    if (json->status != SL_OK) return;
    char *path = sl_file_beside(json->path, name);
    if (!path) {
        json->status = sl_fail_memory(json->error, "a file name");
        return;
    }
    sl_affine placement = sl_affine_after(&file->turn, &transform);
    size_t first = file->model.scene.object_count, first_vertex = file->model.vertex_count,
           surfaces = file->model.bicubic_count;
    sl_error problem = {0};
    sl_status status = sl_model_may_read(&file->model, path, &problem);
    if (status == SL_OK) status = sl_mesh_file_load(path, &placement, &file->model, &problem);
    sl_free(path);
    sl_json_take(json, named, "mesh", status, &problem);
    if (faceted && file->model.bicubic_count > surfaces)
        sl_json_fail(json, item, "expected 'normals' other than 'faceted' for bicubic surfaces");
    if (json->status != SL_OK) return;
    if (label) rename_objects(file, first, label);
    size_t vertices = file->model.vertex_count - first_vertex;
    if (faceted && vertices) memset(file->model.normals + 3 * first_vertex, 0, 3 * vertices * sizeof(float));
    sl_scene_file_object_keys(file, sl_json_get(item, "keyframes"), (uint32_t)first,
                              (uint32_t)(file->model.scene.object_count - first));
}

/* All meshes, then the materials that override theirs, then the materials that meshes ask for. */
static void read_meshes(sl_scene_file *file, const cJSON *list, const cJSON *materials) {
    sl_json *json = &file->json;
    size_t count = sl_json_array(json, list), i = 0;
    size_t *first_triangle = sl_allocate(count + 1, sizeof *first_triangle);
    if (!first_triangle) {
        json->status = sl_fail_memory(json->error, "the list of meshes");
        return;
    }
    for (const cJSON *item = count ? list->child : NULL; item && json->status == SL_OK; item = item->next) {
        load_mesh(file, item);
        first_triangle[++i] = file->model.triangle_count;
    }
    sl_scene_file_materials(file, materials, list);
    i = 0;
    for (const cJSON *item = count ? list->child : NULL; item && json->status == SL_OK;
         item = item->next, i++) {
        const cJSON *asked = sl_json_get(item, "material");
        const char *name = sl_json_string(json, asked);
        uint32_t material = name ? sl_scene_file_material_named(file, asked, name) : 0;
        for (size_t t = first_triangle[i]; name && t < first_triangle[i + 1]; t++)
            file->model.material_index[t] = material;
    }
    sl_free(first_triangle);
}

/* ---- the rest -------------------------------------------------------------------------------- */

static void read_film(sl_scene_file *file, const cJSON *item) {
    sl_json *json = &file->json;
    if (!item || !SL_JSON_KEYS(json, item, "the film", "width", "height")) return;
    double size[2] = {0, 0};
    sl_json_number(json, sl_json_need(json, item, "width"), 1.0, SL_LARGEST_FILM, &size[0]);
    sl_json_number(json, sl_json_need(json, item, "height"), 1.0, SL_LARGEST_FILM, &size[1]);
    if (json->status != SL_OK) return;
    file->model.scene.film_width = (int)size[0];
    file->model.scene.film_height = (int)size[1];
    if ((double)file->model.scene.film_width != size[0] || (double)file->model.scene.film_height != size[1])
        sl_json_fail(json, item, "expected 'width' and 'height' to be whole numbers");
}

static void read_root(sl_scene_file *file) {
    sl_json *json = &file->json;
    const cJSON *root = json->root;
    if (!SL_JSON_KEYS(json, root, "the scene", "softlux", "up", "meshes", "materials", "lights",
                      "environment", "camera", "film"))
        return;
    double version = 0.0;
    if (sl_json_number(json, sl_json_need(json, root, "softlux"), -1e9, 1e9, &version) &&
        version != VERSION) {
        char text[32];
        sl_json_fail(json, sl_json_get(root, "softlux"), "expected version \"softlux\": %d, got %s", VERSION,
                     sl_outside_text(version, VERSION, VERSION, text));
    }
    read_up(file, sl_json_get(root, "up"));
    read_meshes(file, sl_json_get(root, "meshes"), sl_json_get(root, "materials"));
    sl_scene_file_lights(file, sl_json_get(root, "lights"));
    sl_scene_file_environment(file, sl_json_get(root, "environment"));
    sl_scene_file_camera(file, sl_json_get(root, "camera"));
    read_film(file, sl_json_get(root, "film"));
}

/* Builds what the parts say together; it has no line of its own. */
static sl_status build(sl_scene_file *file, sl_scene **scene) {
    sl_error problem = {0};
    sl_status status = sl_model_build(&file->model, scene, &problem);
    if (status == SL_OK && file->animation->track_count > 0) {
        status = sl_animation_attach(*scene, file->animation, &problem);
        file->animation = NULL; /* the scene's now */
    }
    if (status == SL_OK) return SL_OK;
    sl_scene_destroy(*scene);
    *scene = NULL;
    return status == SL_ERROR_INPUT
               ? sl_fail(file->json.error, status, "%s: %s", file->json.path, problem.message)
               : sl_fail(file->json.error, status, "%s", problem.message);
}

sl_status sl_scene_file_load(const char *path, const sl_load_options *options, sl_scene **scene,
                             sl_error *error) {
    *scene = NULL;
    sl_scene_file file = {.model = {.view = options->view},
                          .animation = sl_allocate(1, sizeof(sl_animation))};
    if (!file.animation) return sl_fail_memory(error, "the scene file");
    sl_status opened = sl_json_open(path, &file.json, error);
    if (opened == SL_OK && !options->allow_outside)
        file.json.status = sl_model_confine(&file.model, path, error);
    if (file.json.status == SL_OK) file.json.status = sl_model_note_file(&file.model, path, error);
    if (file.json.status == SL_OK) read_root(&file);
    if (file.json.status == SL_OK) file.json.status = build(&file, scene);
    sl_status status = file.json.status;
    sl_animation_destroy(file.animation);
    sl_model_clear(&file.model);
    sl_json_close(&file.json);
    return status;
}
