/* A scene that all ranks render: the first one reads it. */
#pragma once

#include "cache/frame/settings.h"

/* As sl_load_within_memory(). Of several ranks the first one loads the scene, and gives the others its files.
 * INPUT: it is not the same scene everywhere. */
sl_status sl_load_for_ranks(const char *path, const sl_load_options *load, const sl_settings *settings,
                            sl_scene **scene, sl_error *error);
