/* Scenes from arrays: what a program gives goes the way that files go, into a model by the rules of
 * scene/parts.h. */
#include <float.h>
#include <stdio.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "image/color.h"
#include "scene/derive.h"
#include "scene/parts.h"

typedef struct given_mesh {
    char *name;
    sl_mesh_data data; /* whose arrays are its own, unless they are borrowed */
} given_mesh;

struct sl_scene_builder {
    sl_model model;
    given_mesh *meshes;
    size_t mesh_count, mesh_room, light_count;
    uint32_t grey; /* 1 + the material of what names none; 0: there is none yet */
    bool built;
};

enum { LARGEST_TEXTURE = 65536, NAME_ROOM = 256 };

/* ---- what is handed over --------------------------------------------------------------------- */

static sl_status check_usable(const sl_scene_builder *b, bool given, const char *expected, sl_error *error) {
    if (!b || !given) return sl_fail_null(error, expected);
    if (!b->built) return SL_OK;
    return sl_fail(error, SL_ERROR_USAGE, "the scene is built: its builder can only be destroyed");
}

/* Returns the name that is given, or one by number. */
static const char *name_of(const char *given, const char *kind, size_t number, char text[NAME_ROOM]) {
    if (given && *given) snprintf(text, NAME_ROOM, "%.200s", given);
    else snprintf(text, NAME_ROOM, "%s %zu", kind, number);
    return text;
}

static sl_status fail_of(const char *kind, const char *name, const char *expected, sl_error *error) {
    return sl_fail(error, SL_ERROR_INPUT, "%s '%s': %s", kind, name, expected);
}

/* Fails where nothing of that number was added before; 0 is none. */
static sl_status check_number(const char *kind, const char *name, const char *what, uint32_t number,
                              size_t count, sl_error *error) {
    if (number <= count) return SL_OK;
    return sl_fail(error, SL_ERROR_INPUT, "%s '%s': %s is number %u, of %zu that were added", kind, name,
                   what, number, count);
}

/* ---- textures -------------------------------------------------------------------------------- */

static sl_status check_texture(const sl_texture_data *t, const char *name, sl_error *error) {
    char text[SL_RULE_TEXT];
    if (!sl_is_within("width", t->width, 1.0, LARGEST_TEXTURE, text) ||
        !sl_is_within("height", t->height, 1.0, LARGEST_TEXTURE, text) ||
        !sl_is_within("channels", t->channels, 1.0, 4.0, text))
        return fail_of("texture", name, text, error);
    if (!t->srgb == !t->linear)
        return fail_of("texture", name, "expected either 'srgb' or 'linear' texels", error);
    const size_t width = (size_t)t->width, channels = (size_t)t->channels;
    for (size_t i = 0; t->linear && i < width * (size_t)t->height * channels; i++) {
        if (sl_is_within("linear", (double)t->linear[i], 0.0, 1.0, text)) continue;
        return sl_fail(error, SL_ERROR_INPUT, "texture '%s': row %zu, column %zu: %s", name,
                       i / channels / width, i / channels % width, text);
    }
    return SL_OK;
}

static uint8_t byte_of(const sl_texture_data *t, size_t index, bool is_alpha) {
    if (t->srgb) return t->srgb[index];
    const float value = t->linear[index];
    return (uint8_t)(255.0f * (is_alpha ? value : sl_srgb_encode(value)) + 0.5f);
}

static void fill_texels(const sl_texture_data *t, uint8_t *rgba) {
    const size_t n = (size_t)t->channels;
    for (size_t i = 0; i < (size_t)t->width * (size_t)t->height; i++) {
        for (size_t c = 0; c < 3; c++) rgba[4 * i + c] = byte_of(t, n * i + (n < 3 ? 0 : c), false);
        rgba[4 * i + 3] = n % 2 == 0 ? byte_of(t, n * i + n - 1, true) : 255;
    }
}

sl_status sl_scene_builder_texture(sl_scene_builder *b, const sl_texture_data *data, uint32_t *texture,
                                   sl_error *error) {
    sl_texture_data t;
    uint32_t index;
    char name[NAME_ROOM], key[NAME_ROOM + 32];
    if (texture) *texture = 0;
    sl_status status =
        check_usable(b, data && texture, "a builder, a texture and a place for its number", error);
    if (status == SL_OK) status = SL_TAKE(sl_texture_data, &t, data, error);
    if (status != SL_OK) return status;
    const size_t number = b->model.scene.texture_count + 1;
    status = check_texture(&t, name_of(t.name, "texture", number, name), error);
    if (status != SL_OK) return status;
    sl_texture made = {.width = t.width, .height = t.height, .has_alpha = t.channels % 2 == 0};
    made.texels = sl_allocate_unset((size_t)t.width * (size_t)t.height, 4);
    if (!made.texels) return sl_fail_memory(error, name);
    fill_texels(&t, made.texels);
    snprintf(key, sizeof key, "%s (%zu)", name, number); /* the model takes textures of one name for one */
    status = sl_model_add_texture(&b->model, key, &made, &index, error);
    if (status == SL_OK) *texture = index + 1;
    return status;
}

/* ---- materials ------------------------------------------------------------------------------- */

static sl_rgb colour(const float c[3]) { return (sl_rgb){c[0], c[1], c[2]}; }

sl_status sl_scene_builder_material(sl_scene_builder *b, const sl_material_data *data, uint32_t *material,
                                    sl_error *error) {
    sl_material_data d;
    sl_material made;
    uint32_t index;
    char name[NAME_ROOM];
    if (material) *material = 0;
    sl_status status =
        check_usable(b, data && material, "a builder, a material and a place for its number", error);
    if (status == SL_OK) status = SL_TAKE(sl_material_data, &d, data, error);
    if (status != SL_OK) return status;
    name_of(d.name, "material", b->model.scene.material_count + 1, name);
    status = sl_material_take(&b->model.scene, data, name, &made, error);
    if (status == SL_OK) status = sl_model_add_material(&b->model, &made, &index, error);
    if (status == SL_OK) *material = index + 1;
    return status;
}

/* Finds the index of a material that was added, or of the grey one. */
static sl_status find_material(sl_scene_builder *b, uint32_t number, uint32_t *index, sl_error *error) {
    const sl_material grey = sl_grey_material("grey", 0.5f);
    *index = (number ? number : b->grey) - 1;
    if (number || b->grey) return SL_OK;
    sl_status status = sl_model_add_material(&b->model, &grey, index, error);
    if (status == SL_OK) b->grey = *index + 1;
    return status;
}

/* ---- meshes ---------------------------------------------------------------------------------- */

static sl_mesh mesh_from(const sl_mesh_data *d, const char *name) {
    return (sl_mesh){.name = name,
                     .vertex_count = d->vertex_count,
                     .triangle_count = d->triangle_count,
                     .positions = d->positions,
                     .normals = d->normals,
                     .uvs = d->texture_coordinates,
                     .corners = d->indices};
}

static sl_status check_mesh(size_t materials, const sl_mesh_data *d, const char *name, sl_error *error) {
    const sl_mesh mesh = mesh_from(d, name);
    char what[64];
    if (d->vertex_count >= SL_NO_INDEX || d->triangle_count >= SL_NO_INDEX / 3)
        return fail_of("mesh", name, "expected fewer vertices and triangles", error);
    if ((d->vertex_count && !d->positions) || (d->triangle_count && !d->indices))
        return fail_of("mesh", name, "expected its vertices' positions and its triangles' indices", error);
    sl_status status = sl_mesh_check("", &mesh, error);
    if (status == SL_OK) status = check_number("mesh", name, "'material'", d->material, materials, error);
    for (size_t t = 0; t < d->triangle_count && d->materials && status == SL_OK; t++) {
        if (d->materials[t] <= materials) continue;
        snprintf(what, sizeof what, "the material of triangle %zu", t);
        status = check_number("mesh", name, what, d->materials[t], materials, error);
    }
    return status;
}

static void *copy_of(const void *array, size_t bytes, bool *copied) {
    void *copy = array ? sl_copy_of(array, bytes, 1) : NULL;
    *copied &= !array || copy;
    return copy;
}

static bool copy_arrays(sl_mesh_data *d) {
    const size_t vertices = d->vertex_count * sizeof(float), triangles = d->triangle_count * sizeof(uint32_t);
    bool copied = true;
    d->positions = copy_of(d->positions, 3 * vertices, &copied);
    d->normals = copy_of(d->normals, 3 * vertices, &copied);
    d->texture_coordinates = copy_of(d->texture_coordinates, 2 * vertices, &copied);
    d->indices = copy_of(d->indices, 3 * triangles, &copied);
    d->materials = copy_of(d->materials, triangles, &copied);
    return copied;
}

static void release_mesh(given_mesh *m) {
    const void *const arrays[] = {m->data.positions, m->data.normals, m->data.texture_coordinates,
                                  m->data.indices, m->data.materials};
    for (int i = 0; i < 5 && !m->data.borrowed; i++) sl_free((void *)(uintptr_t)arrays[i]);
    sl_free(m->name);
}

sl_status sl_scene_builder_mesh(sl_scene_builder *b, const sl_mesh_data *data, uint32_t *mesh,
                                sl_error *error) {
    given_mesh m;
    char name[NAME_ROOM];
    if (mesh) *mesh = 0;
    sl_status status = check_usable(b, data && mesh, "a builder, a mesh and a place for its number", error);
    if (status == SL_OK) status = SL_TAKE(sl_mesh_data, &m.data, data, error);
    if (status != SL_OK) return status;
    name_of(m.data.name, "mesh", b->mesh_count + 1, name);
    status = check_mesh(b->model.scene.material_count, &m.data, name, error);
    if (status != SL_OK) return status;
    m.name = sl_string_copy(name);
    const bool copied = m.data.borrowed || copy_arrays(&m.data);
    if (!m.name || !copied || !sl_make_room(&b->meshes, b->mesh_count, &b->mesh_room, sizeof *b->meshes)) {
        release_mesh(&m);
        return sl_fail_memory(error, "a mesh");
    }
    b->meshes[b->mesh_count++] = m;
    *mesh = (uint32_t)b->mesh_count;
    return SL_OK;
}

/* ---- instances ------------------------------------------------------------------------------- */

/* Gives the triangles that were added last the materials that they name themselves; all of them are there. */
static void spread_materials(sl_model *model, const sl_mesh_data *d, uint32_t otherwise) {
    uint32_t *index = model->material_index + model->triangle_count - d->triangle_count;
    for (size_t t = 0; t < d->triangle_count; t++)
        index[t] = (d->materials[t] ? d->materials[t] : otherwise) - 1;
}

sl_status sl_mesh_take(const sl_scene *scene, sl_model *model, const sl_mesh_data *data, const char *name,
                       uint32_t object, const sl_affine *placement, sl_error *error) {
    sl_mesh_data d;
    bool named = true;
    sl_status status = SL_TAKE(sl_mesh_data, &d, data, error);
    if (status == SL_OK) status = check_mesh(scene->material_count, &d, name, error);
    for (size_t t = 0; t < d.triangle_count && d.materials && status == SL_OK; t++)
        named &= d.materials[t] != 0;
    if (status == SL_OK && !d.material && !(d.materials && named))
        status = fail_of("mesh", name, "expected the numbers of its materials", error);
    sl_mesh mesh = mesh_from(&d, name);
    mesh.material = d.material - 1;
    mesh.object = object;
    if (status == SL_OK) status = sl_model_add_mesh(model, "", &mesh, placement, error);
    if (status == SL_OK && d.materials) spread_materials(model, &d, d.material);
    return status;
}

static sl_status place_mesh(sl_scene_builder *b, const sl_instance_data *d, const sl_affine *placement,
                            sl_error *error) {
    const given_mesh *m = &b->meshes[d->mesh - 1];
    const bool of_many = m->data.materials && !d->material;
    uint32_t number = d->material ? d->material : m->data.material;
    for (size_t t = 0; t < m->data.triangle_count && of_many; t++)
        number = t && !number ? 0 : m->data.materials[t]; /* 0, if any of them is */
    sl_mesh mesh = mesh_from(&m->data, m->name);
    sl_status status = find_material(b, number, &mesh.material, error);
    if (status == SL_OK)
        status = sl_model_add_object(&b->model, d->name && *d->name ? d->name : m->name, &mesh.object, error);
    if (status == SL_OK) status = sl_model_add_mesh(&b->model, "", &mesh, placement, error);
    if (status == SL_OK && of_many) spread_materials(&b->model, &m->data, b->grey);
    return status;
}

sl_status sl_scene_builder_instance(sl_scene_builder *b, const sl_instance_data *data, sl_error *error) {
    sl_instance_data d;
    sl_affine placement = sl_affine_identity();
    char name[NAME_ROOM];
    sl_status status = check_usable(b, data, "a builder and an instance", error);
    if (status == SL_OK) status = SL_TAKE(sl_instance_data, &d, data, error);
    if (status != SL_OK) return status;
    name_of(d.name, "object", b->model.scene.object_count + 1, name);
    if (d.mesh == 0) return fail_of("instance", name, "expected the number of a mesh", error);
    status = check_number("instance", name, "'mesh'", d.mesh, b->mesh_count, error);
    if (status == SL_OK)
        status =
            check_number("instance", name, "'material'", d.material, b->model.scene.material_count, error);
    const char *fault = d.transform ? sl_matrix_fault(d.transform, &placement) : NULL;
    if (status == SL_OK && fault) status = fail_of("instance", name, fault, error);
    return status == SL_OK ? place_mesh(b, &d, &placement, error) : status;
}

/* ---- lights and sky -------------------------------------------------------------------------- */

sl_status sl_scene_builder_light(sl_scene_builder *b, const sl_light_data *data, sl_error *error) {
    const sl_affine turn = sl_affine_identity();
    sl_light_data d;
    uint32_t index;
    char name[NAME_ROOM], text[SL_RULE_TEXT];
    sl_status status = check_usable(b, data, "a builder and a light", error);
    if (status == SL_OK) status = SL_TAKE(sl_light_data, &d, data, error);
    if (status != SL_OK) return status;
    name_of(d.name, "light", b->light_count + 1, name);
    if (sl_light_fault(&d, text)) return fail_of("light", name, text, error);
    if (d.type == SL_LIGHT_QUAD) {
        status = sl_model_add_quad(&b->model, "", name, &d, &turn, &index, error);
    } else {
        const sl_light light = sl_light_from(&d, &turn);
        status = sl_model_add_light(&b->model, &light, &index, error);
    }
    b->light_count += status == SL_OK;
    return status;
}

sl_status sl_sky_take(int width, int height, const float *radiance, sl_environment *taken,
                      sl_error *error) {
    char text[SL_RULE_TEXT];
    const bool constant = width == 0 && height == 0;
    sl_environment sky = {.present = true, .width = width, .height = height};
    if (constant) {
        sky.constant = colour(radiance);
        for (int c = 0; c < 3; c++) {
            if (!sl_is_within("radiance", (double)radiance[c], 0.0, (double)FLT_MAX, text))
                return sl_fail(error, SL_ERROR_INPUT, "environment: %s", text);
        }
    } else {
        if (!sl_is_within("width", width, 1.0, LARGEST_TEXTURE, text) ||
            !sl_is_within("height", height, 1.0, LARGEST_TEXTURE, text))
            return sl_fail(error, SL_ERROR_INPUT, "environment: %s", text);
        const size_t texels = (size_t)width * (size_t)height;
        bool copied = true;
        sky.texels = copy_of(radiance, 3 * texels * sizeof(float), &copied);
        if (!copied) return sl_fail_memory(error, "the environment");
    }
    *taken = sky;
    return SL_OK;
}

sl_status sl_scene_builder_environment(sl_scene_builder *b, int width, int height, const float *radiance,
                                       sl_error *error) {
    sl_environment sky;
    sl_status status = check_usable(b, radiance, "a builder and the radiance of its sky", error);
    if (status == SL_OK) status = sl_sky_take(width, height, radiance, &sky, error);
    if (status != SL_OK) return status;
    sl_environment_release(&b->model.scene.environment);
    b->model.scene.environment = sky;
    return SL_OK;
}

/* ---- camera and film ------------------------------------------------------------------------- */

sl_status sl_view_take(const float eye[3], const float target[3], const float up[3], float vertical_fov_rad,
                       sl_camera *camera, sl_error *error) {
    if (!(vertical_fov_rad >= (float)sl_radians(SL_LEAST_FOV_DEG) &&
          vertical_fov_rad <= (float)sl_radians(SL_MOST_FOV_DEG)))
        return sl_fail(error, SL_ERROR_INPUT, "camera: expected 'fov_deg' from %g to %g, got %.10g",
                       SL_LEAST_FOV_DEG, SL_MOST_FOV_DEG, (double)vertical_fov_rad / sl_radians(1.0));
    if (!sl_camera_look_at(camera, sl_v3_of(eye), sl_v3_of(target), sl_v3_of(up), vertical_fov_rad))
        return sl_fail(error, SL_ERROR_INPUT, "camera: %s", SL_EXPECTED_VIEW);
    return SL_OK;
}

sl_status sl_scene_builder_camera(sl_scene_builder *b, const float eye[3], const float target[3],
                                  const float up[3], float vertical_fov_rad, sl_error *error) {
    sl_camera camera;
    sl_status status = check_usable(b, eye && target && up, "a builder and three vectors", error);
    if (status == SL_OK) status = sl_view_take(eye, target, up, vertical_fov_rad, &camera, error);
    if (status != SL_OK) return status;
    b->model.has_camera = true;
    b->model.camera = camera;
    return SL_OK;
}

sl_status sl_scene_builder_film(sl_scene_builder *b, int width, int height, sl_error *error) {
    char text[SL_RULE_TEXT];
    sl_status status = check_usable(b, true, "a builder", error);
    if (status != SL_OK) return status;
    if (!sl_is_within("width", width, 1.0, SL_LARGEST_FILM, text) ||
        !sl_is_within("height", height, 1.0, SL_LARGEST_FILM, text))
        return sl_fail(error, SL_ERROR_INPUT, "film: %s", text);
    b->model.scene.film_width = width;
    b->model.scene.film_height = height;
    return SL_OK;
}

/* ---- the whole ------------------------------------------------------------------------------- */

sl_status sl_scene_builder_create(sl_scene_builder **builder, sl_error *error) {
    if (!builder) return sl_fail_null(error, "a place for a builder");
    *builder = sl_allocate(1, sizeof **builder);
    if (!*builder) return sl_fail_memory(error, "a builder");
    (*builder)->model.keeps_dark_lights = true;
    return SL_OK;
}

static void release_all(sl_scene_builder *b) {
    for (size_t i = 0; i < b->mesh_count; i++) release_mesh(&b->meshes[i]);
    sl_free(b->meshes);
    b->meshes = NULL;
    b->mesh_count = 0;
    sl_model_clear(&b->model);
}

void sl_scene_builder_destroy(sl_scene_builder *builder) {
    if (builder) release_all(builder);
    sl_free(builder);
}

sl_status sl_scene_builder_build(sl_scene_builder *b, sl_scene **scene, sl_error *error) {
    if (scene) *scene = NULL;
    sl_status status = check_usable(b, scene, "a builder and a place for its scene", error);
    if (status != SL_OK) return status;
    b->built = true;
    status = sl_model_build(&b->model, scene, error);
    release_all(b);
    return status;
}
