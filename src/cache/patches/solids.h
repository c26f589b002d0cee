/* Points inside other geometry, where a table leg stands on the floor: light there is nobody's, and would
 * darken what is around it. A ray from inside a solid meets its surface from behind; so do rays in scenes
 * whose walls are wound the wrong way, or below a sheet that has no thickness, and those are points as good
 * as others. So back faces count where they belong to what looks outwards as a whole and has no light inside:
 *
 *   closed     more than half of the probe rays meet such back faces
 *   open       (a box without a bottom) all of them do
 *
 * What has light inside is a room, as a rule. But of what is sealed (each edge is that of two triangles, and
 * no mask has holes) an eye outside sees nothing of the inside, and the light there would only leak out of
 * the leaves at its foot: to such an eye it is closed.
 *
 * A solid is at least a hundredth of its bounding box; what is wound inside out is none. Where solids run
 * through one another points next to the other's surface may count as outside. */
#pragma once

#include "cache/light/light_sample.h"

typedef struct sl_solids sl_solids;

/* The scene must outlive them. */
sl_status sl_solids_find(const sl_scene *scene, sl_solids **solids, sl_error *error);
void sl_solids_destroy(sl_solids *solids);
/* Finds them anew after objects or lights have moved. */
void sl_solids_edit(sl_solids *solids);
/* Tells whether a point lies inside a solid other than that of its triangle (SL_NO_INDEX: several meet
 * there). eye: NULL where light is kept for all eyes; then nothing that is open or has light inside is a
 * solid. */
bool sl_solids_hold(const sl_solids *solids, const sl_tracer *tracer, const sl_lit_point *at,
                    const sl_vec3 *eye, sl_counters *counters);
/* Tells whether an eye that moves goes into a lit solid, or out of one: points within are others then. */
bool sl_solids_eye_matters(const sl_solids *solids, sl_vec3 before, sl_vec3 now);
/* Tells whether a triangle's back is the inner side of a sealed solid without light: nobody sees it. */
bool sl_solids_hide_back(const sl_solids *solids, uint32_t triangle);
