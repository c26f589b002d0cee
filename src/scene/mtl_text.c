#include "scene/mtl_text.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/error.h"
#include "base/memory.h"
#include "scene/file.h"

enum { LONGEST_NUMBER = 2000 /* the importer takes longer ones for two */ };

/* One statement at a time, on one line and with a zero behind it. */
typedef struct reader {
    const char *path;
    unsigned long line, next_line; /* of the statement, behind it */
    sl_text statement, *plain;
    bool named;                    /* a newmtl has been */
    unsigned told;                 /* which of the unused statements, bit by bit */
    sl_model *model;
    sl_error *error;
} reader;

static bool is_blank(char c) { return c == ' ' || c == '\t'; }
static bool is_line_end(char c) { return c == '\n' || c == '\r'; }

static const char *skip_blanks(const char *at) {
    while (is_blank(*at)) at++;
    return at;
}
static int word_length(const char *at) { return (int)strcspn(at, " \t"); }
static const char *next_word(const char *at) { return skip_blanks(at + word_length(at)); }
static bool is_word(const char *at, const char *word) {
    return (size_t)word_length(at) == strlen(word) && strncasecmp(at, word, strlen(word)) == 0;
}
static bool is_end(const char *at) { return !*at || *at == '#'; }
static int shown(const char *at) { return word_length(at) < 40 ? word_length(at) : 40; }

static void add(reader *r, const char *text) { sl_text_add(r->plain, text, strlen(text)); }

static sl_status fail(const reader *r, const char *expected, const char *got) {
    return sl_fail(r->error, SL_ERROR_INPUT, "%s:%lu: expected %s, got '%.*s'", r->path, r->line, expected,
                   shown(got), got);
}

/* ---- numbers --------------------------------------------------------------------------------- */

/* Past a number that the importer reads as what it is. */
static const char *number_end(const char *at, double *value) {
    const char *end = sl_text_number_end(at, at + strlen(at));
    if (!end || (!is_blank(*end) && !is_end(end)) || end - at >= LONGEST_NUMBER) return NULL;
    char copy[LONGEST_NUMBER];
    memcpy(copy, at, (size_t)(end - at));
    copy[end - at] = 0;
    char *comma = strchr(copy, ',');
    if (comma) *comma = '.';
    *value = strtod(copy, NULL);
    return end;
}

/* Of a colour of one number green and blue are as red; the importer makes them 0. */
static sl_status add_colour(reader *r, const char *word, const char *at) {
    const char *first = at, *last = at;
    int count = 0;
    double value;
    for (; !is_end(at) && count < 3; at = skip_blanks(last), count++) {
        last = number_end(at, &value);
        if (!last || !(value >= 0.0 && value <= (double)FLT_MAX))
            return fail(r, "a colour: 1 or 3 numbers of at least 0", at);
    }
    if (count != 1 && count != 3)
        return sl_fail(r->error, SL_ERROR_INPUT,
                       "%s:%lu: expected a colour: 1 or 3 numbers of at least 0, got %d", r->path, r->line,
                       count);
    if (!is_end(at) && r->model)
        sl_model_warn(r->model, "%s:%lu: what stands behind the third number of %s is not used", r->path,
                      r->line, word);
    add(r, word);
    for (int i = count; i <= 3; i++) {
        add(r, " ");
        sl_text_add(r->plain, first, (size_t)(last - first));
    }
    return SL_OK;
}

static sl_status add_number(reader *r, const char *word, const char *at, double least, double most,
                            const char *expected) {
    double value;
    const char *end = number_end(at, &value);
    if (!end || !is_end(skip_blanks(end)) || !(value >= least && value <= most)) return fail(r, expected, at);
    add(r, word);
    add(r, " ");
    sl_text_add(r->plain, at, (size_t)(end - at));
    return SL_OK;
}

/* Beyond a scene file's limit it is the limit: no picture tells the two apart. Below 0, which some exporters
 * write for what is dull, it is 0. */
static sl_status add_exponent(reader *r, const char *at) {
    double value;
    if (!number_end(at, &value) || !(value < 0.0 || value > SL_LARGEST_EXPONENT))
        return add_number(r, "Ns", at, 0.0, SL_LARGEST_EXPONENT,
                          "an exponent Ns: a number from 0 to 1000000");
    if (r->model)
        sl_model_warn(r->model, "%s:%lu: exponent Ns %.*s is not from 0 to 1000000; cut to that", r->path,
                      r->line, shown(at), at);
    add(r, value < 0.0 ? "Ns 0" : "Ns 1000000");
    return SL_OK;
}

/* -halo says where more of it is seen through; what can be seen through is drawn opaque, with a warning. */
static sl_status add_opacity(reader *r, const char *word, const char *at) {
    if (is_word(at, "-halo")) at = next_word(at);
    return add_number(r, word, at, 0.0, 1.0,
                      *word == 'd' ? "an opacity d: a number from 0 to 1"
                                   : "a transparency Tr: a number from 0 to 1");
}

/* ---- textures -------------------------------------------------------------------------------- */

/* Numbers or words that may stand behind an option, and what changes nothing here: every number of them, or
 * the word. */
typedef struct option {
    const char *word;
    int least, most;
    const char *none;
} option;

static const option options[] = {{"-blendu", 1, 1, "on"}, {"-blendv", 1, 1, "on"}, {"-clamp", 1, 1, "off"},
                                 {"-cc", 1, 1, "off"},    {"-imfchan", 1, 1, "l"}, {"-type", 1, 1, NULL},
                                 {"-texres", 1, 1, NULL}, {"-boost", 1, 1, "0"},   {"-bm", 1, 1, "1"},
                                 {"-mm", 2, 2, "0 1"},    {"-o", 1, 3, "0 0 0"},   {"-s", 1, 3, "1 1 1"},
                                 {"-t", 1, 3, "0 0 0"}};

static const option *option_at(const char *at) {
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
        if (is_word(at, options[i].word)) return &options[i];
    }
    return NULL;
}

/* Past one option. A number that nothing stands behind is the file's name. */
static sl_status skip_option(reader *r, const option *o, const char **at) {
    const char *none = o->none, *value = next_word(*at);
    bool is_number = o->most > 1 || !none || (*none >= '0' && *none <= '9'), changes = !none;
    if (is_word(*at, "-type")) is_number = false;
    for (int i = 0; i < o->most;
         i++, value = next_word(value), none = none && *none ? next_word(none) : none) {
        double found = 0.0;
        bool fits = !is_end(value) && !is_end(next_word(value)) && (!is_number || number_end(value, &found));
        if (!fits && i >= o->least) break;
        if (!fits) {
            return sl_fail(r->error, SL_ERROR_INPUT,
                           "%s:%lu: expected %s behind %s and then a file's name, got '%.*s'", r->path,
                           r->line,
                           !is_number     ? "a word"
                           : o->most == 1 ? "a number"
                           : o->most == 2 ? "two numbers"
                                          : "1 to 3 numbers",
                           o->word, shown(value), value);
        }
        if (none) changes |= is_number ? found != strtod(none, NULL) : !is_word(value, none);
    }
    if (changes && r->model)
        sl_model_warn(r->model, "%s:%lu: the texture's option %s is not applied", r->path, r->line, o->word);
    *at = value;
    return SL_OK;
}

static sl_status exists(const reader *r, const char *name, bool *there) {
    char *path = sl_file_beside(r->path, name);
    if (!path) return sl_fail_memory(r->error, "a file name");
    *there = sl_file_exists(path);
    sl_free(path);
    return SL_OK;
}

/* A name may have a # in it; if there is no such file that begins a comment. */
static size_t name_length(const char *name) {
    const char *at = name;
    while (*at && !(*at == '#' && (at == name || is_blank(at[-1])))) at++;
    while (at > name && is_blank(at[-1])) at--;
    return (size_t)(at - name);
}

static sl_status add_texture(reader *r, const char *word, const char *at) {
    const option *o;
    sl_status status = SL_OK;
    while (status == SL_OK && (o = option_at(at))) status = skip_option(r, o, &at);
    bool there = false;
    if (status == SL_OK) status = exists(r, at, &there);
    if (status != SL_OK) return status;
    size_t length = there ? strlen(at) : name_length(at);
    if (length == 0) {
        if (r->model) sl_model_warn(r->model, "%s:%lu: %s names no file", r->path, r->line, word);
        return SL_OK;
    }
    add(r, word);
    add(r, *at == '-' ? " ./" : " "); /* the importer would take it for an option */
    sl_text_add(r->plain, at, length);
    return SL_OK;
}

/* ---- statements ------------------------------------------------------------------------------ */

/* A material without a name, as exporters write it, is that of a usemtl without one. */
static void add_name(reader *r, const char *name) {
    r->named = true;
    add(r, "newmtl ");
    add(r, *name ? name : SL_NAMELESS_MATERIAL);
}

/* Of what is seen in other renderers' pictures and not in ours: one line for each kind and library. */
static void tell_unused(reader *r, const char *at) {
    static const char *const unused[][2] = {{"norm", "a normal map"},
                                            {"disp", "a displacement map"},
                                            {"refl", "a reflection map"},
                                            {"map_Ks", "a texture of Ks"},
                                            {"map_Ns", "a texture of Ns"},
                                            {"map_Ke", "a texture of Ke"},
                                            {"map_Pr", "a texture of roughness"},
                                            {"map_Pm", "a texture of metalness"}};
    for (unsigned i = 0; r->model && i < sizeof unused / sizeof unused[0]; i++) {
        if (!is_word(at, unused[i][0]) || (r->told >> i & 1u)) continue;
        r->told |= 1u << i;
        sl_model_warn(r->model, "%s:%lu: %s, %s, is not used", r->path, r->line, unused[i][0], unused[i][1]);
    }
}

/* What no material here has is left out, whatever its values. */
static sl_status add_statement(reader *r, const char *at) {
    static const char *const colours[] = {"Kd", "Ks", "Ke"}, *const textures[] = {"map_Kd", "map_d",
                                                                                  "map_bump", "bump"};
    const char *rest = next_word(at);
    if (is_word(at, "newmtl")) add_name(r, rest);
    if (!r->named) return SL_OK; /* the importer would give it to faces before the first usemtl */
    for (int i = 0; i < 3; i++) {
        if (is_word(at, colours[i])) return add_colour(r, colours[i], rest);
    }
    for (int i = 0; i < 4; i++) {
        if (is_word(at, textures[i])) return add_texture(r, textures[i], rest);
    }
    if (is_word(at, "Ns")) return add_exponent(r, rest);
    if (is_word(at, "d")) return add_opacity(r, "d", rest);
    if (is_word(at, "Tr")) return add_opacity(r, "Tr", rest);
    if (is_word(at, "illum"))
        return add_number(r, "illum", rest, 0.0, 10.0, "an illumination model illum: a number from 0 to 10");
    tell_unused(r, at);
    return SL_OK;
}

static bool is_behind_blank(const sl_text *text) {
    return text->size == 0 || is_blank(text->data[text->size - 1]);
}

static const char *skip_line_end(const char *at, const char *end) {
    return at + (at[0] == '\r' && at + 1 < end && at[1] == '\n' ? 2 : 1);
}

/* A line end behind a backslash is none, but for that of a comment, where a path of Windows may stand. */
static const char *take_statement(reader *r, const char *at, const char *end) {
    bool comment = false;
    r->statement.size = 0;
    r->line = r->next_line;
    while (at < end && !is_line_end(*at)) {
        comment |= *at == '#' && is_behind_blank(&r->statement);
        bool continued = !comment && at[0] == '\\' && at + 1 < end && is_line_end(at[1]);
        sl_text_add(&r->statement, continued || *at == '\f' || *at == '\v' ? " " : at, 1);
        r->next_line += continued;
        at = continued ? skip_line_end(at + 1, end) : at + 1;
    }
    r->next_line++;
    return at < end ? skip_line_end(at, end) : end;
}

static sl_status read_statement(reader *r, const char **at, const char *end) {
    *at = take_statement(r, *at, end);
    sl_text_trim(&r->statement);
    sl_text_add(&r->statement, "", 1);
    if (r->statement.starved) return sl_fail_memory(r->error, r->path);
    const char *word = skip_blanks(r->statement.data);
    sl_status status = is_end(word) ? SL_OK : add_statement(r, word);
    add(r, "\n");
    return status;
}

sl_status sl_mtl_text_read(const char *path, sl_model *model, sl_text *plain, sl_error *error) {
    *plain = (sl_text){0};
    char *data;
    size_t size;
    sl_status status = sl_file_read(path, &data, &size, error);
    if (status != SL_OK) return status;
    reader r = {.path = path, .next_line = 1, .plain = plain, .model = model, .error = error};
    if (!sl_text_is_utf16(data, size)) {
        const char *at = data + sl_text_mark_bytes(data, size);
        status = sl_text_refuse_zeros(data, size, path, error);
        while (status == SL_OK && at < data + size) status = read_statement(&r, &at, data + size);
        if (status == SL_OK) status = sl_text_check(plain, path, error);
    }
    sl_free(data);
    sl_text_release(&r.statement);
    if (status != SL_OK) sl_text_release(plain);
    return status;
}
