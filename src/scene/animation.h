/* Keyframes of objects, lights and camera. A state is a pure function of the time: what moves is always
 * placed from its rest state, never from where it was. */
#pragma once

#include "scene/affine.h"
#include "scene/scene.h"

typedef struct sl_quaternion {
    double w, x, y, z;
} sl_quaternion;

/* Rotations about x, then y, then z, in radians. */
sl_quaternion sl_quaternion_from_euler(double x, double y, double z);
/* Along the shorter arc, at constant angular speed; t in [0,1]. Unit quaternions. */
sl_quaternion sl_quaternion_slerp(sl_quaternion a, sl_quaternion b, double t);

/* A state at a time, of which each kind of track has some. */
typedef struct sl_key {
    double time;
    sl_vec3d position;  /* of a light, of a camera's eye; an object's translation */
    sl_quaternion rotate;
    sl_vec3d scale;     /* > 0: an object is scaled, then rotated, then translated, after its own transform */
    sl_vec3d direction; /* of a light */
    sl_vec3d target, up;
    double vertical_fov;
} sl_key;

typedef enum sl_track_kind { SL_TRACK_OBJECTS, SL_TRACK_LIGHT, SL_TRACK_CAMERA } sl_track_kind;

typedef struct sl_track {
    sl_track_kind kind;
    uint32_t first, count; /* objects; the light */
    size_t key_count;
    sl_key *keys; /* times rise strictly */
    bool is_placed; /* an object stays where an edit has placed it, whatever the time; no count: no more */
    sl_affine placement; /* ... in our world */
} sl_track;

struct sl_animation {
    bool z_up; /* object keys are in a world with z up */
    size_t track_count, track_room;
    sl_track *tracks;
    /* Made by sl_animation_attach(): of each vertex its track (or SL_NO_INDEX) and its rest state. */
    uint32_t *track_of_vertex;
    sl_vec3 *rest_position, *rest_normal;
    sl_vec3 *rest_control; /* 16 of each bicubic surface; its track is that of its vertices */
};

sl_affine sl_key_placement(const sl_key *key);

/* Tells whether sl_scene_set_time() would succeed, and why not; what it takes memory for is not asked. */
sl_status sl_scene_check_time(const sl_scene *scene, double time_seconds, sl_error *error);

/* The scene takes the animation over (also where this fails: it goes with the scene), keeps the scene's state
 * as the rest state, and moves the scene to time 0. */
sl_status sl_animation_attach(sl_scene *scene, sl_animation *animation, sl_error *error);
/* Returns an object's motion from its rest state as the scene stands now; *keyed: its keyframes move it. */
sl_affine sl_animation_placement(const sl_scene *scene, uint32_t object, bool *keyed);
/* An object's motion from its rest state. */
typedef struct sl_placement {
    uint32_t object;
    sl_affine placement;
    bool released; /* in place of that, its keyframes move it again; if it has none, it rests */
} sl_placement;
/* Places objects, each once, in place of their keyframes from then on; SL_CHANGED_ bits are added to
 * *changes. All or nothing. */
sl_status sl_animation_place(sl_scene *scene, size_t count, const sl_placement *placement, unsigned *changes,
                             sl_error *error);
void sl_animation_destroy(sl_animation *animation); /* NULL is allowed */
