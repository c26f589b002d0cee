/* Output for people and for programs: lines on stderr, JSON, and pages that hold everything they show and
 * fetch nothing: a style, data as JSON, and a script that makes the page of it. */
#pragma once

#include "softlux.h"

#include <cjson/cJSON.h>
#include <stdio.h>

/* Prints an error's line; returns its status, with which the command ends. */
int sl_complain(const sl_error *error);
/* Prints what loading a scene had to repair, a line each. */
void sl_tell_warnings(const sl_scene *scene, bool quiet);

/* Returns the next item of a list (or NULL) behind `*at`, of which it is the length; NULL: there is none. */
const char *sl_next_item(const char **at, const char *between, size_t *length);

/* Files that the linker has put in, from their beginning to their end. */
typedef struct sl_page_files {
    const char *css, *css_end, *js, *js_end;
    const char *before_js, *before_js_end; /* a script that the page's own calls; NULL: none */
} sl_page_files;

/* Writes the page, with its heading unless that is ""; the file appears whole or not at all. */
sl_status sl_page_write(const char *path, const char *title, const char *heading, const sl_page_files *files,
                        const cJSON *data, sl_error *error);
typedef void sl_printer(FILE *out, const void *what);
/* Returns what is printed as text, which the caller frees; NULL: no memory. */
char *sl_printed(sl_printer *print, const void *what);
/* Writes it to a file that appears whole or not at all. */
sl_status sl_print_file(const char *path, sl_printer *print, const void *what, sl_error *error);
/* Prints and deletes the object, on one line if asked for. Names of files are bytes, JSON is UTF-8: each byte
 * that belongs to no character is a question mark. */
void sl_json_print(cJSON *json, bool one_line);
/* Prints what stands in the object for people, a line each, and deletes it. */
void sl_json_lines(FILE *out, cJSON *json);
/* Adds an object of that name with the counters, also those that are 0 where asked for. */
void sl_json_add_counters(cJSON *to, const char *name, const sl_counters *counters, bool zeros);
/* Text as HTML and SVG have it. */
void sl_put_escaped(FILE *out, const char *text);
/* Bytes in base 64, which the caller frees; NULL: no memory. */
char *sl_base_64(const void *bytes, size_t count);
/* As PNG in base 64, which the caller frees; NULL: no memory. tone: of radiance; else values as they are. */
char *sl_picture_text(const sl_image *image, bool tone);
