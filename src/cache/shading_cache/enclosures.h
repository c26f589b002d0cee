/* Points inside other geometry, where a table leg stands on the floor: light there is nobody's, and would darken what is around it. A ray from inside a
 * solid meets its surface from behind; so do rays in scenes whose walls are wound the wrong way, or below a sheet that has no thickness, and those are
 * points as good as others. So back faces count where they belong to what looks outwards as a whole and has no light inside:
 *
 *   closed     more than half of the probe rays meet such back faces
 *   open       (a box without a bottom) all of them do
 *
 * What has light inside is a room, as a rule. But of what is sealed (each edge is that of two triangles, and no mask has holes) an eye outside sees nothing of the inside, and the
 * light there would only leak out of the leaves at its foot: to such an eye it is closed. */
#ifndef SL_SHADING_CACHE_ENCLOSURES_H
#define SL_SHADING_CACHE_ENCLOSURES_H

#include "cache/shading_cache/primitives.h"
#include "trace/trace.h"

typedef struct sl_enclosures sl_enclosures;

sl_status sl_enclosures_find(const sl_scene *scene, sl_enclosures **solids, sl_error *error);
void sl_enclosures_destroy(sl_enclosures *solids);
/* Objects or lights have moved. */
void sl_enclosures_edit(sl_enclosures *solids);
bool sl_enclosures_hold(const sl_enclosures *solids, const sl_tracer *tracer, const sl_root_point *point, sl_vec3 eye, sl_counters *counters);
/* The eye has gone into a lit solid, or out of one: points within are others now. */
bool sl_enclosures_eye_matters(const sl_enclosures *solids, sl_vec3 before, sl_vec3 now);

#endif
