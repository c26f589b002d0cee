/* Reading JSON with errors that a person can act on: file, line, what was expected. The first error sticks:
 * whoever reads on reads nothing more, so that a reader asks for everything in order and looks at `status`
 * once. */
#pragma once

#include <cjson/cJSON.h>

#include "base/vec.h"
#include "softlux.h"

/* Limits of a file (docs/scene-format.md): more is an error. */
enum { SL_JSON_BYTES = 64 << 20, SL_JSON_ENTRIES = 65536, SL_JSON_STRING = 4095 };

typedef struct sl_json {
    const char *path;
    char *text;
    cJSON *root;
    sl_status status;
    sl_error *error;
} sl_json;

/* Syntax errors give their line. The parser (cJSON) takes numbers as 012 and 2. for 12 and 2. */
sl_status sl_json_open(const char *path, sl_json *json, sl_error *error);
void sl_json_close(sl_json *json);

/* `path:line: message`, the line being that on which the item (its key, where it has one) begins. */
__attribute__((format(printf, 3, 4))) void sl_json_fail(sl_json *json, const cJSON *item, const char *format,
                                                        ...);

/* Takes over what went wrong elsewhere, if anything did: an input error with the item's line, after `what`.
 */
void sl_json_take(sl_json *json, const cJSON *item, const char *what, sl_status status,
                  const sl_error *problem);

/* `object` must be an object with these keys only, each once. False where it is not. */
bool sl_json_keys(sl_json *json, const cJSON *object, const char *what, const char *const *keys,
                  size_t count);
#define SL_JSON_KEYS(json, object, what, ...) \
    sl_json_keys(json, object, what, (const char *const[]){__VA_ARGS__}, \
                 sizeof((const char *const[]){__VA_ARGS__}) / sizeof(const char *))

/* The value of a key; NULL where it is not given. */
const cJSON *sl_json_get(const cJSON *object, const char *key);
/* The same, but not giving it is an error. */
const cJSON *sl_json_need(sl_json *json, const cJSON *object, const char *key);

/* Each reads an item (NULL: nothing is read); true where it was there and right, and only then is anything
 * written. */
bool sl_json_number(sl_json *json, const cJSON *item, double low, double high, double *value);
bool sl_json_numbers(sl_json *json, const cJSON *item, int count, double *values);
bool sl_json_vec3(sl_json *json, const cJSON *item, sl_vec3d *value);
bool sl_json_rgb(sl_json *json, const cJSON *item, sl_rgb *value); /* three numbers >= 0, or one for all */
bool sl_json_bool(sl_json *json, const cJSON *item, bool *value);
const char *sl_json_string(sl_json *json, const cJSON *item); /* NULL where it is none */
/* Counts the entries of an array or object, at most SL_JSON_ENTRIES; 0 where it is not given or has more. */
size_t sl_json_entries(sl_json *json, const cJSON *item);
/* The same, of what must be an array. */
size_t sl_json_array(sl_json *json, const cJSON *item);
