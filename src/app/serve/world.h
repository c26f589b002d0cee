/* The scene that a server shows: as it stands, what was done to it so far, and how that is undone. What is
 * done is an event, with a number, and can be done to any other copy of the scene, to the same bits. */
#pragma once

#include "app/options.h"
#include "cache/frame/live.h"
#include "scene/scene.h"

/* ---- events ---- */

typedef enum sl_item_kind {
    SL_ITEM_CAMERA,
    SL_ITEM_TIME,
    SL_ITEM_OBJECT,
    SL_ITEM_MATERIAL,
    SL_ITEM_LIGHT,
    SL_ITEM_ADD_LIGHT, /* a point */
    SL_ITEM_SKY,
    SL_ITEM_RELEASE /* an object: its keyframes move it again */
} sl_item_kind;

typedef struct sl_light_item {
    bool has_strength, has_position, has_direction;
    float strength[3]; /* as sl_edit_light() has it */
    double position[3], direction[3];
} sl_light_item;

typedef struct sl_item {
    sl_item_kind kind;
    uint32_t number; /* of the object, material or light, from 1 */
    union {
        sl_camera camera;
        struct {
            double seconds;
            bool keeps_camera; /* somebody has taken it from its keyframes */
        } time;
        double columns[16];
        sl_material_data material; /* its name does not count */
        sl_light_item light;
        double stops; /* of the sky, from the file's */
    } to;
} sl_item;

typedef struct sl_sky sl_sky; /* the file's */

typedef struct sl_event {
    uint64_t number; /* from 1 */
    uint64_t kind;   /* as sl_live_change has it */
    const sl_sky *sky;
    size_t count;
    sl_item items[]; /* either one camera or time, or others, which are one edit */
} sl_event;

/* Makes an event (what) to a copy of the scene that has had all those before: sl_live_change.make. */
sl_status sl_event_make(const void *event, sl_scene *scene, unsigned *changes, sl_error *error);
/* Makes some of them, one after the other. */
sl_status sl_events_make(const sl_event *const *events, size_t count, sl_scene *scene, sl_error *error);
/* The sky of a scene, which the caller frees with free(); NULL: no memory. */
sl_sky *sl_sky_of(const sl_scene *scene);
/* As sl_live_change.kind: equal where the later event is all that counts; 0: it is like none. */
uint64_t sl_event_kind(const sl_item *items, size_t count);

/* ---- the world ---- */

enum { SL_ITEMS = 16 }; /* of an event, at most */

typedef struct sl_undo {
    size_t count;
    sl_item before[SL_ITEMS], after[SL_ITEMS];
} sl_undo;

typedef struct sl_world {
    const char *path; /* of the scene; the caller's, as is what follows */
    const sl_reading *reading;
    sl_scene *scene;
    sl_sky *sky;
    sl_camera first_camera;
    double time, first_time, duration, stops;
    bool looks; /* the camera is not the keyframes' */
    bool edited;
    const sl_event **events;
    size_t count, room;
    sl_undo *undo;
    size_t undone, undo_count; /* of undo_count steps so many are undone */
    bool drags;                /* what comes next may belong to the newest of them */
} sl_world;

/* The scene at a time. */
sl_status sl_world_open(sl_world *world, const char *path, const sl_reading *reading, double time_seconds,
                        sl_error *error);
void sl_world_close(sl_world *world);
/* A copy of the scene as it was in the beginning, which the caller destroys. */
sl_status sl_world_copy(const sl_world *world, sl_scene **scene, sl_error *error);

/* Does it, or nothing; *changes gets SL_CHANGED_ bits. The newest event is then the last of world->events. */
sl_status sl_world_look(sl_world *world, const sl_camera *camera, unsigned *changes, sl_error *error);
sl_status sl_world_go_to(sl_world *world, double time_seconds, unsigned *changes, sl_error *error);
/* An edit that can be undone. drag: more of the same follows, which is to be undone together. */
sl_status sl_world_edit(sl_world *world, const sl_item *items, size_t count, bool drag, unsigned *changes,
                        sl_error *error);
/* Undoes the newest edit that is not undone; again: does the one that was undone last. USAGE: there is none.
 */
sl_status sl_world_undo(sl_world *world, bool again, unsigned *changes, sl_error *error);
