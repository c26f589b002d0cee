/* Change: what moves is found out by shading vertices again under the same samples (section on dynamic
 * scenes). Objects whose shading changes grow old all at once, and are shown with coarser patches until it
 * has settled. */
#pragma once

#include "cache/shading_cache/priority.h"

typedef struct sl_object_change {
    bool changing;
    uint32_t changed;          /* update of the last change found; 0: never */
    uint32_t moved;            /* update of its last motion; 0: never */
    uint32_t stale_before;     /* the update of the last edit: vertices evaluated before it are stale */
    bool dropped;              /* its fine patches went for this change: once is enough */
} sl_object_change;

typedef struct sl_changes {
    size_t object_count;
    sl_object_change *object;  /* the caller's, of zeros before all */
    uint32_t eye_moved;        /* update of the camera's last motion; 0: never */
    float threshold;           /* tau_c, grey levels */
    int window;                /* W */
    bool no_ageing;            /* nothing grows old, or is stale */
} sl_changes;

/* The scene was edited before update `now`: moved[i] tells which objects have moved. */
void sl_changes_edit(sl_changes *changes, unsigned what, const bool *moved, uint32_t now);
/* An object's shading is known to have changed. */
void sl_changes_begin(sl_changes *changes, uint32_t object, uint32_t now);
/* A vertex was shaded again and is now so many display levels apart from what it was. True: that is a change,
 * and its object is changing. */
bool sl_changes_compare(sl_changes *changes, uint32_t object, float levels, uint32_t now);
/* Since when patches of an object age: `changed` of sl_patch_age(). What was evaluated after the edit that
 * its change is due to is as good as new, however late the change was found. 0: it does not. */
static inline uint32_t sl_changes_since(const sl_changes *changes, uint32_t object) {
    bool ages = changes->object[object].changing && !changes->no_ageing;
    return ages ? changes->object[object].stale_before : 0;
}
/* At an update's end: objects whose change has ended. still_stale[i]: some visible leaf of the object has
 * vertices from before. */
void sl_changes_settle(sl_changes *changes, const bool *still_stale, uint32_t now);
/* Smallest projected area of quads of changing objects that T_c leaves time for: A / (r T_c); of triangles
 * half of it, as their grids have half as many vertices as leaves. A: their visible pixels. */
float sl_changes_coarsest(double visible_pixels, double rate, double seconds);
/* Drops children that are at or below that, a quarter of their parent's projected area, where they belong to
 * changing objects, once for each change: what is left is no more than there is time for. */
void sl_changes_drop(sl_changes *changes, sl_patches *patches, const sl_view *view, float coarsest);
/* Things move again after a rest: what has been refined since is to be dropped once more. */
void sl_changes_drop_again(sl_changes *changes);

/* ---- blending ---- */

/* Values that come in slowly, so that nothing pops (beta below 1; section on blending): a vertex of an
 * unchanged scene that gets its first sample starts from what the picture has shown there, and goes beta of
 * the way in each update: (1 - beta)^k are left after k. After an edit nothing fades: what has changed is to
 * be seen. */
typedef struct sl_fade {
    uint32_t vertex, evaluated; /* another value by now: evaluated in another update */
    float left;                 /* (1 - beta)^k */
    float value[6];             /* where it goes */
} sl_fade;

typedef struct sl_fades {
    sl_fade *fade;
    size_t count, capacity;
} sl_fades;

/* The vertex has its value; from now on it shows what lies between `from` (sl_vertex_surroundings()) and
 * that. Without memory it shows its value. */
void sl_fade_begin(sl_fades *fades, sl_patches *patches, uint32_t vertex, const float from[6], float beta);
/* Once an update, before new ones begin. */
void sl_fades_go_on(sl_fades *fades, sl_patches *patches, float beta);
void sl_fades_finish(sl_fades *fades, sl_patches *patches);
void sl_fades_release(sl_fades *fades);
