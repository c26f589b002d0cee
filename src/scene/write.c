/* A scene as files: JSON, OBJ and MTL, control points of surfaces, PNG and EXR, that give it again bit for
 * bit.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/print.h"
#include "base/values.h"
#include "image/formats.h"
#include "scene/derive.h"
#include "scene/file.h"
#include "scene/lines.h"
#include "scene/parts.h"

/* Text that grows as it is printed. */
typedef struct text {
    FILE *out; /* NULL: there is no memory for any */
    char *bytes;
    size_t count;
} text;

typedef struct writer {
    const sl_scene *scene;
    char *base;              /* the path without ".json" */
    sl_names materials, objects; /* that files can have, by index, each of another */
    text json;
    size_t meshes;           /* mesh files so far */
    sl_error *error;
} writer;

static FILE *open_text(text *t) { return t->out = open_memstream(&t->bytes, &t->count); }

/* ---- files ----------------------------------------------------------------------------------- */

/* Returns base + suffix, to be freed; NULL without memory. */
static char *path_of(const writer *w, const char *suffix) {
    char *path = sl_allocate(strlen(w->base) + strlen(suffix) + 1, 1);
    if (path) strcat(strcpy(path, w->base), suffix);
    else sl_fail_memory(w->error, "a file name");
    return path;
}

/* Closes the text; false: it is not whole. */
static bool close_text(text *t) {
    const bool whole = t->out && !ferror(t->out);
    const bool closed = t->out && fclose(t->out) == 0;
    t->out = NULL;
    return whole && closed && t->bytes;
}

/* Writes the text to a file of its own and frees it. */
static sl_status write_text(const writer *w, text *t, const char *suffix) {
    char *path = path_of(w, suffix);
    const bool whole = close_text(t);
    sl_status status = !path   ? SL_ERROR_RESOURCES
                       : whole ? sl_output_whole(path, t->bytes, t->count, w->error)
                               : sl_fail_memory(w->error, path);
    sl_free(path);
    free(t->bytes);
    t->bytes = NULL;
    return status;
}

/* ---- names ----------------------------------------------------------------------------------- */

enum { NAME_ROOM = 201 };

/* Replaces what ends, continues or quotes a line or a string by "_", and a blank at an end. */
static void make_plain(char name[NAME_ROOM]) {
    const size_t length = strlen(name);
    for (size_t i = 0; i < length; i++) {
        const bool at_end = i == 0 || i + 1 == length;
        if ((unsigned char)name[i] < ' ' || strchr("\\\"#\x7f", name[i]) || (at_end && name[i] == ' '))
            name[i] = '_';
    }
}

/* Adds a name of its own: one by number, where it is in the list already or empty. */
static bool add_name(sl_names *names, const char *given, const char *kind, size_t number) {
    const size_t before = names->count;
    char name[NAME_ROOM];
    uint32_t place;
    snprintf(name, sizeof name, "%s", given);
    make_plain(name);
    for (; names->count == before; number++) {
        if (*name && !sl_names_find(names, name, &place)) return false;
        snprintf(name, sizeof name, "%s-%zu", kind, number);
    }
    return true;
}

static sl_status make_names(writer *w) {
    const sl_scene *s = w->scene;
    bool made = true;
    for (size_t i = 0; i < s->material_count && made; i++)
        made = add_name(&w->materials, s->materials[i].name, "material", i);
    for (size_t i = 0; i < s->object_count && made; i++)
        made = add_name(&w->objects, s->object_names[i], "object", i);
    return made ? SL_OK : sl_fail_memory(w->error, "the names of materials and objects");
}

/* Puts a string of JSON, in two parts. */
static void put_strings(FILE *t, const char *string, const char *rest) {
    fprintf(t, "\"");
    for (const char *c = string; *c; c++) {
        if (*c == '"' || *c == '\\') fprintf(t, "\\");
        if ((unsigned char)*c < ' ') fprintf(t, "\\u%04x", (unsigned)*c);
        else fputc(*c, t);
    }
    fprintf(t, "%s\"", rest);
}
static void put_string(FILE *t, const char *string) { put_strings(t, string, ""); }

/* Puts the name of a file beside the JSON file. */
static void put_file(writer *w, const char *suffix) {
    put_strings(w->json.out, sl_file_name(w->base), suffix);
}

static void put_number(FILE *t, float value) {
    char number[SL_NUMBER_ROOM];
    fprintf(t, "%s", sl_write_number(value, number));
}

static void put_floats(FILE *t, const char *key, const float *v, int count) {
    fprintf(t, "\"%s\": [", key);
    for (int i = 0; i < count; i++) {
        if (i) fprintf(t, ", ");
        put_number(t, v[i]);
    }
    fprintf(t, "]");
}
static void put_rgb(FILE *t, const char *key, sl_rgb c) {
    put_floats(t, key, (float[3]){c.r, c.g, c.b}, 3);
}
static void put_vec3(FILE *t, const char *key, sl_vec3 v) {
    put_floats(t, key, (float[3]){v.x, v.y, v.z}, 3);
}

/* ---- triangles ------------------------------------------------------------------------------- */

static void put_values(FILE *t, const char *word, const float *values, int count) {
    fprintf(t, "%s", word);
    for (int i = 0; i < count; i++) {
        fprintf(t, " ");
        put_number(t, values[i]);
    }
    fprintf(t, "\n");
}

/* Finds the vertices that triangles from `first` to `end` name: they are together. */
static void range_of(const sl_scene *s, size_t first, size_t end, uint32_t *low, uint32_t *high) {
    *low = UINT32_MAX, *high = 0;
    for (size_t t = first; t < end; t++) {
        for (int c = 0; c < 3; c++) {
            const uint32_t v = s->vertex[c][t];
            *low = v < *low ? v : *low;
            *high = v > *high ? v : *high;
        }
    }
}

static void put_vertices(FILE *out, const sl_scene *s, uint32_t low, uint32_t high) {
    for (uint32_t v = low; v <= high; v++) {
        put_values(out, "v", (float[3]){s->position_x[v], s->position_y[v], s->position_z[v]}, 3);
        put_values(out, "vn", (float[3]){s->normal_x[v], s->normal_y[v], s->normal_z[v]}, 3);
        put_values(out, "vt", (float[2]){s->texture_u[v], s->texture_v[v]}, 2);
    }
}

static void put_library(const writer *w, FILE *out) {
    fprintf(out, "mtllib %s.mtl\n", sl_file_name(w->base));
}

/* With a library triangles name their materials; without, the scene file does. */
static sl_status write_triangles(writer *w, size_t first, size_t end, bool library, const char *suffix) {
    const sl_scene *s = w->scene;
    text out;
    if (!open_text(&out)) return sl_fail_memory(w->error, "a file of the scene");
    uint32_t low, high;
    if (library) put_library(w, out.out);
    range_of(s, first, end, &low, &high);
    put_vertices(out.out, s, low, high);
    for (size_t t = first; t < end; t++) {
        const uint32_t object = s->object_index[t], material = s->material_index[t];
        if (t == first || object != s->object_index[t - 1])
            fprintf(out.out, "o %s\n", w->objects.name[object]);
        if (library && (t == first || material != s->material_index[t - 1]))
            fprintf(out.out, "usemtl %s\n", w->materials.name[material]);
        fprintf(out.out, "f");
        for (int c = 0; c < 3; c++) {
            const uint32_t v = s->vertex[c][t] - low + 1;
            fprintf(out.out, " %u/%u/%u", v, v, v);
        }
        fprintf(out.out, "\n");
    }
    return write_text(w, &out, suffix);
}

/* Triangles that go to one file. */
typedef struct run {
    size_t first, end;
    const sl_bicubic *surface; /* the first of those whose triangles they are */
    size_t surfaces;
    bool library;              /* it has all materials */
} run;

static sl_status write_surfaces(writer *w, const run *r, const char *suffix) {
    text out;
    if (!open_text(&out)) return sl_fail_memory(w->error, "a file of the scene");
    fprintf(out.out, "%zu\n", r->surfaces);
    for (size_t k = 0; k < 16 * r->surfaces; k++) {
        const sl_vec3 p = r->surface[k / 16].point[k % 16 / 4][k % 4];
        fprintf(out.out, "%s%.9g %.9g %.9g\n", k % 16 ? "" : "3 3\n", (double)p.x, (double)p.y, (double)p.z);
    }
    return write_text(w, &out, suffix);
}

static bool are_of_one(const sl_scene *s, size_t t, size_t u) {
    return s->object_index[t] == s->object_index[u] && s->material_index[t] == s->material_index[u];
}

/* Returns the surfaces of one object and material from `first` on. */
static run surfaces_from(const sl_scene *s, size_t first, const sl_bicubic *next) {
    run r = {first, first, next, 0, false};
    for (; next < s->bicubics + s->bicubic_count && next->first_triangle == r.end; next++, r.surfaces++) {
        if (!are_of_one(s, first, r.end)) break;
        r.end += next->triangle_count;
    }
    return r;
}

/* Returns the triangles from `first` on that go to one file: of surfaces; or up to the next one, of one
 * material once there is a library: a second one would have materials of its own. */
static run run_from(const sl_scene *s, size_t first, size_t surfaces, bool has_library) {
    const sl_bicubic *next = surfaces < s->bicubic_count ? &s->bicubics[surfaces] : NULL;
    run r = {first, next ? next->first_triangle : s->triangle_count, NULL, 0, !has_library};
    if (next && first == r.end) return surfaces_from(s, first, next);
    for (size_t t = first; t < r.end && has_library; t++) {
        if (s->material_index[t] != s->material_index[first]) r.end = t;
    }
    return r;
}

static void put_run(writer *w, const run *r, const char *suffix) {
    const sl_scene *s = w->scene;
    fprintf(w->json.out, "%s\n    {\"file\": ", w->meshes ? "," : "");
    put_file(w, suffix);
    if (r->surfaces) {
        fprintf(w->json.out, ", \"name\": ");
        put_string(w->json.out, w->objects.name[s->object_index[r->first]]);
    }
    if (!r->library) {
        fprintf(w->json.out, ", \"material\": ");
        put_string(w->json.out, w->materials.name[s->material_index[r->first]]);
    }
    fprintf(w->json.out, "}");
}

static sl_status write_meshes(writer *w, bool *has_library) {
    const sl_scene *s = w->scene;
    sl_status status = SL_OK;
    fprintf(w->json.out, "  \"meshes\": [");
    for (size_t t = 0, surfaces = 0; t < s->triangle_count && status == SL_OK; w->meshes++) {
        const run r = run_from(s, t, surfaces, *has_library);
        char suffix[48];
        snprintf(suffix, sizeof suffix, "-%zu%s", w->meshes, r.surfaces ? ".bpt" : ".obj");
        status = r.surfaces ? write_surfaces(w, &r, suffix)
                            : write_triangles(w, r.first, r.end, r.library, suffix);
        put_run(w, &r, suffix);
        *has_library = *has_library || r.library;
        surfaces += r.surfaces;
        t = r.end;
    }
    fprintf(w->json.out, "],\n");
    return status;
}

/* ---- materials ------------------------------------------------------------------------------- */

/* Names the materials, whose values are in the JSON file, to the bit. */
static sl_status write_library(writer *w) {
    text out;
    if (!open_text(&out)) return sl_fail_memory(w->error, "a file of the scene");
    for (size_t i = 0; i < w->scene->material_count; i++)
        fprintf(out.out, "newmtl %s\n", w->materials.name[i]);
    return write_text(w, &out, ".mtl");
}

static void texture_suffix(uint32_t texture, char suffix[48]) {
    snprintf(suffix, 48, "-texture-%u.png", texture + 1);
}

/* Scene files name a mirror's reflectance or that of the other lobes. */
static bool is_named(const sl_material_number *n, const sl_material *m) {
    const bool of_mirrors = n->field == offsetof(sl_material, mirror),
               of_others = n->field == offsetof(sl_material, diffuse) ||
                           n->field == offsetof(sl_material, specular);
    return sl_material_is_mirror(m) ? !of_others : !of_mirrors;
}

static void put_material_number(FILE *t, const sl_material_number *n, const sl_material *m) {
    float value[3];
    memcpy(value, (const char *)m + n->field, (size_t)n->floats * sizeof *value);
    fprintf(t, ", ");
    if (n->floats == 3) put_floats(t, n->key, value, 3);
    else fprintf(t, "\"%s\": ", n->key), put_number(t, *value);
}

static void put_texture(writer *w, const sl_material_texture *of, const sl_material *m) {
    char suffix[48];
    uint32_t texture;
    memcpy(&texture, (const char *)m + of->field, sizeof texture);
    fprintf(w->json.out, ", \"%s\": ", of->key);
    texture_suffix(texture, suffix);
    if (texture == SL_NO_INDEX) fprintf(w->json.out, "null");
    else put_file(w, suffix);
}

static void put_material(writer *w, const sl_material *m) {
    fprintf(w->json.out, ": {\"two_sided\": %s", m->emission_two_sided ? "true" : "false");
    for (int i = 0; i < SL_MATERIAL_NUMBERS; i++) {
        if (is_named(&sl_material_numbers[i], m))
            put_material_number(w->json.out, &sl_material_numbers[i], m);
    }
    for (int i = 0; i < SL_MATERIAL_TEXTURES; i++) put_texture(w, &sl_material_textures[i], m);
    fprintf(w->json.out, "}");
}

static bool is_used(const sl_scene *s, size_t material) {
    for (size_t t = 0; t < s->triangle_count; t++) {
        if (s->material_index[t] == material) return true;
    }
    return false;
}

/* Puts all materials; without a library only those that a mesh asks for may be named. */
static void put_materials(writer *w, bool has_library) {
    const char *between = "\n";
    fprintf(w->json.out, "  \"materials\": {");
    for (size_t i = 0; i < w->scene->material_count; i++) {
        if (!has_library && !is_used(w->scene, i)) continue;
        fprintf(w->json.out, "%s    ", between);
        put_string(w->json.out, w->materials.name[i]);
        put_material(w, &w->scene->materials[i]);
        between = ",\n";
    }
    fprintf(w->json.out, "},\n");
}

static sl_status write_texture(const writer *w, uint32_t number) {
    const sl_texture *t = &w->scene->textures[number];
    const size_t texels = (size_t)t->width * (size_t)t->height, channels = t->has_alpha ? 4 : 3;
    char suffix[48];
    texture_suffix(number, suffix);
    char *path = path_of(w, suffix);
    uint8_t *bytes = path ? sl_allocate_unset(texels, channels) : NULL;
    for (size_t i = 0; bytes && i < texels; i++) memcpy(bytes + channels * i, t->texels + 4 * i, channels);
    sl_status status = path ? SL_OK : SL_ERROR_RESOURCES;
    if (path && !bytes) status = sl_fail_memory(w->error, path);
    if (bytes) status = sl_png_file(path, t->width, t->height, (int)channels, bytes, NULL, 0, w->error);
    sl_free(bytes);
    sl_free(path);
    return status;
}

/* ---- light ----------------------------------------------------------------------------------- */

static double degrees_of(float cosine) { return sl_acos((double)cosine) / sl_radians(1.0); }

static void put_light(FILE *t, const sl_light *l) {
    static const char *const types[] = {"point", "spot", "directional"};
    const bool sun = l->type == SL_LIGHT_DIRECTIONAL;
    fprintf(t, "{\"type\": \"%s\", ", types[l->type]);
    put_rgb(t, sun ? "irradiance" : "intensity", l->intensity);
    if (!sun) fprintf(t, ", "), put_vec3(t, "position", l->position);
    if (l->type != SL_LIGHT_POINT) fprintf(t, ", "), put_vec3(t, "direction", l->direction);
    if (l->type == SL_LIGHT_SPOT)
        fprintf(t, ", \"inner_deg\": %.17g, \"outer_deg\": %.17g", degrees_of(l->cos_inner),
            degrees_of(l->cos_outer));
    fprintf(t, "}");
}

static void put_lights(writer *w) {
    fprintf(w->json.out, "  \"lights\": [");
    for (size_t i = 0; i < w->scene->light_count; i++) {
        fprintf(w->json.out, "%s\n    ", i ? "," : "");
        put_light(w->json.out, &w->scene->lights[i]);
    }
    fprintf(w->json.out, "],\n");
}

static sl_status write_sky(writer *w) {
    static const char suffix[] = "-sky.exr";
    const sl_environment *e = &w->scene->environment;
    sl_image *image = NULL;
    if (!e->present) return SL_OK;
    fprintf(w->json.out, "  \"environment\": {");
    if (e->width == 0) {
        put_rgb(w->json.out, "radiance", e->constant);
        fprintf(w->json.out, "},\n");
        return SL_OK;
    }
    fprintf(w->json.out, "\"file\": ");
    put_file(w, suffix);
    fprintf(w->json.out, "},\n");
    char *path = path_of(w, suffix);
    sl_status status =
        path ? sl_image_create(e->width, e->height, 3, NULL, &image, w->error) : SL_ERROR_RESOURCES;
    const size_t texels = (size_t)e->width * (size_t)e->height;
    for (size_t i = 0; image && i < 3 * texels; i++) image->planes[i % 3 * texels + i / 3] = e->texels[i];
    if (status == SL_OK) status = sl_image_write(image, path, w->error);
    sl_image_destroy(image);
    sl_free(path);
    return status;
}

/* ---- the whole ------------------------------------------------------------------------------- */

static void put_view(writer *w) {
    const sl_camera *c = &w->scene->camera;
    FILE *t = w->json.out;
    fprintf(t, "  \"camera\": {");
    put_vec3(t, "eye", c->eye);
    const sl_vec3 x = c->right, y = c->up, z = c->back;
    fprintf(t, ", ");
    put_floats(t, "frame", (float[9]){x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z}, 9);
    fprintf(t, ", \"fov_deg\": %.17g},\n", (double)c->vertical_fov / sl_radians(1.0));
    fprintf(t, "  \"film\": {\"width\": %d, \"height\": %d}\n}\n", w->scene->film_width,
            w->scene->film_height);
}

static sl_status write_all(writer *w) {
    bool has_library = false;
    sl_status status = make_names(w);
    fprintf(w->json.out, "{\n  \"softlux\": 1,\n");
    for (uint32_t i = 0; i < w->scene->texture_count && status == SL_OK; i++) status = write_texture(w, i);
    if (status == SL_OK) status = write_meshes(w, &has_library);
    if (status == SL_OK && has_library) status = write_library(w);
    if (status != SL_OK) return status;
    put_materials(w, has_library);
    put_lights(w);
    status = write_sky(w);
    put_view(w);
    return status == SL_OK ? write_text(w, &w->json, ".json") : status;
}

sl_status sl_scene_write(const sl_scene *scene, const char *path, sl_error *error) {
    if (!scene || !path) return sl_fail_null(error, "a scene and the name of a file");
    const size_t length = strlen(path);
    if (!sl_ends_with(path, ".json"))
        return sl_fail(error, SL_ERROR_USAGE, "cannot write %s: the name must end in .json", path);
    writer w = {.scene = scene, .base = sl_string_copy(path), .error = error};
    if (!w.base) return sl_fail_memory(error, path);
    w.base[length - 5] = 0;
    void *before = sl_c_locale_begin();
    sl_status status = open_text(&w.json) ? write_all(&w) : sl_fail_memory(error, path);
    close_text(&w.json);
    free(w.json.bytes);
    sl_c_locale_end(before);
    sl_names_release(&w.materials);
    sl_names_release(&w.objects);
    sl_free(w.base);
    return status;
}
