/* Logs that were kept, replayed. */
#pragma once

#include "app/serve/stage_parts.h"

/* The picture of a log's show, the first (0) or second, which the caller destroys: that which lay beside the
 * log when it was kept, to the bit. */
sl_status sl_log_replay(const char *path, const char *scene, const sl_reading *reading, int show,
                        sl_image **picture, sl_error *error);
