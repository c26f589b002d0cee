/* The page: index.html, which holds everything it shows and fetches nothing. */
#ifndef SL_APP_STEPS_PAGE_H
#define SL_APP_STEPS_PAGE_H

#include "app/steps/run.h"

/* One method, or two beside each other. The file appears whole or not at all. */
sl_status sl_page_write(const char *folder, const char *scene, const sl_steps_run *runs, size_t count,
                        sl_error *error);

#endif
