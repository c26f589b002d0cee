/* The passes of a side whose method is observed. */
#pragma once

#include "app/serve/stage_parts.h"

/* NULL: no memory. The observer is given to the method, and told of passes until that is gone. */
sl_passes *sl_passes_create(const char *method);
void sl_passes_destroy(sl_passes *passes); /* NULL is allowed */
const sl_observer *sl_passes_observer(const sl_passes *passes);
/* The marks of which pass are shown, by a part of its name; "": none. */
void sl_passes_overlay(sl_passes *passes, const char *kind);
/* Has all sent once more: somebody else wants to see them. */
void sl_passes_again(sl_passes *passes);
/* Sends what is new, now and then. */
void sl_passes_step(sl_stage *stage, sl_passes *passes, int side, double now);
