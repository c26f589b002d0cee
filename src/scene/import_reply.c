#include "scene/import_reply.h"

#include <string.h>

#include "base/error.h"
#include "base/memory.h"

/* One description serves both ways: pass() writes what it is given, or reads into it. Once anything is amiss
 * there is no more to be read: all that follows is 0. */
typedef struct stream {
    bool reads;
    FILE *to; /* NULL: bytes are counted alone */
    uint64_t bytes;
    const char *at, *end; /* what is left to be read */
    bool amiss;
    sl_model *model;
    size_t first_material, first_object; /* of the model, when reading began */
    uint32_t *texture;                   /* the model's, of each of the reply's */
    size_t texture_count;
    sl_status status; /* of adding to the model */
    sl_error *error;
} stream;

static void pass(stream *s, void *data, uint64_t size) {
    if (!s->reads) {
        s->bytes += size;
        if (s->to && size) fwrite(data, 1, size, s->to);
    } else if (size <= (uint64_t)(s->end - s->at)) {
        if (size) memcpy(data, s->at, size);
        s->at += size;
    } else {
        s->amiss = true;
        s->at = s->end;
        if (size) memset(data, 0, size);
    }
}

static uint32_t pass_word(stream *s, uint32_t word) {
    pass(s, &word, sizeof word);
    return word;
}

/* A number of elements that take so many bytes each at least: no more of them than there can be. */
static uint32_t pass_count(stream *s, size_t count, size_t least_bytes) {
    const uint32_t passed = pass_word(s, (uint32_t)count);
    if (!s->reads || passed <= (size_t)(s->end - s->at) / least_bytes) return passed;
    s->amiss = true;
    s->at = s->end;
    return 0;
}

static uint32_t pass_below(stream *s, uint32_t value, size_t limit) {
    const uint32_t passed = pass_word(s, value);
    if (!s->reads || passed < limit) return passed;
    s->amiss = true;
    return 0;
}

static const char *pass_text(stream *s, const char *text) {
    const uint32_t bytes = pass_count(s, strlen(text) + 1, 1);
    if (!s->reads) {
        pass(s, (char *)(uintptr_t)text, bytes); /* which is not written to */
        return text;
    }
    const char *found = s->at;
    s->at += bytes;
    if (bytes && memchr(found, 0, bytes) == found + bytes - 1) return found;
    s->amiss = true;
    return "";
}

/* Tells whether an element that has been read is to be added. */
static bool adds(const stream *s) { return s->reads && !s->amiss && s->status == SL_OK; }

/* ---- lists --------------------------------------------------------------------------------------------- */

static void pass_texts(stream *s) {
    sl_scene *scene = &s->model->scene;
    uint32_t count = pass_count(s, scene->file_count, 4);
    for (uint32_t i = 0; i < count; i++) {
        const char *file = pass_text(s, s->reads ? "" : scene->files[i]);
        if (adds(s)) s->status = sl_model_note_file(s->model, file, s->error);
    }
    count = pass_count(s, scene->warning_count, 4);
    for (uint32_t i = 0; i < count; i++) {
        const char *line = pass_text(s, s->reads ? "" : scene->warnings[i]);
        if (adds(s)) sl_scene_warn(scene, "%s", line);
    }
    const uint32_t left_out = pass_word(s, (uint32_t)scene->warnings_left_out);
    if (adds(s) && left_out) sl_scene_leave_out_warnings(scene, left_out);
}

static void pass_texture(stream *s, uint32_t i) {
    sl_texture t = s->reads ? (sl_texture){0} : s->model->scene.textures[i];
    const char *name = pass_text(s, s->reads ? "" : t.file);
    t.width = (int)pass_below(s, (uint32_t)t.width, INT32_MAX);
    t.height = (int)pass_below(s, (uint32_t)t.height, INT32_MAX);
    t.has_alpha = pass_below(s, t.has_alpha, 2);
    const uint64_t bytes = 4 * (uint64_t)t.width * (uint64_t)t.height;
    if (s->reads) {
        s->amiss |= !bytes || bytes > (uint64_t)(s->end - s->at);
        t.texels = adds(s) ? sl_allocate_unset(bytes, 1) : NULL;
        if (adds(s) && !t.texels) s->status = sl_fail_memory(s->error, "the textures");
        if (!adds(s)) return;
    }
    pass(s, t.texels, bytes);
    if (s->reads) s->status = sl_model_add_texture(s->model, name, &t, &s->texture[i], s->error);
}

static void pass_textures(stream *s) {
    const uint32_t count = pass_count(s, s->model->scene.texture_count, 20);
    s->texture_count = count;
    s->texture = s->reads ? sl_allocate(count, sizeof *s->texture) : NULL;
    if (s->reads && !s->texture) s->status = sl_fail_memory(s->error, "the textures");
    for (uint32_t i = 0; i < count && s->status == SL_OK && !s->amiss; i++) pass_texture(s, i);
}

/* 0 stands for none. */
static uint32_t pass_texture_index(stream *s, uint32_t index) {
    const uint32_t number = pass_below(s, index == SL_NO_INDEX ? 0 : index + 1, s->texture_count + 1);
    return !number || !adds(s) ? SL_NO_INDEX : s->texture[number - 1];
}

static void pass_materials(stream *s) {
    const uint32_t count = pass_count(s, s->model->scene.material_count, 60);
    for (uint32_t i = 0, index; i < count; i++) {
        sl_material m = s->reads ? sl_grey_material("", 0.0f) : s->model->scene.materials[i];
        m.name = (char *)(uintptr_t)pass_text(s, s->reads ? "" : m.name);
        pass(s, &m.diffuse, offsetof(sl_material, emission_two_sided) - offsetof(sl_material, diffuse));
        m.emission_two_sided = pass_below(s, m.emission_two_sided, 2);
        m.texture = pass_texture_index(s, m.texture);
        m.alpha_texture = pass_texture_index(s, m.alpha_texture);
        if (adds(s)) s->status = sl_model_add_material(s->model, &m, &index, s->error);
    }
}

static void pass_objects(stream *s) {
    const uint32_t count = pass_count(s, s->model->scene.object_count, 4);
    for (uint32_t i = 0, index; i < count; i++) {
        const char *name = pass_text(s, s->reads ? "" : s->model->scene.object_names[i]);
        if (adds(s)) s->status = sl_model_add_object(s->model, name, &index, s->error);
    }
}

static void shift(stream *s, uint32_t *index, size_t count, size_t by, size_t limit) {
    for (size_t i = 0; i < count; i++) {
        s->amiss |= index[i] >= limit;
        index[i] += (uint32_t)by;
    }
}

static void pass_triangles(stream *s, size_t materials, size_t objects) {
    sl_model *m = s->model;
    const uint32_t vertices = pass_count(s, m->vertex_count, 32);
    const uint32_t triangles = pass_count(s, m->triangle_count, 20);
    size_t vertex = 0, first = 0;
    if (!vertices || !triangles) return;
    if (adds(s)) s->status = sl_model_add_vertices(m, vertices, &vertex, s->error);
    if (adds(s)) s->status = sl_model_add_triangles(m, triangles, &first, s->error);
    if (s->reads && !adds(s)) return;
    pass(s, m->positions + 3 * vertex, 12 * (uint64_t)vertices);
    pass(s, m->normals + 3 * vertex, 12 * (uint64_t)vertices);
    pass(s, m->uvs + 2 * vertex, 8 * (uint64_t)vertices);
    pass(s, m->indices + 3 * first, 12 * (uint64_t)triangles);
    pass(s, m->material_index + first, 4 * (uint64_t)triangles);
    pass(s, m->object_index + first, 4 * (uint64_t)triangles);
    if (!s->reads) return;
    shift(s, m->indices + 3 * first, 3 * (size_t)triangles, vertex, vertices);
    shift(s, m->material_index + first, triangles, s->first_material, materials);
    shift(s, m->object_index + first, triangles, s->first_object, objects);
}

static void pass_lights(stream *s) {
    const uint32_t count = pass_count(s, s->model->scene.light_count, sizeof(sl_light));
    for (uint32_t i = 0, index; i < count; i++) {
        sl_light l = s->reads ? (sl_light){0} : s->model->scene.lights[i];
        pass(s, &l, sizeof l);
        s->amiss |= (unsigned)l.type > SL_LIGHT_DIRECTIONAL;
        if (adds(s)) s->status = sl_model_add_light(s->model, &l, &index, s->error);
    }
}

/* The model keeps the camera that it has. */
static void pass_camera(stream *s) {
    sl_model *m = s->model;
    sl_camera camera = m->camera;
    const bool has_one = pass_below(s, m->has_camera, 2);
    if (has_one) pass(s, &camera, sizeof camera);
    if (!adds(s) || !has_one || m->has_camera) return;
    m->camera = camera;
    m->has_camera = true;
}

static void pass_model(stream *s) {
    pass_textures(s);
    if (s->status != SL_OK) return;
    pass_materials(s);
    pass_objects(s);
    pass_triangles(s, s->model->scene.material_count - s->first_material,
                   s->model->scene.object_count - s->first_object);
    pass_lights(s);
    pass_camera(s);
}

/* ---- the whole ----------------------------------------------------------------------------------------- */

static void write_all(stream *s, uint64_t bytes, sl_status status, const char *message) {
    s->bytes = 0;
    pass_word(s, SL_IMPORT_MAGIC);
    pass_word(s, SL_IMPORT_VERSION);
    pass(s, &bytes, sizeof bytes);
    pass_word(s, status);
    pass_text(s, message);
    pass_texts(s);
    if (status == SL_OK) pass_model(s);
    pass_word(s, SL_IMPORT_MAGIC);
}

bool sl_import_reply_write(FILE *to, sl_status status, const char *message, sl_model *model) {
    stream s = {.model = model};
    write_all(&s, 0, status, message);
    s.to = to;
    write_all(&s, s.bytes, status, message);
    return fflush(to) == 0 && !ferror(to);
}

uint64_t sl_import_reply_bytes(const void *header) {
    uint32_t word[2];
    uint64_t bytes;
    memcpy(word, header, sizeof word);
    memcpy(&bytes, (const char *)header + sizeof word, sizeof bytes);
    const bool begins =
        word[0] == SL_IMPORT_MAGIC && word[1] == SL_IMPORT_VERSION && bytes >= SL_IMPORT_HEADER_BYTES;
    return begins ? bytes : 0;
}

sl_status sl_import_reply_read(const char *path, const void *reply, size_t size, sl_model *model,
                               sl_error *error) {
    stream s = {.reads = true,
                .at = reply,
                .end = (const char *)reply + size,
                .model = model,
                .first_material = model->scene.material_count,
                .first_object = model->scene.object_count,
                .error = error};
    s.amiss = size < SL_IMPORT_HEADER_BYTES || sl_import_reply_bytes(reply) != size;
    if (!s.amiss) s.at += SL_IMPORT_HEADER_BYTES;
    const sl_status outcome = (sl_status)pass_below(&s, 0, SL_ERROR_RESOURCES + 1);
    const char *message = pass_text(&s, "");
    s.amiss |= outcome != SL_OK && (outcome < SL_ERROR_USAGE || !*message);
    pass_texts(&s);
    if (outcome == SL_OK && !s.amiss && s.status == SL_OK) pass_model(&s);
    sl_free(s.texture);
    if (s.status != SL_OK) return s.status;
    if (pass_word(&s, 0) == SL_IMPORT_MAGIC && s.at == s.end && !s.amiss)
        return outcome == SL_OK ? SL_OK : sl_fail(error, outcome, "%s", message);
    return sl_fail(
        error, SL_ERROR_INPUT,
        "%s: cannot be read: the importer of mesh files went astray, what it answers makes no sense; "
        "expected a sound file",
        path);
}
