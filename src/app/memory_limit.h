/* --memory as the system's limit, too: what is taken while a scene loads cannot be worked out before, and
 * what a method says may be wrong. */
#pragma once

#include "cache/frame/settings.h"

/* As sl_scene_load_with(). Where settings->memory_bytes says how much may be taken, what would be more fails
 * while the scene loads; then a little more is allowed, since the system counts what is reserved and not what
 * is used, and the method keeps account itself. From then on what is freed goes back to the system. A scene
 * that could not be loaded for want of memory says so, whatever its reader made of that. */
sl_status sl_load_within_memory(const char *path, const sl_load_options *load, const sl_settings *settings,
                                sl_scene **scene, sl_error *error);
/* For shows and films, where every frame takes what the one before gave back: the system need not take it and
 * clear it in between. Where memory is limited nothing is kept. */
void sl_keep_freed_memory(const sl_settings *settings);
