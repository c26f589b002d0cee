/* Which pixels of a picture show surfaces, and which a light source or the sky itself. */
#ifndef SL_CACHE_AUDIT_SURFACES_H
#define SL_CACHE_AUDIT_SURFACES_H

#include "trace/path_walk.h"

/* A picture of one channel: 0 where a pixel's first hit shines towards the eye or a sky that shines is seen,
 * else 1. A pixel of a box shows what any part of it does. 1 everywhere where nearly nothing but light is
 * seen (a furnace), or the transport leaves out emission. The caller destroys it. */
sl_status sl_audit_surfaces(const sl_path_walk *walk, const sl_path_lens *lens, unsigned threads,
                            sl_image **surfaces, sl_error *error);

#endif
