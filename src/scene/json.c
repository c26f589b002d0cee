#include "scene/json.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/print.h"
#include "base/values.h"
#include "image/formats.h"
#include "scene/file.h"
#include "scene/parts.h"

/* ---- lines: values stand in the text in the order of the parsed tree ------------------------- */

static bool is_space(char c) { return c && (unsigned char)c <= ' '; }

static const char *skip_space(const char *at) {
    while (is_space(*at)) at++;
    return at;
}

static const char *behind_string(const char *at) {
    for (at++; *at && *at != '"'; at++) at += *at == '\\' && at[1];
    return at + (*at == '"');
}

static unsigned long line_of(const char *text, const char *at) {
    unsigned long line = 1;
    for (; text < at && *text; text++) line += *text == '\n';
    return line;
}

/* Counts the items that stand before the wanted one; false: it is not among them. */
static bool count_before(const cJSON *item, const cJSON *wanted, size_t *count) {
    if (item == wanted) return true;
    ++*count;
    for (const cJSON *child = item->child; child; child = child->next) {
        if (count_before(child, wanted, count)) return true;
    }
    return false;
}

/* Returns the line on which an item (its key, where it has one) begins. */
static unsigned long line_of_item(const sl_json *json, const cJSON *item) {
    size_t before = 0;
    if (!item || !count_before(json->root, item, &before)) return 1;
    for (const char *at = json->text, *key = NULL; *at;) {
        const char *token = at++;
        if (is_space(*token) || strchr(",:]}", *token)) continue;
        if (*token == '"') at = behind_string(token);
        else if (!strchr("{[", *token)) at = token + strcspn(token, ",]} \t\r\n");
        if (*token == '"' && *skip_space(at) == ':') key = token;
        else if (before-- == 0) return line_of(json->text, key ? key : token);
        else key = NULL;
    }
    return 1;
}

void sl_json_fail(sl_json *json, const cJSON *item, const char *format, ...) {
    if (json->status != SL_OK) return;
    char message[900];
    va_list arguments;
    va_start(arguments, format);
    sl_print_list(message, sizeof message, format, arguments);
    va_end(arguments);
    json->status =
        sl_fail(json->error, SL_ERROR_INPUT, "%s:%lu: %s", json->path, line_of_item(json, item), message);
}

void sl_json_take(sl_json *json, const cJSON *item, const char *what, sl_status status,
                  const sl_error *problem) {
    if (status == SL_ERROR_INPUT) sl_json_fail(json, item, "%s %s", what, problem->message);
    else if (status != SL_OK) json->status = sl_fail(json->error, status, "%s", problem->message);
}

/* ---- the file -------------------------------------------------------------------------------- */

static const char *behind_digits(const char *at) { return at + strspn(at, "0123456789"); }

/* Returns what is behind a number as JSON has it: -12, 0.5, 1e-3; at itself where it is none (012, 2., +1).
 */
static const char *behind_number(const char *at) {
    const char *digits = at + (*at == '-'), *end = behind_digits(digits);
    if (end == digits || (*digits == '0' && end > digits + 1)) return at;
    if (*end == '.') {
        digits = end + 1, end = behind_digits(digits);
        if (end == digits) return at;
    }
    if (*end == 'e' || *end == 'E') {
        digits = end + 1 + strspn(end + 1, "+-") % 2, end = behind_digits(digits);
        if (end == digits) return at;
    }
    return strchr(",]} \t\r\n", *end) ? end : at;
}

/* Returns what the parser takes, or tells at the end of the file: numbers in other words, a comma before a
 * closing bracket. NULL: nothing. */
static const char *find_what_is_no_json(const char *text) {
    for (const char *at = text; *at; at++) {
        if (*at == '"') {
            at = behind_string(at) - 1;
        } else if (*at == ',' && strchr("]}", at[1 + strspn(at + 1, " \t\r\n")])) {
            return at;
        } else if (strchr("+-.0123456789", *at)) {
            const char *end = behind_number(at);
            if (end == at) return at;
            at = end - 1;
        }
    }
    return NULL;
}

static sl_status fail_syntax(const sl_json *json, const char *at) {
    while (*at == ' ' || *at == '\t' || *at == '\n' || *at == '\r') at++;
    int shown = (int)strcspn(at, "\r\n");
    return sl_fail(json->error, SL_ERROR_INPUT, "%s:%lu: expected valid JSON, got %s%.*s", json->path,
                   line_of(json->text, at), *at ? "" : "the end of the file", shown < 40 ? shown : 40, at);
}

sl_status sl_json_open(const char *path, sl_json *json, sl_error *error) {
    sl_bytes bytes;
    *json = (sl_json){.path = path, .error = error};
    json->status = sl_bytes_read(path, SL_FILE_BYTES, &bytes, error);
    if (json->status != SL_OK) return json->status;
    json->text = (char *)bytes.data;
    if (bytes.size > SL_JSON_BYTES)
        return json->status = sl_fail(error, SL_ERROR_INPUT,
                                      "%s: expected a scene file of at most %d bytes, got %zu", path,
                                      SL_JSON_BYTES, bytes.size);
    const char *start = json->text, *end = start + strlen(start);
    /* a byte order mark says nothing */
    if (strncmp(start, "\xef\xbb\xbf", 3) == 0) memset(json->text, ' ', 3);
    const char *stray = find_what_is_no_json(start);
    if (stray) return json->status = fail_syntax(json, stray);
    /* It does not tell want of memory from bad text: which is bad again. */
    for (int i = 0; i < 2 && !json->root && strlen(start) == bytes.size; i++)
        json->root = cJSON_ParseWithOpts(start, &end, 1);
    if (!json->root)
        json->status = sl_memory_has_ended() ? sl_fail_memory(error, path) : fail_syntax(json, end);
    return json->status;
}

void sl_json_close(sl_json *json) {
    cJSON_Delete(json->root);
    sl_free(json->text);
    json->root = NULL;
    json->text = NULL;
}

/* ---- keys ------------------------------------------------------------------------------------ */

static bool is_one_of(const char *name, const char *const *names, size_t count) {
    for (size_t i = 0; i < count; i++) {
        if (strcmp(name, names[i]) == 0) return true;
    }
    return false;
}

bool sl_json_keys(sl_json *json, const cJSON *object, const char *what, const char *const *keys,
                  size_t count) {
    if (json->status != SL_OK) return false;
    if (!cJSON_IsObject(object)) {
        sl_json_fail(json, object, "expected %s to be an object { ... }", what);
        return false;
    }
    for (const cJSON *item = object->child; item; item = item->next) {
        if (!is_one_of(item->string, keys, count)) {
            const char *near = sl_nearest_word(item->string, keys, count);
            sl_json_fail(json, item, "unknown key '%.100s' in %s%s%s%s", item->string, what,
                         near ? "; expected '" : "", near ? near : "", near ? "'?" : "");
            return false;
        }
        for (const cJSON *other = object->child; other != item; other = other->next) {
            if (strcmp(other->string, item->string) != 0) continue;
            sl_json_fail(json, item, "key '%s' is given twice", item->string);
            return false;
        }
    }
    return true;
}

const cJSON *sl_json_get(const cJSON *object, const char *key) {
    return cJSON_GetObjectItemCaseSensitive(object, key);
}

const cJSON *sl_json_need(sl_json *json, const cJSON *object, const char *key) {
    const cJSON *item = sl_json_get(object, key);
    if (!item) sl_json_fail(json, object, "expected a key '%s' here", key);
    return item;
}

/* ---- values ---------------------------------------------------------------------------------- */

static const char *name_of(const cJSON *item) { return item->string ? item->string : "this entry"; }

static bool is_number(const cJSON *item) {
    return cJSON_IsNumber(item) && isfinite(item->valuedouble) && fabs(item->valuedouble) <= (double)FLT_MAX;
}

bool sl_json_number(sl_json *json, const cJSON *item, double low, double high, double *value) {
    char text[SL_RULE_TEXT];
    if (json->status != SL_OK || !item) return false;
    if (!is_number(item)) sl_json_fail(json, item, "expected '%s' to be a number", name_of(item));
    else if (!sl_is_within(name_of(item), item->valuedouble, low, high, text))
        sl_json_fail(json, item, "%s", text);
    else *value = item->valuedouble;
    return json->status == SL_OK;
}

bool sl_json_numbers(sl_json *json, const cJSON *item, int count, double *values) {
    if (json->status != SL_OK || !item) return false;
    const cJSON *wrong = cJSON_IsArray(item) && cJSON_GetArraySize(item) == count ? NULL : item;
    const cJSON *entry = item->child;
    for (int i = 0; i < count && !wrong; i++, entry = entry->next) {
        if (is_number(entry)) values[i] = entry->valuedouble;
        else wrong = entry;
    }
    if (wrong) sl_json_fail(json, wrong, "expected '%s' to be an array of %d numbers", name_of(item), count);
    return !wrong;
}

bool sl_json_vec3(sl_json *json, const cJSON *item, sl_vec3d *value) {
    double v[3];
    if (!sl_json_numbers(json, item, 3, v)) return false;
    *value = sl_v3d(v[0], v[1], v[2]);
    return true;
}

bool sl_json_rgb(sl_json *json, const cJSON *item, sl_rgb *value) {
    double v[3];
    if (cJSON_IsNumber(item)) {
        if (!sl_json_number(json, item, 0.0, (double)FLT_MAX, &v[0])) return false;
        v[1] = v[2] = v[0];
    } else if (!sl_json_numbers(json, item, 3, v)) {
        return false;
    }
    if (!(v[0] >= 0.0 && v[1] >= 0.0 && v[2] >= 0.0)) {
        sl_json_fail(json, item, "expected '%s' to be at least 0 in every channel", name_of(item));
        return false;
    }
    *value = (sl_rgb){(float)v[0], (float)v[1], (float)v[2]};
    return true;
}

bool sl_json_bool(sl_json *json, const cJSON *item, bool *value) {
    if (json->status != SL_OK || !item) return false;
    if (!cJSON_IsBool(item)) {
        sl_json_fail(json, item, "expected '%s' to be true or false", name_of(item));
        return false;
    }
    *value = cJSON_IsTrue(item);
    return true;
}

const char *sl_json_string(sl_json *json, const cJSON *item) {
    if (json->status != SL_OK || !item) return NULL;
    if (!cJSON_IsString(item) || !item->valuestring[0]) {
        sl_json_fail(json, item, "expected '%s' to be a string that is not empty", name_of(item));
        return NULL;
    }
    if (strlen(item->valuestring) > SL_JSON_STRING) {
        sl_json_fail(json, item, "expected '%s' to be a string of at most %d bytes, got %zu", name_of(item),
                     SL_JSON_STRING, strlen(item->valuestring));
        return NULL;
    }
    return item->valuestring;
}

size_t sl_json_entries(sl_json *json, const cJSON *item) {
    if (json->status != SL_OK || !item) return 0;
    size_t count = (size_t)cJSON_GetArraySize(item);
    if (count > SL_JSON_ENTRIES) {
        sl_json_fail(json, item, "expected '%s' to have at most %d entries, got %zu", name_of(item),
                     SL_JSON_ENTRIES, count);
        return 0;
    }
    return count;
}

size_t sl_json_array(sl_json *json, const cJSON *item) {
    if (!item || cJSON_IsArray(item)) return sl_json_entries(json, item);
    sl_json_fail(json, item, "expected '%s' to be an array [ ... ]", name_of(item));
    return 0;
}
