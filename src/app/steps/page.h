/* The page: index.html, which holds everything it shows and fetches nothing. */
#ifndef SL_APP_STEPS_PAGE_H
#define SL_APP_STEPS_PAGE_H

#include "softlux.h"

#include <cjson/cJSON.h>

/* runs: a JSON array of one method (run.h), or two beside each other. The file appears whole or not at all. */
sl_status sl_page_write(const char *folder, const char *scene, const cJSON *runs, sl_error *error);

#endif
