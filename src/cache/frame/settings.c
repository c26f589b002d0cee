/* The table of options as data, and what is made from it: settings set and told by name, checked, completed,
 * and stamped on pictures. */
#include "cache/frame/settings.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/print.h"
#include "base/values.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- the rows ---- */

typedef enum field_kind { FIELD_FLAG, FIELD_INT, FIELD_UINT, FIELD_COUNT, FIELD_REAL, FIELD_NAME } field_kind;

typedef struct row {
    sl_setting told;
    const char *flag; /* the name without the method's */
    field_kind kind;
    size_t offset;
    bool stamped;
} row;

#define KIND(place) \
    _Generic(((sl_settings *)0)->place, bool: FIELD_FLAG, int: FIELD_INT, unsigned: FIELD_UINT, \
             uint64_t: FIELD_COUNT, double: FIELD_REAL, const char *: FIELD_NAME)

#define NOTHING 0.0, 0.0, 0.0, NULL
#define IS(value) value, value, value, NULL
#define BY(draft, normal, high) draft, normal, high, NULL
#define TOLD(words) 0.0, 0.0, 0.0, words
#define USER(letter) true, letter, true
#define UNSTAMPED(letter) true, letter, false
#define RESEARCH false, 0, true

#define ROW(place, methods, prefix, ...) ROW_OF(place, methods, prefix, __VA_ARGS__)
#define ROW_OF(place, methods, prefix, name, unit, least, most, draft, normal, high, words, symbol, \
               everyday, letter, stamped, help) \
    {{prefix name, methods, unit, symbol, help, least, most, {draft, normal, high}, words, everyday, \
      letter}, name, KIND(place), offsetof(sl_settings, place), stamped},
#define COMMON(type, field, ...) ROW(field, "", "", __VA_ARGS__)
#define GATHERING(type, field, ...) ROW(field, "splatting, multi-mesh", "", __VA_ARGS__)
#define SPLATTING(type, field, ...) ROW(field, "splatting", "splatting.", __VA_ARGS__)
#define RADIANCE_MAP(type, field, ...) \
    ROW(radiance_map.field, "direct-radiance", "direct-radiance.", __VA_ARGS__)
#define LIGHT_OCTREE(type, field, ...) ROW(light_octree.field, "light-octree", "light-octree.", __VA_ARGS__)
#define MULTI_MESH(type, field, ...) ROW(multi_mesh.field, "multi-mesh", "multi-mesh.", __VA_ARGS__)
#define SHADING_CACHE(type, field, ...) \
    ROW(shading_cache.field, "shading-cache", "shading-cache.", __VA_ARGS__)

static const row rows[] = {
    SL_OPTIONS_OF_COMMON(COMMON)
    SL_OPTIONS_OF_GATHERING(GATHERING)
    SL_OPTIONS_OF_SPLATTING(SPLATTING)
    SL_OPTIONS_OF_RADIANCE_MAP(RADIANCE_MAP)
    SL_OPTIONS_OF_LIGHT_OCTREE(LIGHT_OCTREE)
    SL_OPTIONS_OF_MULTI_MESH(MULTI_MESH)
    SL_OPTIONS_OF_SHADING_CACHE(SHADING_CACHE)
};
enum { ROWS = sizeof rows / sizeof rows[0] };

const sl_setting *sl_setting_at(size_t index) { return index < ROWS ? &rows[index].told : NULL; }

static bool is_size(const row *r) { return strcmp(r->told.unit, "WxH") == 0; }
static bool is_choice(const row *r) { return strchr(r->told.unit, '|') != NULL; }
static double unit_of(const row *r) { return strcmp(r->told.unit, "DEGREES") == 0 ? SL_PI / 180.0 : 1.0; }
static bool concerns(const row *r, const char *method) {
    return !*r->told.methods || strstr(r->told.methods, method);
}

/* By its whole name, or by the last part: that of a method that has an option of the name goes before
 * others'. */
static const row *find_row(const char *name, const char *method) {
    const row *found = NULL;
    for (size_t i = 0; i < ROWS; i++) {
        const row *r = &rows[i];
        if (strcmp(r->told.name, name) == 0) return r;
        if (strcmp(r->flag, name) == 0 && (!found || concerns(r, method))) found = r;
    }
    return found;
}

const sl_setting *sl_setting_named(const char *name) {
    const row *r = name ? find_row(name, "") : NULL;
    return r ? &r->told : NULL;
}

/* ---- fields ---- */

static const void *field_of(const row *r, const sl_settings *s) { return (const char *)s + r->offset; }

static double value_of(const row *r, const sl_settings *s) {
    const void *at = field_of(r, s);
    switch (r->kind) {
    case FIELD_FLAG: return *(const bool *)at ? 1.0 : 0.0;
    case FIELD_INT: return *(const int *)at;
    case FIELD_UINT: return *(const unsigned *)at;
    case FIELD_COUNT: return (double)*(const uint64_t *)at;
    case FIELD_REAL: return *(const double *)at;
    case FIELD_NAME: break;
    }
    return 0.0;
}

static void put_value(const row *r, sl_settings *s, double value) {
    void *at = (char *)s + r->offset;
    switch (r->kind) {
    case FIELD_FLAG: *(bool *)at = value != 0.0; break;
    case FIELD_INT: *(int *)at = (int)value; break;
    case FIELD_UINT: *(unsigned *)at = (unsigned)value; break;
    case FIELD_COUNT: *(uint64_t *)at = (uint64_t)value; break;
    case FIELD_REAL: *(double *)at = value; break;
    case FIELD_NAME: break;
    }
}

double sl_settings_number(const sl_settings *s, const char *name) { return value_of(find_row(name, ""), s); }

void sl_settings_put_number(sl_settings *s, const char *name, double value) {
    put_value(find_row(name, ""), s, value);
}

/* ---- settings as a whole ---- */

sl_settings sl_settings_default(void) {
    return (sl_settings){.method = "splatting", .quality = SL_QUALITY_NORMAL, .filter = SL_FILTER_BOX};
}

sl_settings sl_settings_of_papers(void) {
    return (sl_settings){.method = "splatting", .quality = SL_QUALITY_NORMAL, .bounces = 1};
}

sl_status sl_settings_create(sl_settings **settings, sl_error *error) {
    if (!settings) return sl_fail_null(error, "a place for settings");
    *settings = sl_allocate(1, sizeof **settings);
    if (!*settings) return sl_fail_memory(error, "settings");
    **settings = sl_settings_default();
    return SL_OK;
}

void sl_settings_destroy(sl_settings *settings) { sl_free(settings); }

void sl_settings_observe(sl_settings *settings, const sl_observer *observer) {
    settings->observer = observer;
}

void sl_settings_complete(sl_settings *s) {
    for (size_t i = 0; i < ROWS; i++) {
        const row *r = &rows[i];
        const double standard = r->told.by_quality[s->quality];
        if (standard > 0.0 && value_of(r, s) == 0.0) put_value(r, s, standard * unit_of(r));
    }
}

/* ---- what is allowed ---- */

bool sl_is_tracer(const char *method) {
    return strcmp(method, "path") == 0 || strcmp(method, "bidirectional") == 0;
}

/* Pixels a side: what is rasterized is snapped to 1/256 pixel, in 22 bits. */
static int largest_side(const sl_settings *s) { return sl_is_tracer(s->method) ? 32768 : 16384; }

static double choices_of(const row *r) {
    double count = 1.0;
    for (const char *c = r->told.unit; *c; c++) count += *c == '|';
    return count;
}

/* 0 is a default, and what people write in degrees is rounded. */
static sl_status check_row(const row *r, const sl_settings *s, sl_error *error) {
    const double slack = 1e-9, value = value_of(r, s) / unit_of(r);
    const double least = r->told.minimum, most = is_choice(r) ? choices_of(r) - 1.0 : r->told.maximum;
    if (!(least < most) || value == 0.0 || is_size(r)) return SL_OK;
    if (value >= least * (1.0 - slack) && value <= most * (1.0 + (unit_of(r) == 1.0 ? 0.0 : slack)))
        return SL_OK;
    char text[32];
    return sl_fail(error, SL_ERROR_USAGE, "%s: expected %g to %g, got %s", r->told.name, least, most,
                   sl_outside_text(value, least, most, text));
}

sl_status sl_settings_check(const sl_settings *s, sl_error *error) {
    const int most = largest_side(s);
    if (s->width < 1 || s->height < 1 || s->width > most || s->height > most)
        return sl_fail(error, SL_ERROR_USAGE, "expected a size of 1 to %d pixels each way for %s, got %dx%d",
                       most, s->method, s->width, s->height);
    if (s->gather_size % 2)
        return sl_fail(error, SL_ERROR_USAGE, "gather-size: expected an even number, got %d", s->gather_size);
    sl_status status = SL_OK;
    for (size_t i = 0; i < ROWS && status == SL_OK; i++) status = check_row(&rows[i], s, error);
    return status;
}

/* ---- from text ---- */

#define METHODS(of) \
    of "splatting", of "direct-radiance", of "light-octree", of "multi-mesh", of "shading-cache", of "path", \
        of "bidirectional"
static const char *const names[] = {METHODS(""), "auto", "direct", "one-bounce", "full",
                                    METHODS("matched:")};
enum { METHODS_AND_AUTO = 8, NAMES = sizeof names / sizeof names[0] };

/* Names outlive the text that they are read from. */
static sl_status set_name(const row *r, sl_settings *s, const char *text, sl_error *error) {
    const bool method = r->offset == offsetof(sl_settings, method);
    const size_t from = method ? 0 : METHODS_AND_AUTO, to = method ? METHODS_AND_AUTO : NAMES;
    for (size_t i = from; i < to; i++) {
        if (strcmp(text, names[i]) != 0) continue;
        *(const char **)(void *)((char *)s + r->offset) = names[i];
        return SL_OK;
    }
    const char *near = sl_nearest_word(text, names + from, to - from);
    return sl_fail(error, SL_ERROR_USAGE, "unknown %s '%s'; expected %s%s%s%s", r->flag, text,
                   method ? "one of " : "",
                   method ? r->told.help : "direct, one-bounce, full or matched:METHOD",
                   near ? "; did you mean " : "", near ? near : "");
}

/* A flag is a choice of four words. */
static sl_status set_choice(const row *r, sl_settings *s, const char *text, sl_error *error) {
    const bool flag = r->kind == FIELD_FLAG;
    int index = 0;
    sl_status status = sl_value_choice(text, flag ? "0|1|false|true" : r->told.unit, &index, error);
    if (status == SL_OK) put_value(r, s, flag ? index % 2 : index);
    return status;
}

static sl_status set_number(const row *r, sl_settings *s, const char *text, sl_error *error) {
    const double least = r->told.minimum, most = r->told.maximum;
    uint64_t count = 0;
    double value = 0.0;
    if (r->kind == FIELD_REAL) {
        sl_status status = sl_value_real(text, least, most, &value, error);
        if (status == SL_OK) put_value(r, s, value * unit_of(r));
        return status;
    }
    sl_status status = strcmp(r->told.unit, "BYTES") == 0 ? sl_value_bytes(text, least, most, &count, error)
                                                          : sl_value_count(text, least, most, &count, error);
    if (status == SL_OK && r->kind == FIELD_COUNT) *(uint64_t *)(void *)((char *)s + r->offset) = count;
    else if (status == SL_OK) put_value(r, s, (double)count);
    return status;
}

static sl_status set_row(const row *r, sl_settings *s, const char *text, sl_error *error) {
    if (r->kind == FIELD_NAME) return set_name(r, s, text, error);
    if (is_size(r)) {
        int size[2];
        sl_status status = sl_value_size(text, (int)r->told.maximum, size, error);
        if (status == SL_OK) s->width = size[0], s->height = size[1];
        return status;
    }
    return r->kind == FIELD_FLAG || is_choice(r) ? set_choice(r, s, text, error)
                                                 : set_number(r, s, text, error);
}

static sl_status unknown(const char *name, sl_error *error) {
    const char *known[2 * ROWS];
    for (size_t i = 0; i < ROWS; i++) known[i] = rows[i].told.name, known[ROWS + i] = rows[i].flag;
    const char *near = sl_nearest_word(name, known, 2 * ROWS);
    return sl_fail(error, SL_ERROR_USAGE, "unknown option %s%s%s%s", name, near ? "; did you mean " : "",
                   near ? find_row(near, "")->told.name : "", near ? "?" : "");
}

sl_status sl_settings_set(sl_settings *settings, const char *name, const char *value, sl_error *error) {
    if (!settings || !name || !value) return sl_fail_null(error, "settings, a name and a value");
    const row *r = find_row(name, settings->method);
    if (!r) return unknown(name, error);
    sl_error why;
    if (set_row(r, settings, value, &why) == SL_OK) return SL_OK;
    return sl_fail(error, SL_ERROR_USAGE, "%s: %s", r->told.name, why.message);
}

/* ---- to text ---- */

/* As few digits as give the value again, so that what is told can be asked for. */
static void print_real(double value, double unit, char *text, size_t room) {
    enum { DIGITS_OF_A_DOUBLE = 17 };
    void *before = sl_c_locale_begin();
    for (int digits = 9; digits <= DIGITS_OF_A_DOUBLE; digits++) {
        snprintf(text, room, "%.*g", digits, value / unit);
        if (strtod(text, NULL) * unit == value) break;
    }
    sl_c_locale_end(before);
}

static void print_row(const row *r, const sl_settings *s, char *text, size_t room) {
    const char *name = r->kind == FIELD_NAME ? *(const char *const *)field_of(r, s) : NULL;
    if (r->kind == FIELD_NAME) snprintf(text, room, "%s", name ? name : "");
    else if (r->kind == FIELD_FLAG) snprintf(text, room, "%s", value_of(r, s) != 0.0 ? "true" : "false");
    else if (is_size(r)) snprintf(text, room, "%dx%d", s->width, s->height);
    else if (is_choice(r)) sl_value_choice_name(r->told.unit, (int)value_of(r, s), text, room);
    else if (r->kind == FIELD_REAL) print_real(value_of(r, s), unit_of(r), text, room);
    else if (r->kind == FIELD_COUNT) snprintf(text, room, "%" PRIu64, *(const uint64_t *)field_of(r, s));
    else snprintf(text, room, "%.0f", value_of(r, s));
}

sl_status sl_settings_get(const sl_settings *settings, const char *name, char *text, size_t room,
                          sl_error *error) {
    if (!settings || !name || !text || !room)
        return sl_fail_null(error, "settings, a name and room for text");
    text[0] = '\0';
    const row *r = find_row(name, settings->method);
    if (!r) return unknown(name, error);
    print_row(r, settings, text, room);
    return SL_OK;
}

/* Nothing that is 0, and so left open, but for what has a choice there. */
static bool is_told(const row *r, const sl_settings *s) {
    static const char matched[] = "matched:";
    if (!r->stamped) return false;
    if (r->kind == FIELD_FLAG && value_of(r, s) == 0.0) return false;
    if (r->told.minimum > 0.0 && value_of(r, s) == 0.0) return false;
    const char *paths = s->transport && strncmp(s->transport, matched, sizeof matched - 1) == 0
                            ? s->transport + sizeof matched - 1
                            : s->method;
    return concerns(r, s->method) || concerns(r, paths);
}

sl_status sl_settings_stamp(const sl_settings *s, sl_image *image, sl_error *error) {
    sl_status status = SL_OK;
    for (size_t i = 0; i < ROWS && status == SL_OK; i++) {
        char key[SL_METADATA_KEY_MAX], text[64];
        if (!is_told(&rows[i], s)) continue;
        snprintf(key, sizeof key, "softlux.%s", rows[i].flag);
        for (char *c = key; *c; c++) *c = *c == '-' ? '_' : *c;
        print_row(&rows[i], s, text, sizeof text);
        status = sl_image_set_metadata(image, key, text, error);
    }
    return status;
}
