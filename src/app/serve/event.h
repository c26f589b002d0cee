/* Events of a world, made to scenes. */
#pragma once

#include "app/serve/world.h"

/* The sky of a scene, which the caller frees with free(); NULL: no memory. */
sl_sky *sl_sky_of(const sl_scene *scene);
/* As sl_live_change.kind: equal where the later event is all that counts; 0: it is like none. */
uint64_t sl_event_kind(const sl_item *items, size_t count);
