/* A method draws a picture's sub-frames one after the other; ranks (base/ranks.h) share out those that only
 * show what is there, since each of them can be drawn by itself. */
#pragma once

#include "cache/frame/method.h"

/* Shows the class the first sub-frame, of which it is told nothing else. Without a film: the scene itself. */
void sl_expose_anew(sl_method *method, bool objects_moved);
/* Updates the class, and hands the sub-frames that are finished to the film. now->batches goes up by what
 * there was on top of one update; now->done: the picture is whole. */
sl_status sl_expose(sl_method *method, sl_progress *now, sl_error *error);
