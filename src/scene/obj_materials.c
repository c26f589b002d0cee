#include "scene/obj_materials.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "scene/file.h"
#include "scene/lines.h"

/* ---- the table ---------------------------------------------------------------------------------------- */

sl_status sl_obj_materials_find(sl_obj_materials *m, const char *name, unsigned long line, uint32_t *index,
                                sl_error *error) {
    uint32_t number;
    if (!*name) name = "DefaultMaterial";
    if (!sl_make_room(&m->material, m->count, &m->material_room, sizeof *m->material) ||
        !sl_names_find(&m->names, name, &number))
        return sl_fail_memory(error, "the materials");
    *index = m->first + number;
    sl_status status = SL_OK;
    if (number == m->count) {
        sl_material grey = sl_grey_material(name, 0.6f);
        grey.bump_depth = SL_BUMP_DEPTH;
        m->material[m->count++].line = line;
        status = sl_model_add_material(m->model, &grey, index, error);
    }
    if (line == 0) m->material[number].line = 0;
    return status;
}

void sl_obj_materials_finish(sl_obj_materials *m) {
    for (size_t i = 0; i < m->count; i++) {
        sl_material *made = &m->model->scene.materials[m->first + i];
        if (!m->material[i].may_mirror || sl_material_is_diffuse(made)) continue;
        made->mirror = made->specular;
        made->specular = sl_grey(0.0f);
    }
}

void sl_obj_materials_release(sl_obj_materials *m) {
    sl_free(m->material);
    sl_names_release(&m->names);
}

/* ---- values ------------------------------------------------------------------------------------------- */

typedef enum kind { NAME, COLOUR, EXPONENT, OPACITY, ILLUM, TEXTURE, MASK, HEIGHTS, UNUSED } kind;

typedef struct statement {
    const char *word;
    kind kind;
    float most;
    size_t colour;    /* where in sl_material it is */
    const char *text; /* what is expected, or what is not used */
} statement;

#define COLOUR_OF(field) \
    COLOUR, FLT_MAX, offsetof(sl_material, field), "a colour: 1 or 3 numbers of at least 0"
static const statement statements[] = {
    {"newmtl", NAME, 0.0f, 0, ""},
    {"Kd", COLOUR_OF(diffuse)},
    {"Ks", COLOUR_OF(specular)},
    {"Ke", COLOUR_OF(emission)},
    {"Ns", EXPONENT, (float)SL_LARGEST_EXPONENT, 0, "an exponent Ns: a number from 0 to 1000000"},
    {"d", OPACITY, 1.0f, 0, "an opacity d: a number from 0 to 1"},
    {"Tr", OPACITY, 1.0f, 0, "a transparency Tr: a number from 0 to 1"},
    {"illum", ILLUM, 10.0f, 0, "an illumination model illum: a number from 0 to 10"},
    {"map_Kd", TEXTURE, 0.0f, 0, ""},
    {"map_d", MASK, 0.0f, 0, ""},
    {"map_bump", HEIGHTS, 0.0f, 0, ""},
    {"bump", HEIGHTS, 0.0f, 0, ""},
    {"norm", UNUSED, 0.0f, 0, "a normal map"},
    {"disp", UNUSED, 0.0f, 0, "a displacement map"},
    {"refl", UNUSED, 0.0f, 0, "a reflection map"},
    {"map_Ks", UNUSED, 0.0f, 0, "a texture of Ks"},
    {"map_Ns", UNUSED, 0.0f, 0, "a texture of Ns"},
    {"map_Ke", UNUSED, 0.0f, 0, "a texture of Ke"},
    {"map_Pr", UNUSED, 0.0f, 0, "a texture of roughness"},
    {"map_Pm", UNUSED, 0.0f, 0, "a texture of metalness"},
};
enum { STATEMENTS = sizeof statements / sizeof statements[0] };

typedef struct reader {
    sl_lines lines;
    sl_obj_materials *materials;
    uint32_t current; /* SL_NO_INDEX before the first newmtl */
    unsigned told;    /* which statements that are not used, bit by bit */
} reader;

static sl_material *current(const reader *r) { return &r->materials->model->scene.materials[r->current]; }

static void warn(const reader *r, const char *what, const char *of, const char *why) {
    sl_scene_warn(&r->materials->model->scene, "%s:%lu: %s%s%s", r->lines.path, r->lines.line, what, of, why);
}

/* Reads a colour: one number stands for all three. */
static sl_status read_colour(reader *r, const statement *s, char *at) {
    float value[3];
    int count = 0;
    for (char *end; !sl_is_line_end(at) && count < 3; at = end, count++) {
        end = sl_read_number(at, &value[count]);
        if (!end || !(value[count] >= 0.0f && value[count] <= s->most))
            return sl_lines_fail(&r->lines, s->text, at);
    }
    if (count != 1 && count != 3)
        return sl_fail(r->lines.error, SL_ERROR_INPUT, "%s:%lu: expected %s, got %d", r->lines.path,
                       r->lines.line, s->text, count);
    if (!sl_is_line_end(at)) warn(r, "what stands behind the third number of ", s->word, " is not used");
    const sl_rgb colour = count == 3 ? (sl_rgb){value[0], value[1], value[2]} : sl_grey(value[0]);
    memcpy((char *)current(r) + s->colour, &colour, sizeof colour);
    return SL_OK;
}

/* Uses a number. Whatever is seen through is drawn opaque. */
static void set_number(reader *r, const statement *s, float value) {
    sl_scene *scene = &r->materials->model->scene;
    const bool transparent = s->kind == OPACITY && (sl_word_is(s->word, "Tr") ? value > 0.0f : value < 1.0f);
    if (s->kind == EXPONENT) current(r)->exponent = value;
    if (s->kind == ILLUM)
        r->materials->material[r->current - r->materials->first].may_mirror =
            floorf(value) == 3.0f || floorf(value) == 5.0f;
    if (transparent)
        sl_scene_warn(scene, "%s: material '%s' is transparent, which is not modelled: it is drawn opaque",
                      r->materials->path, current(r)->name);
}

/* Reads a number. An exponent that is negative, as some exporters write it for what is dull, or so large that
 * no picture tells is cut to its limits. -halo says where more of an opacity is seen through. */
static sl_status read_number(reader *r, const statement *s, char *at) {
    float value;
    if (s->kind == OPACITY && sl_word_is(at, "-halo")) at = sl_word_after(at);
    char *end = sl_read_number(at, &value);
    if (!end || isnan(value) || !sl_is_line_end(end)) return sl_lines_fail(&r->lines, s->text, at);
    const bool beyond = !(value >= 0.0f && value <= s->most);
    if (beyond && s->kind != EXPONENT) return sl_lines_fail(&r->lines, s->text, at);
    *sl_word_end(at) = 0;
    if (beyond) warn(r, "exponent Ns ", at, " is not from 0 to 1000000; cut to that");
    set_number(r, s, fminf(fmaxf(value, 0.0f), s->most));
    return SL_OK;
}

/* ---- textures ----------------------------------------------------------------------------------------- */

/* Options of textures; behind the first ones stands a word, behind the others numbers. */
static const char *const options[] = {"-blendu", "-blendv", "-clamp", "-cc", "-imfchan", "-type", "-texres",
                                      "-boost",  "-bm",     "-mm",    "-o",  "-s",       "-t"};
enum { OPTIONS = sizeof options / sizeof options[0], OF_A_WORD = 6, MOST_NUMBERS = 3 };

/* Passes over an option, if there is one; the file's name comes last. */
static bool skip_option(reader *r, char **at) {
    float unused;
    int i = 0;
    while (i < OPTIONS && !sl_word_is(*at, options[i])) i++;
    if (i == OPTIONS) return false;
    char *value = sl_word_after(*at), *next = sl_word_after(value);
    for (int k = 0; k < (i < OF_A_WORD ? 1 : MOST_NUMBERS) && !sl_is_line_end(next) &&
                    (i < OF_A_WORD || sl_read_number(value, &unused));
         k++)
        value = next, next = sl_word_after(value);
    warn(r, "the texture's option ", options[i], " is not applied");
    *at = value;
    return true;
}

/* Cuts a name where a comment begins, unless there is a file of the whole. */
static sl_status cut_name(reader *r, char *name) {
    char *path = sl_file_beside(r->materials->path, name);
    if (!path) return sl_fail_memory(r->lines.error, "a file name");
    char *comment = sl_file_exists(path) ? NULL : name;
    sl_free(path);
    while (comment && (comment = strchr(comment, '#')) && comment > name &&
           sl_word_end(comment - 1) != comment - 1)
        comment++;
    if (!comment) return SL_OK;
    while (comment > name && (comment[-1] == ' ' || comment[-1] == '\t')) comment--;
    *comment = 0;
    return SL_OK;
}

/* Tells whether a picture's colours are unit normals, as (n + 1) / 2, that mostly point away from the
 * surface: exporters put such maps where heights are meant. */
static bool holds_normals(const sl_texture *t) {
    const size_t texels = (size_t)t->width * (size_t)t->height;
    size_t unit = 0;
    for (size_t i = 0; i < texels; i++) {
        const uint8_t *p = t->texels + 4 * i;
        const double x = p[0] / 127.5 - 1.0, y = p[1] / 127.5 - 1.0, z = p[2] / 127.5 - 1.0,
                     square = x * x + y * y + z * z;
        unit += z > 0.0 && square > 0.7 && square < 1.3 && p[2] > p[0] && p[2] > p[1];
    }
    return (double)unit > 0.9 * (double)texels;
}

static void use_texture(reader *r, const statement *s, uint32_t texture) {
    sl_scene *scene = &r->materials->model->scene;
    if (s->kind == TEXTURE) current(r)->texture = texture;
    if (s->kind == MASK) current(r)->alpha_texture = texture;
    if (s->kind != HEIGHTS || texture == SL_NO_INDEX) return;
    if (holds_normals(&scene->textures[texture]))
        sl_scene_warn(scene, "%s: material '%s': its bump map holds normals, not heights, and is not used",
                      r->materials->path, current(r)->name);
    else current(r)->height_map = texture;
}

static sl_status read_texture(reader *r, const statement *s, char *at) {
    uint32_t texture;
    sl_error problem;
    while (skip_option(r, &at)) {}
    sl_status status = cut_name(r, at);
    if (status != SL_OK) return status;
    if (!*at) {
        warn(r, s->word, " names no file", "");
        return SL_OK;
    }
    status = sl_model_texture_beside(r->materials->model, r->materials->path, at, &texture, &problem);
    if (status == SL_OK) use_texture(r, s, texture);
    else if (status == SL_ERROR_INPUT)
        sl_fail(r->lines.error, status, "%s:%lu: texture %s", r->lines.path, r->lines.line, problem.message);
    else sl_fail(r->lines.error, status, "%s", problem.message);
    return status;
}

/* ---- the library -------------------------------------------------------------------------------------- */

static sl_status read_statement(reader *r, char *at) {
    int i = 0;
    while (i < STATEMENTS && !sl_word_is(at, statements[i].word)) i++;
    if (i == STATEMENTS || (r->current == SL_NO_INDEX && statements[i].kind != NAME)) return SL_OK;
    const statement *s = &statements[i];
    char *rest = sl_word_after(at);
    switch (s->kind) {
    case NAME: return sl_obj_materials_find(r->materials, rest, 0, &r->current, r->lines.error);
    case COLOUR: return read_colour(r, s, rest);
    case EXPONENT:
    case OPACITY:
    case ILLUM: return read_number(r, s, rest);
    case UNUSED: break;
    default: return read_texture(r, s, rest);
    }
    char what[64];
    snprintf(what, sizeof what, "%s, %s,", s->word, s->text);
    if (!(r->told >> i & 1u)) warn(r, what, " is not used", "");
    r->told |= 1u << i;
    return SL_OK;
}

sl_status sl_obj_materials_read(sl_obj_materials *m, const char *path, sl_error *error) {
    reader r = {.materials = m, .current = SL_NO_INDEX};
    char *text, *line;
    sl_status status = sl_lines_open(path, &text, &r.lines, error);
    while (status == SL_OK && (line = sl_lines_next(&r.lines))) status = read_statement(&r, line);
    sl_free(text);
    return status;
}
