#include "scene/import_reply.h"

#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "scene/scene.h"

/* Once anything is amiss there is no more: all further words are 0. */
typedef struct reader {
    uint32_t *at, *end;
    bool amiss, starved;
    char none[1]; /* a text that is empty */
} reader;

static uint32_t fail(reader *r) {
    r->amiss = true;
    r->at = r->end;
    return 0;
}

static uint32_t *take(reader *r, uint64_t words) {
    if (words > (uint64_t)(r->end - r->at)) {
        fail(r);
        return NULL;
    }
    uint32_t *from = r->at;
    r->at += words;
    return from;
}

static uint32_t take_word(reader *r) {
    const uint32_t *word = take(r, 1);
    return word ? *word : 0;
}

static uint32_t take_below(reader *r, uint32_t limit) {
    uint32_t value = take_word(r);
    return value < limit ? value : fail(r);
}

static const float *take_floats(reader *r, uint64_t count) {
    return (const float *)(const void *)take(r, count);
}

static void copy_floats(reader *r, float *to, unsigned count) {
    const float *from = take_floats(r, count);
    if (from) memcpy(to, from, count * sizeof *to);
}

static float take_float(reader *r) {
    float value = 0.0f;
    copy_floats(r, &value, 1);
    return value;
}

static char *take_text(reader *r) {
    uint32_t length = take_word(r);
    char *text = (char *)take(r, (uint64_t)length / 4 + 1);
    if (text && memchr(text, 0, (size_t)length + 1) == text + length) return text;
    fail(r);
    return r->none;
}

/* A list of elements that take so many words each at least: no more of them than there can be. */
static void *take_list(reader *r, size_t size, size_t least_words, uint32_t *count) {
    *count = take_word(r);
    if (*count > (size_t)(r->end - r->at) / least_words) *count = fail(r);
    void *list = sl_allocate(*count, size);
    r->starved |= !list;
    if (!list) *count = fail(r);
    return list;
}

/* ---- parts --------------------------------------------------------------------------------------------- */

static void take_files(reader *r, sl_import *in) {
    in->files = take_list(r, sizeof *in->files, 2, &in->file_count);
    for (uint32_t i = 0; i < in->file_count; i++) in->files[i] = take_text(r);
}

static void take_textures(reader *r, sl_import *in) {
    in->textures = take_list(r, sizeof *in->textures, 2, &in->texture_count);
    for (sl_import_texture *t = in->textures; t < in->textures + in->texture_count; t++) {
        t->compressed = take_below(r, 2);
        t->bytes = take_word(r);
        t->data = take(r, ((uint64_t)t->bytes + 3) / 4);
    }
}

static void take_material(reader *r, sl_import_material *m) {
    m->name = take_text(r);
    m->has = take_below(r, 1u << SL_IMPORT_FIELDS);
    copy_floats(r, m->value[0], SL_IMPORT_FIELDS * SL_IMPORT_FIELD_NUMBERS);
    uint32_t names = take_below(r, 2u << SL_IMPORT_MAPS);
    if (names & 1) m->alpha_mode = take_text(r);
    for (int i = 0; i < SL_IMPORT_MAPS; i++) {
        if (names & 2u << i) m->map[i] = take_text(r);
    }
}

static void take_mesh(reader *r, const sl_import *in, sl_import_mesh *m) {
    m->name = take_text(r);
    m->material = take_below(r, in->material_count);
    m->flags = take_below(r, SL_IMPORT_MESH_FLAGS);
    m->vertex_count = take_word(r);
    m->triangle_count = take_word(r);
    m->positions = take_floats(r, 3 * (uint64_t)m->vertex_count);
    if (m->flags & SL_IMPORT_NORMALS) m->normals = take_floats(r, 3 * (uint64_t)m->vertex_count);
    for (int i = 0; i < SL_IMPORT_UV_SETS; i++) {
        if (m->flags & (uint32_t)SL_IMPORT_UVS << i)
            m->uvs[i] = take_floats(r, 2 * (uint64_t)m->vertex_count);
    }
    m->corners = take(r, 3 * (uint64_t)m->triangle_count);
}

static void take_node(reader *r, const sl_import *in, uint32_t index) {
    sl_import_node *n = &in->nodes[index];
    n->parent = take_word(r);
    if (index == 0 ? n->parent != SL_NO_INDEX : n->parent >= index) fail(r);
    n->name = take_text(r);
    n->transform = take_floats(r, 12);
    n->mesh_count = take_word(r);
    n->mesh = take(r, n->mesh_count);
    for (uint32_t i = 0; n->mesh && i < n->mesh_count; i++) {
        if (n->mesh[i] >= in->mesh_count) fail(r);
    }
}

static void take_light(reader *r, sl_import_light *l) {
    l->name = take_text(r);
    l->type = take_below(r, SL_IMPORT_LIGHT_TYPES);
    copy_floats(r, l->position, 3);
    copy_floats(r, l->direction, 3);
    copy_floats(r, l->colour, 3);
    l->quadratic = take_float(r);
    l->inner = take_float(r);
    l->outer = take_float(r);
}

static void take_camera(reader *r, sl_import_camera *c) {
    c->name = take_text(r);
    copy_floats(r, c->position, 3);
    copy_floats(r, c->direction, 3);
    copy_floats(r, c->up, 3);
    c->horizontal_fov = take_float(r);
    c->aspect = take_float(r);
    c->orthographic_width = take_float(r);
}

static void take_scene(reader *r, sl_import *in) {
    take_textures(r, in);
    in->materials = take_list(r, sizeof *in->materials, 5 + SL_IMPORT_FIELDS * SL_IMPORT_FIELD_NUMBERS,
                              &in->material_count);
    for (uint32_t i = 0; i < in->material_count; i++) take_material(r, &in->materials[i]);
    in->meshes = take_list(r, sizeof *in->meshes, 6, &in->mesh_count);
    for (uint32_t i = 0; i < in->mesh_count; i++) take_mesh(r, in, &in->meshes[i]);
    in->nodes = take_list(r, sizeof *in->nodes, 16, &in->node_count);
    for (uint32_t i = 0; i < in->node_count; i++) take_node(r, in, i);
    in->lights = take_list(r, sizeof *in->lights, 15, &in->light_count);
    for (uint32_t i = 0; i < in->light_count; i++) take_light(r, &in->lights[i]);
    in->cameras = take_list(r, sizeof *in->cameras, 14, &in->camera_count);
    for (uint32_t i = 0; i < in->camera_count; i++) take_camera(r, &in->cameras[i]);
    if (in->node_count == 0) fail(r);
}

/* ---- the whole ----------------------------------------------------------------------------------------- */

uint64_t sl_import_reply_bytes(const void *header) {
    uint32_t word[4];
    memcpy(word, header, sizeof word);
    uint64_t bytes = (uint64_t)word[3] << 32 | word[2];
    bool begins = word[0] == SL_IMPORT_MAGIC && word[1] == SL_IMPORT_VERSION && bytes % 4 == 0 &&
                  bytes >= SL_IMPORT_HEADER_BYTES;
    return begins ? bytes : 0;
}

sl_status sl_import_reply_read(const char *path, void *reply, size_t size, sl_import *in, sl_error *error) {
    *in = (sl_import){.text = ""};
    uint32_t *words = reply;
    reader r = {.at = words, .end = words + size / 4};
    if (size < SL_IMPORT_HEADER_BYTES || sl_import_reply_bytes(reply) != size) fail(&r);
    take(&r, SL_IMPORT_HEADER_BYTES / 4);
    in->outcome = (sl_import_outcome)take_below(&r, SL_IMPORT_OUTCOMES);
    in->text = take_text(&r);
    take_files(&r, in);
    if (in->outcome == SL_IMPORT_READ) take_scene(&r, in);
    if (take_word(&r) != SL_IMPORT_MAGIC || r.at != r.end) fail(&r);
    if (r.starved) return sl_fail_memory(error, path);
    if (r.amiss) {
        return sl_fail(error, SL_ERROR_INPUT,
                       "%s: cannot be read: the importer of mesh files went astray, what it answers makes no "
                       "sense; expected a sound file",
                       path);
    }
    return SL_OK;
}

void sl_import_release(sl_import *in) {
    sl_free(in->files);
    sl_free(in->textures);
    sl_free(in->materials);
    sl_free(in->meshes);
    sl_free(in->nodes);
    sl_free(in->lights);
    sl_free(in->cameras);
    *in = (sl_import){.text = ""};
}
