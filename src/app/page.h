/* Pages that hold everything they show and fetch nothing: a style, data as JSON, and a script that makes the
 * page of it. */
#ifndef SL_APP_PAGE_H
#define SL_APP_PAGE_H

#include "softlux.h"

#include <cjson/cJSON.h>

/* Files that the linker has put in, from their beginning to their end. */
typedef struct sl_page_files {
    const char *css, *css_end, *js, *js_end;
} sl_page_files;

/* Writes the page, with its heading unless that is ""; the file appears whole or not at all. */
sl_status sl_page_write(const char *path, const char *title, const char *heading, const sl_page_files *files,
                        const cJSON *data, sl_error *error);

#endif
